//! Turning points of a signal: reversals larger than a threshold.

/// One reversal of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningPoint {
    /// Sample index of the extremum.
    pub index: usize,
    /// Value there.
    pub value: f64,
    /// True if it is a maximum.
    pub is_maximum: bool,
}

/// Shortest time between two reversals \[samples\] that are more than a tenth of the range apart, ignoring
/// the shortest tenth, which a start or an end may cut short; with one reversal the longer time to or from it
/// (half of a single period), without any the whole length. At least 1.
pub fn shortest_swing(samples: &[f64]) -> usize {
    let (low, high) = range_of(samples);
    let turns = turning_points(samples, 0.1 * (high - low));
    if let [only] = turns.as_slice() {
        return only.index.max(samples.len() - 1 - only.index).max(1);
    }
    let mut swings: Vec<usize> = turns.windows(2).map(|w| w[1].index - w[0].index).collect();
    swings.sort_unstable();
    swings.get(swings.len() / 10).copied().unwrap_or(samples.len()).max(1)
}

/// Extrema between which the signal moves by more than `threshold`, in order, alternating maximum and
/// minimum; the two ends do not count.
///
/// Noise below the threshold makes no turning point (a dead band, as in rainflow counting).
pub fn turning_points(samples: &[f64], threshold: f64) -> Vec<TurningPoint> {
    let mut points = Vec::new();
    let Some(&first) = samples.first() else { return points };
    let (mut low, mut high) = ((0, first), (0, first));
    let mut rising: Option<bool> = None;
    for (k, &x) in samples.iter().enumerate() {
        if x < low.1 {
            low = (k, x);
        }
        if x > high.1 {
            high = (k, x);
        }
        match rising {
            None if x - low.1 > threshold => (rising, high) = (Some(true), (k, x)),
            None if high.1 - x > threshold => (rising, low) = (Some(false), (k, x)),
            Some(true) if high.1 - x > threshold => {
                points.push(TurningPoint { index: high.0, value: high.1, is_maximum: true });
                (rising, low) = (Some(false), (k, x));
            }
            Some(false) if x - low.1 > threshold => {
                points.push(TurningPoint { index: low.0, value: low.1, is_maximum: false });
                (rising, high) = (Some(true), (k, x));
            }
            _ => {}
        }
    }
    points
}

/// Smallest and largest value; `(0, 0)` of nothing.
#[doc(hidden)]
pub fn range_of(samples: &[f64]) -> (f64, f64) {
    let mut it = samples.iter().copied();
    let Some(first) = it.next() else { return (0.0, 0.0) };
    it.fold((first, first), |(low, high), x| (low.min(x), high.max(x)))
}

/// Smallest and largest value of several signals; `None` without one.
#[doc(hidden)]
pub fn ends_of<'a>(signals: impl IntoIterator<Item = &'a Vec<f64>>) -> Option<(f64, f64)> {
    let ends = signals.into_iter().map(|samples| range_of(samples));
    ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Largest less smallest value; 0 of nothing.
#[doc(hidden)]
pub fn span(samples: &[f64]) -> f64 {
    let (low, high) = range_of(samples);
    high - low
}

/// Median (upper of the two middle ones for an even count); NaN of nothing.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return f64::NAN;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_reversals_above_the_threshold_count() {
        let x = [0.0, 1.0, 0.9, 2.0, 1.0, 1.05, 0.5, 3.0, 3.0, 2.0];
        let found: Vec<(usize, bool)> =
            turning_points(&x, 0.3).iter().map(|p| (p.index, p.is_maximum)).collect();
        assert_eq!(found, [(3, true), (6, false), (7, true)]);
        assert!(turning_points(&x, 10.0).is_empty());
        assert!(turning_points(&[], 0.1).is_empty());
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert!(median(vec![]).is_nan());
    }
}
