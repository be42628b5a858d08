//! Local fit by bounded Levenberg–Marquardt.
//!
//! At t on the unit box, with residuals r and Jacobian J, a step p minimises ‖J p + r‖² + λ ‖D p‖² subject to
//! 0 ≤ t + p ≤ 1, exactly, by an active set ([`bounded_linear`]): so the model always decreases, active
//! bounds are met exactly, and p = 0 only where the Karush–Kuhn–Tucker conditions hold (Kanzow, Yamashita and
//! Fukushima 2004, doi:10.1016/j.cam.2004.02.013). D holds the largest column norms of J so far (Moré 1978,
//! doi:10.1007/BFb0067700); λ follows the gain ratio (Nielsen 1999, IMM-REP-1999-05).
//!
//! Non-negative coefficients c that the problem eliminates are unknowns of the step, with their columns Φ:
//! ‖J p − Φ d + r‖² + λ ‖D p‖², c + d ≥ 0, not damped. With p alone, by derivatives that hold while the same
//! coefficients are 0, a fit creeps along the edges where one becomes 0 (`docs/theory/joint.md`).
//!
//! Where residuals stay large, the model of the step has the second derivatives of the residuals as well, by
//! secants ([`curvature`]).

mod curvature;

use super::jacobian::UnitResiduals;
use super::ledger::Ledger;
use super::{LeastSquaresOptions, LocalStatus, Settings, bounded_linear};
use curvature::{Curvature, Secant};
use hysteron_numeric::{dot, triangular};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

const FIRST_DAMPING: f64 = 1e-3;
const LEAST_DAMPING: f64 = 1e-15;
const LARGEST_DAMPING: f64 = 1e30;
/// Iterations over which the rate of convergence is judged.
const PACE: usize = 10;
/// A step whose predicted fall is below this share of the tolerance is not worth its evaluation.
const SURELY: f64 = 0.01;
/// Smallest gain ratio of an accepted step.
const LEAST_GAIN: f64 = 1e-4;

/// State of a local fit between two iterations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LocalFit {
    pub(super) point: Vec<f64>,
    pub(super) cost: f64,
    pub(super) initial_cost: f64,
    /// λ.
    damping: f64,
    /// Factor of λ on the next rejection.
    growth: f64,
    /// D.
    scale: Vec<f64>,
    pub(super) iterations: usize,
    /// Cost when the rate of convergence was last judged.
    judged: f64,
    curvature: Curvature,
    /// Evaluations of the run before this fit began.
    pub(super) evaluations_before: usize,
}

impl LocalFit {
    pub(super) fn new(point: &[f64], cost: f64, evaluations_before: usize) -> Self {
        Self {
            point: point.to_vec(),
            cost,
            initial_cost: cost,
            damping: FIRST_DAMPING,
            growth: 2.0,
            scale: vec![0.0; point.len()],
            iterations: 0,
            judged: cost,
            curvature: Curvature::none(point.len()),
            evaluations_before,
        }
    }

    pub(super) fn is_consistent(&self, dimension: usize) -> bool {
        self.point.len() == dimension
            && self.point.iter().all(|t| (0.0..=1.0).contains(t))
            && self.scale.len() == dimension
            && self.scale.iter().all(|&d| d >= 0.0 && d.is_finite())
            && self.damping > 0.0
            && self.damping.is_finite()
            && self.growth >= 2.0
            && self.growth.is_finite()
            && self.judged.is_finite()
            && self.curvature.is_consistent(dimension)
    }

    /// True if, at the rate of its last iterations, the fit would reach the limit of `iterations` before the
    /// cost `best`. Judged every [`PACE`] iterations.
    pub(super) fn is_hopeless(&mut self, iterations: usize, best: f64) -> bool {
        if !self.iterations.is_multiple_of(PACE) {
            return false;
        }
        let fall = self.judged - self.cost;
        self.judged = self.cost;
        let paces_left = iterations.saturating_sub(self.iterations) as f64 / PACE as f64;
        self.cost - paces_left * fall > best
    }

