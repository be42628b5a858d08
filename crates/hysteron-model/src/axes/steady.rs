//! The mean period of a record whose inputs repeat.

use nalgebra::RealField;

use super::{AxesError, AxesRecord};
use crate::record::{InputOutput, find_periods};

/// Largest deviation of all periods together from whole samples at which a period counts as whole.
const WHOLE: f64 = 0.1;
/// Least similarity of every input with itself one period later at which the inputs count as periodic (1:
/// exact).
const REPEATS: f64 = 0.98;

/// One period of a record in its steady state: the mean over the settled periods. Samples are interleaved,
/// all channels of the first sample first.
#[derive(Clone, Debug, PartialEq)]
pub struct SteadyPeriod {
    /// Name of the record.
    pub name: String,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Inputs \[V\], their mean over the period left as it is.
    pub u: Vec<f64>,
    /// Outputs \[µm\], less the mean of each.
    pub y: Vec<f64>,
    /// Means removed from the outputs.
    pub offset: Vec<f64>,
    /// Periods averaged.
    pub averaged: usize,
    /// Periods before those, in which the output still settles.
    pub settling: usize,
    /// rms of the inputs about their means, over all of them \[V\]: the level of the record.
    pub level: f64,
}

impl SteadyPeriod {
    /// Finds the period that all inputs share and averages the periods in which the outputs have settled.
    ///
    /// `whole`: where no period is found, the whole record counts as one.
    ///
    /// # Errors
    /// [`AxesError::NotPeriodic`], [`AxesError::NoDrive`], [`AxesError::Masked`].
    pub fn find(record: &AxesRecord, whole: bool) -> Result<Self, AxesError> {
        let not_periodic = || AxesError::NotPeriodic { record: record.name.clone() };
        let moves = |x: &[f64]| x.windows(2).any(|w| w[0] != w[1]);
        let Some(first) = record.u.iter().find(|u| moves(u)) else {
            return Err(AxesError::NoDrive { record: record.name.clone() });
        };
        let mut found: Option<(usize, usize, usize)> = None;
        // Without outputs the drive is used in their place.
        let outputs = if record.y.is_empty() { std::slice::from_ref(first) } else { record.y.as_slice() };
        for y in outputs.iter().filter(|y| moves(y)) {
            let data = InputOutput::new(&record.name, record.time.clone(), first.clone(), y.clone())?;
            let periods = find_periods(&data).ok().filter(|p| p.start == 0 && p.count >= 2);
            let Some(p) = periods else { continue };
            let samples = p.period_samples.round();
            if (p.period_samples - samples).abs() * p.count as f64 <= WHOLE {
                let settling = p.settling_before_mean(y).max(found.map_or(0, |f| f.1));
                found = Some((samples as usize, settling, p.count));
            }
        }
        match found {
            Some((samples, settling, count)) if record.u.iter().all(|u| repeats(u, samples)) => {
                Self::mean(record, samples, settling, count)
            }
            _ if whole => Self::mean(record, record.len(), 0, 1),
            _ => Err(not_periodic()),
        }
    }

    /// The mean over periods `settling..count` of `samples` samples from the first on.
    ///
    /// # Errors
    /// [`AxesError::Masked`]; [`AxesError::Period`] where the record does not hold them.
    pub fn mean(
        record: &AxesRecord,
        samples: usize,
        settling: usize,
        count: usize,
    ) -> Result<Self, AxesError> {
        if samples < 2 || settling >= count || record.len() < samples * (settling + 1) {
            return Err(AxesError::Period { samples: record.len(), period_samples: samples });
        }
        let valid = |k: usize| record.valid.as_ref().is_none_or(|mask| mask.get(k) == Some(&true));
        let places = |k: usize| {
            (settling..count).map(move |p| p * samples + k).filter(|&i| i < record.len() && valid(i))
        };
        if let Some(sample) = (0..samples).find(|&k| places(k).next().is_none()) {
            return Err(AxesError::Masked { record: record.name.clone(), sample });
        }
        let (inputs, outputs) = (record.u.len(), record.y.len());
        let averaged = |channels: &[Vec<f64>]| -> Vec<f64> {
            let mean = |channel: &Vec<f64>, k: usize| {
                let (sum, n) = places(k).fold((0.0, 0.0), |(sum, n), i| (sum + channel[i], n + 1.0));
                sum / n
            };
            (0..samples).flat_map(|k| channels.iter().map(move |c| mean(c, k))).collect()
        };
        let u = averaged(&record.u);
        let mut y = averaged(&record.y);
        let offset = remove_means(&mut y, outputs);
        let level = level(&u, inputs);
        if level <= 0.0 {
            return Err(AxesError::NoDrive { record: record.name.clone() });
        }
        Ok(Self {
            name: record.name.clone(),
            sample_rate_hz: record.sample_rate_hz,
            inputs,
            outputs,
            u,
            y,
            offset,
            averaged: count - settling,
            settling,
            level,
        })
    }

