//! Levenberg–Marquardt on normal equations (J. J. Moré, doi:10.1007/BFb0067700: scaled by the diagonal).
//!
//! The matrix takes most of an iteration. So it is in single precision and, where it takes long, of one record of
//! each level in turn, and several dampings are tried with it on these records, of which the one that lowers their
//! cost most is taken if it lowers that of all. The gradient is of all records, in double precision.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::columns::{Freedom, Group};
use super::normal::{cost, normal_equations};
use super::records::{Alike, Campaign, RecordPeriod, error_of};
use super::ridge::Ridge;
use super::stress_scale;
use crate::watch::{Event, State};
use crate::{ModesCheckpoint, Searches, Watch};
use hysteron_model::Model;
use hysteron_model::axes::{LARGEST_POLE, ScheduledModes};
use hysteron_model::model_file::ModesFile;
use hysteron_numeric::cholesky;

/// Factor of the damping after a step that does not lower the cost.
const HARDER: f64 = 6.0;
/// Factor between the dampings compared.
const COMPARED: f64 = 3.0;
/// Least damping.
const LEAST_DAMPING: f64 = 1e-9;
/// Most further trials until a step lowers the cost, and most of those compared with it in its direction.
const TRIES: usize = 7;
const COMPARISONS: usize = 3;

/// One search: free parameters, initial damping, iterations.
pub(super) struct Stage {
    pub name: &'static str,
    pub groups: &'static [Group],
    pub damping: f64,
    pub iterations: usize,
    /// Relative fall of the cost below which it ends.
    pub stop: f64,
    /// Relative cost of an iteration, for progress.
    pub work: u64,
    /// Weight of the ridge on the slopes.
    pub ridge: f64,
}

/// Progress, its listener, and the checkpoint.
pub(super) struct Ledger<'a, 'w> {
    pub watch: &'a Watch<'w>,
    pub done: u64,
    pub whole: u64,
    /// Converts the model of a search to its model file.
    pub file: &'a dyn Fn(&ScheduledModes) -> ModesFile,
    /// Fingerprint of the records and options.
    pub problem: &'a str,
    /// Number of searches done.
    pub stage: usize,
    /// State at the last beginning of an iteration.
    pub state: Option<Box<ModesCheckpoint>>,
}

/// State from which a search begins or resumes.
#[derive(Clone, Copy)]
pub(super) struct From {
    pub iteration: usize,
    pub damping: f64,
}

impl Ledger<'_, '_> {
    /// Reports progress; false if stopped.
    pub(super) fn tell(&self, stage: &str, rmse: Option<f64>, model: Option<&ScheduledModes>) -> bool {
        let fraction = self.done as f64 / self.whole.max(self.done).max(1) as f64;
        let model = || model.and_then(|model| Model::try_from((self.file)(model)).ok());
        let searches = || Searches { modes: self.state.clone(), ..Searches::default() };
        let state = State { model: Some(&model), searches: Some(&searches), ..State::default() };
        self.watch.tell(Event::new(stage, fraction, rmse).with(state)).is_continue()
    }

    /// Stores the state of the search.
    fn keep(&mut self, iteration: usize, damping: f64, model: &ScheduledModes) {
        let (problem, stage, model) = (self.problem.to_owned(), self.stage, (self.file)(model));
        self.state = Some(Box::new(ModesCheckpoint { problem, stage, iteration, damping, model }));
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.watch.is_stopped()
    }
}

