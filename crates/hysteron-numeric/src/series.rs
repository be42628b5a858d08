//! Power series of many short stretches at once, one lane per stretch: multiplied, raised to a power,
//! evaluated.

use super::InstructionSet;
use super::dispatch::{series_evaluate, series_power, series_product};
use super::elementary::{exp, sin_cos};

/// Power series of [`Self::LANES`] functions: coefficient n of lane i is `re[n][i] + i·im[n][i]`.
#[derive(Clone, Debug, PartialEq)]
pub struct SeriesPanel {
    /// Real parts.
    pub re: [[f64; Self::LANES]; Self::TERMS],
    /// Imaginary parts.
    pub im: [[f64; Self::LANES]; Self::TERMS],
}

impl SeriesPanel {
    /// Series in a panel.
    pub const LANES: usize = 8;
    /// Coefficients of each.
    pub const TERMS: usize = 11;
    /// Most points at which a series is evaluated in one call.
    pub const MOST: usize = 256;

    /// Zero.
    pub const ZERO: Self =
        Self { re: [[0.0; Self::LANES]; Self::TERMS], im: [[0.0; Self::LANES]; Self::TERMS] };

    /// exp(order · log): with log the series of ln s, the series of s^order.
    pub fn power(set: InstructionSet, order: f64, log: &Self, out: &mut Self) {
        series_power(set, order, log, out);
    }

    /// out = a · b, cut off behind the last coefficient.
    pub fn product(set: InstructionSet, a: &Self, b: &Self, out: &mut Self) {
        series_product(set, a, b, out);
    }

    /// Adds factor · `other`.
    pub fn add(&mut self, factor: f64, other: &Self) {
        for (to, from) in [(&mut self.re, &other.re), (&mut self.im, &other.im)] {
            for (to, from) in to.as_flattened_mut().iter_mut().zip(from.as_flattened()) {
                *to += factor * from;
            }
        }
    }

    /// Values of the series in lane `lane`, cut off behind `degree`, at whole steps about the middle: at
    /// t_j = j − (count − 1)/2, `count` ≤ [`Self::MOST`] the length of the slices.
    pub fn evaluate(&self, set: InstructionSet, lane: usize, degree: usize, re: &mut [f64], im: &mut [f64]) {
        let mut coefficients = [[0.0; 2]; Self::TERMS];
        for (c, (re, im)) in coefficients.iter_mut().zip(self.re.iter().zip(&self.im)) {
            *c = [re[lane], im[lane]];
        }
        Self::evaluate_one(set, &coefficients, degree, re, im);
    }

    /// [`Self::evaluate`] of one series, given by real and imaginary part of each coefficient.
    pub fn evaluate_one(
        set: InstructionSet,
        coefficients: &[[f64; 2]; Self::TERMS],
        degree: usize,
        re: &mut [f64],
        im: &mut [f64],
    ) {
        series_evaluate(set, coefficients, degree, re, im);
    }
}

/// 0, 1, 2, …
static STEPS: [f64; SeriesPanel::MOST] = {
    let mut steps = [0.0; SeriesPanel::MOST];
    let mut j = 0;
    while j < SeriesPanel::MOST {
        steps[j] = j as f64;
        j += 1;
    }
    steps
};

/// f = exp(α l) has n f_n = α Σ k l_k f_(n−k), k from 1 to n.
#[inline(always)]
pub(super) fn series_power_kernel(order: f64, log: &SeriesPanel, out: &mut SeriesPanel) {
    const LANES: usize = SeriesPanel::LANES;
    let (mut slope_re, mut slope_im) = (log.re, log.im);
    for (k, row) in slope_re.iter_mut().chain(&mut slope_im).enumerate() {
        let k = (k % SeriesPanel::TERMS) as f64;
        row.iter_mut().for_each(|l| *l *= k * order);
    }
    for i in 0..LANES {
        let size = exp(order * log.re[0][i]);
        let (sin, cos) = sin_cos(order * log.im[0][i]);
        out.re[0][i] = size * cos;
        out.im[0][i] = size * sin;
    }
    for n in 1..SeriesPanel::TERMS {
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        for k in 1..=n {
            let (l, f) = ((&slope_re[k], &slope_im[k]), (&out.re[n - k], &out.im[n - k]));
            for i in 0..LANES {
                re[i] += l.0[i] * f.0[i] - l.1[i] * f.1[i];
                im[i] += l.0[i] * f.1[i] + l.1[i] * f.0[i];
            }
        }
        let per = 1.0 / n as f64;
        for i in 0..LANES {
            out.re[n][i] = per * re[i];
            out.im[n][i] = per * im[i];
        }
    }
}

#[inline(always)]
pub(super) fn series_product_kernel(a: &SeriesPanel, b: &SeriesPanel, out: &mut SeriesPanel) {
    const LANES: usize = SeriesPanel::LANES;
    for n in 0..SeriesPanel::TERMS {
        let (mut re, mut im) = ([0.0; LANES], [0.0; LANES]);
        for k in 0..=n {
            let (a, b) = ((&a.re[k], &a.im[k]), (&b.re[n - k], &b.im[n - k]));
            for i in 0..LANES {
                re[i] += a.0[i] * b.0[i] - a.1[i] * b.1[i];
                im[i] += a.0[i] * b.1[i] + a.1[i] * b.0[i];
            }
        }
        (out.re[n], out.im[n]) = (re, im);
    }
}

