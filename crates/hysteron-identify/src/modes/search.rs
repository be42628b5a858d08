//! Levenberg–Marquardt on normal equations (J. J. Moré, doi:10.1007/BFb0067700: scaled by the diagonal).

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use super::columns::{Freedom, Group};
use super::normal::{cost, normal_equations};
use super::records::{Campaign, Piece, error_of};
use super::{ModesObserver, ModesProgress};
use hysteron_model::axes::{LARGEST_POLE, ScheduledModes};

/// Factors of the damping after a step that was taken and one that was not.
const EASIER: f64 = 0.25;
const HARDER: f64 = 6.0;
/// Least damping.
const LEAST_DAMPING: f64 = 1e-9;
/// Most tries of a step.
const TRIES: usize = 8;

/// One search: which parameters, from which damping, how long.
pub(super) struct Stage {
    pub name: &'static str,
    pub groups: &'static [Group],
    pub damping: f64,
    pub iterations: usize,
    /// Relative fall of the cost below which it ends.
    pub stop: f64,
    /// Work of an iteration, for the time left.
    pub work: u64,
}

/// Work done, of all.
pub(super) struct Ledger<'a, 'b> {
    pub observer: &'a mut ModesObserver<'b>,
    pub done: u64,
    pub whole: u64,
    pub stopped: bool,
}

impl Ledger<'_, '_> {
    /// Tells the observer; remembers if it wants to stop.
    pub(super) fn tell(&mut self, step: &'static str, rmse: Option<f64>) {
        let progress = ModesProgress { step, done: self.done, whole: self.whole.max(self.done), rmse };
        if let ControlFlow::Break(()) = (self.observer)(&progress) {
            self.stopped = true;
        }
    }
}

/// The best model found, and the free parameters.
pub(super) fn search(
    start: ScheduledModes,
    stage: &Stage,
    (campaign, pieces): (&Campaign, &[&Piece]),
    ledger: &mut Ledger<'_, '_>,
) -> (ScheduledModes, usize) {
    let freedom = Freedom::new(&start, stage.groups);
    let mut model = start;
    let mut least = cost(&model, pieces);
    let mut damping = stage.damping;
    let end = ledger.done + stage.work * stage.iterations as u64;
    for _ in 0..stage.iterations {
        ledger.tell(stage.name, error_of(least, pieces));
        if ledger.stopped {
            break;
        }
        let Some(equations) = normal_equations(&model, &freedom, pieces) else { break };
        let scale: Vec<f64> = equations.matrix.diagonal().iter().map(|d| d.sqrt()).collect();
        // A parameter without effect stays.
        let per = |k: usize| if scale[k] > 0.0 { 1.0 / scale[k] } else { 0.0 };
        let count = scale.len();
        let scaled = DMatrix::from_fn(count, count, |i, j| equations.matrix[(i, j)] * per(i) * per(j));
        let target = DVector::from_fn(count, |i, _| equations.gradient[i] * per(i));
        let mut taken = None;
        for _ in 0..TRIES {
            let mut matrix = scaled.clone();
            (0..count).for_each(|k| matrix[(k, k)] += damping);
            if let Some(factor) = matrix.cholesky() {
                let step: Vec<f64> =
                    factor.solve(&target).iter().enumerate().map(|(k, x)| x * per(k)).collect();
                let candidate = freedom.moved(&model, &step);
                if is_stable(&candidate, campaign) {
                    let found = cost(&candidate, pieces);
                    if found < least {
                        taken = Some((candidate, found));
                        break;
                    }
                }
            }
            damping = (damping * HARDER).max(LEAST_DAMPING * 100.0);
        }
        let Some((candidate, found)) = taken else { break };
        let fall = (least - found) / least;
        (model, least) = (candidate, found);
        damping = (damping * EASIER).max(LEAST_DAMPING);
        ledger.done += stage.work;
        if fall < stage.stop {
            break;
        }
    }
    ledger.done = end;
    (model, freedom.columns.len())
}

/// Whether every pole decays at every level of the records.
fn is_stable(model: &ScheduledModes, campaign: &Campaign) -> bool {
    campaign.levels.iter().all(|level| {
        let (magnitude, _) = model.largest_pole(model.level.state(*level));
        magnitude < LARGEST_POLE
    })
}
