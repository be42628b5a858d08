//! Records at another sample rate.

use std::f64::consts::PI;
use std::ops::Range;

use super::time_base::check_rate;
use super::{Channel, ChannelChoice, Gap, InputOutput, Quantity, Record, RecordError, TimeBase};

/// Zero crossings of the interpolating kernel on either side.
const HALF_WIDTH: f64 = 32.0;
/// Shape of its Kaiser window: side lobes below −90 dB.
const KAISER_BETA: f64 = 9.0;
/// Cut-off as a fraction of the lower of the two Nyquist frequencies.
const PASSBAND: f64 = 0.92;
/// Share of the shortest intervals between stamps that counts as jitter, not as a rate.
const SHARE_OF_SHORT_PERIODS: f64 = 0.02;
/// A channel of labels changes in at most one of this many steps.
const LABEL_STEPS: usize = 100;
/// Most samples of a resampled record, and of the grid between.
const MAX_SAMPLES: f64 = (1u64 << 29) as f64;
/// Most samples of the finer grid for each new one.
const FINEST: f64 = 4096.0;

impl Record {
    /// The record at another sample rate, over the same time: its channels as [`InputOutput::resampled`]. But
    /// a channel of labels (the number of a segment, the frequency in it), which a filter would smear, keeps
    /// its last value until the next: one that changes in at most one of a hundred steps, and is no voltage,
    /// length or angle, and not the input or output by the rules of [`Record::select`].
    ///
    /// # Errors
    /// Those of [`InputOutput::resampled`].
    pub fn resampled(&self, sample_rate_hz: f64) -> Result<Record, RecordError> {
        let columns: Vec<&[f64]> = self.channels.iter().map(|c| c.samples.as_slice()).collect();
        let new = match resampled(&self.name, &self.time, self.valid.as_deref(), &columns, sample_rate_hz)? {
            Some(new) => new,
            None => return Ok(self.clone()),
        };
        let mut record = Record { time: new.time, valid: new.valid, ..self.clone() };
        let chosen = self.select(&ChannelChoice::default()).ok();
        for (index, (channel, samples)) in record.channels.iter_mut().zip(new.columns).enumerate() {
            let is_signal = chosen.as_ref().is_some_and(|c| [c.input, c.output].contains(&index));
            channel.samples = if !is_signal && holds_labels(channel) {
                let last = channel.samples.len().saturating_sub(1);
                // A place that rounding alone puts before a sample is that sample's.
                let before = |place: &f64| ((place + 1e-9) as usize).min(last);
                new.places.iter().map(|place| channel.samples[before(place)]).collect()
            } else {
                samples
            };
        }
        Ok(record)
    }
}

/// True if the samples of a channel are labels rather than a signal.
fn holds_labels(channel: &Channel) -> bool {
    let changes = channel.samples.windows(2).filter(|two| two[0] != two[1]).count();
    channel.unit.base().0 == Quantity::Other && changes * LABEL_STEPS < channel.samples.len()
}

impl InputOutput {
    /// The record at another sample rate, over the same time.
    ///
    /// Uniform samples are interpolated with a Kaiser-windowed sinc of 2 · 32 zero crossings, cut off at 0.92
    /// of the lower Nyquist frequency (so nothing aliases); within that distance of the ends the kernel is
    /// truncated and scaled to unit gain at zero frequency. Measured on a sine at 0.4 of the old rate's
    /// Nyquist frequency: error below 1e-4 of the amplitude, away from the ends. A new sample is valid where
    /// its two old neighbours are.
    ///
    /// Non-uniform samples are split at their gaps ([`TimeBase::gaps`]). A uniform part is treated as above.
    /// Any other is interpolated linearly (through the mean where stamps are equal) to a multiple of the new
    /// rate that resolves its closest samples, and then filtered to the new rate as above: nothing aliases,
    /// but linear interpolation attenuates near the Nyquist frequency of the old samples. Samples within a
    /// gap lie on the straight line across it and are not valid.
    ///
    /// # Errors
    /// [`RecordError::BadSampleRate`]; [`RecordError::NoTimes`] without a time base;
    /// [`RecordError::TooShort`] where fewer than two samples would remain; [`RecordError::BadSetting`] above
    /// 2²⁹ samples.
    pub fn resampled(&self, sample_rate_hz: f64) -> Result<InputOutput, RecordError> {
        let mut columns = vec![self.u.as_slice(), self.y.as_slice()];
        columns.extend(self.rate.as_deref());
        let Some(new) = resampled(&self.name, &self.time, self.valid.as_deref(), &columns, sample_rate_hz)?
        else {
            return Ok(self.clone());
        };
        let mut columns = new.columns.into_iter();
        Ok(InputOutput {
            time: new.time,
            u: columns.next().unwrap_or_default(),
            y: columns.next().unwrap_or_default(),
            rate: columns.next(),
            valid: new.valid,
            ..self.without_samples()
        })
    }

