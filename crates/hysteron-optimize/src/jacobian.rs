//! Residuals on the unit box and their derivatives.

use super::evaluate::{EvaluateResiduals, Evaluator};
use super::ledger::Ledger;
use super::points::Points;
use super::{
    Bounds, Derivative, Eliminated, LeastSquaresProblem, LocalStatus, OptimizeError, Settings,
    root_mean_square,
};
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Finite differences of residuals, where the problem supplies no derivatives. A step out of the box, or to a
/// point that cannot be simulated, is taken to the other side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Differences {
    /// (r(t + h) − r(t))/h: one evaluation a parameter.
    Forward {
        /// Step h on the unit box, 0 < h ≤ 0.01.
        step: f64,
    },
    /// (r(t + h) − r(t − h))/2h where both are in the box: two evaluations a parameter.
    Central {
        /// Step h on the unit box, 0 < h ≤ 0.01.
        step: f64,
    },
}

impl Default for Differences {
    /// Forward with 1e−7: a compromise between truncation (∝ h) and rounding of an FFT (about 1e−13, ∝ 1/h).
    fn default() -> Self {
        Self::Forward { step: 1e-7 }
    }
}

impl Differences {
    /// Central differences with the step 1e−5, for standard errors.
    pub fn central() -> Self {
        Self::Central { step: 1e-5 }
    }

    pub(super) fn step(self) -> f64 {
        match self {
            Self::Forward { step } | Self::Central { step } => step,
        }
    }

    fn evaluations(self, parameters: usize) -> usize {
        match self {
            Self::Forward { .. } => parameters,
            Self::Central { .. } => 2 * parameters,
        }
    }
}

/// Jacobian ∂rᵢ/∂xⱼ of the residuals at `x`, rows residuals, columns parameters, in the problem's own units:
/// the problem's own derivatives, or finite differences.
///
/// # Errors
/// [`OptimizeError::NotDifferentiable`] where the model cannot be simulated at or near `x`; an invalid box,
/// or `x` not of its dimension.
pub fn residual_jacobian<P: LeastSquaresProblem>(
    problem: &P,
    x: &[f64],
    differences: Differences,
) -> Result<DMatrix<f64>, OptimizeError> {
    let bounds = problem.bounds();
    bounds.validate()?;
    let settings = Settings { starts: vec![x.to_vec()], ..Settings::default() };
    settings.validate(bounds.dimension())?;
    let mut evaluator = Evaluator::new(problem, None, None)?;
    let mut residuals = UnitResiduals::new(bounds, &mut evaluator);
    let mut unit = vec![0.0; bounds.dimension()];
    bounds.to_unit(x, &mut unit);
    let mut ledger = Ledger::new(bounds.dimension());
    let failed = |j: usize| OptimizeError::NotDifferentiable {
        name: bounds.ranges.get(j).map(|range| range.name.clone()).unwrap_or_default(),
        x: x.to_vec(),
    };
    if !residuals.load(&unit) {
        return Err(failed(0));
    }
    residuals
        .differentiate(&unit, differences, &settings, &mut ledger)
        .map_err(|_| failed(residuals.failed))?;
    let mut jacobian = DMatrix::from_column_slice(residuals.count(), bounds.dimension(), &residuals.columns);
    for ((mut column, range), &t) in jacobian.column_iter_mut().zip(&bounds.ranges).zip(&unit) {
        column /= range.slope(range.from_unit(t));
    }
    Ok(jacobian)
}

/// Residuals at the current and at a trial point, and the derivatives at the current one, on the unit box.
pub(super) struct UnitResiduals<'a> {
    bounds: &'a Bounds,
    evaluator: &'a mut dyn EvaluateResiduals,
    /// Point that `current` belongs to.
    at: Vec<f64>,
    current: Vec<f64>,
    trial: Vec<f64>,
    /// ∂r/∂t at the current point, one column a parameter.
    columns: Vec<f64>,
    /// Non-negative coefficients that the problem eliminates, and −∂r/∂c, column by column.
    coefficients: Vec<f64>,
    eliminated: Vec<f64>,
    other_side: Vec<f64>,
    points: Points,
    feasible: Vec<bool>,
    /// First parameter that could not be differentiated.
    failed: usize,
}

impl<'a> UnitResiduals<'a> {
    pub(super) fn new(bounds: &'a Bounds, evaluator: &'a mut dyn EvaluateResiduals) -> Self {
        let (dimension, count) = (bounds.dimension(), evaluator.residual_count());
        Self {
            bounds,
            evaluator,
            at: Vec::new(),
            current: vec![0.0; count],
            trial: vec![0.0; count],
            columns: vec![0.0; count * dimension],
            coefficients: Vec::new(),
            eliminated: Vec::new(),
            other_side: Vec::new(),
            points: Points::new(dimension),
            feasible: Vec::new(),
            failed: 0,
        }
    }