    /// One Jacobian and trial steps until one is accepted; the status if the fit has ended.
    pub(super) fn iterate(
        &mut self,
        options: &LeastSquaresOptions,
        settings: &Settings,
        ledger: &mut Ledger,
        residuals: &mut UnitResiduals<'_>,
    ) -> Option<LocalStatus> {
        if !residuals.load(&self.point) {
            return Some(LocalStatus::Infeasible);
        }
        if let Err(status) = residuals.differentiate(&self.point, options.differences, settings, ledger) {
            return Some(status);
        }
        let model = Linearised::at(&self.point, residuals);
        self.update_scale(&model.column_norms);
        if model.optimality(&self.point) <= options.gradient_tolerance {
            return Some(LocalStatus::GradientTolerance);
        }
        self.curvature.update(&model.gradient);
        let curved = self.curvature.used().and_then(|matrix| model.with_curvature(&matrix));
        let mut local = curved.as_ref().unwrap_or(&model);
        loop {
            let whole = local.step(&self.point, self.damping, &self.scale);
            let step = local.own(&whole);
            if step.iter().all(|p| p.abs() <= options.step_tolerance) {
                return Some(LocalStatus::StepTolerance);
            }
            let predicted = local.predicted_fall(&whole);
            let negligible = options.cost_tolerance * model.half_square;
            if predicted <= SURELY * negligible && self.damping <= FIRST_DAMPING {
                return Some(LocalStatus::CostTolerance);
            }
            if ledger.remaining(settings) == 0 {
                return Some(LocalStatus::Budget);
            }
            let trial: Vec<f64> =
                self.point.iter().zip(step.iter()).map(|(t, p)| (t + p).clamp(0.0, 1.0)).collect();
            let cost = residuals.try_point(&trial, ledger);
            let fall = fall(residuals, cost);
            // At low damping the predicted reduction suffices: the actual one may be rounding error.
            let settled =
                predicted <= negligible && (fall.abs() <= negligible || self.damping <= FIRST_DAMPING);
            if fall > LEAST_GAIN * predicted && fall > 0.0 {
                let gain = fall / predicted;
                self.damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(0.1, 2.0);
                self.damping = self.damping.max(LEAST_DAMPING);
                self.growth = 2.0;
                let secant = Secant {
                    step: trial.iter().zip(&self.point).map(|(to, from)| to - from).collect(),
                    gradient: model.gradient.as_slice().to_vec(),
                    crossed: model.gradient_of(residuals),
                };
                self.curvature.note(secant, fall, model.predicted_fall(&whole));
                residuals.accept_trial(&trial);
                ledger.prefer(&trial, cost);
                (self.point, self.cost) = (trial, cost);
                self.iterations += 1;
                return match () {
                    () if settled => Some(LocalStatus::CostTolerance),
                    () if self.iterations >= options.iterations => Some(LocalStatus::Iterations),
                    () => None,
                };
            }
            if settled {
                return Some(LocalStatus::CostTolerance);
            }
            if !std::ptr::eq(local, &model) {
                // What earlier steps taught does not hold here.
                local = &model;
                continue;
            }
            if predicted <= negligible && cost.is_finite() {
                return Some(LocalStatus::Stalled);
            }
            self.damping *= self.growth;
            self.growth *= 2.0;
            if self.damping > LARGEST_DAMPING {
                return Some(LocalStatus::StepTolerance);
            }
        }
    }

    /// D ← max(D, ‖Jⱼ‖); a parameter without effect gets the largest scale.
    fn update_scale(&mut self, column_norms: &[f64]) {
        let largest = column_norms.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        for (d, &norm) in self.scale.iter_mut().zip(column_norms) {
            *d = if *d == 0.0 && norm == 0.0 { largest } else { d.max(norm) };
        }
    }
}