/// The best model found, and the free parameters.
pub(super) fn search(
    start: ScheduledModes,
    stage: &Stage,
    from: From,
    (campaign, pieces): (&Campaign, &[&RecordPeriod]),
    ledger: &mut Ledger<'_, '_>,
) -> (ScheduledModes, usize) {
    let freedom = Freedom::new(&start, stage.groups);
    let alike = Alike::new(pieces, freedom.columns.len());
    let mut model = start;
    let all = vec![1.0; pieces.len()];
    let mut misfit = cost(&model, pieces, &all);
    let mut damping = from.damping;
    let end = ledger.done + stage.work * stage.iterations as u64;
    ledger.done += stage.work * from.iteration as u64;
    for iteration in from.iteration..stage.iterations {
        ledger.keep(iteration, damping, &model);
        if !ledger.tell(stage.name, error_of(misfit, pieces), Some(&model)) {
            break;
        }
        let stop = ledger.watch.stop();
        let shares = alike.shares(iteration);
        let Some(mut equations) = normal_equations(&model, &freedom, pieces, &shares, stop) else { break };
        let ridge = Ridge::new(&freedom, &model, &equations.matrix, stage.ridge);
        let values = freedom.values(&model);
        ridge.add(&mut equations.matrix, &mut equations.gradient, &values);
        let least = misfit + ridge.of(&values);
        stress_scale::hold(&mut equations, &freedom, &model);
        let scale: Vec<f64> = equations.matrix.diagonal().iter().map(|d| d.sqrt()).collect();
        // A parameter without effect is not changed.
        let per = |k: usize| if scale[k] > 0.0 { 1.0 / scale[k] } else { 0.0 };
        let count = scale.len();
        let scaled = DMatrix::from_fn(count, count, |i, j| equations.matrix[(i, j)] * per(i) * per(j));
        let target = DVector::from_fn(count, |i, _| equations.gradient[i] * per(i));
        let trial = |damping: f64| -> Option<Step> {
            let mut matrix = scaled.clone();
            (0..count).for_each(|k| matrix[(k, k)] += damping);
            let step = cholesky(matrix)?.solve(&target);
            let step: Vec<f64> = step.iter().enumerate().map(|(k, x)| x * per(k)).collect();
            let model = freedom.moved(&model, &step);
            if stop.is_requested() || !is_stable(&model, campaign) {
                return None;
            }
            let penalty = ridge.of(&freedom.values(&model));
            let misfit = cost(&model, pieces, &shares);
            misfit.is_finite().then_some(Step { model, damping, misfit, penalty })
        };
        let lowers = |mut step: Step| -> Option<Step> {
            if shares != all {
                step.misfit = cost(&step.model, pieces, &all);
            }
            (step.penalised() < least).then_some(step)
        };
        let Some(step) = best_step(damping, trial, lowers) else { break };
        let fall = (least - step.penalised()) / least;
        (model, misfit, damping) = (step.model, step.misfit, step.damping);
        ledger.done += stage.work;
        // After a stop not all dampings were compared: a resumed search takes this iteration again.
        if fall < stage.stop || stop.is_requested() {
            break;
        }
    }
    ledger.done = end;
    (model, freedom.columns.len())
}

/// A step at one damping.
struct Step {
    model: ScheduledModes,
    damping: f64,
    /// Of the records compared; of all once the step is known to lower it.
    misfit: f64,
    /// Of the ridge.
    penalty: f64,
}

impl Step {
    fn penalised(&self) -> f64 {
        self.misfit + self.penalty
    }
}

/// The step of the least cost of the records compared among dampings around `start`, each a trial, if it lowers
/// the cost of all; else the first of harder dampings that does; `None` where none does.
fn best_step(
    start: f64,
    trial: impl Fn(f64) -> Option<Step> + Sync,
    lowers: impl Fn(Step) -> Option<Step>,
) -> Option<Step> {
    let better = |a: Step, b: Step| if b.penalised() < a.penalised() { b } else { a };
    let start = start.max(LEAST_DAMPING);
    let around = [start, start / COMPARED, start * COMPARED];
    let tried: Vec<Option<Step>> = around.into_par_iter().with_max_len(1).map(&trial).collect();
    let further = |mut best: Step| {
        let factor = if best.damping < start { COMPARED.recip() } else { COMPARED };
        if best.damping != start {
            for _ in 0..COMPARISONS {
                match trial(best.damping * factor) {
                    Some(next) if next.penalised() < best.penalised() => best = next,
                    _ => break,
                }
            }
        }
        best
    };
    tried.into_iter().flatten().reduce(better).map(further).and_then(&lowers).or_else(|| {
        let harder = |damping: &f64| Some((damping * HARDER).max(LEAST_DAMPING * 100.0));
        let dampings = std::iter::successors(harder(&(start * COMPARED)), harder);
        dampings.take(TRIES).find_map(|damping| trial(damping).and_then(&lowers))
    })
}

/// True if all poles are stable at every level of the records.
fn is_stable(model: &ScheduledModes, campaign: &Campaign) -> bool {
    campaign.levels.iter().all(|level| {
        let (magnitude, _) = model.largest_pole(model.level.state(*level));
        magnitude < LARGEST_POLE
    })
}