/// Horner's rule, as many steps as the degree needs.
#[inline(always)]
pub(super) fn series_evaluate_kernel(
    coefficients: &[[f64; 2]; SeriesPanel::TERMS],
    degree: usize,
    re: &mut [f64],
    im: &mut [f64],
) {
    match degree {
        0..=3 => horner::<3>(coefficients, re, im),
        4 => horner::<4>(coefficients, re, im),
        5 => horner::<5>(coefficients, re, im),
        6 => horner::<6>(coefficients, re, im),
        7 => horner::<7>(coefficients, re, im),
        8 => horner::<8>(coefficients, re, im),
        9 => horner::<9>(coefficients, re, im),
        _ => horner::<10>(coefficients, re, im),
    }
}

#[inline(always)]
fn horner<const DEGREE: usize>(
    coefficients: &[[f64; 2]; SeriesPanel::TERMS],
    re: &mut [f64],
    im: &mut [f64],
) {
    let middle = 0.5 * (re.len() as f64 - 1.0);
    for ((re, im), step) in re.iter_mut().zip(im).zip(&STEPS) {
        let t = step - middle;
        let [mut x, mut y] = coefficients[DEGREE];
        for n in (0..DEGREE).rev() {
            x = x * t + coefficients[n][0];
            y = y * t + coefficients[n][1];
        }
        (*re, *im) = (x, y);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Complex64;
    use super::*;

    /// ln(c + t) in each lane, about t = 0, c on and off the real axis.
    fn logarithm() -> (SeriesPanel, [Complex64; SeriesPanel::LANES]) {
        let centres = std::array::from_fn(|i| Complex64::from_polar(40.0 + 9.0 * i as f64, 0.2 * i as f64));
        let mut log = SeriesPanel::ZERO;
        for (i, c) in centres.iter().enumerate() {
            for n in 0..SeriesPanel::TERMS {
                let l = if n == 0 { c.ln() } else { -(-c.inv()).powi(n as i32) / n as f64 };
                (log.re[n][i], log.im[n][i]) = (l.re, l.im);
            }
        }
        (log, centres)
    }

    #[test]
    fn powers_and_their_products_with_the_logarithm_are_those_of_the_points() {
        let (log, centres) = logarithm();
        for order in [0.0, 0.4, 1.0, 2.0384, 5.3] {
            let mut want: Option<SeriesPanel> = None;
            for set in InstructionSet::available() {
                let (mut power, mut product) = (SeriesPanel::ZERO, SeriesPanel::ZERO);
                SeriesPanel::power(set, order, &log, &mut power);
                SeriesPanel::product(set, &power, &log, &mut product);
                for (i, c) in centres.iter().enumerate() {
                    let (mut re, mut im) = ([0.0; 3], [0.0; 3]);
                    let degree = SeriesPanel::TERMS - 1;
                    power.evaluate(set, i, degree, &mut re, &mut im);
                    let points = [-1.0, 0.0, 1.0].map(|t| (c + t).ln());
                    for (k, ln) in points.iter().enumerate() {
                        let expected = (ln * order).exp();
                        let error = (Complex64::new(re[k], im[k]) - expected).norm() / expected.norm();
                        assert!(error < 5e-15, "order {order} at {c}: {error:e}");
                    }
                    product.evaluate(set, i, degree, &mut re, &mut im);
                    for (k, ln) in points.iter().enumerate() {
                        let expected = (ln * order).exp() * ln;
                        let error = (Complex64::new(re[k], im[k]) - expected).norm() / expected.norm();
                        assert!(error < 5e-15, "order {order} at {c}: {error:e}");
                    }
                }
                power.add(-0.3, &product);
                assert!(want.as_ref().is_none_or(|want| *want == power), "{set:?} rounds differently");
                want = Some(power);
            }
        }
    }

    #[test]
    fn a_series_is_cut_off_behind_the_degree_asked_for() {
        let mut panel = SeriesPanel::ZERO;
        for n in 0..SeriesPanel::TERMS {
            (panel.re[n][2], panel.im[n][2]) = (1.0, -2.0);
        }
        let geometric = |t: f64, degree: i32| (0..=degree).map(|n| t.powi(n)).sum::<f64>();
        for set in InstructionSet::available() {
            for degree in 3..SeriesPanel::TERMS {
                let (mut re, mut im) = ([0.0; 4], [0.0; 4]);
                panel.evaluate(set, 2, degree, &mut re, &mut im);
                for (t, (re, im)) in [-1.5, -0.5, 0.5, 1.5].into_iter().zip(re.into_iter().zip(im)) {
                    let expected = geometric(t, degree as i32);
                    assert!((re - expected).abs() < 1e-12 && (im + 2.0 * expected).abs() < 1e-12);
                }
            }
        }
    }
}