    /// Every `factor`-th sample, after an anti-alias low-pass (see [`InputOutput::resampled`]).
    ///
    /// # Errors
    /// Those of [`InputOutput::resampled`]; [`RecordError::BadSetting`] for a factor of 0.
    pub fn decimated(&self, factor: usize) -> Result<InputOutput, RecordError> {
        if factor == 0 {
            return Err(RecordError::BadSetting {
                record: self.name.clone(),
                setting: "decimation factor",
                value: 0.0,
                allowed: "it must be at least 1",
            });
        }
        self.resampled(self.require_sample_rate_hz("decimation")? / factor as f64)
    }
}

/// Columns on another grid.
struct Resampled {
    time: TimeBase,
    columns: Vec<Vec<f64>>,
    /// Places of the new samples, in indices of the old ones.
    places: Vec<f64>,
    valid: Option<Vec<bool>>,
}

/// The columns at another rate; `None` where they have it.
fn resampled(
    name: &str,
    time: &TimeBase,
    valid: Option<&[bool]>,
    columns: &[&[f64]],
    sample_rate_hz: f64,
) -> Result<Option<Resampled>, RecordError> {
    check_rate(name, sample_rate_hz)?;
    let n = columns.iter().map(|x| x.len()).min().unwrap_or(0);
    if matches!(time, TimeBase::Uniform { sample_rate_hz: old, .. } if *old == sample_rate_hz) {
        return Ok(None);
    }
    let (Some(start), Some(end)) = (time.time_s(0), time.time_s(n.saturating_sub(1))) else {
        return Err(RecordError::NoTimes { record: name.to_owned(), purpose: "resampling" });
    };
    // A last sample that rounding alone puts beyond the end is kept.
    let intervals = ((end - start) * sample_rate_hz * (1.0 + 1e-12) + 1e-9).floor();
    if n < 2 || intervals < 1.0 {
        return Err(RecordError::TooShort {
            record: name.to_owned(),
            got: intervals as usize + 1,
            need: 2,
            purpose: "resampling to this rate",
        });
    }
    if intervals >= MAX_SAMPLES {
        return Err(RecordError::BadSetting {
            record: name.to_owned(),
            setting: "sample rate",
            value: sample_rate_hz,
            allowed: "the new record must stay below 2^29 samples",
        });
    }
    let count = intervals as usize + 1;
    let new_time = TimeBase::Uniform { start_s: start, sample_rate_hz, jitter_samples: 0.0 };
    let (places, columns, in_gap) = match time {
        TimeBase::NonUniform { times_s } => {
            let new = NonUniform { times_s, columns, start_s: start, sample_rate_hz };
            new.resampled(count, &time.gaps())
        }
        _ => {
            let old = match time {
                TimeBase::Uniform { sample_rate_hz: old, .. } => *old,
                _ => sample_rate_hz,
            };
            let ratio = old / sample_rate_hz;
            let places: Vec<f64> = (0..count).map(|i| (i as f64 * ratio).min((n - 1) as f64)).collect();
            let columns = filtered(columns, &places, PASSBAND * (1.0 / ratio).min(1.0));
            (places, columns, Vec::new())
        }
    };
    let is_valid = |k: f64| valid.is_none_or(|valid| valid.get(k as usize).copied().unwrap_or(true));
    let valid = (valid.is_some() || in_gap.contains(&true)).then(|| {
        let mask = places.iter().enumerate();
        mask.map(|(i, p)| {
            is_valid(p.floor()) && is_valid(p.ceil()) && !in_gap.get(i).copied().unwrap_or(false)
        })
        .collect()
    });
    Ok(Some(Resampled { time: new_time, columns, places, valid }))
}

