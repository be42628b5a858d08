//! The period of a repeating record, and from where on it repeats.

use super::turning_points::median;
use super::{InputOutput, RecordError};
use hysteron_numeric::fft::{RealFft, fast_length};
use hysteron_numeric::root_mean_square;

/// Similarity of the drive with itself one period later above which it counts as repeating (1: exactly).
const REPEATS: f64 = 0.98;

/// Change of an output that settles, against its typical or last one.
const SETTLES: f64 = 2.0;

/// Periods of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periods {
    /// Length of one period \[samples\], not necessarily whole.
    pub period_samples: f64,
    /// First sample of the first whole period counted: where the drive begins to move.
    pub start: usize,
    /// Whole periods from there to where the drive ends.
    pub count: usize,
    /// Whole periods at the start, of `count`, in which the output has not settled to repeating.
    pub settling: usize,
    /// Least similarity of the drive with itself 1, 2, 4 … periods later: 2Σ u_k u_(k+P) / Σ (u_k² +
    /// u_(k+P)²), mean removed.
    pub similarity: f64,
}

impl Periods {
    /// First sample of period `m`, rounded to the nearest.
    pub fn first_sample(&self, m: usize) -> usize {
        self.start + (m as f64 * self.period_samples).round() as usize
    }

    /// Periods to leave out of a mean of steady periods: [`Self::settling`]; of two, the first where it
    /// differs from the second more than twice as much in its first quarter as in its last.
    pub fn settling_before_mean(&self, y: &[f64]) -> usize {
        if self.count != 2 {
            return self.settling.min(self.count.saturating_sub(1));
        }
        let change = self.change(y, 1);
        let quarter = (change.len() / 4).max(1).min(change.len());
        let (first, last) = (&change[..quarter], &change[change.len() - quarter..]);
        usize::from(root_mean_square(first) > SETTLES * root_mean_square(last))
    }

    /// Change from period m − 1 to period m.
    fn change(&self, y: &[f64], m: usize) -> Vec<f64> {
        self.one(y, m - 1).iter().zip(self.one(y, m)).map(|(a, b)| b - a).collect()
    }

    /// First sample of the part in which the output repeats.
    pub fn steady_start(&self) -> usize {
        self.first_sample(self.settling)
    }

    /// Period m of `samples`, of `floor(period)` samples; read between samples by a cubic through four where
    /// the period is not whole.
    pub(crate) fn one(&self, samples: &[f64], m: usize) -> Vec<f64> {
        let length = self.period_samples.floor() as usize;
        let from = self.start as f64 + m as f64 * self.period_samples;
        (0..length).map(|i| between(samples, from + i as f64)).collect()
    }
}

/// Finds the period of the drive by its normalised autocorrelation (the smallest lag whose peak reaches 99 %
/// of the highest among lags up to half the record), refined over as many periods as there are; and the
/// periods in which the output still settles: those before the last change between successive periods above
/// twice the typical one.
///
/// # Errors
/// [`RecordError::TooShort`] below 8 samples, [`RecordError::ConstantSignal`], [`RecordError::NotPeriodic`].
pub fn find_periods(data: &InputOutput) -> Result<Periods, RecordError> {
    const PURPOSE: &str = "finding its period";
    if data.len() < 8 {
        return Err(RecordError::TooShort {
            record: data.name.clone(),
            got: data.len(),
            need: 8,
            purpose: PURPOSE,
        });
    }
    let not_periodic = || RecordError::NotPeriodic { record: data.name.clone(), purpose: PURPOSE };
    let (start, end) = active_range(&data.u).ok_or_else(|| RecordError::ConstantSignal {
        record: data.name.clone(),
        channel: data.input.clone(),
        value: data.u.first().copied().unwrap_or(0.0),
        purpose: PURPOSE,
    })?;
    let moving = data.u.get(start..end).ok_or_else(not_periodic)?;
    let (period_samples, similarity) =
        period_of(moving).filter(|(_, s)| *s >= REPEATS).ok_or_else(not_periodic)?;
    let (start, end) = continued(&data.u, (start, end), period_samples);
    let count = (((end - start) as f64 + 0.5) / period_samples).floor() as usize;
    let mut periods = Periods { period_samples, start, count, settling: 0, similarity };
    periods.settling = settling_periods(&periods, &data.y);
    Ok(periods)
}

