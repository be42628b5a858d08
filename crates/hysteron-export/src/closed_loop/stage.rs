//! A stage that is not the model: its dynamics alone, without hysteresis, and it moves a little further.

use hysteron_model::control::{Stage, StageError, StageRun, StageSample};
use hysteron_model::realise::LinearRealisation;
use hysteron_numeric::Complex64;

use super::ClosedLoop;

/// Displacement of the stage over that of the model's straight line.
const FURTHER: f64 = 1.05;
/// Frequency at which the straight line has the gain of the model, as a share of the sample rate.
const SLOW: f64 = 1e-4;

/// displacement = gain (H ∗ u)(t), H the dynamics that the loop was designed for.
pub(super) struct OtherStage<'a> {
    dynamics: &'a LinearRealisation,
    gain: f64,
}

/// One run of it.
pub(super) struct OtherRun<'a> {
    stage: &'a OtherStage<'a>,
    /// Voltages, the newest first, as far back as delay and taps reach.
    recent: Vec<f64>,
    states: Vec<Complex64>,
}

impl<'a> OtherStage<'a> {
    pub fn new(closed: &'a ClosedLoop) -> Self {
        let (dynamics, rate) = (&closed.made.dynamics, closed.made.settings.sample_rate_hz);
        let slow = dynamics.response(SLOW * rate, rate).norm();
        Self { dynamics, gain: FURTHER * closed.made.line.slope / slow }
    }

    /// At rest.
    pub fn run(&self, rest_v: f64) -> OtherRun<'_> {
        let depth = self.dynamics.delay_samples + self.dynamics.taps.len();
        let states = vec![Complex64::new(rest_v, 0.0); self.dynamics.sections.len()];
        OtherRun { stage: self, recent: vec![rest_v; depth.max(1)], states }
    }
}

impl Stage for OtherStage<'_> {
    fn at_rest(&self, _: f64, rest_v: f64) -> Result<Box<dyn StageRun + '_>, StageError> {
        Ok(Box::new(self.run(rest_v)))
    }
}

impl StageRun for OtherRun<'_> {
    fn step(&mut self, drive_v: f64) -> Result<StageSample, StageError> {
        let now = self.moved(drive_v);
        Ok(StageSample { reading_um: now, true_um: now })
    }
}

impl OtherRun<'_> {
    /// Displacement at the beginning of a period at this voltage.
    pub fn moved(&mut self, drive_v: f64) -> f64 {
        let OtherStage { dynamics, gain } = self.stage;
        let taps = dynamics.taps.iter().zip(self.recent.iter().skip(dynamics.delay_samples));
        let direct: f64 = taps.map(|(tap, u)| tap * u).sum();
        let weighted = dynamics.sections.iter().zip(&self.states);
        let now = gain * (direct + weighted.map(|(s, x)| (s.weight * x).re).sum::<f64>());
        // The states answer the voltage behind delay and taps.
        let oldest = self.recent.last().copied().unwrap_or(drive_v);
        for (section, state) in dynamics.sections.iter().zip(&mut self.states) {
            *state += section.gain * (oldest - *state);
        }
        self.recent.rotate_right(1);
        if let Some(newest) = self.recent.first_mut() {
            *newest = drive_v;
        }
        now
    }
}
