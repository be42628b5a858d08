//! Noise floor of the output: the part that a model cannot and need not explain.

use super::turning_points::median;
use super::{InputOutput, Periods};

/// Standard deviation of the white part of the output's noise, and how it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFloor {
    /// Standard deviation, in the output's unit.
    pub rms: f64,
    /// Method of the estimate.
    pub method: NoiseMethod,
}

/// Method that estimated a [`NoiseFloor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseMethod {
    /// From successive periods: rms of (y_(m+1) − y_m, its straight-line trend removed) / √2. Whatever
    /// repeats, and any slow drift, cancels.
    PeriodRepeats {
        /// Pairs of periods used.
        pairs: usize,
    },
    /// From fourth differences y_(k−2) − 4y_(k−1) + 6y_k − 4y_(k+1) + y_(k+2), median of the absolute value /
    /// 0.6745 / √70: an upper bound where the motion itself is rough within five samples.
    FourthDifferences,
    /// Steps of the converter hide the noise: step / √12, the rounding that they leave.
    Quantisation,
}

/// Estimates the noise floor of the output: from period repeats where there are two settled periods, else
/// from fourth differences. `None` below five samples.
pub fn noise_floor(data: &InputOutput, periods: Option<&Periods>) -> Option<NoiseFloor> {
    if let Some(periods) = periods
        && periods.count >= periods.settling + 2
        && periods.period_samples >= 3.0
    {
        let valid: Option<Vec<f64>> =
            data.valid.as_ref().map(|mask| mask.iter().map(|&valid| f64::from(u8::from(valid))).collect());
        let (mut sum, mut freedom) = (0.0, 0.0);
        for m in periods.settling..periods.count - 1 {
            let change: Vec<f64> =
                periods.one(&data.y, m).iter().zip(periods.one(&data.y, m + 1)).map(|(a, b)| b - a).collect();
            let both = valid.as_ref().map(|valid| (periods.one(valid, m), periods.one(valid, m + 1)));
            // Between samples a mask of ones reads as one.
            let is_valid =
                |i: usize| both.as_ref().is_none_or(|(a, b)| (a[i] - 1.0).abs() + (b[i] - 1.0).abs() < 1e-9);
            let kept: Vec<f64> = (0..change.len()).filter(|&i| is_valid(i)).map(|i| change[i]).collect();
            sum += squares_about_a_line(&kept);
            freedom += (kept.len() as f64 - 2.0).max(0.0);
        }
        if freedom == 0.0 {
            return None;
        }
        return Some(NoiseFloor {
            rms: (sum / freedom / 2.0).sqrt(),
            method: NoiseMethod::PeriodRepeats { pairs: periods.count - 1 - periods.settling },
        });
    }
    let whole = |k: usize| {
        data.valid.as_ref().is_none_or(|mask| mask.get(k..k + 5).is_some_and(|m| m.iter().all(|v| *v)))
    };
    let windows = data.y.windows(5).enumerate().filter(|(k, _)| whole(*k));
    let differences: Vec<f64> =
        windows.map(|(_, w)| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()).collect();
    (!differences.is_empty()).then(|| NoiseFloor {
        rms: median(differences) / 0.674_489_750_196_081_7 / 70f64.sqrt(),
        method: NoiseMethod::FourthDifferences,
    })
}

/// Σ of squares about the least-squares line.
fn squares_about_a_line(x: &[f64]) -> f64 {
    let n = x.len() as f64;
    let centre = 0.5 * (n - 1.0);
    let mean = x.iter().sum::<f64>() / n;
    let (mut cross, mut square) = (0.0, 0.0);
    for (k, v) in x.iter().enumerate() {
        let i = k as f64 - centre;
        cross += i * (v - mean);
        square += i * i;
    }
    let slope = if square > 0.0 { cross / square } else { 0.0 };
    x.iter().enumerate().map(|(k, v)| v - mean - slope * (k as f64 - centre)).map(|r| r * r).sum()
}

#[cfg(test)]
mod tests {
    use super::super::{TimeBase, find_periods};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use std::f64::consts::TAU;

    /// Sum of twelve uniform deviates less six: standard deviation 1.
    fn noise(n: usize) -> Vec<f64> {
        let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(7);
        (0..n).map(|_| (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0).collect()
    }

    fn record(sigma: f64, drift: f64) -> InputOutput {
        let n = 4000;
        let u: Vec<f64> = (0..n).map(|k| (TAU * k as f64 / 200.0).sin()).collect();
        let y = u
            .iter()
            .zip(noise(n))
            .enumerate()
            .map(|(k, (u, e))| 20.0 * u + 5.0 * u * u + drift * k as f64 + sigma * e)
            .collect();
        InputOutput::new("r", TimeBase::uniform(1000.0), u, y).unwrap()
    }

    #[test]
    fn repeats_give_the_noise_whatever_the_loop_and_the_drift() {
        // 19 pairs of 198 degrees of freedom, neighbours sharing a period: the estimate scatters by about 1.5
        // %.
        for drift in [0.0, 1e-3] {
            let data = record(0.05, drift);
            let floor = noise_floor(&data, find_periods(&data).ok().as_ref()).unwrap();
            assert_eq!(floor.method, NoiseMethod::PeriodRepeats { pairs: 19 });
            assert!((floor.rms / 0.05 - 1.0).abs() < 0.05, "{}", floor.rms);
        }
    }

    #[test]
    fn fourth_differences_give_it_where_nothing_repeats() {
        // 4000 correlated differences: the median scatters by about 3 %; the motion leaves 20 (2π/200)⁴ =
        // 2e-5.
        let floor = noise_floor(&record(0.05, 0.0), None).unwrap();
        assert_eq!(floor.method, NoiseMethod::FourthDifferences);
        assert!((floor.rms / 0.05 - 1.0).abs() < 0.1, "{}", floor.rms);
    }
}
