//! Poles of a rational response by vector fitting, in the form of [`Core::Rational`].
//!
//! Sanathanan and Koerner's iteration in partial fractions, where it stays well conditioned at any number of
//! poles (Gustavsen and Semlyen 1999, doi:10.1109/61.772353): with σ(s) = 1 + Σ c̃_k φ_k(s), the equations (σ
//! G)(s_i) ≈ Σ c_k φ_k(s_i) [+ d] are linear, and the zeros of σ are improved poles.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::super::projection::Projection;
use hysteron_numeric::Complex64;
use hysteron_numeric::dot;

/// Data of the pole relocation: relative weights, so that the target is 1 everywhere.
pub(super) struct Relocation<'a> {
    /// Angular frequencies \[rad/s\].
    pub omega: &'a [f64],
    /// G without its power law, loss angle and delay.
    pub values: &'a [Complex64],
    /// Includes a direct feedthrough.
    pub direct: bool,
}

impl Relocation<'_> {
    /// Poles (upper half-plane and real, in the left half-plane) after one pass; `None` where it fails.
    pub fn pass(&self, poles: &[Complex64]) -> Option<Vec<Complex64>> {
        let points = self.omega.len();
        let order: usize = poles.iter().map(|p| if p.im == 0.0 { 1 } else { 2 }).sum();
        let constant = usize::from(self.direct);
        let (rows, columns) = (2 * points, 2 * order + constant);
        let mut matrix = vec![0.0; rows * columns];
        let mut target = vec![0.0; rows];
        for (i, (&omega, g)) in self.omega.iter().zip(self.values).enumerate() {
            let s = Complex64::new(0.0, omega);
            let mut put = |column: usize, z: Complex64| {
                matrix[column * rows + i] = z.re;
                matrix[column * rows + points + i] = z.im;
            };
            let weight = g.inv();
            if self.direct {
                put(0, weight);
            }
            let mut k = constant;
            for &p in poles {
                let (one, conjugate) = ((s - p).inv(), (s - p.conj()).inv());
                let pair = [one + conjugate, Complex64::I * (one - conjugate)];
                let functions = if p.im == 0.0 { &[one][..] } else { &pair[..] };
                for &function in functions {
                    put(k, weight * function);
                    put(k + order, -function);
                    k += 1;
                }
            }
            target[i] = 1.0;
        }
        // Columns scaled to unit length: poles differ by decades.
        let lengths: Vec<f64> = matrix.chunks_exact(rows).map(|c| dot(c, c).sqrt()).collect();
        for (column, length) in matrix.chunks_exact_mut(rows).zip(&lengths) {
            column.iter_mut().for_each(|x| *x /= length.max(f64::MIN_POSITIVE));
        }
        let mut projection = Projection::new(rows, columns);
        projection.decompose(&matrix);
        let mut solution = vec![0.0; columns];
        projection.coefficients_into(&target, &mut solution);
        let first = constant + order;
        let residues: Vec<f64> =
            solution[first..].iter().zip(&lengths[first..]).map(|(c, length)| c / length).collect();
        zeros_of_sigma(poles, &residues)
    }
}

/// Eigenvalues of A − b c̃ᵀ for the real state space of the poles, reflected into the left half-plane.
fn zeros_of_sigma(poles: &[Complex64], residues: &[f64]) -> Option<Vec<Complex64>> {
    let order = residues.len();
    let mut matrix = DMatrix::zeros(order, order);
    let mut drive = vec![0.0; order];
    let mut k = 0;
    for p in poles {
        matrix[(k, k)] = p.re;
        if p.im == 0.0 {
            drive[k] = 1.0;
            k += 1;
        } else {
            matrix[(k + 1, k + 1)] = p.re;
            matrix[(k, k + 1)] = p.im;
            matrix[(k + 1, k)] = -p.im;
            drive[k] = 2.0;
            k += 2;
        }
    }
    for (i, b) in drive.iter().enumerate() {
        for (j, c) in residues.iter().enumerate() {
            matrix[(i, j)] -= b * c;
        }
    }
    if !matrix.iter().all(|x: &f64| x.is_finite()) {
        return None;
    }
    let schur = nalgebra::linalg::Schur::try_new(matrix, f64::EPSILON, 10_000)?;
    let eigenvalues = schur.complex_eigenvalues();
    let mut zeros: Vec<Complex64> = Vec::new();
    for z in eigenvalues.iter() {
        let stable = Complex64::new(-z.re.abs().max(1e-9 * z.norm()), z.im);
        if !stable.is_finite() || stable.re == 0.0 {
            return None;
        }
        if stable.im >= 0.0 {
            zeros.push(stable);
        }
    }
    let found: usize = zeros.iter().map(|z| if z.im == 0.0 { 1 } else { 2 }).sum();
    (found == order).then_some(zeros)
}

