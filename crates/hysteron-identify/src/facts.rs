//! Facts of a record that an identification needs before any fit.

use super::IdentifyError;
use hysteron_model::record::{
    InputOutput, Periods, Swings, TimeBase, Timing, find_periods, range_of, shortest_swing, span,
    turning_points,
};
use hysteron_model::validate::{first_cycle, settled_period, settling_samples};

/// Swings whose size differs by less than this share of the range count as one amplitude.
const ONE_AMPLITUDE: f64 = 0.05;
/// Swings below this share of the range are noise rather than loops.
const SMALLEST_LOOP: f64 = 0.1;

/// A record is dynamic relative to one whose fastest swing is slower by this factor.
const FASTER: f64 = 3.0;

/// … or if its own swings above this share of its range, at least this many, differ in speed by that factor.
const WIDE: f64 = 0.5;
const FEWEST_SWINGS: usize = 5;
/// Fewest cycles that allow leaving out the first.
const SEVERAL_CYCLES: usize = 3;
/// A drive that stays within this share of its range rests.
const AT_REST: f64 = 0.01;

/// A record and quantities derived from it.
#[derive(Clone, Debug)]
pub(super) struct RecordFacts {
    pub(super) data: InputOutput,
    /// Lowest and highest value of the drive.
    pub(super) ends: (f64, f64),
    pub(super) periods: Option<Periods>,
    /// Shortest time between two reversals of the drive, in samples (its 10 % quantile).
    pub(super) shortest_swing: usize,
    /// Frequencies of its swings where it is non-uniformly sampled.
    pub(super) swings: Option<Swings>,
}

impl RecordFacts {
    pub(super) fn new(data: InputOutput) -> Self {
        let ends = range_of(&data.u);
        let periods = find_periods(&data).ok();
        let shortest_swing = shortest_swing(&data.u);
        let uneven = matches!(data.time, TimeBase::NonUniform { .. });
        let swings = if uneven { Swings::of(&data.u, &data.time) } else { None };
        Self { data, ends, periods, shortest_swing, swings }
    }

    /// These facts with the first `samples` not valid.
    pub(super) fn without_first(&self, samples: usize) -> Self {
        Self { data: self.data.without_first(samples), ..self.clone() }
    }

    /// Number of initial samples to score: `most`, or the whole record where these hold fewer than two valid
    /// ones.
    pub(super) fn beginning(&self, most: usize) -> usize {
        let scored = self.scored(0);
        if scored.get(1).is_some_and(|&second| second < most) {
            self.data.y.len().min(most)
        } else {
            self.data.y.len()
        }
    }

    pub(super) fn range_v(&self) -> f64 {
        self.ends.1 - self.ends.0
    }

    /// The drive's samples.
    pub(super) fn drive(&self) -> &[f64] {
        &self.data.u
    }

    /// max y − min y over the valid samples.
    pub(super) fn stroke(&self) -> f64 {
        let valid: Vec<f64> = self.scored(0).iter().map(|&k| self.data.y[k]).collect();
        span(&valid)
    }

    /// Samples of a period, where the drive repeats from the first sample on or the record is one closed
    /// loop.
    pub(super) fn period_samples(&self) -> Option<usize> {
        settled_period(&self.data, self.periods)
    }

    /// Samples before the drive first moves (beyond a noise of [`AT_REST`]); 0 where that is within a quarter
    /// of a swing.
    pub(super) fn samples_at_rest(&self) -> usize {
        let u = &self.data.u;
        let near = AT_REST * self.range_v();
        let still = u.iter().take_while(|x| (**x - u[0]).abs() <= near).count();
        if still > 3 + self.shortest_swing / 4 { still } else { 0 }
    }

    /// True if the drive leaves its rest with a step above this share of its range.
    pub(super) fn jumps_after_rest(&self, share: f64) -> bool {
        let first = self.samples_at_rest();
        let step = self.data.u.get(first).map_or(0.0, |x| (x - self.data.u[0]).abs());
        step > share * self.range_v()
    }

    /// Samples of the first cycle of a non-uniformly sampled record that holds several.
    pub(super) fn first_of_several_cycles(&self) -> Option<usize> {
        first_cycle(&self.data).filter(|cycle| self.data.len() >= SEVERAL_CYCLES * cycle)
    }

    /// Cycles of a non-uniformly sampled record; 1 where it holds fewer than [`SEVERAL_CYCLES`].
    pub(super) fn cycles(&self) -> usize {
        let of = |cycle: usize| (self.data.len() as f64 / cycle as f64).round() as usize;
        self.first_of_several_cycles().map_or(1, of)
    }

