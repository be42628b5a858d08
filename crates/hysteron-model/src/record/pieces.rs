//! Uniformly sampled segments within time stamps.

use std::ops::Range;

use super::TimeBase;

/// Largest deviation from an even grid within a piece, in its periods: the rounding of a logger's stamps.
/// Neighbouring segments whose rates differ by more are separated at their first sample.
const TOLERANCE_PERIODS: f64 = 0.01;
/// Fewest samples of a piece; shorter ones are single stamps.
const FEWEST_SAMPLES: usize = 8;
/// A step longer than this many periods of the pieces beside it is a gap.
pub const GAP_PERIODS: f64 = 3.0;

/// Samples taken at one rate, without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct UniformSegment {
    /// Samples of the record.
    pub samples: Range<usize>,
    /// Time of the first one \[s\].
    pub start_s: f64,
    /// Time from one to the next \[s\]; 0 for a single stamp.
    pub period_s: f64,
}

impl UniformSegment {
    /// Sample rate \[Hz\]; `None` for a single stamp.
    pub fn sample_rate_hz(&self) -> Option<f64> {
        (self.period_s > 0.0).then(|| 1.0 / self.period_s)
    }

    /// Time from its first to its last sample \[s\].
    pub fn duration_s(&self) -> f64 {
        (self.samples.len().max(1) - 1) as f64 * self.period_s
    }
}

impl TimeBase {
    /// The pieces of a base of this many samples, in their order: one where it is uniform, none where it is
    /// unknown.
    pub fn pieces(&self, samples: usize) -> Vec<UniformSegment> {
        match self {
            Self::Uniform { start_s, sample_rate_hz, .. } => {
                vec![UniformSegment {
                    samples: 0..samples,
                    start_s: *start_s,
                    period_s: 1.0 / sample_rate_hz,
                }]
            }
            Self::NonUniform { times_s } => pieces(times_s).collect(),
            Self::Unknown => Vec::new(),
        }
    }

    /// Times of the samples \[s\], within pieces on their even grid, so that rounding of the stamps is no
    /// jitter. `None` where they are unknown.
    pub fn times_s(&self, samples: usize) -> Option<Vec<f64>> {
        if *self == Self::Unknown {
            return None;
        }
        Some(times_of(self.pieces(samples).into_iter(), samples))
    }

    /// Shortest time between samples that many of them have \[s\]: that of the fastest piece, or the median
    /// of single stamps. `None` where it is unknown.
    pub fn shortest_period_s(&self, samples: usize) -> Option<f64> {
        if let Self::NonUniform { times_s } = self {
            let pieces = pieces(times_s).map(|piece| piece.period_s);
            let fastest = pieces.filter(|period| *period > 0.0).min_by(f64::total_cmp);
            return fastest.or_else(|| {
                let mut steps: Vec<f64> = times_s.windows(2).map(|two| two[1] - two[0]).collect();
                steps.retain(|step| *step > 0.0);
                steps.sort_by(f64::total_cmp);
                steps.get(steps.len() / 2).copied()
            });
        }
        self.pieces(samples).first().map(|piece| piece.period_s)
    }
}

/// Stamps on the even grids of their pieces.
pub fn even_times(times_s: &[f64]) -> Vec<f64> {
    times_of(pieces(times_s), times_s.len())
}

fn times_of(pieces: impl Iterator<Item = UniformSegment>, samples: usize) -> Vec<f64> {
    let mut times_s = Vec::with_capacity(samples);
    for UniformSegment { samples, start_s, period_s } in pieces {
        times_s.extend((0..samples.len()).map(|k| start_s + k as f64 * period_s));
    }
    times_s
}

fn pieces(times_s: &[f64]) -> impl Iterator<Item = UniformSegment> {
    // Next sample, and the end of the single stamps found.
    let (mut next, mut singles_end) = (0, 0);
    std::iter::from_fn(move || {
        let from = next;
        let start_s = *times_s.get(from)?;
        if from >= singles_end {
            let end = end_of_piece(times_s, from);
            if end - from >= FEWEST_SAMPLES {
                next = end;
                let period_s = (times_s[end - 1] - start_s) / (end - 1 - from) as f64;
                return Some(UniformSegment { samples: from..end, start_s, period_s });
            }
            singles_end = end;
        }
        next += 1;
        Some(UniformSegment { samples: from..next, start_s, period_s: 0.0 })
    })
}

/// One past the last sample that lies on the even grid through those from `from` on.
fn end_of_piece(times_s: &[f64], from: usize) -> usize {
    // Bounds of the period that every stamp so far allows.
    let (mut low, mut high) = (0.0, f64::INFINITY);
    let mut end = from + 1;
    while let Some(time) = times_s.get(end) {
        let (elapsed, count) = (time - times_s[from], (end - from) as f64);
        let period = elapsed / count;
        let slack = TOLERANCE_PERIODS * period / count;
        let (next_low, next_high) = (f64::max(low, period - slack), f64::min(high, period + slack));
        if next_low > next_high || elapsed <= 0.0 {
            break;
        }
        (low, high) = (next_low, next_high);
        end += 1;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(start_s: f64, period_s: f64, count: usize, digits: usize) -> Vec<f64> {
        let stamp = |k: usize| format!("{:.digits$}", start_s + k as f64 * period_s).parse().unwrap();
        (0..count).map(stamp).collect()
    }

    #[test]
    fn segments_of_different_rates_are_told_apart_at_their_first_sample() {
        // Rates of an AFM scanner, stamps rounded to 0.1 µs: 2 kHz, 2048 Hz, a gap, 30 kHz, 600 Hz.
        let parts = [
            segment(0.0, 5e-4, 1200, 7),
            segment(0.6, 1.0 / 2048.0, 1024, 7),
            segment(1.15, 1.0 / 30_000.0, 2000, 7),
            segment(1.15 + 2000.0 / 30_000.0, 1.0 / 600.0, 2000, 7),
        ];
        let pieces = TimeBase::NonUniform { times_s: parts.concat() }.pieces(6224);
        let lengths: Vec<usize> = pieces.iter().map(|piece| piece.samples.len()).collect();
        // The first sample of the next segment lies on the grid of the one before it where there is no gap.
        let expected = [1201, 1023, 2001, 1999];
        let near = |(a, b): (&usize, &usize)| a.abs_diff(*b) <= 1;
        assert!(lengths.len() == 4 && lengths.iter().zip(&expected).all(near), "{lengths:?}");
        for (piece, rate) in pieces.iter().zip([2000.0, 2048.0, 30_000.0, 600.0]) {
            assert!((piece.sample_rate_hz().unwrap() / rate - 1.0).abs() < 1e-5, "{piece:?}");
        }
        let times = TimeBase::NonUniform { times_s: parts.concat() }.times_s(6224).unwrap();
        let moved = times.iter().zip(parts.concat()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(moved < 2e-7, "{moved}");
    }

    #[test]
    fn irregular_stamps_are_single_and_kept_to_the_last_bit() {
        let times_s: Vec<f64> = (0..50).map(|k| f64::from(k) + 0.3 * (f64::from(k) * 1.7).sin()).collect();
        let base = TimeBase::NonUniform { times_s: times_s.clone() };
        assert!(base.pieces(50).iter().filter(|piece| piece.period_s == 0.0).count() > 40);
        let kept = base.times_s(50).unwrap();
        assert!(kept.iter().zip(&times_s).all(|(a, b)| (a - b).abs() < 0.01));
    }
}
