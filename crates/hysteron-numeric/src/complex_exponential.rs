//! e^(pt) − 1 for a complex p and many t.

use super::Complex64;
use super::dispatch::{self, InstructionSet};
use super::elementary::{exp_m1, sin_cos};

/// Largest angle that [`sin_cos`] takes.
const LARGEST_ANGLE: f64 = 1e5;

/// e^(pt) − 1 for each t of `times` ≥ 0, as real and imaginary parts, on the shortest of the slices; with
/// full relative precision where pt is small. The real part of pt is limited to \[−708, 709\].
pub fn exponentials_less_one(
    set: InstructionSet,
    pole: Complex64,
    times: &[f64],
    re: &mut [f64],
    im: &mut [f64],
) {
    dispatch::exponentials_less_one(set, pole, times, re, im);
    for ((&time, re), im) in times.iter().zip(re).zip(im) {
        if (0.5 * pole.im * time).abs() > LARGEST_ANGLE {
            let exact = (pole * time).exp() - 1.0;
            (*re, *im) = (exact.re, exact.im);
        }
    }
}

/// With half the angle β: cos 2β − 1 = −2 sin² β, so that nothing cancels.
#[inline(always)]
pub(super) fn exponentials_less_one_kernel(pole: Complex64, times: &[f64], re: &mut [f64], im: &mut [f64]) {
    let half = 0.5 * pole.im;
    for ((&time, re), im) in times.iter().zip(re).zip(im) {
        let grown = exp_m1(pole.re * time);
        let (sin, cos) = sin_cos(half * time);
        let twice = 2.0 * (1.0 + grown) * sin;
        *re = grown - twice * sin;
        *im = twice * cos;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ (pt)ʲ/j!, j ≥ 1.
    fn series(x: Complex64) -> Complex64 {
        let (mut term, mut sum) = (Complex64::ONE, Complex64::ZERO);
        for j in 1..40 {
            term *= x / f64::from(j);
            sum += term;
        }
        sum
    }

    #[test]
    fn every_instruction_set_meets_series_and_library() {
        let times: Vec<f64> = (0..3000_i32).map(|k| 10_f64.powf(-14.0 + 0.006 * f64::from(k))).collect();
        for pole in
            [Complex64::new(-0.03, 1.0), Complex64::new(-0.8, 0.6), Complex64::new(-1.0, 0.0), Complex64::I]
        {
            let mut same: Option<(Vec<f64>, Vec<f64>)> = None;
            for set in InstructionSet::available() {
                let (mut re, mut im) = (vec![0.0; times.len()], vec![0.0; times.len()]);
                exponentials_less_one(set, pole, &times, &mut re, &mut im);
                for ((&time, &re), &im) in times.iter().zip(&re).zip(&im) {
                    let x = pole * time;
                    let expected = if x.norm() < 2.0 { series(x) } else { x.exp() - 1.0 };
                    let error = (Complex64::new(re, im) - expected).norm();
                    // At large angles the error is the rounding of the angle itself.
                    let allowed = 4.0 * f64::EPSILON * expected.norm().min(1.0) * x.im.abs().max(1.0);
                    assert!(error <= allowed, "{pole} {time:e}: {error:e}");
                }
                assert!(
                    same.as_ref().is_none_or(|(a, b)| (a, b) == (&re, &im)),
                    "{set:?} rounds differently"
                );
                same = Some((re, im));
            }
        }
    }
}