    pub(super) fn whole_periods(&self) -> usize {
        self.periods.map_or(0, |p| p.count)
    }

    /// Longest time scale of one cycle \[s\]: the period, or twice the shortest swing.
    pub(super) fn period_s(&self) -> f64 {
        if let Some(Swings { slowest_hz, .. }) = self.swings {
            return 1.0 / slowest_hz;
        }
        let samples = self.periods.map_or(2.0 * self.shortest_swing as f64, |p| p.period_samples);
        samples / self.data.sample_rate_hz().unwrap_or(1.0)
    }

    /// Frequency of the fastest swing \[Hz\]; 0 without a time base.
    pub(super) fn highest_frequency_hz(&self) -> f64 {
        if let Some(Swings { fastest_hz, .. }) = self.swings {
            return fastest_hz;
        }
        self.data.sample_rate_hz().map_or(0.0, |rate| rate / (2.0 * self.shortest_swing as f64))
    }

    /// True if the record is dynamic relative to one whose fastest swing has the frequency `slowest_hz`.
    pub(super) fn is_dynamic(&self, slowest_hz: f64) -> bool {
        self.highest_frequency_hz() > FASTER * slowest_hz
    }

    /// True if its wide swings differ widely in speed, as in a sweep or a random drive: such a record by
    /// itself determines dynamics.
    pub(super) fn is_broad(&self) -> bool {
        if let Some(Swings { slowest_hz, fastest_hz }) = self.swings {
            return fastest_hz > FASTER * slowest_hz;
        }
        let turns = turning_points(&self.data.u, WIDE * self.range_v());
        let mut swings: Vec<usize> = turns.windows(2).map(|w| w[1].index - w[0].index).collect();
        swings.sort_unstable();
        let at = |tenths: usize| swings[swings.len() * tenths / 10] as f64;
        swings.len() >= FEWEST_SWINGS && self.data.sample_rate_hz().is_some() && at(9) > FASTER * at(1)
    }

    /// Indices of the samples that are valid and not among the first `left_out`.
    pub(super) fn scored(&self, left_out: usize) -> Vec<usize> {
        let valid = |k: usize| self.data.is_valid(k);
        (left_out..self.data.y.len()).filter(|&k| valid(k)).collect()
    }

    /// Samples after which a model without dynamics may be compared with a record that starts with a jump.
    pub(super) fn settling_samples(&self) -> usize {
        settling_samples(&self.data.u, self.shortest_swing)
    }

    /// Times of its samples, and the sample rate of its fastest part \[Hz\].
    pub(super) fn require_timing(&self) -> Result<(Timing<'_>, f64), IdentifyError> {
        match (&self.data.time, self.data.time.shortest_period_s(self.data.len())) {
            (base @ TimeBase::NonUniform { .. }, Some(period_s)) => Ok((base.into(), 1.0 / period_s)),
            _ => self.require_sample_rate().map(|rate| (Timing::Rate(rate), rate)),
        }
    }

    /// Time from the first to one past the last sample \[s\].
    pub(super) fn duration_s(&self) -> f64 {
        let samples = self.data.len();
        match self.data.time.extent_s(samples) {
            Some((first, last)) if self.swings.is_some() => last - first,
            _ => self.data.sample_rate_hz().map_or(0.0, |rate| samples as f64 / rate),
        }
    }

    pub(super) fn require_sample_rate(&self) -> Result<f64, IdentifyError> {
        self.data.sample_rate_hz().ok_or_else(|| IdentifyError::NotUniform {
            record: self.data.name.clone(),
            found: match self.data.time {
                TimeBase::NonUniform { .. } => "non-uniform time stamps",
                _ => "no time column and no sample rate",
            },
        })
    }
}

/// Number of distinct loop amplitudes in all drives together.
pub(super) fn amplitudes<'a>(drives: impl Iterator<Item = &'a [f64]> + Clone) -> usize {
    let range = drives.clone().map(span).fold(0.0, f64::max);
    let mut sizes: Vec<f64> = drives
        .flat_map(|drive| {
            let turns = turning_points(drive, SMALLEST_LOOP * range);
            turns.windows(2).map(|w| (w[1].value - w[0].value).abs()).collect::<Vec<_>>()
        })
        .collect();
    sizes.sort_by(f64::total_cmp);
    let mut count = usize::from(!sizes.is_empty());
    let mut last = sizes.first().copied().unwrap_or(0.0);
    for size in sizes {
        if size - last > ONE_AMPLITUDE * range {
            count += 1;
            last = size;
        }
    }
    count
}
