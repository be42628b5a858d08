//! A jump of the drive out of rest: the only part of a slow record that shows dead time and lag.

use super::turning_points::range_of;
use super::{InputOutput, Periods};

/// Dead time and first-order lag fitted to the start of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUp {
    /// Sample at which the drive jumps.
    pub index: usize,
    /// Dead time \[s\].
    pub delay_s: f64,
    /// Dead times that fit nearly as well (rms up to 1.5 times the best) \[s\].
    pub delay_range_s: (f64, f64),
    /// Time constant of the lag after it \[s\].
    pub lag_s: f64,
    /// Rms of the fit in % of the output's move in it.
    pub misfit_percent: f64,
    /// True if the rest itself is in the record; if not, the drive is assumed to have jumped at the first
    /// sample.
    pub rest_recorded: bool,
}

/// Samples of rest before a jump that make it a start out of rest.
const REST_SAMPLES: usize = 20;
/// Sub-steps of one sample in the fit.
const SUB_STEPS: usize = 10;

/// Searches for a start out of rest and fits y = a + b (L u) + c (L step) after a dead time, with L a
/// first-order lag: over the first samples, up to 25 or the drive's first turn, so that hysteresis stays on
/// one branch. A start is either a jump of the drive by at least 20 % of its range after 20 samples of rest,
/// or a record whose first output lies outside the range of its settled periods by more than 1 % of the
/// stroke, as if the drive had jumped to its first value there. `None` where there is none, or where no dead
/// time and lag explain it to 10 % of the move.
pub fn fit_start_up(data: &InputOutput, periods: Option<&Periods>) -> Option<StartUp> {
    let rate = data.sample_rate_hz()?;
    let (index, rest_recorded) = start_index(data, periods)?;
    let until = (index + 26).min(data.len());
    let (u, y) = (data.u.get(index..until)?, data.y.get(index..until)?);
    let direction = (u.get(1)? - u.first()?).signum();
    let monotone = u.windows(2).take_while(|w| (w[1] - w[0]) * direction >= 0.0).count() + 1;
    let (u, y) = (&u[..monotone], &y[..monotone]);
    if monotone < 12 {
        return None;
    }
    let (low, high) = range_of(y);
    let mut fits: Vec<(f64, f64, f64)> = Vec::new();
    let mut branch = Branch::new(u);
    for i in 0..48 {
        let lag_samples = 0.1 * 1.12f64.powi(i);
        branch.follow(lag_samples);
        for delay_steps in 0..=8 * SUB_STEPS {
            fits.push((branch.misfit(y, delay_steps), delay_steps as f64 / SUB_STEPS as f64, lag_samples));
        }
    }
    // The shortest delay among equals.
    let best = fits.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)))?;
    let misfit_percent = 100.0 * best.0 / (high - low);
    if misfit_percent.is_nan() || misfit_percent >= 10.0 {
        return None;
    }
    let close = || fits.iter().filter(|f| f.0 <= 1.5 * best.0).map(|f| f.1 / rate);
    Some(StartUp {
        index,
        delay_s: best.1 / rate,
        delay_range_s: (close().fold(f64::INFINITY, f64::min), close().fold(0.0, f64::max)),
        lag_s: best.2 / rate,
        misfit_percent,
        rest_recorded,
    })
}

/// Sample of the jump, and whether the rest before it is in the record.
fn start_index(data: &InputOutput, periods: Option<&Periods>) -> Option<(usize, bool)> {
    let (low, high) = range_of(&data.u);
    let jump = data.u.windows(2).position(|w| w[0] != w[1])? + 1;
    if jump >= REST_SAMPLES {
        return ((data.u[jump] - data.u[jump - 1]).abs() >= 0.2 * (high - low)).then_some((jump, true));
    }
    let settled = data.y.get(periods?.steady_start()..)?;
    let (y_low, y_high) = range_of(settled);
    let first = *data.y.first()?;
    let outside = (y_low - first).max(first - y_high);
    (outside > 0.01 * (y_high - y_low)).then_some((0, false))
}

/// The drive's first branch at every sub-step, its response and that of a step through a lag, and buffers for
/// their delayed samples.
struct Branch {
    fine: Vec<f64>,
    fine_lagged: Vec<f64>,
    fine_step: Vec<f64>,
    lagged: Vec<f64>,
    step: Vec<f64>,
}

impl Branch {
    fn new(u: &[f64]) -> Self {
        let n = (u.len() - 1) * SUB_STEPS + 1;
        let fine = (0..n)
            .map(|i| {
                let (k, t) = (i / SUB_STEPS, (i % SUB_STEPS) as f64 / SUB_STEPS as f64);
                u[k] + t * (u.get(k + 1).unwrap_or(&u[k]) - u[k]) - u[0]
            })
            .collect();
        let (of_steps, of_samples) = (vec![0.0; n], vec![0.0; u.len()]);
        Branch {
            fine,
            fine_lagged: of_steps.clone(),
            fine_step: of_steps,
            lagged: of_samples.clone(),
            step: of_samples,
        }
    }

