//! The force over a record.

use std::borrow::Cow;

use super::{ForceModel, ForceModelError, Saturation, rate_of};
use crate::hysteresis::DriveGrid;
use crate::record::TimeBase;
use crate::start::Start;

/// A displacement in time.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Displacement x \[µm\].
    pub x: &'a [f64],
    /// Its rate where it was measured \[µm/s\]; otherwise it is computed from x.
    pub rate: Option<&'a [f64]>,
    /// When the samples were taken.
    pub time: &'a TimeBase,
}

impl Motion<'_> {
    /// The rate, as measured or else of the displacement over this window.
    ///
    /// # Errors
    /// [`ForceModelError`]: no times, another length, a sample that is not finite.
    pub fn rate(&self, window_s: f64) -> Result<Cow<'_, [f64]>, ForceModelError> {
        finite("displacement", self.x)?;
        let Some(rate) = self.rate else {
            return rate_of(self.x, self.time, window_s).map(Cow::Owned);
        };
        if rate.len() != self.x.len() {
            return Err(ForceModelError::RateLength { expected: self.x.len(), found: rate.len() });
        }
        finite("rate", rate)?;
        Ok(Cow::Borrowed(rate))
    }

    /// Seconds from each sample to the next.
    fn intervals_s(&self) -> Result<Vec<f64>, ForceModelError> {
        let times = (0..self.x.len()).map(|k| self.time.time_s(k)).collect::<Option<Vec<f64>>>();
        let times = times.ok_or(ForceModelError::NoTimes)?;
        Ok(times.windows(2).map(|two| two[1] - two[0]).collect())
    }
}

fn finite(signal: &'static str, samples: &[f64]) -> Result<(), ForceModelError> {
    match samples.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(ForceModelError::Sample { signal, index, value: samples[index] }),
        None => Ok(()),
    }
}

/// Periods of a settled start that are simulated before the record.
const SETTLING_PERIODS: usize = 5;

impl ForceModel {
    /// Force at every sample, from rest at the first one, or settled on a period: after five of them.
    ///
    /// # Errors
    /// [`ForceModelError`].
    pub fn simulate(&self, motion: &Motion<'_>, start: Start) -> Result<Vec<f64>, ForceModelError> {
        self.validate()?;
        let samples = motion.x.len();
        let period_samples = match start {
            Start::AsIdentified => return self.simulate_from_rest(motion),
            Start::Rest { .. } | Start::Remembering { .. } => return Err(ForceModelError::Start),
            Start::Settled { period_samples, .. } => period_samples.unwrap_or(samples),
        };
        let period = motion.x.get(..period_samples).filter(|period| period.len() >= 2);
        let period = period.ok_or(ForceModelError::Period { samples, period_samples })?;
        let prologue = SETTLING_PERIODS * period_samples;
        let before = |signal: &[f64]| -> Vec<f64> {
            let period = signal.iter().take(period_samples);
            period.cycle().take(prologue).chain(signal).copied().collect()
        };
        let x = [period.repeat(SETTLING_PERIODS), motion.x.to_vec()].concat();
        let rate = if self.needs_rate() { Some(motion.rate(self.rate_window_s)?) } else { None };
        let rate = rate.map(|rate| before(&rate));
        let time = match motion.time {
            TimeBase::NonUniform { times_s } => {
                let spans = times_s.iter().take(period_samples).map(|t| t - times_s[0]);
                let spans: Vec<f64> = spans.collect();
                let (last, first) = (spans[period_samples - 1], spans[1]);
                let period_s = last + first;
                let periods = (0..SETTLING_PERIODS).map(|i| (i as f64 - SETTLING_PERIODS as f64) * period_s);
                let earlier = periods.flat_map(|shift| spans.iter().map(move |t| times_s[0] + t + shift));
                TimeBase::NonUniform { times_s: earlier.chain(times_s.iter().copied()).collect() }
            }
            time => time.clone(),
        };
        let longer = Motion { x: &x, rate: rate.as_deref(), time: &time };
        Ok(self.simulate_from_rest(&longer)?.split_off(prologue))
    }

    /// Force from rest at the first sample.
    fn simulate_from_rest(&self, motion: &Motion<'_>) -> Result<Vec<f64>, ForceModelError> {
        let mut force = vec![0.0; motion.x.len()];
        let sample_rate_hz = match motion.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(*sample_rate_hz),
            TimeBase::NonUniform { .. } | TimeBase::Unknown => None,
        };
        let grid = DriveGrid::new(sample_rate_hz, 1, 1);
        self.hysteresis.simulate_every(grid, motion.x, Start::AsIdentified, &mut force)?;
        force.iter_mut().for_each(|f| *f += self.offset);
        if !self.needs_rate() {
            return Ok(force);
        }
        let rate = motion.rate(self.rate_window_s)?;
        force.iter_mut().zip(rate.iter()).for_each(|(f, v)| *f += self.viscous * v);
        for saturation in &self.saturating {
            let s = saturation.shares(motion, &rate)?;
            force.iter_mut().zip(s).for_each(|(f, s)| *f += saturation.force * s);
        }
        Ok(force)
    }
}

impl Saturation {
    /// s at every sample, from rest (s = 0) at the first one.
    ///
    /// # Errors
    /// [`ForceModelError::NoTimes`].
    pub fn shares(&self, motion: &Motion<'_>, rate: &[f64]) -> Result<Vec<f64>, ForceModelError> {
        let intervals = motion.intervals_s()?;
        let mut w = if self.reach == 0.0 { rate.first().map_or(0.0, |v| v / self.rate) } else { 0.0 };
        let mut shares = Vec::with_capacity(rate.len());
        shares.extend(rate.first().map(|_| w.tanh()));
        for (two, interval) in rate.windows(2).zip(intervals) {
            w = self.moved(w, [two[0], two[1]], interval);
            shares.push(w.tanh());
        }
        Ok(shares)
    }
}