    pub(super) fn bounds(&self) -> &'a Bounds {
        self.bounds
    }

    pub(super) fn count(&self) -> usize {
        self.current.len()
    }

    /// Residuals at the current point.
    pub(super) fn current(&self) -> &[f64] {
        &self.current
    }

    /// Residuals at the last tried point.
    pub(super) fn trial(&self) -> &[f64] {
        &self.trial
    }

    pub(super) fn columns(&self) -> &[f64] {
        &self.columns
    }

    /// Non-negative coefficients that the problem eliminates, with −∂r/∂c, column by column.
    pub(super) fn eliminated(&self) -> Eliminated<'_> {
        Eliminated { columns: &self.eliminated, coefficients: &self.coefficients }
    }

    /// Makes `point` the current one, simulating it (uncounted) if needed; false if it cannot be simulated.
    pub(super) fn load(&mut self, point: &[f64]) -> bool {
        if self.at == point {
            return true;
        }
        if !self.simulate_trial(point) {
            return false;
        }
        self.accept_trial(point);
        true
    }

    /// Simulates and counts `point`; returns its cost, +∞ where it cannot be simulated.
    pub(super) fn try_point(&mut self, point: &[f64], ledger: &mut Ledger) -> f64 {
        let cost = if self.simulate_trial(point) { root_mean_square(&self.trial) } else { f64::INFINITY };
        ledger.count(point, cost);
        cost
    }

    /// Makes the last tried point the current one.
    pub(super) fn accept_trial(&mut self, point: &[f64]) {
        std::mem::swap(&mut self.current, &mut self.trial);
        self.at.clear();
        self.at.extend_from_slice(point);
    }

    fn simulate_trial(&mut self, point: &[f64]) -> bool {
        self.points.clear();
        self.points.push(point);
        self.evaluator.residuals(&self.points, &mut self.trial, &mut self.feasible);
        self.feasible == [true]
    }

    /// Derivatives at the current point `unit`; counts their evaluations.
    pub(super) fn differentiate(
        &mut self,
        unit: &[f64],
        differences: Differences,
        settings: &Settings,
        ledger: &mut Ledger,
    ) -> Result<(), LocalStatus> {
        if ledger.remaining(settings) == 0 {
            return Err(LocalStatus::Budget);
        }
        let (derivative, eliminated) = self.evaluator.jacobian(unit, &mut self.columns);
        self.eliminated.clear();
        self.coefficients.clear();
        match derivative {
            Derivative::Written => {
                self.eliminated.extend_from_slice(eliminated.columns);
                self.coefficients.extend_from_slice(eliminated.coefficients);
                ledger.count(unit, f64::INFINITY);
                let count = self.count();
                for ((column, range), &t) in self.columns.chunks_mut(count).zip(&self.bounds.ranges).zip(unit)
                {
                    let slope = range.slope(range.from_unit(t));
                    column.iter_mut().for_each(|d| *d *= slope);
                }
                Ok(())
            }
            Derivative::Infeasible => Err(LocalStatus::NotDifferentiable),
            Derivative::ByDifferences if ledger.remaining(settings) < differences.evaluations(unit.len()) => {
                Err(LocalStatus::Budget)
            }
            Derivative::ByDifferences => self.difference(unit, differences, settings, ledger),
        }
    }

    fn difference(
        &mut self,
        unit: &[f64],
        differences: Differences,
        settings: &Settings,
        ledger: &mut Ledger,
    ) -> Result<(), LocalStatus> {
        let (count, h) = (self.count(), differences.step());
        let mut steps: Vec<f64> = unit.iter().map(|&t| if t + h <= 1.0 { h } else { -h }).collect();
        let feasible = self.simulate_beside(unit, &steps, ledger);
        for j in (0..unit.len()).filter(|&j| !feasible[j]) {
            steps[j] = -steps[j];
            if ledger.remaining(settings) == 0 {
                return Err(LocalStatus::Budget);
            }
            if !self.simulate_one_beside(unit, j, steps[j], ledger) {
                self.failed = j;
                return Err(LocalStatus::NotDifferentiable);
            }
        }
        let both = if let Differences::Central { .. } = differences {
            std::mem::swap(&mut self.columns, &mut self.other_side);
            self.columns.resize(self.other_side.len(), 0.0);
            let opposite: Vec<f64> = steps.iter().map(|h| -h).collect();
            if ledger.remaining(settings) < unit.len() {
                return Err(LocalStatus::Budget);
            }
            let both = self.simulate_beside(unit, &opposite, ledger);
            std::mem::swap(&mut self.columns, &mut self.other_side);
            both
        } else {
            vec![false; unit.len()]
        };
        for (j, column) in self.columns.chunks_mut(count).enumerate() {
            // The step after rounding.
            let taken = (unit[j] + steps[j]) - unit[j];
            if both[j] {
                let width = taken - ((unit[j] - steps[j]) - unit[j]);
                let other = &self.other_side[j * count..(j + 1) * count];
                column.iter_mut().zip(other).for_each(|(r, other)| *r = (*r - other) / width);
            } else {
                column.iter_mut().zip(&self.current).for_each(|(r, centre)| *r = (*r - centre) / taken);
            }
        }
        Ok(())
    }

    /// Residuals at t + hⱼ eⱼ for every j into `columns`; true for those in the box that could be simulated.
    fn simulate_beside(&mut self, unit: &[f64], steps: &[f64], ledger: &mut Ledger) -> Vec<bool> {
        self.points.clear();
        for (j, step) in steps.iter().enumerate() {
            self.points.push(unit)[j] = (unit[j] + step).clamp(0.0, 1.0);
        }
        self.evaluator.residuals(&self.points, &mut self.columns, &mut self.feasible);
        steps.iter().for_each(|_| ledger.count(unit, f64::INFINITY));
        let inside = |j: usize| (0.0..=1.0).contains(&(unit[j] + steps[j]));
        self.feasible.iter().enumerate().map(|(j, &feasible)| feasible && inside(j)).collect()
    }

    /// Residuals at t + h eⱼ into column j; true if it is in the box and could be simulated.
    fn simulate_one_beside(&mut self, unit: &[f64], j: usize, step: f64, ledger: &mut Ledger) -> bool {
        if !(0.0..=1.0).contains(&(unit[j] + step)) {
            return false;
        }
        let mut point = unit.to_vec();
        point[j] += step;
        ledger.count(unit, f64::INFINITY);
        if !self.simulate_trial(&point) {
            return false;
        }
        let count = self.count();
        self.columns[j * count..(j + 1) * count].copy_from_slice(&self.trial);
        true
    }
}

#[cfg(test)]
mod tests;
