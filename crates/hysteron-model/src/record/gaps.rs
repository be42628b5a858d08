//! Pauses in a record.

use serde::{Deserialize, Serialize};

use super::TimeBase;
use super::turning_points::median;

/// An interval longer than this many of its neighbours' periods is a gap.
const LONGEST_PERIODS: f64 = 3.0;
/// Intervals on either side whose median is the period there.
const NEIGHBOURS: usize = 3;

/// A pause between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Index of the last sample before it.
    pub after: usize,
    /// Time of that sample \[s\].
    pub from_s: f64,
    /// Time of the next one \[s\].
    pub to_s: f64,
}

impl TimeBase {
    /// Gaps: intervals between stamps longer than three times the periods on both sides, where a period is
    /// the median of three intervals. A change of the rate is not a gap, nor are equal stamps of a coarse
    /// clock.
    pub fn gaps(&self) -> Vec<Gap> {
        let TimeBase::NonUniform { times_s } = self else { return Vec::new() };
        // Intervals between stamps that differ, with the sample that each begins behind.
        let intervals: Vec<(usize, f64)> = times_s
            .windows(2)
            .enumerate()
            .map(|(k, two)| (k, two[1] - two[0]))
            .filter(|(_, length)| *length > 0.0)
            .collect();
        let period = |of: &[(usize, f64)]| median(of.iter().map(|(_, length)| *length).collect());
        let is_gap = |i: usize| {
            let before = period(&intervals[i.saturating_sub(NEIGHBOURS)..i]);
            let behind = period(&intervals[i + 1..(i + 1 + NEIGHBOURS).min(intervals.len())]);
            // At the ends one of the two is NaN, which `max` leaves out.
            intervals[i].1 > LONGEST_PERIODS * (1.0 + 1e-6) * before.max(behind)
        };
        (0..intervals.len())
            .filter(|&i| is_gap(i))
            .map(|i| intervals[i].0)
            .map(|k| Gap { after: k, from_s: times_s[k], to_s: times_s[k + 1] })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaps(times_s: &[f64]) -> Vec<(f64, f64)> {
        let base = TimeBase::NonUniform { times_s: times_s.to_vec() };
        base.gaps().iter().map(|gap| (gap.from_s, gap.to_s)).collect()
    }

    #[test]
    fn a_pause_is_a_gap_and_another_rate_is_none() {
        let none: [(f64, f64); 0] = [];
        assert_eq!(gaps(&[0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 8.0, 9.0]), none, "two samples are missing");
        assert_eq!(gaps(&[0.0, 1.0, 2.0, 3.0, 7.0, 8.0, 9.0, 10.0]), [(3.0, 7.0)]);
        assert_eq!(gaps(&[0.0, 1.0, 2.0, 3.0, 3.1, 3.2, 3.3, 3.4]), none);
        assert_eq!(gaps(&[0.0, 0.1, 0.2, 0.3, 1.3, 2.3, 3.3]), none);
        assert_eq!(gaps(&[0.0, 9.0, 10.0, 11.0, 12.0, 20.0]), [(0.0, 9.0), (12.0, 20.0)]);
        // A sample alone between two pauses.
        assert_eq!(gaps(&[0.0, 1.0, 2.0, 3.0, 8.0, 13.0, 14.0, 15.0, 16.0]), [(3.0, 8.0), (8.0, 13.0)]);
        // A clock that ticks every second sample, and one pause.
        assert_eq!(gaps(&[0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 9.0, 9.0, 10.0, 11.0]), [(3.0, 9.0)]);
        assert_eq!(gaps(&[0.0, 5.0]), none);
        assert!(TimeBase::uniform(10.0).gaps().is_empty());
    }
}