/// `count` poles spread over the band: lightly damped pairs, and one real pole below them where the number is
/// odd.
pub(super) fn spread(count: usize, low_hz: f64, high_hz: f64) -> Vec<Complex64> {
    let pairs = count / 2;
    let mut poles: Vec<Complex64> = Vec::new();
    if count % 2 == 1 {
        poles.push(Complex64::new(-TAU * low_hz, 0.0));
    }
    for k in 0..pairs {
        let share = (k as f64 + 0.5) / pairs as f64;
        let omega = TAU * low_hz * (high_hz / low_hz).powf(share);
        poles.push(Complex64::new(-0.05 * omega, omega));
    }
    poles
}

/// Parameters of the rational core: frequency of the odd real pole, then frequency \[Hz\] and damping of each
/// pair by ascending frequency. Real poles are paired neighbour by neighbour.
pub(super) fn parameters(poles: &[Complex64]) -> Vec<f64> {
    let mut real: Vec<f64> = poles.iter().filter(|p| p.im == 0.0).map(|p| -p.re).collect();
    real.sort_by(f64::total_cmp);
    let odd = (real.len() % 2 == 1).then(|| real.remove(0));
    let mut pairs: Vec<(f64, f64)> =
        poles.iter().filter(|p| p.im != 0.0).map(|p| (p.norm(), -p.re / p.norm())).collect();
    pairs.extend(real.chunks_exact(2).map(|two| {
        let omega = (two[0] * two[1]).sqrt();
        (omega, (two[0] + two[1]) / (2.0 * omega))
    }));
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let single = odd.map(|omega| omega / TAU);
    single.into_iter().chain(pairs.into_iter().flat_map(|(omega, zeta)| [omega / TAU, zeta])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_of_an_exact_rational_response_are_found_from_a_spread_start() {
        // Modes at 40 and 90 Hz of damping 2 and 5 %, a real pole at 8 Hz and a constant.
        let mode = |f: f64, zeta: f64| {
            let omega = TAU * f;
            Complex64::new(-zeta * omega, omega * (1.0 - zeta * zeta).sqrt())
        };
        let truth = [Complex64::new(-TAU * 8.0, 0.0), mode(40.0, 0.02), mode(90.0, 0.05)];
        let omega: Vec<f64> = (0..120).map(|k| TAU * 1.05f64.powi(k)).collect();
        let values: Vec<Complex64> = omega
            .iter()
            .map(|&w| {
                let s = Complex64::new(0.0, w);
                let pair = |p: Complex64, r: Complex64| r / (s - p) + r.conj() / (s - p.conj());
                0.3 + 40.0 / (s - truth[0])
                    + pair(truth[1], Complex64::new(5.0, -30.0))
                    + pair(truth[2], Complex64::new(-8.0, 20.0))
            })
            .collect();
        let relocation = Relocation { omega: &omega, values: &values, direct: true };
        let mut poles = spread(5, 1.0, 300.0);
        for _ in 0..12 {
            poles = relocation.pass(&poles).unwrap();
        }
        let found = parameters(&poles);
        for (found, expected) in found.iter().zip([8.0, 40.0, 0.02, 90.0, 0.05]) {
            assert!((found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
        }
    }

    #[test]
    fn two_real_poles_are_one_overdamped_pair() {
        // (s + 2)(s + 18): ω = 6, ζ = 20/12.
        let found = parameters(&[Complex64::new(-18.0, 0.0), Complex64::new(-2.0, 0.0)]);
        assert!((found[0] * TAU - 6.0).abs() < 1e-12 && (found[1] - 20.0 / 12.0).abs() < 1e-12);
    }
}
