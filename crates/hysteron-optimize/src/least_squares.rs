//! Bounded multi-start least squares.
//!
//! Local fits follow one another in the order of their starts (the given ones first) and share the budget,
//! until all starts are done, or enough of them have ended in the same best minimum. An iteration of a fit is
//! a generation of the run; so is the beginning of a fit. All evaluations are counted: starts, steps,
//! differences.

use super::algorithm::check_option;
use super::jacobian::UnitResiduals;
use super::ledger::Ledger;
use super::levenberg_marquardt::LocalFit;
use super::outcome::Advance;
use super::starts::fill_start;
use super::{Bounds, Differences, OptimizeError, Settings, Starts, StopReason};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Two costs J₁ ≤ J₂ belong to the same minimum when J₂ − J₁ ≤ this · J₁ …
const SAME_RELATIVE: f64 = 1e-6;
/// … or this · (the largest cost of a start): the floor of an exact fit.
const SAME_ABSOLUTE: f64 = 1e-8;

/// Options of least squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeastSquaresOptions {
    /// Number of starts, including those of [`Settings::starts`] (all of which are used, even if more).
    pub starts: usize,
    /// Distribution of the other starts.
    pub spread: Starts,
    /// Stop once this many starts have ended in the same best minimum; `None`: use all starts. Three may
    /// agree on a local minimum: in 2 of 200 runs of the study's static problem, whose box has a bound
    /// without hysteresis.
    pub agreement: Option<usize>,
    /// Most iterations of one start.
    pub iterations: usize,
    /// Differences, where the problem supplies no derivatives.
    pub differences: Differences,
    /// A fit has converged where the cosine between the residuals and every column of the Jacobian is below
    /// this.
    pub gradient_tolerance: f64,
    /// … or where both actual and predicted relative reduction of the squared cost are below this.
    pub cost_tolerance: f64,
    /// … or where no parameter changes by more than this on the unit box.
    pub step_tolerance: f64,
}

impl Default for LeastSquaresOptions {
    /// 20 Halton starts, three of which must agree; 100 iterations each; tolerances 1e−10, 1e−12, 1e−12.
    fn default() -> Self {
        Self {
            starts: 20,
            spread: Starts::Halton,
            agreement: Some(3),
            iterations: 100,
            differences: Differences::default(),
            gradient_tolerance: 1e-10,
            cost_tolerance: 1e-12,
            step_tolerance: 1e-12,
        }
    }
}

impl LeastSquaresOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        let step = self.differences.step();
        check_option("starts", self.starts as f64, self.starts > 0, "at least 1")?;
        check_option("iterations", self.iterations as f64, self.iterations > 0, "at least 1")?;
        check_option("agreement", 0.0, self.agreement != Some(0), "at least 1")?;
        check_option("differences.step", step, step > 0.0 && step <= 0.01, "0 < step ≤ 0.01")?;
        for (option, value) in [
            ("gradient_tolerance", self.gradient_tolerance),
            ("cost_tolerance", self.cost_tolerance),
            ("step_tolerance", self.step_tolerance),
        ] {
            check_option(option, value, (0.0..1.0).contains(&value), "0 ≤ tolerance < 1")?;
        }
        Ok(())
    }

    fn total_starts(&self, settings: &Settings) -> usize {
        self.starts.max(settings.starts.len())
    }

    pub(super) fn planned_iterations(&self, settings: &Settings) -> usize {
        self.total_starts(settings).saturating_mul(self.iterations.saturating_add(1))
    }
}

/// Termination reason of a local fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum LocalStatus {
    /// Converged: the residuals are orthogonal to every feasible direction.
    GradientTolerance,
    /// Converged: the cost no longer decreases.
    CostTolerance,
    /// Converged: the parameters no longer change.
    StepTolerance,
    /// Steps whose promised fall is above the tolerance do not lower the cost: it has jumps, or an edge.
    Stalled,
    /// Iteration limit reached.
    Iterations,
    /// Abandoned: at its rate of convergence it would reach the iteration limit before the best cost of
    /// earlier starts.
    Abandoned,
    /// The run's budget of evaluations was spent.
    Budget,
    /// The model cannot be simulated at the start.
    Infeasible,
    /// The model cannot be simulated near the point.
    NotDifferentiable,
}

impl LocalStatus {
    /// True if the fit ended in a (local) minimum.
    pub fn converged(self) -> bool {
        matches!(self, Self::GradientTolerance | Self::CostTolerance | Self::StepTolerance)
    }
}

/// Result of one start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartResult {
    /// Final point, in the problem's units.
    pub best: Vec<f64>,
    /// Cost there; +∞ (`null` in JSON) where the start could not be simulated.
    #[serde(with = "super::infinite_as_null::one")]
    pub cost: f64,
    /// Cost at the start.
    #[serde(with = "super::infinite_as_null::one")]
    pub initial_cost: f64,
    /// Iterations.
    pub iterations: usize,
    /// Evaluations.
    pub evaluations: usize,
    /// Termination reason.
    pub status: LocalStatus,
}

