//! The anhysteretic polynomial l\[u\] = Σ c\[i−1\] uⁱ, i ≥ 1: no constant term.

use std::borrow::Cow;

use super::HysteresisError;

/// Name of the coefficient of uⁱ, i = `degree` ≥ 1: `linear`, `quadratic`, `cubic`, `quartic`, `quintic`,
/// then `degree_6`, `degree_7`, ….
pub fn polynomial_name(degree: usize) -> Cow<'static, str> {
    const NAMES: [&str; 5] = ["linear", "quadratic", "cubic", "quartic", "quintic"];
    match degree.checked_sub(1).and_then(|i| NAMES.get(i)) {
        Some(name) => Cow::Borrowed(name),
        None => Cow::Owned(format!("degree_{degree}")),
    }
}

/// At least one coefficient, all finite.
pub(super) fn check(coefficients: &[f64]) -> Result<(), HysteresisError> {
    if coefficients.is_empty() {
        return Err(HysteresisError::EmptyPolynomial);
    }
    match coefficients.iter().position(|c| !c.is_finite()) {
        Some(index) => Err(HysteresisError::Coefficient { power: index + 1, value: coefficients[index] }),
        None => Ok(()),
    }
}

/// l(u).
pub(super) fn value(coefficients: &[f64], u: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| (sum + c) * u)
}

/// l(u) and l'(u).
pub(super) fn value_and_slope(coefficients: &[f64], u: f64) -> (f64, f64) {
    coefficients.iter().rev().fold((0.0, 0.0), |(sum, slope), c| ((sum + c) * u, sum + c + slope * u))
}

/// Part of the range below which the search for the least slope does not divide it further.
const FINEST: f64 = 1e-12;

/// A voltage in \[low, high\] at which l' is not above `floor`; none where l' > `floor` throughout. A minimum
/// that comes within rounding of `floor` counts as not above.
///
/// With the Taylor coefficients tₖ of l' at the middle of an interval of half-width h, |l' − t₀| ≤ Σ_{k≥1}
/// |tₖ| hᵏ on all of it; intervals that this leaves open are halved.
pub(super) fn not_steeper(coefficients: &[f64], floor: f64, [low, high]: [f64; 2]) -> Option<f64> {
    let above = |u: f64| value_and_slope(coefficients, u).1 - floor;
    if let Some(end) = [low, high].into_iter().find(|&u| above(u).is_nan() || above(u) <= 0.0) {
        return Some(end);
    }
    let finest = FINEST * (high - low);
    let mut taylor = vec![0.0; coefficients.len()];
    let mut open = vec![(low, high)];
    while let Some((low, high)) = open.pop() {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        for ((t, c), power) in taylor.iter_mut().zip(coefficients).zip(1_u32..) {
            *t = f64::from(power) * c;
        }
        shift(&mut taylor, middle);
        let spread = taylor.iter().skip(1).rev().fold(0.0, |sum, t| (sum + t.abs()) * half);
        let least = taylor.first().map_or(0.0, |t| t - floor);
        if least > spread {
            continue;
        }
        if least.is_nan() || least <= 0.0 || half <= finest {
            return Some(middle);
        }
        open.extend([(low, middle), (middle, high)]);
    }
    None
}

/// Coefficients of p(x + by), lowest first, from those of p: repeated synthetic division.
fn shift(p: &mut [f64], by: f64) {
    for done in 0..p.len() {
        let mut carry = 0.0;
        for c in p.iter_mut().skip(done).rev() {
            *c += carry * by;
            carry = *c;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_is_the_derivative() {
        // l = 2u − 3u² + u⁴ at 2: 8, l' = 2 − 12 + 32.
        assert_eq!(value_and_slope(&[2.0, -3.0, 0.0, 1.0], 2.0), (8.0, 22.0));
        assert_eq!(value(&[2.0, -3.0, 0.0, 1.0], 2.0), 8.0);
    }

    #[test]
    fn shifted_polynomial_by_hand() {
        // (x + 2)³ = x³ + 6x² + 12x + 8.
        let mut p = [0.0, 0.0, 0.0, 1.0];
        shift(&mut p, 2.0);
        assert_eq!(p, [8.0, 12.0, 6.0, 1.0]);
    }

    #[test]
    fn least_slope_is_found_wherever_it_lies() {
        // l' = (u − 1)² + 0.01: above 0.01 − 1e-9 everywhere, below 0.01 + 1e-9 next to 1 alone.
        let l = [1.01, -1.0, 1.0 / 3.0];
        assert_eq!(not_steeper(&l, 0.01 - 1e-9, [-5.0, 7.3]), None);
        let at = not_steeper(&l, 0.01 + 1e-9, [-5.0, 7.3]).unwrap();
        assert!((at - 1.0).abs() < 4e-5, "{at}");
        assert_eq!(not_steeper(&l, 0.01 + 1e-9, [1.1, 7.3]), None);
        // A minimum that touches is refused, and so are ends.
        assert!(not_steeper(&[1.0, -1.0, 1.0 / 3.0], 0.0, [0.0, 2.0]).is_some());
        assert_eq!(not_steeper(&[1.0, -0.5], 0.0, [0.0, 1.0]), Some(1.0));
        assert_eq!(not_steeper(&[f64::MAX, f64::MAX], 0.0, [-1.0, 9.0]), Some(-1.0));
        assert_eq!(not_steeper(&[2.0], 0.0, [-1.0, 9.0]), None);
    }
}
