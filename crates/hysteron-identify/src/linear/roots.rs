//! Zeros of polynomials, and polynomials with their unstable zeros reflected.

use nalgebra::DMatrix;

use hysteron_numeric::Complex64;

/// Zeros of xⁿ + c₁ xⁿ⁻¹ + … + c_n, the eigenvalues of its companion matrix.
pub(super) fn roots(c: &[f64]) -> Vec<Complex64> {
    let n = c.len();
    if n == 0 || c.iter().any(|c| !c.is_finite()) {
        return Vec::new();
    }
    let companion = DMatrix::from_fn(n, n, |i, j| match i {
        0 => -c[j],
        _ if i == j + 1 => 1.0,
        _ => 0.0,
    });
    companion.complex_eigenvalues().iter().map(|z| Complex64::new(z.re, z.im)).collect()
}

/// c₁ … c_n of the monic polynomial with these zeros, which come in conjugate pairs.
pub(super) fn monic(roots: &[Complex64]) -> Vec<f64> {
    let mut c = vec![Complex64::ONE];
    for root in roots {
        c.push(Complex64::ZERO);
        for k in (1..c.len()).rev() {
            let below = c[k - 1];
            c[k] -= root * below;
        }
    }
    c.iter().skip(1).map(|c| c.re).collect()
}

/// Reflects zeros on or outside the unit circle into it.
pub(super) fn inside_the_circle(c: &[f64]) -> Vec<f64> {
    let mirror = |z: Complex64| match z.norm() {
        size if size >= 1.0 => (1.0 / z.conj()) * if size < 1.0 + 1e-6 { 0.999 } else { 1.0 },
        _ => z,
    };
    reflected(c, mirror)
}

/// Reflects zeros on or right of the imaginary axis to its left.
pub(super) fn left_of_the_axis(c: &[f64]) -> Vec<f64> {
    let mirror = |s: Complex64| Complex64::new(-s.re.abs().max(1e-6 * s.norm()), s.im);
    reflected(c, |s| if s.re < 0.0 { s } else { mirror(s) })
}

fn reflected(c: &[f64], mirror: impl Fn(Complex64) -> Complex64) -> Vec<f64> {
    let roots = roots(c);
    if roots.iter().all(|&z| mirror(z) == z) {
        return c.to_vec();
    }
    monic(&roots.into_iter().map(mirror).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unstable_zeros_go_to_their_mirror_points() {
        // (z − 2)(z − 0.5) → (z − 0.5)²; (s − 1)(s + 3) → (s + 1)(s + 3).
        for (found, expected) in [
            (inside_the_circle(&[-2.5, 1.0]), [-1.0, 0.25]),
            (left_of_the_axis(&[2.0, -3.0]), [4.0, 3.0]),
            (inside_the_circle(&[-0.9, 0.2]), [-0.9, 0.2]),
        ] {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        }
        // A pair 1 ± 2i goes to −1 ± 2i.
        let pair = left_of_the_axis(&[-2.0, 5.0]);
        assert!((pair[0] - 2.0).abs() < 1e-12 && (pair[1] - 5.0).abs() < 1e-12, "{pair:?}");
    }
}