    /// Lags the branch and a step. The drive is straight between sub-steps, so the lag is exact:
    /// x₁ = w₁ − sT + (x₀ − w₀ + sT) e^(−h/T), s = (w₁ − w₀)/h.
    fn follow(&mut self, lag_samples: f64) {
        let h = 1.0 / SUB_STEPS as f64;
        let decay = (-h / lag_samples).exp();
        for i in 1..self.fine.len() {
            let (w0, w1) = (self.fine[i - 1], self.fine[i]);
            let rise = (w1 - w0) / h * lag_samples;
            self.fine_lagged[i] = w1 - rise + (self.fine_lagged[i - 1] - w0 + rise) * decay;
            self.fine_step[i] = 1.0 - (-(i as f64) * h / lag_samples).exp();
        }
    }

    /// Rms of `y` about the best a + b·lagged + c·step, both delayed: they are 0 until then.
    fn misfit(&mut self, y: &[f64], delay_steps: usize) -> f64 {
        for k in 0..self.lagged.len() {
            let since = (k * SUB_STEPS).checked_sub(delay_steps);
            self.lagged[k] = since.map_or(0.0, |i| self.fine_lagged[i]);
            self.step[k] = since.map_or(0.0, |i| self.fine_step[i]);
        }
        residual_rms(y, &self.lagged, &self.step)
    }
}

/// Rms of y about its least-squares fit by 1, p and q (Gram–Schmidt; a regressor that the others explain is
/// left out).
fn residual_rms(y: &[f64], p: &[f64], q: &[f64]) -> f64 {
    let n = y.len() as f64;
    let centred = |x: &[f64]| -> Vec<f64> {
        let mean = x.iter().sum::<f64>() / n;
        x.iter().map(|v| v - mean).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let remove = |x: &mut [f64], direction: &[f64], scale: f64| {
        let square = dot(direction, direction);
        if square > 1e-20 * scale {
            let factor = dot(x, direction) / square;
            for (x, d) in x.iter_mut().zip(direction) {
                *x -= factor * d;
            }
        }
    };
    let (mut y, p, mut q) = (centred(y), centred(p), centred(q));
    let (p_scale, q_scale) = (dot(&p, &p), dot(&q, &q));
    remove(&mut q, &p, p_scale);
    remove(&mut y, &p, p_scale);
    remove(&mut y, &q, q_scale);
    (dot(&y, &y) / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::{TimeBase, find_periods};
    use super::*;
    use std::f64::consts::TAU;

    /// y' = (3 u(t − delay) − y)/lag integrated in steps of a thousandth of a sample; rest at 0 before t0.
    fn started(rate: f64, rest: usize, n: usize, delay: f64, lag: f64) -> InputOutput {
        let drive = |t: f64| if t < 0.0 { 0.0 } else { 2.0 + (TAU * t).sin() };
        let fine = 1000;
        let h = 1.0 / (rate * f64::from(fine));
        let mut x = 0.0;
        let (mut u, mut y) = (Vec::new(), Vec::new());
        for k in 0..n as i32 * fine {
            let t = (f64::from(k) - (rest as f64) * f64::from(fine)) * h;
            if k % fine == 0 {
                u.push(drive(t));
                y.push(x);
            }
            x += h * (3.0 * drive(t - delay + 0.5 * h) - x) / lag;
        }
        InputOutput::new("r", TimeBase::uniform(rate), u, y).unwrap()
    }

    #[test]
    fn dead_time_and_lag_are_found_whether_the_rest_is_recorded_or_not() {
        for rest in [0, 40] {
            let data = started(200.0, rest, 1000 + rest, 0.006, 0.013);
            let found = fit_start_up(&data, find_periods(&data).ok().as_ref()).unwrap();
            assert_eq!((found.index, found.rest_recorded), (rest, rest > 0));
            assert!((found.delay_s - 0.006).abs() < 0.0006, "{found:?}");
            assert!((found.lag_s - 0.013).abs() < 0.001, "{found:?}");
            assert!(found.delay_range_s.0 <= found.delay_s && found.delay_s <= found.delay_range_s.1);
            assert!(found.misfit_percent < 0.5, "{found:?}");
        }
    }

    #[test]
    fn a_steady_record_has_no_start_up() {
        let data = started(200.0, 0, 1000, 0.006, 0.013).cropped(400..1000).unwrap();
        assert_eq!(fit_start_up(&data, find_periods(&data).ok().as_ref()), None);
    }
}