/// The range of a drive of this period with the rests before and after it that are part of a period, as those of
/// a square wave.
fn continued(u: &[f64], (start, end): (usize, usize), period_samples: f64) -> (usize, usize) {
    let period = period_samples.round() as usize;
    if (period_samples - period as f64).abs() > 1e-9 * period_samples {
        return (start, end);
    }
    let before = start < period && (0..start).all(|k| u.get(k + period) == u.get(k));
    let after = u.len() - end < period && (end..u.len()).all(|k| k >= period && u[k - period] == u[k]);
    (if before { 0 } else { start }, if after { u.len() } else { end })
}

/// Samples between the leading and the trailing rest of the drive: one sample before the first and up to the
/// last change. `None` if it never changes.
pub(crate) fn active_range(u: &[f64]) -> Option<(usize, usize)> {
    let first = u.windows(2).position(|w| w[0] != w[1])?;
    let last = u.windows(2).rposition(|w| w[0] != w[1])?;
    // A rest of a few samples is the flat top of a coarse wave rather than a rest.
    let start = if first > 3 { first + 1 } else { 0 };
    let end = if u.len() - (last + 2) > 3 { last + 1 } else { u.len() };
    (end > start + 4).then_some((start, end))
}

/// Period \[samples\] of a signal and its least similarity 1, 2, 4, 8 … periods later; `None` where the
/// autocorrelation has no peak.
pub(crate) fn period_of(x: &[f64]) -> Option<(f64, f64)> {
    let similarity = self_similarity(x);
    let longest = x.len() / 2;
    let is_peak = |l: usize| {
        similarity[l] >= similarity[l - 1] && similarity.get(l + 1).is_none_or(|next| similarity[l] >= *next)
    };
    // Lags before the first fall below 1/2 belong to the peak at zero.
    let away = (1..=longest).find(|&l| similarity[l] < 0.5)?;
    // Place and height of a peak, by the parabola through its three lags.
    let refine = |l: usize| -> (f64, f64) {
        match (similarity.get(l - 1), similarity.get(l), similarity.get(l + 1)) {
            (Some(a), Some(b), Some(c)) if a - 2.0 * b + c < 0.0 => {
                let shift = (0.5 * (a - c) / (a - 2.0 * b + c)).clamp(-0.5, 0.5);
                (l as f64 + shift, (b - 0.25 * (a - c) * shift).min(1.0))
            }
            (_, Some(b), _) => (l as f64, *b),
            _ => (l as f64, 0.0),
        }
    };
    let best = (away..=longest).filter(|&l| is_peak(l)).map(|l| refine(l).1).fold(f64::MIN, f64::max);
    let lag = (away..=longest).find(|&l| is_peak(l) && refine(l).1 >= 0.99 * best)?;
    let (mut period, height) = refine(lag);
    if !period.is_finite() || period < 1.0 {
        return None;
    }
    // The peak of the m-th multiple gives the period m times as precisely. A periodic signal repeats to the
    // end: the least similarity counts.
    let (mut multiple, mut least) = (2, height);
    while multiple as f64 * period + 2.5 <= longest as f64 {
        let near = (multiple as f64 * period).round() as usize;
        let peak = (near.saturating_sub(2)..=near + 2)
            .filter(|l| *l >= 1)
            .max_by(|a, b| similarity[*a].total_cmp(&similarity[*b]))?;
        least = least.min(refine(peak).1);
        let refined = refine(peak).0 / multiple as f64;
        if similarity[peak] < 0.9 * best || (refined / period - 1.0).abs() > 0.1 {
            break;
        }
        period = refined;
        multiple *= 2;
    }
    let whole = period.round();
    // Within a tenth of a sample over the whole record a whole period is preferred, and one without any difference.
    let later = x.get(whole as usize..).unwrap_or(&[]);
    let same = !later.is_empty() && x.iter().zip(later).all(|(a, b)| a == b);
    if same || (period - whole).abs() * x.len() as f64 / whole < 0.1 {
        period = whole;
    }
    Some((period, least))
}

