//! Residual tests: whiteness of the residual and its independence of the input.
//!
//! L. Ljung, *System Identification: Theory for the User*, 2nd ed., Prentice Hall 1999, §16.6.

use hysteron_numeric::dot;

/// Largest lag tested \[samples\].
const LAGS: usize = 25;
/// 99 % two-sided quantile of the standard normal distribution.
const QUANTILE_99: f64 = 2.575_829_303_548_901;

/// Outcome of a correlation test: correlation coefficients against the 99 % bound ±2.576/√N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrelationTest {
    /// Lags tested.
    pub lags: usize,
    /// Lags whose coefficient leaves the bound; about one in a hundred does so by chance.
    pub outside: usize,
    /// The bound, 2.576/√N.
    pub bound: f64,
    /// Coefficient of largest magnitude, in \[−1, 1\].
    pub largest: f64,
    /// Its lag \[samples\].
    pub largest_lag: i64,
}

/// Correlation coefficients by lag, and the bound that 99 % of them keep where nothing is correlated.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlogram {
    /// Lag of the first coefficient \[samples\]; the others follow one by one.
    pub first_lag: i64,
    /// Coefficients, in \[−1, 1\].
    pub coefficients: Vec<f64>,
    /// 2.576/√N.
    pub bound: f64,
}

impl Correlogram {
    /// The coefficients against the bound.
    pub fn test(&self) -> CorrelationTest {
        let Correlogram { first_lag, bound, .. } = *self;
        let lags = self.coefficients.len();
        let mut result = CorrelationTest { lags, outside: 0, bound, largest: 0.0, largest_lag: first_lag };
        for (lag, &r) in (first_lag..).zip(&self.coefficients) {
            result.outside += usize::from(r.abs() > bound);
            if r.abs() > result.largest.abs() {
                (result.largest, result.largest_lag) = (r, lag);
            }
        }
        result
    }
}

/// Autocorrelation r_k = Σ e_t e_{t−k} / Σ e_t² of the residual at lags 1 … 25, over pairs of scored samples.
///
/// A white residual stays within the bound at 99 % of the lags. `None` where the residual vanishes or fewer
/// than 50 samples are scored.
pub fn residual_whiteness(e: &[f64], scored: &[bool]) -> Option<Correlogram> {
    correlogram(e, e, scored, 1)
}

/// Correlation r_k = Σ (u_{t−k} − ū) e_t / √(Σ (u_t − ū)² Σ e_t²) of the residual with past (k ≥ 0) and
/// future (k < 0) input, lags −25 … 25, over pairs of scored samples.
///
/// Positive lags outside the bound indicate unmodelled dynamics or hysteresis; negative ones feedback, or too
/// long a delay in the model. The bound holds where the residual is white. `None` where the residual or the
/// input's variation vanishes or fewer than 50 samples are scored.
pub fn residual_input_correlation(e: &[f64], u: &[f64], scored: &[bool]) -> Option<Correlogram> {
    let n = scored.iter().filter(|&&s| s).count();
    let mean = u.iter().zip(scored).filter(|(_, s)| **s).map(|(u, _)| u).sum::<f64>() / n as f64;
    let centred: Vec<f64> = u.iter().map(|u| u - mean).collect();
    correlogram(e, &centred, scored, -(LAGS as i64))
}

/// Correlates `e_t` with `x_{t−k}` for k = `first_lag` … 25.
fn correlogram(e: &[f64], x: &[f64], scored: &[bool], first_lag: i64) -> Option<Correlogram> {
    let n = scored.iter().filter(|&&s| s).count();
    if n < 2 * LAGS {
        return None;
    }
    // Scaled by the largest sample, so that squares neither overflow nor vanish.
    let scale =
        |x: &[f64]| x.iter().zip(scored).filter(|(_, s)| **s).fold(0.0_f64, |m, (x, _)| m.max(x.abs()));
    let (e_scale, x_scale) = (scale(e), scale(x));
    if !(e_scale > 0.0 && x_scale > 0.0 && e_scale.is_finite() && x_scale.is_finite()) {
        return None;
    }
    let prepare = |x: &[f64], scale: f64| -> Vec<f64> {
        x.iter().zip(scored).map(|(x, s)| if *s { x / scale } else { 0.0 }).collect()
    };
    let (e, x) = (prepare(e, e_scale), prepare(x, x_scale));
    let norm = (dot(&e, &e) * dot(&x, &x)).sqrt();
    let bound = QUANTILE_99 / (n as f64).sqrt();
    let coefficient = |lag: i64| {
        let shift = lag.unsigned_abs() as usize;
        let (late, early) = if lag >= 0 { (&e, &x) } else { (&x, &e) };
        dot(&late[shift..], &early[..early.len() - shift]) / norm
    };
    Some(Correlogram { first_lag, coefficients: (first_lag..=LAGS as i64).map(coefficient).collect(), bound })
}
