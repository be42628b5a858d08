//! Starts: the shape of the loop by the equation error.

use rayon::prelude::*;

use super::Options;
use super::coordinates::{Coordinates, SHARPEST};
use super::equation_error::{Coefficients, EquationError, Scratch};
use crate::IdentifyError;
use crate::engine::Engine;
use hysteron_optimize::{
    Algorithm, Bounds, LeastSquaresOptions, LeastSquaresProblem, Outcome, Problem, Range, root_mean_square,
};

/// Grid of |b|: from a nearly straight loop to one that saturates within a small part of the motion.
const SIZES: [f64; 5] = [0.05, 0.2, 0.6, 1.8, 5.0];
/// Grid of g/b.
const SHARES: [f64; 4] = [-1.3, -0.5, 0.5, 1.3];
/// Grid of n: the two with closed-form steps.
const EXPONENTS: [f64; 2] = [1.0, 2.0];
/// Grid points refined, of each exponent.
const FOLLOWED: usize = 3;
/// A candidate with more than this multiple of the best error is discarded.
const WORSE: f64 = 1.5;

/// A start of the output-error fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    pub coordinates: Coordinates,
    pub error: f64,
}

/// The starts, best first, and their searches.
pub(super) fn candidates(
    regression: &EquationError,
    options: &Options,
    engine: &mut Engine<'_, '_>,
) -> Result<(Vec<Candidate>, Vec<Outcome>), IdentifyError> {
    let held = options.fixed.iter().find(|(name, _)| name == "n").map(|(_, n)| *n);
    let given = options.start.map(|start| Coordinates::of(&start, regression.size).0);
    let exponents = match (held, given) {
        (Some(n), _) => vec![n],
        (None, Some([.., n])) => vec![if n < 1.5 { EXPONENTS[0] } else { EXPONENTS[1] }],
        (None, None) => EXPONENTS.to_vec(),
    };
    let mut found = Vec::new();
    let mut searches = Vec::new();
    for n in exponents {
        let shapes = match given {
            Some([.., b, g, _]) => best_of_ray(regression, [b, g], n),
            None => best_of_lattice(regression, n),
        };
        if shapes.is_empty() {
            continue;
        }
        let problem = ShapeProblem::new(regression, n);
        let algorithm = Algorithm::LeastSquares(LeastSquaresOptions {
            starts: shapes.len(),
            agreement: Some(2),
            iterations: 60,
            // Low accuracy suffices for starts.
            gradient_tolerance: 1e-5,
            cost_tolerance: 1e-6,
            step_tolerance: 1e-6,
            ..LeastSquaresOptions::default()
        });
        let outcome = engine.run(&format!("shapes, n = {n}"), &problem, &algorithm, shapes, None)?.outcome;
        if let &[b, g] = outcome.best.as_slice()
            && let Some((coefficients, error)) = regression.project([b, g, n], &mut Scratch::default(), None)
        {
            found.push(Candidate { coordinates: coordinates(regression, coefficients, [b, g, n]), error });
        }
        searches.push(outcome);
    }
    found.sort_by(|a, b| a.error.total_cmp(&b.error));
    let best = found.first().ok_or(IdentifyError::NoLoop)?.error;
    found.retain(|candidate| candidate.error <= WORSE * best);
    Ok((found, searches))
}

/// The best grid points.
fn best_of_lattice(regression: &EquationError, n: f64) -> Vec<Vec<f64>> {
    let points = SIZES.iter().flat_map(|&b| SHARES.map(|share| [b, share * b])).collect();
    best_of(regression, points, n)
}

/// The best of the points (b, g).
fn best_of(regression: &EquationError, points: Vec<[f64; 2]>, n: f64) -> Vec<Vec<f64>> {
    let errors: Vec<Option<f64>> = points
        .par_iter()
        .map_init(Scratch::default, |scratch, &[b, g]| {
            let (found, error) = regression.project([b, g, n], scratch, None)?;
            (found.mass > 0.0 && found.alpha > 0.0).then_some(error)
        })
        .collect();
    let mut tried: Vec<(f64, [f64; 2])> =
        errors.into_iter().zip(points).filter_map(|(error, point)| Some((error?, point))).collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.into_iter().take(FOLLOWED).map(|(_, point)| point.to_vec()).collect()
}

/// The given shape at the best of several sizes: the cost has no useful gradient for a loop much larger or
/// smaller than the motion.
fn best_of_ray(regression: &EquationError, [b, g]: [f64; 2], n: f64) -> Vec<Vec<f64>> {
    let largest = b.abs().max(g.abs());
    if largest == 0.0 || !largest.is_finite() {
        return best_of_lattice(regression, n);
    }
    let points: Vec<[f64; 2]> = SIZES.map(|size| [b, g].map(|x| x / largest * size)).to_vec();
    best_of(regression, points, n)
}

/// Coordinates of an oscillator from regression, with non-positive values replaced by those of the linear
/// oscillator.
fn coordinates(regression: &EquationError, found: Coefficients, [b, g, n]: [f64; 3]) -> Coordinates {
    let [mass, damping, stiffness] = regression.linear;
    let or = |value: f64, linear: f64| if value > 0.0 { value } else { linear };
    let whole = or(found.stiffness + found.alpha, stiffness);
    let share = found.alpha / whole;
    Coordinates([or(found.mass, mass), or(found.damping, damping), whole, share, b, g, n])
}

/// b and g at a given n.
struct ShapeProblem<'a> {
    regression: &'a EquationError,
    n: f64,
    bounds: Bounds,
}

impl<'a> ShapeProblem<'a> {
    fn new(regression: &'a EquationError, n: f64) -> Self {
        let range = |name: &str| Range::linear(name, -SHARPEST, SHARPEST);
        Self {
            regression,
            n,
            bounds: Bounds { ranges: vec![range("beta over size"), range("gamma over size")] },
        }
    }
}

impl Problem for ShapeProblem<'_> {
    type Workspace = (Scratch, Vec<f64>);

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Self::Workspace {
        (Scratch::default(), vec![0.0; self.regression.rows()])
    }

    fn cost(&self, x: &[f64], (scratch, residual): &mut Self::Workspace) -> f64 {
        let &[b, g] = x else { return f64::INFINITY };
        let left = self.regression.project([b, g, self.n], scratch, Some(residual));
        if left.is_some() { root_mean_square(residual) } else { f64::INFINITY }
    }
}

impl LeastSquaresProblem for ShapeProblem<'_> {
    fn residual_count(&self) -> usize {
        self.regression.rows()
    }

    fn residuals(&self, x: &[f64], (scratch, _): &mut Self::Workspace, out: &mut [f64]) -> bool {
        let &[b, g] = x else { return false };
        self.regression.project([b, g, self.n], scratch, Some(out)).is_some()
    }
}