/// State of the run: the current fit and the results of earlier ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MultiStart {
    /// Random shift of the Halton sequence.
    shift: Vec<f64>,
    current: Option<LocalFit>,
    /// `best` in the unit box.
    done: Vec<StartResult>,
}

impl MultiStart {
    pub(super) fn new(ledger: &mut Ledger, settings: &Settings) -> Self {
        let mut random = ledger.stream(settings);
        let shift = ledger.best.iter().map(|_| random.unit()).collect();
        Self { shift, current: None, done: Vec::new() }
    }

    pub(super) fn is_consistent(&self, dimension: usize) -> bool {
        self.shift.len() == dimension
            && self.shift.iter().all(|t| (0.0..1.0).contains(t))
            && self.current.as_ref().is_none_or(|fit| fit.is_consistent(dimension))
            && self.done.iter().all(|start| start.best.len() == dimension)
    }

    /// One iteration of the current fit, or the beginning of the next.
    pub(super) fn iterate(
        &mut self,
        options: &LeastSquaresOptions,
        settings: &Settings,
        ledger: &mut Ledger,
        residuals: &mut UnitResiduals<'_>,
    ) -> Advance {
        let Some(fit) = &mut self.current else {
            return self.begin_next(options, settings, ledger, residuals);
        };
        let best = self.done.iter().map(|start| start.cost).fold(f64::INFINITY, f64::min);
        let status = match fit.iterate(options, settings, ledger, residuals) {
            Some(status) => status,
            None if fit.is_hopeless(options.iterations, best) => LocalStatus::Abandoned,
            None => return Advance::Continue,
        };
        let result = StartResult {
            best: fit.point.clone(),
            cost: fit.cost,
            initial_cost: fit.initial_cost,
            iterations: fit.iterations,
            evaluations: ledger.evaluations - fit.evaluations_before,
            status,
        };
        self.current = None;
        self.close(result, options, settings)
    }

    /// Evaluates the next start.
    pub(super) fn begin_next(
        &mut self,
        options: &LeastSquaresOptions,
        settings: &Settings,
        ledger: &mut Ledger,
        residuals: &mut UnitResiduals<'_>,
    ) -> Advance {
        let index = self.done.len();
        let mut point = vec![0.0; self.shift.len()];
        let mut random = ledger.stream(settings);
        match settings.starts.get(index) {
            Some(start) => residuals.bounds().to_unit(start, &mut point),
            None => {
                let index = index - settings.starts.len();
                fill_start(options.spread, index, &self.shift, &mut random, &mut point);
            }
        }
        let before = ledger.evaluations;
        let cost = residuals.try_point(&point, ledger);
        if cost.is_finite() {
            residuals.accept_trial(&point);
            self.current = Some(LocalFit::new(&point, cost, before));
            return Advance::Continue;
        }
        let status = LocalStatus::Infeasible;
        let result =
            StartResult { best: point, cost, initial_cost: cost, iterations: 0, evaluations: 1, status };
        self.close(result, options, settings)
    }

    fn close(&mut self, result: StartResult, options: &LeastSquaresOptions, settings: &Settings) -> Advance {
        let out_of_budget = result.status == LocalStatus::Budget;
        self.done.push(result);
        if out_of_budget {
            Advance::Finished(StopReason::Budget)
        } else if options.agreement.is_some_and(|wanted| self.agreeing() >= wanted) {
            Advance::Finished(StopReason::Agreement)
        } else if self.done.len() >= options.total_starts(settings) {
            Advance::Finished(StopReason::StartsDone)
        } else {
            Advance::Continue
        }
    }

    /// Number of converged starts that ended in the best minimum.
    fn agreeing(&self) -> usize {
        let best = self.done.iter().map(|start| start.cost).fold(f64::INFINITY, f64::min);
        let finite = self.done.iter().map(|start| start.initial_cost).filter(|cost| cost.is_finite());
        let floor = SAME_ABSOLUTE * finite.fold(0.0, f64::max);
        let same = |start: &&StartResult| {
            start.status.converged() && start.cost - best <= (SAME_RELATIVE * best).max(floor)
        };
        self.done.iter().filter(same).count()
    }

    /// Results in the problem's units, without the current fit of a cancelled run.
    pub(super) fn results(&self, bounds: &Bounds) -> Vec<StartResult> {
        let mut results = self.done.clone();
        for (result, start) in results.iter_mut().zip(&self.done) {
            bounds.from_unit(&start.best, &mut result.best);
        }
        results
    }
}

#[cfg(test)]
mod tests;
