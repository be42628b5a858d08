//! Oscillation frequencies of a drive, for any time base and amplitude.

use super::turning_points::{shortest_swing, span, turning_points};
use super::{TimeBase, UniformSegment};

/// Smallest reversal counted within a piece, as a share of the piece's range.
const OWN_SHARE: f64 = 0.3;
/// Share of the record's range below which the drive of a piece counts as held.
const HELD: f64 = 1e-3;
/// Smallest reversal counted over the whole record, as a share of its range.
const WIDE: f64 = 0.1;
/// Fewest reversals of an oscillation.
const FEWEST_REVERSALS: usize = 3;

/// Lowest and highest oscillation frequency of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swings {
    /// One over twice the longest time between wide reversals, or than the record where there are none
    /// \[Hz\].
    pub slowest_hz: f64,
    /// Frequency of the fastest piece, small swings included \[Hz\].
    pub fastest_hz: f64,
}

impl Swings {
    /// Swings of a drive on time stamps; of a uniform one by its wide reversals alone. `None` without a time
    /// base.
    pub fn of(u: &[f64], time: &TimeBase) -> Option<Self> {
        if let TimeBase::Uniform { sample_rate_hz, .. } = time {
            let hz = sample_rate_hz / (2.0 * shortest_swing(u) as f64);
            return Some(Self { slowest_hz: hz, fastest_hz: hz });
        }
        let (first_s, last_s) = time.extent_s(u.len())?;
        let at = |k: usize| time.time_s(k);
        let range = span(u);
        let wide = turning_points(u, WIDE * range);
        let ends = wide.windows(2).map(|two| Some(at(two[1].index)? - at(two[0].index)?));
        let times: Vec<f64> = ends.collect::<Option<_>>()?;
        let duration = last_s - first_s;
        let longest = times.iter().copied().reduce(f64::max).unwrap_or(duration);
        let shortest = times.iter().copied().filter(|t| *t > 0.0).reduce(f64::min).unwrap_or(duration);
        let of_pieces = time.pieces(u.len());
        let oscillations = of_pieces.iter().filter_map(|piece| oscillation_hz(u, piece, HELD * range));
        Some(Self { slowest_hz: 0.5 / longest, fastest_hz: oscillations.fold(0.5 / shortest, f64::max) })
    }
}

/// Frequency of the oscillation in a piece, where there is one.
pub fn oscillation_hz(u: &[f64], piece: &UniformSegment, least_range: f64) -> Option<f64> {
    let own = u.get(piece.samples.clone())?;
    let range = span(own);
    let turns = turning_points(own, OWN_SHARE * range);
    if range < least_range || turns.len() < FEWEST_REVERSALS {
        return None;
    }
    let samples = turns[turns.len() - 1].index - turns[0].index;
    Some((turns.len() - 1) as f64 / (2.0 * samples as f64 * piece.period_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_small_fast_sine_behind_a_slow_ramp_is_seen() {
        let ramp = (0..1000).map(|k| (f64::from(k) * 5e-4, f64::from(k) * 0.02));
        let sine = (0..2000).map(|k| {
            let t = 0.6 + f64::from(k) / 30_000.0;
            (t, 20.0 + 0.1 * (TAU * 300.0 * t).sin())
        });
        let (times_s, u): (Vec<f64>, Vec<f64>) = ramp.chain(sine).unzip();
        let swings = Swings::of(&u, &TimeBase::NonUniform { times_s }).unwrap();
        assert!((swings.fastest_hz / 300.0 - 1.0).abs() < 0.01, "{swings:?}");
        assert!(swings.slowest_hz < 1.0, "{swings:?}");
    }
}