/// Non-uniform samples and the grid that they are to be on.
struct NonUniform<'a> {
    times_s: &'a [f64],
    columns: &'a [&'a [f64]],
    start_s: f64,
    sample_rate_hz: f64,
}

impl NonUniform<'_> {
    /// Places of the new samples among the old ones, their values, and whether each lies in a gap.
    fn resampled(&self, count: usize, gaps: &[Gap]) -> (Vec<f64>, Vec<Vec<f64>>, Vec<bool>) {
        let grid: Vec<f64> = (0..count).map(|i| self.start_s + i as f64 / self.sample_rate_hz).collect();
        let places = places_in(self.times_s, &grid);
        let mut columns: Vec<Vec<f64>> =
            self.columns.iter().map(|x| places.iter().map(|&place| by_line(x, place)).collect()).collect();
        let ends = gaps.iter().map(|gap| gap.after + 1).chain([self.times_s.len()]);
        let mut begin = 0;
        for end in ends {
            let part = begin..end;
            // New samples from the first old one of the part to its last.
            let new = places.partition_point(|p| *p < begin as f64)
                ..places.partition_point(|p| *p <= (end - 1) as f64);
            if let Some(values) = self.part(part, &grid[new.clone()]) {
                for (column, values) in columns.iter_mut().zip(values) {
                    column[new.clone()].copy_from_slice(&values);
                }
            }
            begin = end;
        }
        let within = |place: &f64| {
            let gap = gaps.partition_point(|gap| (gap.after as f64) < *place);
            gap > 0 && *place < gaps[gap - 1].after as f64 + 1.0
        };
        let in_gap = places.iter().map(within).collect();
        (places, columns, in_gap)
    }

    /// Filtered values of a part without gaps at the times of `grid`; `None` where only linear interpolation
    /// is possible.
    fn part(&self, part: Range<usize>, grid: &[f64]) -> Option<Vec<Vec<f64>>> {
        let times = &self.times_s[part.clone()];
        let columns: Vec<&[f64]> = self.columns.iter().map(|x| &x[part.clone()]).collect();
        let (&first, &last) = (times.first()?, times.last()?);
        let origin = *grid.first()?;
        if let Ok(TimeBase::Uniform { start_s, sample_rate_hz: old, .. }) =
            TimeBase::from_times("", times.to_vec())
        {
            let most = (times.len() - 1) as f64;
            let places: Vec<f64> = grid.iter().map(|t| ((t - start_s) * old).clamp(0.0, most)).collect();
            return Some(filtered(&columns, &places, PASSBAND * (self.sample_rate_hz / old).min(1.0)));
        }
        let finer = (1.0 / (shortest_period(times)? * self.sample_rate_hz)).ceil().min(FINEST);
        if finer <= 1.0 || (last - first) * self.sample_rate_hz * finer >= MAX_SAMPLES {
            return None;
        }
        let fine_rate = self.sample_rate_hz * finer;
        let before = ((origin - first) * fine_rate + 1e-9).floor();
        let fine_start = origin - before / fine_rate;
        let intervals = ((last - fine_start) * fine_rate + 1e-9).floor() as usize;
        let fine: Vec<f64> = (0..=intervals).map(|i| fine_start + i as f64 / fine_rate).collect();
        let fine_places = places_in(times, &fine);
        let lines: Vec<Vec<f64>> =
            columns.iter().map(|x| fine_places.iter().map(|&place| by_line(x, place)).collect()).collect();
        let lines: Vec<&[f64]> = lines.iter().map(Vec::as_slice).collect();
        let places: Vec<f64> =
            (0..grid.len()).map(|i| (before + i as f64 * finer).min(intervals as f64)).collect();
        Some(filtered(&lines, &places, PASSBAND / finer))
    }
}