    /// Samples of the period.
    pub fn samples(&self) -> usize {
        self.u.len() / self.inputs.max(1)
    }

    /// rms of the outputs about their means, over all of them.
    pub fn output_rms(&self) -> f64 {
        (self.y.iter().map(|y| y * y).sum::<f64>() / self.y.len().max(1) as f64).sqrt()
    }
}

/// Removes and returns the mean of each of `channels` interleaved channels.
#[doc(hidden)]
pub fn remove_means<T: RealField + Copy>(x: &mut [T], channels: usize) -> Vec<T> {
    let mut means = vec![T::zero(); channels];
    if channels == 0 {
        return means;
    }
    let samples: T = nalgebra::convert((x.len() / channels).max(1) as f64);
    for row in x.chunks_exact(channels) {
        means.iter_mut().zip(row).for_each(|(mean, x)| *mean += *x / samples);
    }
    for row in x.chunks_exact_mut(channels) {
        row.iter_mut().zip(&means).for_each(|(x, mean)| *x -= *mean);
    }
    means
}

/// rms about the means, over all channels.
pub(crate) fn level(u: &[f64], channels: usize) -> f64 {
    let mut centred = u.to_vec();
    remove_means(&mut centred, channels);
    (centred.iter().map(|u| u * u).sum::<f64>() / centred.len().max(1) as f64).sqrt()
}

/// True if `x` repeats after this number of samples, to its noise.
pub(crate) fn repeats(x: &[f64], period: usize) -> bool {
    similarity(x, period) >= REPEATS
}

/// 2Σ x_k x_(k+P) / Σ (x_k² + x_(k+P)²), mean removed; 1 for a constant.
fn similarity(x: &[f64], period: usize) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (mut product, mut power) = (0.0, 0.0);
    for (a, b) in x.iter().zip(x.get(period..).unwrap_or(&[])) {
        let (a, b) = (a - mean, b - mean);
        product += 2.0 * a * b;
        power += a * a + b * b;
    }
    if power > 0.0 { product / power } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{Channel, Record, TimeBase};

    fn record(second: impl Fn(usize) -> f64, samples: usize) -> AxesRecord {
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / 32.0;
        let of = |f: &dyn Fn(usize) -> f64| (0..samples).map(f).collect::<Vec<_>>();
        let channels = vec![
            Channel::new("u1", "V", of(&|k| turn(k).sin() + 0.4 * (3.0 * turn(k)).cos())),
            Channel::new("u2", "V", of(&second)),
            Channel::new("y1", "um", of(&|k| 2.0 + turn(k).cos())),
        ];
        let record = Record::new("r", TimeBase::uniform(10.0), channels).unwrap();
        AxesRecord::new(&record, &["u1".into(), "u2".into()], &["y1".into()]).unwrap()
    }

    #[test]
    fn the_mean_period_is_that_of_all_inputs_and_its_level_their_rms() {
        let turn = |k: usize| std::f64::consts::TAU * k as f64 / 32.0;
        let steady = SteadyPeriod::find(&record(|k| 5.0 + (2.0 * turn(k)).sin(), 128), false).unwrap();
        assert_eq!((steady.samples(), steady.averaged + steady.settling), (32, 4));
        // Mean squares 1/2 + 0.08 and 1/2 about the mean 5.
        assert!((steady.level - (1.08f64 / 2.0).sqrt()).abs() < 1e-12, "{}", steady.level);
        assert!((steady.offset[0] - 2.0).abs() < 1e-12 && (steady.y[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn inputs_of_different_periods_do_not_repeat() {
        let odd = record(|k| (std::f64::consts::TAU * k as f64 / 41.3).sin(), 128);
        assert!(matches!(SteadyPeriod::find(&odd, false), Err(AxesError::NotPeriodic { .. })));
        assert_eq!(SteadyPeriod::find(&odd, true).unwrap().samples(), 128);
    }

    #[test]
    fn a_sample_that_is_valid_in_one_period_is_taken_from_there() {
        let mut r = record(|_| 0.0, 128);
        let mut mask = vec![true; 128];
        mask[5] = false;
        r.y[0][5] = 1e9;
        r.valid = Some(mask);
        let steady = SteadyPeriod::mean(&r, 32, 0, 4).unwrap();
        assert!(steady.y.iter().all(|y| y.abs() < 1.001));
        r.valid = Some((0..128).map(|k| k % 32 != 5).collect());
        assert_eq!(
            SteadyPeriod::mean(&r, 32, 0, 4),
            Err(AxesError::Masked { record: "r".into(), sample: 5 })
        );
    }
}
