//! The bench in closed loop, one sample period at a time.

use hysteron_model::control::{Stage, StageError, StageRun, StageSample};

use super::RigError;
use super::period::Periods;
use super::sensor::SensorState;
use super::truth::{Dac, Truth};

/// The simulated bench, driven one period at a time through a zero-order hold. For the same drive its output
/// is bit-identical to that of [`measure`](super::measure).
///
/// ```
/// use hysteron_rig::{Dac, LiveRig, Truth};
///
/// let truth = Truth { dac: Dac::Hold, ..Truth::default() };
/// let mut bench = LiveRig::at_rest(&truth, 10_000.0, 2.0, 1, 0)?;
/// let before = bench.step(2.0)?.true_um;
/// for _ in 0..100 {
///     bench.step(4.0)?;
/// }
/// assert!(bench.step(4.0)?.true_um > before + 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LiveRig<'a> {
    periods: Periods<'a>,
    sensor: SensorState,
}

impl<'a> LiveRig<'a> {
    /// A bench in equilibrium at the voltage `rest_v`; `seed` and `stream` of its noise as in
    /// [`measure`](super::measure).
    ///
    /// # Errors
    /// Those of [`measure`](super::measure); [`RigError::Ahead`] for a truth whose converter interpolates
    /// linearly.
    pub fn at_rest(
        truth: &'a Truth,
        sample_rate_hz: f64,
        rest_v: f64,
        seed: u64,
        stream: usize,
    ) -> Result<Self, RigError> {
        truth.validate()?;
        if truth.dac != Dac::Hold {
            return Err(RigError::Ahead);
        }
        finite(rest_v)?;
        let periods = Periods::at_rest(truth, sample_rate_hz, rest_v)?;
        Ok(LiveRig { periods, sensor: SensorState::new(&truth.sensor, sample_rate_hz, seed, stream) })
    }

    /// Holds `drive_v` for one period. The sample is taken at its beginning: a drive computed from it is
    /// applied one period later.
    ///
    /// # Errors
    /// [`RigError::Drive`] for a voltage that is not finite, [`RigError::Diverged`].
    pub fn step(&mut self, drive_v: f64) -> Result<StageSample, RigError> {
        finite(drive_v)?;
        let (true_um, _) = self.periods.next(drive_v, drive_v)?;
        Ok(StageSample { reading_um: self.sensor.read(true_um), true_um })
    }
}

impl StageRun for LiveRig<'_> {
    fn step(&mut self, drive_v: f64) -> Result<StageSample, StageError> {
        Ok(LiveRig::step(self, drive_v)?)
    }
}

/// The simulated bench as the stage of a control loop.
#[derive(Clone, Copy, Debug)]
pub struct RigStage<'a> {
    /// The device; its converter must be a zero-order hold.
    pub truth: &'a Truth,
    /// Seed of its noise.
    pub seed: u64,
    /// Number of the record, the stream of its noise.
    pub stream: usize,
}

impl Stage for RigStage<'_> {
    fn at_rest(&self, sample_rate_hz: f64, rest_v: f64) -> Result<Box<dyn StageRun + '_>, StageError> {
        Ok(Box::new(LiveRig::at_rest(self.truth, sample_rate_hz, rest_v, self.seed, self.stream)?))
    }
}

fn finite(value: f64) -> Result<(), RigError> {
    let (what, expected) = ("a sample", "finite voltages");
    if value.is_finite() { Ok(()) } else { Err(RigError::Drive { what, value, expected }) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::{BoucWenFractional, Plant, PowerTerm, measure};
    use super::*;
    use crate::excitation::Excitation;

    /// With and without amplifier, delay of none, one and several samples, whole and not.
    #[test]
    fn it_is_measure_one_period_at_a_time() {
        let term = |coefficient, order| PowerTerm { coefficient, order };
        let fast = |delay_s| {
            Plant::BoucWenFractional(BoucWenFractional {
                polynomial: vec![2.0, 0.01],
                alpha: -1.2,
                beta: 0.11,
                gamma: 0.02,
                n: 1.0,
                numerator: vec![term(1.0, 0.0)],
                denominator: vec![term(1.0, 0.0), term(2e-3, 0.9)],
                delay_s,
            })
        };
        let held = Truth { dac: Dac::Hold, ..Truth::default() };
        let mut truths = vec![held.clone()];
        truths.extend([0.0, 1e-4, 2.5e-4, 1.23e-3].map(|d| Truth { plant: fast(d), ..held.clone() }));
        for truth in truths {
            let drive: Vec<f64> =
                (0..300).map(|k| 4.0 + 3.0 * (f64::from(k) * 0.05).sin() + f64::from(k % 7)).collect();
            let played = Excitation::of_samples("drive".into(), "drive".into(), drive.clone(), 10_000.0);
            let whole = measure(&truth, &played, 3, 2).unwrap();
            let mut live = LiveRig::at_rest(&truth, 10_000.0, drive[0], 3, 2).unwrap();
            for (k, u) in drive.iter().enumerate() {
                let seen = live.step(*u).unwrap();
                assert_eq!(seen.true_um, whole.y_true_um[k], "{} {k}", truth.describe());
                assert_eq!(seen.reading_um, whole.record.channels[1].samples[k]);
            }
        }
    }

    #[test]
    fn what_cannot_be_driven_is_refused() {
        let lines = Truth::default();
        assert!(matches!(LiveRig::at_rest(&lines, 1e4, 0.0, 0, 0), Err(RigError::Ahead)));
        let held = Truth { dac: Dac::Hold, ..Truth::default() };
        assert!(LiveRig::at_rest(&held, 0.0, 0.0, 0, 0).is_err());
        assert!(LiveRig::at_rest(&held, 1e4, f64::NAN, 0, 0).is_err());
        let mut live = LiveRig::at_rest(&held, 1e4, 0.0, 0, 0).unwrap();
        assert!(live.step(f64::INFINITY).is_err());
    }
}
