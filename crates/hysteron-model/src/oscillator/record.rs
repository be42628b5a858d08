//! Simulation of a whole record.

use super::{Drive, Oscillator, OscillatorState, SimulationError};
use crate::hysteresis::RecordEnds;
use crate::record::InterSample;
use crate::start::Start;

/// Largest difference of a force from itself one period later, as a share of its largest value, at which it
/// counts as periodic.
const REPEATS: f64 = 1e-9;

impl Oscillator {
    /// Displacement at every sample of the force `u`, in [`Self::steps`] steps per sample. From a settled
    /// start a force that repeats to the last sample gives the steady state, repeated; any other is simulated
    /// on from it.
    ///
    /// # Errors
    /// Those of [`Drive::new`] and [`Self::simulate`]; [`SimulationError::Period`].
    pub fn simulate_record(
        &self,
        u: &[f64],
        sample_rate_hz: f64,
        rule: InterSample,
        start: Start,
    ) -> Result<Vec<f64>, SimulationError> {
        self.validate()?;
        let steps = self.steps(sample_rate_hz);
        let open = |start: Start<OscillatorState>| {
            let drive = Drive::new(u, sample_rate_hz, rule, RecordEnds::Open, steps)?;
            let mut y = vec![0.0; u.len()];
            self.simulate(&drive, start, &mut y).map(|_| y)
        };
        let period_samples = match start {
            Start::Settled { period_samples, .. } => period_samples.unwrap_or(u.len()),
            Start::Remembering { .. } => return Err(SimulationError::Memory),
            Start::AsIdentified | Start::Rest { .. } => return open(Start::AsIdentified),
        };
        let period = u.get(..period_samples).filter(|period| period.len() >= 2);
        let period = period.ok_or(SimulationError::Period { samples: u.len(), period_samples })?;
        let drive = Drive::new(period, sample_rate_hz, rule, RecordEnds::Periodic, steps)?;
        let mut y = vec![0.0; period_samples];
        let first = self.simulate(&drive, Start::PERIODIC, &mut y)?;
        let largest = u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
        let same = |(a, b): (&f64, &f64)| (a - b).abs() <= REPEATS * largest;
        if u.iter().zip(u.iter().skip(period_samples)).all(same) {
            return Ok(y.iter().cycle().take(u.len()).copied().collect());
        }
        open(first.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OSCILLATOR: Oscillator = Oscillator {
        mass: 2.0,
        damping: 40.0,
        stiffness: 5e4,
        alpha: 5e4,
        beta: 600.0,
        gamma: 200.0,
        n: 1.0,
    };

    fn force(samples: usize) -> Vec<f64> {
        (0..samples).map(|k| 30.0 * (std::f64::consts::TAU * k as f64 / 50.0).sin()).collect()
    }

    #[test]
    fn a_settled_record_repeats_and_goes_on_where_the_force_changes() {
        let settled = Start::settled(50);
        let run = |u: &[f64]| OSCILLATOR.simulate_record(u, 750.0, InterSample::Linear, settled).unwrap();
        let repeated = run(&force(175));
        assert!(repeated.iter().zip(&repeated[50..]).all(|(a, b)| a == b));
        let mut changed = force(175);
        changed[174] += 1.0;
        let followed = run(&changed);
        let largest = repeated.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
        // Up to the change the same steady state, to what it settled to.
        assert!(repeated.iter().zip(&followed).take(174).all(|(a, b)| (a - b).abs() < 1e-8 * largest));
        assert!(repeated[174] != followed[174]);
    }

    #[test]
    fn a_period_longer_than_the_record_is_refused() {
        let run = |period_samples| {
            let start = Start::settled(period_samples);
            OSCILLATOR.simulate_record(&force(60), 750.0, InterSample::Linear, start).unwrap_err()
        };
        for period_samples in [0, 1, 61] {
            assert_eq!(run(period_samples), SimulationError::Period { samples: 60, period_samples });
        }
    }
}