/// 2Σ x_k x_(k+l) / Σ (x_k² + x_(k+l)²) for lags 0..=N/2, mean removed (the normalised square difference of
/// McLeod and Wyvill, "A smarter way to find pitch", ICMC 2005).
fn self_similarity(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    // Scaled to its largest deviation, no square overflows.
    let largest = x.iter().map(|v| (v - mean).abs()).fold(f64::MIN_POSITIVE, f64::max);
    let length = fast_length(2 * n);
    let RealFft { forward, inverse } = RealFft::new(length);
    let mut padded = vec![0.0; length];
    for (p, v) in padded.iter_mut().zip(x) {
        *p = (v - mean) / largest;
    }
    let square = |v: &f64| ((v - mean) / largest).powi(2);
    let mut spectrum = forward.make_output_vec();
    let mut correlation = vec![0.0; length];
    // Lengths are the plans' own, so neither transform can fail.
    if forward.process(&mut padded, &mut spectrum).is_err() {
        return vec![0.0; n / 2 + 1];
    }
    for bin in &mut spectrum {
        *bin = realfft::num_complex::Complex::new(bin.norm_sqr(), 0.0);
    }
    if inverse.process(&mut spectrum, &mut correlation).is_err() {
        return vec![0.0; n / 2 + 1];
    }
    let mut energy = 2.0 * x.iter().map(square).sum::<f64>();
    let smallest = energy * 1e-12;
    (0..=n / 2)
        .map(|lag| {
            if lag > 0 {
                energy -= square(&x[lag - 1]) + square(&x[n - lag]);
            }
            if energy > smallest { 2.0 * correlation[lag] / length as f64 / energy } else { 0.0 }
        })
        .collect()
}

fn settling_periods(periods: &Periods, y: &[f64]) -> usize {
    if periods.count < 3 {
        return 0;
    }
    let changes: Vec<f64> = (1..periods.count).map(|m| root_mean_square(&periods.change(y, m))).collect();
    let typical = median(changes[changes.len() / 2..].to_vec());
    // Only the first half may count as settling: a disturbance near the end does not.
    let half = changes.len().div_ceil(2);
    changes[..half].iter().rposition(|c| *c > SETTLES * typical).map_or(0, |m| m + 1)
}

