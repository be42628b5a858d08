//! The article's dynamic problem: orders and coefficients of a fractional transfer function.

use super::noise::add_noise;
use crate::ArticleError;
use hysteron_model::Start;
use hysteron_model::dynamics::{self, InputSpectrum, Scheme, SimulationPlan, Term, TransferFunction};
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, Range, root_mean_square};
use std::f64::consts::TAU;

const SAMPLES: usize = 2000;
const SAMPLE_RATE_HZ: f64 = 1000.0;
const NOISE_UM: f64 = 0.02;

/// Fit of (b, c₁, c₀, α₂, α₁) of b/(s^α₂ + c₁ s^α₁ + c₀), orders and coefficients at once. Input is a linear
/// 1–100 Hz chirp of 1 µm amplitude, 2 s at 1 kHz (2000 samples); truth is article Eq. 13 under the same
/// scheme (Tustin, from rest), with normal noise of 0.02 µm. Coefficients span three decades and are scaled
/// logarithmically; unstable candidates have cost +∞.
///
/// Difficulty depends on the noise: with the article's own input (Table 2's hysteresis from 0 to 10 V, ten
/// times the amplitude) the same noise gives such a narrow valley of the cost that DE-ABC succeeds in 26 % of
/// 31 runs and DE in all.
#[derive(Debug)]
pub struct FractionalBlock {
    bounds: Bounds,
    plan: SimulationPlan,
    input: InputSpectrum,
    y: Vec<f64>,
}

/// Buffers of one thread.
#[derive(Debug)]
pub struct FractionalWorkspace {
    simulation: dynamics::Workspace,
    candidate: TransferFunction,
    residuals: Vec<f64>,
}

impl FractionalBlock {
    /// The problem in one sentence.
    pub const DESCRIPTION: &'static str = "linear 1-100 Hz chirp of 1 um amplitude, 2 s at 1 kHz (2000 \
        samples), article Eq. 13 as truth (Tustin, from rest), normal noise of 0.02 um; b, c1, c0 (three \
        decades each) and the orders alpha2, alpha1 sought at once";

    /// Article Eq. 13 in the order of the parameters: b, c₁, c₀, α₂, α₁.
    pub const TRUTH: [f64; 5] = [5.2589e6, 3081.0, 5.4955e6, 2.0384, 1.0523];

    /// The problem with a noise realisation.
    ///
    /// # Errors
    /// [`ArticleError::Dynamics`] never occurs: the truth is stable.
    pub fn new(noise_seed: u64) -> Result<Self, ArticleError> {
        let duration_s = SAMPLES as f64 / SAMPLE_RATE_HZ;
        let cycles = |t: f64| t + 0.5 * (100.0 - 1.0) * t * t / duration_s;
        let chirp: Vec<f64> = (0..SAMPLES).map(|k| (TAU * cycles(k as f64 / SAMPLE_RATE_HZ)).sin()).collect();
        let plan = SimulationPlan::new(SAMPLES, SAMPLE_RATE_HZ, Scheme::Tustin, Start::AsIdentified)?;
        let input = plan.transform(&chirp)?;
        let mut y = vec![0.0; SAMPLES];
        let mut truth = blank();
        write(&Self::TRUTH, &mut truth);
        plan.simulate_spectrum(&truth, &input, &mut plan.workspace(), &mut y)?;
        add_noise(&mut y, NOISE_UM, noise_seed);
        let ranges = vec![
            Range::logarithmic("b", 1e5, 1e8),
            Range::logarithmic("c1", 1e2, 1e5),
            Range::logarithmic("c0", 1e5, 1e8),
            Range::linear("alpha2", 1.5, 2.5),
            Range::linear("alpha1", 0.5, 1.5),
        ];
        Ok(Self { bounds: Bounds { ranges }, plan, input, y })
    }

    /// Standard deviation of the noise \[µm\].
    pub const fn noise_um() -> f64 {
        NOISE_UM
    }
}

/// b/(s^α₂ + c₁ s^α₁ + c₀) with every number 1 or 0, until [`write`] sets them.
fn blank() -> TransferFunction {
    TransferFunction { numerator: vec![Term::new(1.0, 0.0)], denominator: vec![Term::new(1.0, 0.0); 3] }
}

fn write(x: &[f64; 5], tf: &mut TransferFunction) {
    let &[b, c1, c0, alpha2, alpha1] = x;
    let terms = [Term::new(c0, 0.0), Term::new(c1, alpha1), Term::new(1.0, alpha2)];
    tf.numerator.iter_mut().for_each(|term| term.coefficient = b);
    tf.denominator.iter_mut().zip(terms).for_each(|(term, new)| *term = new);
}

impl Problem for FractionalBlock {
    type Workspace = FractionalWorkspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> FractionalWorkspace {
        FractionalWorkspace {
            simulation: self.plan.workspace(),
            candidate: blank(),
            residuals: vec![0.0; SAMPLES],
        }
    }

    fn cost(&self, x: &[f64], workspace: &mut FractionalWorkspace) -> f64 {
        let mut residuals = std::mem::take(&mut workspace.residuals);
        let feasible = self.residuals(x, workspace, &mut residuals);
        workspace.residuals = residuals;
        if feasible { root_mean_square(&workspace.residuals) } else { f64::INFINITY }
    }

    fn identity(&self) -> String {
        "optimiser study, fractional block".to_owned()
    }
}

impl LeastSquaresProblem for FractionalBlock {
    fn residual_count(&self) -> usize {
        SAMPLES
    }

    fn residuals(&self, x: &[f64], workspace: &mut FractionalWorkspace, out: &mut [f64]) -> bool {
        let Ok(x) = x.try_into() else { return false };
        write(x, &mut workspace.candidate);
        let FractionalWorkspace { simulation, candidate, .. } = workspace;
        if self.plan.simulate_spectrum(candidate, &self.input, simulation, out).is_err() {
            return false;
        }
        out.iter_mut().zip(&self.y).for_each(|(r, y)| *r -= y);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_at_the_truth_are_the_noise() {
        let problem = FractionalBlock::new(3).unwrap();
        let cost = problem.cost(&FractionalBlock::TRUTH, &mut problem.workspace());
        // Standard deviation of the estimate: 0.02/√4000.
        assert!((cost - 0.02).abs() < 4.0 * 3.2e-4, "{cost}");
    }

    #[test]
    fn unstable_candidate_is_infeasible() {
        let problem = FractionalBlock::new(3).unwrap();
        // s^2.5 + 100 s^0.5 + 1e8 has poles in the right half-plane: hardly any damping, order above 2.
        let cost = problem.cost(&[1e6, 100.0, 1e8, 2.5, 0.5], &mut problem.workspace());
        assert_eq!(cost, f64::INFINITY);
    }
}