/// The linear model ½‖J p − Φ d + r‖² at one point, with \[Φ J\] = Q R: the coefficients that are positive
/// first, so that below their rows J is orthogonal to their columns; those that are 0 last.
#[derive(Clone)]
struct Linearised {
    r: DMatrix<f64>,
    /// −Qᵀ r.
    target: DVector<f64>,
    /// Jᵀ r.
    gradient: DVector<f64>,
    /// Norms of the columns of J, orthogonal to those of the positive coefficients.
    column_norms: Vec<f64>,
    /// The positive coefficients, and the number of those that are 0.
    positive: Vec<f64>,
    zeros: usize,
    /// ½‖r‖².
    half_square: f64,
}

/// Damping of the eliminated coefficients, relative to the norm of their columns, for those that depend on
/// one another; columns of zeros are damped as well.
const DEPENDENT: f64 = 1e-8;
/// Damping relative to the squared norm of a column, above the rounding of products: columns that depend on one
/// another, or are zero, have a factor all the same.
const ROUNDING: f64 = 1e-12;

impl Linearised {
    fn at(point: &[f64], residuals: &UnitResiduals<'_>) -> Self {
        let (columns, current) = (residuals.columns(), residuals.current());
        let (count, n) = (current.len(), point.len());
        let eliminated = residuals.eliminated();
        let column = |j: usize| &columns[j * count..(j + 1) * count];
        let of = |is_positive: bool| {
            let each = eliminated.coefficients.iter().zip(eliminated.columns.chunks_exact(count.max(1)));
            each.filter(move |(c, _)| (**c > 0.0) == is_positive)
        };
        let positive: Vec<f64> = of(true).map(|(c, _)| *c).collect();
        let mut all: Vec<&[f64]> = of(true).map(|(_, column)| column).collect();
        all.extend((0..n).map(column));
        all.extend(of(false).map(|(_, column)| column));
        let width = all.len();
        all.push(current);
        let whole = triangular(&all);
        let mut r = whole.view((0, 0), (width, width)).into_owned();
        // The last column of R is Qᵀ r.
        let target = -whole.view((0, width), (width, 1)).column(0);
        let first = positive.len();
        r.columns_mut(0, first).neg_mut();
        r.columns_mut(first + n, width - first - n).neg_mut();
        let column_norms =
            (first..first + n).map(|j| r.view((first, j), (width - first, 1)).norm()).collect();
        let gradient = DVector::from_fn(n, |j, _| dot(column(j), current));
        let half_square = 0.5 * dot(current, current);
        let zeros = width - first - n;
        Self { r, target, gradient, column_norms, positive, zeros, half_square }
    }

    /// This model with the second derivatives `matrix` of the numbers; `None` where it has no minimum.
    fn with_curvature(&self, matrix: &DMatrix<f64>) -> Option<Self> {
        // Those of the positive coefficients are not concerned: the rows below theirs are those of the rest.
        let (first, n) = (self.positive.len(), matrix.ncols());
        let (below, target) = (self.r.view_range(first.., first..), self.target.rows_range(first..));
        let mut hessian = below.tr_mul(&below);
        let mut own = hessian.view_mut((0, 0), (n, n));
        own += matrix;
        for (j, column) in below.column_iter().enumerate() {
            let square = column.norm_squared();
            hessian[(j, j)] += if square > 0.0 { ROUNDING * square } else { 1.0 };
        }
        let lower = hessian.cholesky()?.unpack();
        let turned = lower.solve_lower_triangular(&below.tr_mul(&target))?;
        let mut curved = self.clone();
        curved.r.view_range_mut(first.., first..).copy_from(&lower.transpose());
        curved.target.rows_range_mut(first..).copy_from(&turned);
        Some(curved)
    }

