//! Effects of a converter on a signal: its quantisation step, and clipped samples.

use super::turning_points::range_of;

/// Step of the converter, where the samples lie on one: the smallest distance between different values, if at
/// least 95 % of the distances between neighbouring values are within 5 % of a multiple of it. `None` for
/// values that lie on no grid.
pub fn quantisation_step(samples: &[f64]) -> Option<f64> {
    let mut values = samples.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    let (low, high) = (*values.first()?, *values.last()?);
    // Values that differ by rounding alone are one.
    let rounding = 1e-12 * (high - low).max(low.abs()).max(high.abs());
    values.dedup_by(|b, a| *b - *a <= rounding);
    let gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    if gaps.len() < 3 {
        return None;
    }
    let step = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    let on_grid = gaps
        .iter()
        .filter(|g| {
            let multiple = **g / step;
            (multiple - multiple.round()).abs() <= 0.05 * multiple.round().clamp(1.0, 2.0)
        })
        .count();
    (on_grid as f64 >= 0.95 * gaps.len() as f64).then_some(step)
}

/// Samples at the ends of a signal's range that appear clipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clipping {
    /// Samples held at the smallest value.
    pub at_low: usize,
    /// Samples held at the largest value.
    pub at_high: usize,
}

impl Clipping {
    /// Samples held at either end.
    pub fn total(&self) -> usize {
        self.at_low + self.at_high
    }
}

/// Counts samples in runs of at least four equal values at an end of the range that the signal enters and
/// leaves steeply: half a run's length outside the run it is more than 12 quantisation steps away. (A rounded
/// top read through a converter is only 3 steps away there.) Runs longer than `longest_run` count as intended
/// rests.
pub fn clipping(samples: &[f64], longest_run: usize) -> Clipping {
    let (low, high) = range_of(samples);
    if high <= low {
        return Clipping::default();
    }
    // Computed at the first run only; most signals have none.
    let mut step = None;
    let mut held = |end: f64| {
        let (mut total, mut k) = (0, 0);
        while k < samples.len() {
            let run = samples[k..].iter().take_while(|x| **x == end).count();
            if (4..=longest_run).contains(&run) {
                let reach = run.div_ceil(2);
                let step = *step.get_or_insert_with(|| quantisation_step(samples).unwrap_or(0.0));
                let far = |i: Option<usize>| {
                    i.and_then(|i| samples.get(i))
                        .map(|x| (x - end).abs() > (12.0 * step).max(1e-3 * (high - low)))
                };
                let (before, after) = (far(k.checked_sub(reach)), far(Some(k + run - 1 + reach)));
                // A run that touches an end of the record is judged by its other side.
                if before.or(after).is_some() && before.unwrap_or(true) && after.unwrap_or(true) {
                    total += run;
                }
            }
            k += run.max(1);
        }
        total
    };
    Clipping { at_low: held(low), at_high: held(high) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(amplitude: f64) -> Vec<f64> {
        (0..4000).map(|k| amplitude * (TAU * f64::from(k) / 397.3).sin()).collect()
    }

    #[test]
    fn the_step_of_a_converter_is_found_and_none_in_smooth_samples() {
        let rounded: Vec<f64> = sine(10.0).iter().map(|x| (x / 0.02).round() * 0.02).collect();
        assert!((quantisation_step(&rounded).unwrap() - 0.02).abs() < 1e-9);
        assert_eq!(quantisation_step(&sine(10.0)), None);
        assert_eq!(quantisation_step(&[1.0; 50]), None);
    }

    #[test]
    fn a_cut_sine_is_clipped_and_a_rounded_or_triangular_one_is_not() {
        let cut: Vec<f64> = sine(10.0).iter().map(|x| x.min(8.0)).collect();
        let beyond = sine(10.0).iter().filter(|x| **x >= 8.0).count();
        assert_eq!(clipping(&cut, usize::MAX), Clipping { at_low: 0, at_high: beyond });
        let rounded: Vec<f64> = sine(10.0).iter().map(|x| (x / 0.02).round() * 0.02).collect();
        assert_eq!(clipping(&rounded, usize::MAX).total(), 0);
        let both: Vec<f64> = rounded.iter().map(|x| x.clamp(-7.0, 8.0)).collect();
        let clipped = clipping(&both, usize::MAX);
        assert!(clipped.at_low > clipped.at_high && clipped.at_high > beyond / 2, "{clipped:?}");
        let triangle: Vec<f64> = (0..4000).map(|k| f64::from((k % 400 - 200i32).abs()).min(1e9)).collect();
        assert_eq!(clipping(&triangle, usize::MAX).total(), 0);
        assert_eq!(clipping(&[2.0; 10], usize::MAX).total(), 0);
    }
}
