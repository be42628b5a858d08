//! Run of one controller on the plant, with its score and response to sines.

use std::ops::Range;

use crate::control::{
    AdaptiveFilter, ControlError, Edge, Followed, Loop, Plant, Played, Sines, TrackingScore, play_metered,
};
use hysteron_numeric::Meter;

use super::Controller;

/// Error in per cent of the stroke above which the stage does not follow the reference.
const RUN_AWAY: f64 = 100.0;
/// Ratio of two bandwidths above which they are reported as different.
const DIFFERENT: f64 = 1.1;

/// Run of one controller.
#[derive(Clone, Debug)]
pub struct ControllerRun {
    /// Controller.
    pub controller: Controller,
    /// Loop designed from the model.
    pub made: Loop,
    /// Drive and displacement.
    pub played: Played,
    /// Tracking error.
    pub score: TrackingScore,
    /// Response to sines; `None` where the reference does not move.
    pub followed: Option<Followed>,
    /// Adaptive feedforward, if the controller has one.
    pub adaptation: Option<Adaptation>,
}

/// Adaptation of the weights of an adaptive feedforward.
#[derive(Clone, Debug)]
pub struct Adaptation {
    /// Filter with its step.
    pub filter: AdaptiveFilter,
    /// Residual rms with the best constant weights, in per cent of the stroke.
    pub best_percent: f64,
    /// Largest phase difference between stage and model \[degrees\], and its frequency \[Hz\].
    pub phase_error: Option<(f64, f64)>,
}

/// Reference and plant that every controller is played on.
pub(super) struct Rehearsal<'a> {
    pub plant: Plant<'a>,
    pub virgin_v: Option<f64>,
    pub reference: &'a [f64],
    pub scored: &'a Range<usize>,
    pub sines: Option<Sines>,
}

impl Rehearsal<'_> {
    /// Samples that a run plays, without those that the search for a bandwidth adds.
    pub fn samples(&self, made: &Loop) -> usize {
        let once = self.reference.len() + self.sines.map_or(0, |sines| made.samples_of(&sines));
        if made.adaptive.is_some() { 2 * once } else { once }
    }

    pub fn run(
        &self,
        controller: Controller,
        made: &Loop,
        meter: &Meter<'_>,
    ) -> Result<ControllerRun, ControlError> {
        let Range { start: from, end: to } = *self.scored;
        let played = play_metered(made, self.reference, self.plant, self.virgin_v, meter)?;
        let score = TrackingScore::of(&played.displacement[..to], &self.reference[..to], from);
        let sines = |made: &Loop| match &self.sines {
            Some(sines) => made.sines_metered(sines, self.plant, self.virgin_v, meter).map(Some),
            None => Ok(None),
        };
        let followed = sines(made)?;
        let adaptation = match &made.adaptive {
            Some(filter) => {
                let alone = made.without_adaptation();
                let played = play_metered(&alone, self.reference, self.plant, self.virgin_v, meter)?;
                let left: Vec<f64> =
                    self.reference.iter().zip(&played.displacement).map(|(r, y)| r - y).take(to).collect();
                let ahead = made.inverse.as_ref().map_or(0, |inverse| inverse.preview);
                let first = self.reference.first().copied().unwrap_or(f64::NAN);
                let last = self.reference.last().copied().unwrap_or(f64::NAN);
                let known: Vec<f64> =
                    (0..to).map(|k| self.reference.get(k + ahead).copied().unwrap_or(last) - first).collect();
                Some(Adaptation {
                    best_percent: filter.optimum(&known, &left, from) * score.rms_percent / score.rms,
                    phase_error: sines(&alone)?.and_then(|followed| made.phase_error(&followed.answers)),
                    filter: filter.clone(),
                })
            }
            None => None,
        };
        Ok(ControllerRun { controller, made: made.clone(), played, score, followed, adaptation })
    }
}

impl ControllerRun {
    /// True if the stage fails to follow the reference: an error larger than its whole stroke.
    pub fn runs_away(&self) -> bool {
        self.score.max_percent > RUN_AWAY
    }

    /// Bandwidths, computed \[Hz\] and measured: −3 dB, 1 % error.
    pub fn bandwidths(&self) -> Option<[(f64, Edge); 2]> {
        let (formula, played) = (&self.made.bandwidth, self.followed.as_ref()?);
        Some([(formula.minus_3_db_hz, played.minus_3_db), (formula.one_percent_hz, played.one_percent)])
    }
}

/// True if a computed \[Hz\] and a measured bandwidth differ by more than a tenth.
pub fn differ(formula: f64, played: Edge) -> bool {
    match played {
        Edge::At(f) => (f / formula).max(formula / f) > DIFFERENT,
        Edge::Below(f) => formula > DIFFERENT * f,
        Edge::Above(f) => f > DIFFERENT * formula,
    }
}
