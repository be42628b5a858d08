//! The standard normal distribution.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Quantile of the standard normal distribution at probability `p`, 0 < p < 1: Φ(x) = p, by Newton's method
/// from 0, which cannot overshoot because Φ is concave above 0.
pub fn quantile(p: f64) -> f64 {
    if !(p > 0.0 && p < 1.0) {
        return f64::NAN;
    }
    if p < 0.5 {
        return -upper(p);
    }
    upper(1.0 - p)
}

/// Probability Φ(x) that a standard normal number is at most `x`.
pub fn probability(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

/// x ≥ 0 with 1 − Φ(x) = `tail`, at most ½.
fn upper(tail: f64) -> f64 {
    let mut x = 0.0_f64;
    for _ in 0..200 {
        let excess = 0.5 * libm::erfc(x * FRAC_1_SQRT_2) - tail;
        let step = excess * (2.0 * PI).sqrt() * (0.5 * x * x).exp();
        x += step;
        if step.abs() <= 1e-15 * x.max(1.0) {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::{probability, quantile};

    #[test]
    fn quantiles_are_those_of_tables() {
        // M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, Tables 26.5 and 26.6.
        for (p, x) in [
            (0.5, 0.0),
            (0.75, 0.674_489_750_196_081_7),
            (0.975, 1.959_963_984_540_054),
            (0.995, 2.575_829_303_548_900_4),
            (0.999, 3.090_232_306_167_813_5),
            (1e-6, -4.753_424_308_822_899),
        ] {
            let found = quantile(p);
            assert!((found - x).abs() < 1e-12, "{p}: {found} instead of {x}");
            assert!((probability(x) - p).abs() < 1e-15);
        }
        assert!(quantile(0.0).is_nan() && quantile(1.0).is_nan());
    }
}
