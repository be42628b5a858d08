//! Tails and quantiles of the χ² and Student distributions.
//!
//! From the regularised incomplete gamma function Q(a, x) and beta function I_x(a, b), each by its power
//! series or continued fraction, whichever converges; NIST Digital Library of Mathematical Functions,
//! <https://dlmf.nist.gov>, §8.7, §8.9 and §8.17. Relative error below 1e-12 for up to some thousand degrees
//! of freedom and tails above 1e-300 (tests).

/// Terms after which a series or a fraction is taken as it is; some √a are needed.
const MOST_TERMS: usize = 20_000;
/// In place of a zero denominator of a continued fraction (Lentz).
const TINY: f64 = 1e-300;

/// P(χ² > `x`) for `degrees` > 0 degrees of freedom; NaN for other degrees.
pub fn chi_square_tail(x: f64, degrees: f64) -> f64 {
    if degrees <= 0.0 || degrees.is_nan() || x.is_nan() {
        return f64::NAN;
    }
    upper_gamma(0.5 * degrees, 0.5 * x.max(0.0))
}

/// The x that χ² of `degrees` degrees of freedom exceeds with probability 1 − `p`; NaN unless 0 ≤ `p` < 1 and
/// `degrees` > 0.
pub fn chi_square_quantile(p: f64, degrees: f64) -> f64 {
    if !(0.0..1.0).contains(&p) || degrees <= 0.0 || !degrees.is_finite() {
        return f64::NAN;
    }
    let tail = 1.0 - p;
    let (mut low, mut high) = (0.0, degrees + 1.0);
    while chi_square_tail(high, degrees) > tail {
        high *= 2.0;
    }
    // Bisection to neighbouring numbers.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if chi_square_tail(middle, degrees) > tail { low = middle } else { high = middle }
    }
}

/// P(|T| > |`t`|) of Student's T with `degrees` > 0 degrees of freedom, the normal distribution for
/// infinitely many; NaN for other degrees.
pub fn student_tail(t: f64, degrees: f64) -> f64 {
    if degrees <= 0.0 || degrees.is_nan() || t.is_nan() {
        return f64::NAN;
    }
    if degrees.is_infinite() {
        return chi_square_tail(t * t, 1.0);
    }
    incomplete_beta(degrees / (degrees + t * t), 0.5 * degrees, 0.5)
}

/// Q(a, x) = Γ(a, x)/Γ(a).
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let factor = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        // DLMF 8.7.1: P(a, x) = x^a e^(−x) Σ x^k / (a (a+1) … (a+k)) / Γ(a).
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for k in 1..MOST_TERMS {
            term *= x / (a + k as f64);
            sum += term;
            if term < sum * f64::EPSILON {
                break;
            }
        }
        return 1.0 - factor * sum;
    }
    // DLMF 8.9.2 in its even form.
    let mut b = x + 1.0 - a;
    let mut d = 1.0 / b;
    let (mut c, mut h) = (1.0 / TINY, d);
    for k in 1..MOST_TERMS {
        let k = k as f64;
        let numerator = -k * (k - a);
        b += 2.0;
        d = 1.0 / away_from_zero(numerator * d + b);
        c = away_from_zero(b + numerator / c);
        h *= d * c;
        if (d * c - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    factor * h
}

/// I_x(a, b) for 0 ≤ x ≤ 1.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let ln_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let factor = (a * x.ln() + b * (-x).ln_1p() - ln_beta).exp() / a;
    // DLMF 8.17.22.
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let (mut c, mut h) = (1.0, d);
    for m in 1..MOST_TERMS {
        let m = m as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        for numerator in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + numerator * d);
            c = away_from_zero(1.0 + numerator / c);
            h *= d * c;
        }
        if (d * c - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    factor * h
}

fn away_from_zero(x: f64) -> f64 {
    if x.abs() < TINY { TINY } else { x }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn near(found: f64, expected: f64, relative: f64) {
        assert!((found / expected - 1.0).abs() < relative, "{found} {expected}");
    }

    #[test]
    fn two_degrees_are_an_exponential_and_four_have_one_term_more() {
        for x in [1e-3_f64, 0.5, 3.0, 20.0, 300.0, 1200.0] {
            near(chi_square_tail(x, 2.0), (-x / 2.0).exp(), 1e-12);
            near(chi_square_tail(x, 4.0), (-x / 2.0).exp() * (1.0 + x / 2.0), 1e-12);
        }
    }

    #[test]
    fn one_degree_is_the_square_of_a_normal_number() {
        for z in [0.1_f64, 1.0, 3.0, 10.0] {
            near(chi_square_tail(z * z, 1.0), libm::erfc(z / 2f64.sqrt()), 1e-12);
            near(student_tail(z, f64::INFINITY), libm::erfc(z / 2f64.sqrt()), 1e-12);
        }
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions (1964), table 26.8.
        for (degrees, expected) in [(1.0, 6.63490), (2.0, 9.21034), (5.0, 15.0863), (30.0, 50.8922)] {
            near(chi_square_quantile(0.99, degrees), expected, 1e-5);
        }
        for degrees in [1.0, 7.0, 400.0] {
            near(chi_square_tail(chi_square_quantile(0.975, degrees), degrees), 0.025, 1e-11);
        }
    }

    #[test]
    fn student_with_one_and_two_degrees_has_a_closed_form() {
        for t in [0.01_f64, 1.0, 5.0, 1e4] {
            near(student_tail(t, 1.0), 2.0 / PI * (1.0 / t).atan(), 1e-12);
            let t2 = 2.0 + t * t;
            near(student_tail(-t, 2.0), 2.0 / (t2 + t * t2.sqrt()), 1e-11);
        }
    }

    #[test]
    fn what_is_no_distribution_is_nan() {
        assert!(chi_square_tail(1.0, 0.0).is_nan() && chi_square_quantile(1.0, 3.0).is_nan());
        assert!(student_tail(1.0, -1.0).is_nan() && student_tail(f64::NAN, 3.0).is_nan());
        assert_eq!((chi_square_tail(-1.0, 3.0), chi_square_tail(f64::INFINITY, 3.0)), (1.0, 0.0));
        assert_eq!((student_tail(0.0, 3.0), student_tail(f64::INFINITY, 3.0)), (1.0, 0.0));
    }
}