/// Shortest interval between stamps that is not jitter \[s\].
fn shortest_period(times_s: &[f64]) -> Option<f64> {
    let mut periods: Vec<f64> =
        times_s.windows(2).map(|two| two[1] - two[0]).filter(|period| *period > 0.0).collect();
    let rank = (SHARE_OF_SHORT_PERIODS * periods.len() as f64) as usize;
    (rank < periods.len()).then(|| *periods.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// Places of increasing times among stamps, in indices of these; within the stamps. The middle between equal
/// ones.
fn places_in(times_s: &[f64], at: &[f64]) -> Vec<f64> {
    let n = times_s.len();
    if n < 2 {
        return vec![0.0; at.len()];
    }
    let mut k = 0;
    let place = |&t: &f64| {
        while k + 2 < n && times_s[k + 1] < t {
            k += 1;
        }
        let width = times_s[k + 1] - times_s[k];
        k as f64 + if width > 0.0 { ((t - times_s[k]) / width).clamp(0.0, 1.0) } else { 0.5 }
    };
    at.iter().map(place).collect()
}

/// Columns at places between their samples, low-passed at `cutoff` (1: their Nyquist frequency):
/// Σ x_k h(place − k) / Σ h, h the windowed sinc.
fn filtered(columns: &[&[f64]], places: &[f64], cutoff: f64) -> Vec<Vec<f64>> {
    let n = columns.iter().map(|x| x.len()).min().unwrap_or(0);
    let reach = HALF_WIDTH / cutoff;
    let mut new = vec![Vec::with_capacity(places.len()); columns.len()];
    // The kernel depends only on the distance of a place from the sample before it.
    let (mut behind, mut lowest, mut kernel) = (f64::NAN, 0.0, Vec::new());
    for &place in places {
        if place - place.floor() != behind {
            behind = place - place.floor();
            lowest = (behind - reach).ceil();
            let reached = (behind + reach).floor() - lowest;
            kernel = (0..=reached as usize)
                .map(|i| windowed_sinc(behind - (lowest + i as f64), cutoff, reach))
                .collect();
        }
        let first = place.floor() + lowest;
        let skipped = (-first).max(0.0) as usize;
        let first = first.max(0.0) as usize;
        let kernel = kernel.get(skipped..).unwrap_or_default();
        let kernel = &kernel[..kernel.len().min(n.saturating_sub(first))];
        let gain: f64 = kernel.iter().sum();
        for (new, x) in new.iter_mut().zip(columns) {
            let sum: f64 = kernel.iter().zip(&x[first.min(x.len())..]).map(|(h, x)| h * x).sum();
            new.push(sum / gain);
        }
    }
    new
}

/// Anti-alias low-pass for decimation by `factor`: a Kaiser-windowed sinc that reaches `reach` new samples to
/// either side, an odd number of values with the sum 1. The stop band above half the new rate is attenuated
/// to 5e-5; the pass band, flat to 5e-5 (both from a reach of 16 on), ends at 0.5 − 2.87/reach of the new
/// rate.
#[doc(hidden)]
pub fn low_pass(factor: usize, reach: usize) -> Vec<f64> {
    // Kaiser's rule for the width of the transition, A = 90 dB: (A − 7.95)/14.36 over the length.
    let transition = (90.0 - 7.95) / 14.36 / (2 * reach) as f64;
    let cutoff = (1.0 - transition) / factor as f64;
    let half = (reach * factor) as i32;
    let mut kernel: Vec<f64> =
        (-half..=half).map(|j| windowed_sinc(f64::from(j), cutoff, f64::from(half))).collect();
    let gain: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|h| *h /= gain);
    kernel
}

/// Value between samples by linear interpolation.
fn by_line(x: &[f64], place: f64) -> f64 {
    let k = (place.floor() as usize).min(x.len().saturating_sub(2));
    let t = place - k as f64;
    (1.0 - t) * x[k] + t * x[k + 1]
}

/// The sinc with cut-off `cutoff` (1: the Nyquist frequency) at `d` samples, times Kaiser's window.
fn windowed_sinc(d: f64, cutoff: f64, reach: f64) -> f64 {
    let a = PI * cutoff * d;
    let sinc = if a == 0.0 { 1.0 } else { a.sin() / a };
    sinc * bessel_i0(KAISER_BETA * (1.0 - (d / reach).powi(2)).max(0.0).sqrt())
}

/// Modified Bessel function I₀ by its power series (all terms positive; 40 of them suffice to 1e-15 below
/// 10).
fn bessel_i0(x: f64) -> f64 {
    let quarter = 0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..40 {
        term *= quarter / f64::from(k * k);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests;