    /// Jᵀ of the trial residuals, J orthogonal to the columns of the positive coefficients.
    fn gradient_of(&self, residuals: &UnitResiduals<'_>) -> Vec<f64> {
        let (trial, eliminated) = (residuals.trial(), residuals.eliminated());
        let count = trial.len().max(1);
        let mut gradient: Vec<f64> =
            residuals.columns().chunks_exact(count).map(|column| dot(column, trial)).collect();
        let first = self.positive.len();
        let positive = eliminated.coefficients.iter().zip(eliminated.columns.chunks_exact(count));
        let shares = positive.filter(|(c, _)| **c > 0.0).map(|(_, column)| -dot(column, trial));
        let shares = DVector::from_iterator(first, shares);
        let square = self.r.view((0, 0), (first, first));
        if let Some(shares) = square.tr_solve_upper_triangular(&shares) {
            let beside = self.r.view((0, first), (first, gradient.len())).tr_mul(&shares);
            gradient.iter_mut().zip(&beside).for_each(|(g, by)| *g -= by);
        }
        gradient
    }

    /// Largest |cosine| between r and a column of J with a feasible descent direction.
    fn optimality(&self, point: &[f64]) -> f64 {
        let length = (2.0 * self.half_square).sqrt();
        let cosine = |j: usize| {
            let g = self.gradient[j];
            let blocked = (point[j] <= 0.0 && g > 0.0) || (point[j] >= 1.0 && g < 0.0);
            if g == 0.0 || blocked { 0.0 } else { g.abs() / (self.column_norms[j] * length) }
        };
        (0..point.len()).map(cosine).fold(0.0, f64::max)
    }

    /// The minimiser of ‖J p − Φ d + r‖² + λ ‖D p‖² in the box around `point`, c + d ≥ 0: d of the positive
    /// coefficients, p, d of those that are 0.
    fn step(&self, point: &[f64], damping: f64, scale: &[f64]) -> DVector<f64> {
        let (rows, first, n) = (self.r.nrows(), self.positive.len(), point.len());
        let root = damping.sqrt();
        let mut stacked = DMatrix::zeros(2 * rows, rows);
        stacked.rows_mut(0, rows).copy_from(&self.r);
        for j in 0..rows {
            stacked[(rows + j, j)] = match j.checked_sub(first).and_then(|j| scale.get(j)) {
                Some(d) => root * d,
                None => DEPENDENT * Some(self.r.column(j).norm()).filter(|norm| *norm > 0.0).unwrap_or(1.0),
            };
        }
        let target = self.target.clone().resize_vertically(2 * rows, 0.0);
        let unbounded = std::iter::repeat_n(f64::INFINITY, first);
        let least = self.positive.iter().map(|c| -c).chain(point.iter().map(|t| -t));
        let low: Vec<f64> = least.chain(std::iter::repeat_n(0.0, self.zeros)).collect();
        let most = unbounded.chain(point.iter().map(|t| 1.0 - t));
        let high: Vec<f64> = most.chain(std::iter::repeat_n(f64::INFINITY, rows - first - n)).collect();
        bounded_linear::solve(&stacked, &target, &low, &high)
    }

    /// p of a step.
    fn own<'s>(&self, step: &'s DVector<f64>) -> &'s [f64] {
        let first = self.positive.len();
        &step.as_slice()[first..step.len() - self.zeros]
    }

    /// ½‖r‖² − ½‖J p − Φ d + r‖², not negative.
    fn predicted_fall(&self, step: &DVector<f64>) -> f64 {
        let moved = &self.r * step;
        (moved.dot(&self.target) - 0.5 * moved.norm_squared()).max(0.0)
    }
}

/// ½‖r‖² − ½‖r_new‖² of the trial point, without cancellation; −∞ where it cannot be simulated.
fn fall(residuals: &UnitResiduals<'_>, cost: f64) -> f64 {
    if !cost.is_finite() {
        return f64::NEG_INFINITY;
    }
    let pairs = residuals.current().iter().zip(residuals.trial());
    0.5 * pairs.map(|(old, new)| (old - new) * (old + new)).sum::<f64>()
}

#[cfg(test)]
mod tests;