/// Value between samples by the cubic through the four nearest (exact at samples; the ends are held).
pub(crate) fn between(x: &[f64], at: f64) -> f64 {
    let n = x.len();
    if n == 0 {
        return 0.0;
    }
    let floor = at.floor();
    let t = at - floor;
    let k = floor as i64;
    let get = |i: i64| x[i.clamp(0, n as i64 - 1) as usize];
    if t == 0.0 {
        return get(k);
    }
    let (a, b, c, d) = (get(k - 1), get(k), get(k + 1), get(k + 2));
    // Lagrange weights at −1, 0, 1, 2.
    -t * (t - 1.0) * (t - 2.0) / 6.0 * a + (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0 * b
        - (t + 1.0) * t * (t - 2.0) / 2.0 * c
        + (t + 1.0) * t * (t - 1.0) / 6.0 * d
}

#[cfg(test)]
mod tests {
    use super::super::TimeBase;
    use super::*;
    use std::f64::consts::TAU;

    fn sine(n: usize, period: f64) -> Vec<f64> {
        (0..n).map(|k| (TAU * k as f64 / period).sin()).collect()
    }

    fn data(u: Vec<f64>, y: Vec<f64>) -> InputOutput {
        InputOutput::new("r", TimeBase::uniform(1000.0), u, y).unwrap()
    }

    #[test]
    fn the_similarity_equals_its_definition() {
        let x: Vec<f64> = (0..57).map(|k| ((k * k) as f64 * 0.37).sin() + 0.3).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let fast = self_similarity(&x);
        for (lag, fast) in fast.iter().enumerate() {
            let (mut cross, mut energy) = (0.0, 0.0);
            for k in 0..x.len() - lag {
                let (a, b) = (x[k] - mean, x[k + lag] - mean);
                cross += 2.0 * a * b;
                energy += a * a + b * b;
            }
            assert!((fast - cross / energy).abs() < 1e-12, "lag {lag}");
        }
    }

    #[test]
    fn rests_that_are_part_of_a_square_wave_belong_to_its_periods() {
        for half in [5, 25, 250] {
            let u: Vec<f64> = (0..10 * half).map(|k| if k / half % 2 == 0 { -8.0 } else { 8.0 }).collect();
            let found = find_periods(&data(u.clone(), u.clone())).unwrap();
            assert_eq!((found.period_samples, found.start, found.count), (2.0 * half as f64, 0, 5), "{half}");
            // A longer rest is one.
            let rested: Vec<f64> = vec![-8.0; 3 * half].into_iter().chain(u).collect();
            let found = find_periods(&data(rested.clone(), rested)).unwrap();
            assert!(found.start > 3 * half && found.count < 5, "{found:?}");
        }
    }

    #[test]
    fn whole_and_broken_periods_are_found() {
        for (n, period) in [(8027, 200.0), (5000, 333.25), (400, 10.3), (1000, 400.0)] {
            let (found, similarity) = period_of(&sine(n, period)).unwrap();
            assert!((found / period - 1.0).abs() < 1e-3, "{period}: {found}");
            assert!(similarity > 0.98);
        }
        assert_eq!(period_of(&sine(8000, 200.0)).unwrap().0, 200.0);
    }

    #[test]
    fn a_broadband_wave_repeats_by_its_period_not_by_its_strongest_line() {
        let one: Vec<f64> = (0..512)
            .map(|k| (1..80).map(|h| (TAU * (h * k) as f64 / 512.0 + (h * h) as f64).sin()).sum())
            .collect();
        let x: Vec<f64> = one.iter().cycle().take(3 * 512).copied().collect();
        assert_eq!(period_of(&x).unwrap().0, 512.0);
    }

    #[test]
    fn rest_before_and_after_is_not_counted_and_settling_is() {
        let mut u = vec![0.0; 100];
        u.extend(sine(1000, 100.0).iter().map(|x| x + 2.0));
        u.extend(vec![2.0; 50]);
        let y: Vec<f64> = u.iter().enumerate().map(|(k, u)| u + 5.0 * (-(k as f64) / 60.0).exp()).collect();
        let periods = find_periods(&data(u, y)).unwrap();
        assert_eq!(periods.period_samples, 100.0);
        assert!((99..=101).contains(&periods.start), "{}", periods.start);
        assert!((9..=10).contains(&periods.count), "{}", periods.count);
        assert!(periods.settling >= 3, "{}", periods.settling);
    }

    #[test]
    fn the_first_of_two_periods_settles_where_its_change_dies_down() {
        let noise = |k: usize| 0.01 * ((k * k * 31) as f64).sin();
        let settling = |size: f64, decay: f64| {
            let u = sine(800, 400.0);
            let y = u.iter().enumerate().map(|(k, u)| u + size * (-(k as f64) / decay).exp() + noise(k));
            let data = data(u.clone(), y.collect());
            find_periods(&data).unwrap().settling_before_mean(&data.y)
        };
        assert_eq!(settling(0.0, 1.0), 0);
        for decay in [30.0, 100.0, 300.0] {
            assert_eq!(settling(0.5, decay), 1, "{decay}");
        }
        // Below the noise it does not count.
        assert_eq!(settling(0.002, 100.0), 0);
    }

    #[test]
    fn what_does_not_repeat_is_refused() {
        let chirp: Vec<f64> = (0..4000).map(|k| (1e-4 * (k * k) as f64).sin()).collect();
        assert!(matches!(find_periods(&data(chirp.clone(), chirp)), Err(RecordError::NotPeriodic { .. })));
        assert!(matches!(
            find_periods(&data(vec![1.0; 100], sine(100, 10.0))),
            Err(RecordError::ConstantSignal { .. })
        ));
        assert!(matches!(find_periods(&data(vec![1.0; 4], vec![1.0; 4])), Err(RecordError::TooShort { .. })));
    }

    #[test]
    fn the_cubic_between_samples_is_exact_for_cubics() {
        let f = |t: f64| 0.3 * t * t * t - t * t + 2.0;
        let x: Vec<f64> = (0..10).map(f64::from).map(f).collect();
        for at in [1.25, 3.5, 6.9, 4.0] {
            assert!((between(&x, at) - f(at)).abs() < 1e-12);
        }
    }
}
