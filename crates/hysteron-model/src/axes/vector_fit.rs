//! Common poles and residues of all entries of a frequency response, in the z plane.
//!
//! Relaxed vector fitting: with poles p, σ(z) = Σ c̃ φ_p(z) + d̃ and (σ G)(z) = Σ c φ_p(z) + d are linear in
//! their coefficients; the zeros of σ are the next poles (B. Gustavsen, A. Semlyen, doi:10.1109/61.772353;
//! relaxed: B. Gustavsen, doi:10.1109/TPWRD.2005.860281). Each entry's own coefficients are eliminated first,
//! so that entries share nothing but σ (D. Deschrijver et al., doi:10.1109/LMWC.2008.922585).

use nalgebra::{DMatrix, DMatrixView, Dyn};
use rayon::prelude::*;

use super::{AxesError, FrequencyMatrix};
use hysteron_numeric::{Complex64, least_squares};

/// Share of a column outside the span of the others below which poles coincide.
const DEPENDENT: f64 = 1e-14;

/// Largest move of a pole in a pass that is no longer worth another.
const SETTLED: f64 = 1e-9;

/// Share of a column of σ outside all others, of its size before the entries' own coefficients explain their part,
/// from which the difference of the products keeps the digits that a pass needs: its square is right to 1e-8.
const KEPT: f64 = 1e-4;

/// Imaginary part below which a pole counts as real.
const REAL: f64 = 1e-9;

/// Entries to be fitted by 1/(z − p) of complex pairs p, of real poles, and a constant.
#[derive(Clone, Debug)]
pub struct VectorFit {
    /// e^(iωT) at every frequency.
    z: Vec<Complex64>,
    /// Entries in columns, real parts above imaginary parts.
    entries: DMatrix<f64>,
    /// Fixed real poles.
    held: Vec<f64>,
}

/// Poles that all entries share.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonPoles {
    /// The pole above the real axis of each complex pair.
    pub pairs: Vec<Complex64>,
    /// Real poles, but for those held.
    pub real: Vec<f64>,
}

impl CommonPoles {
    /// Pairs by ascending angle, real poles by value.
    fn sort(&mut self) {
        self.pairs.sort_by(|a, b| a.arg().total_cmp(&b.arg()));
        self.real.sort_by(f64::total_cmp);
    }

    /// True if no pole differs by more than [`SETTLED`].
    fn is_near(&self, other: &Self) -> bool {
        let mut pairs = self.pairs.iter().zip(&other.pairs);
        let mut real = self.real.iter().zip(&other.real);
        self.pairs.len() == other.pairs.len()
            && self.real.len() == other.real.len()
            && pairs.all(|(a, b)| (a - b).norm() <= SETTLED)
            && real.all(|(a, b)| (a - b).abs() <= SETTLED)
    }
}

/// Pairs e^(2πf(i − damping)T), f equally spaced from `low_hz` to `high_hz`, and no real poles.
pub fn spread_poles(count: usize, (low_hz, high_hz): (f64, f64), damping: f64, rate_hz: f64) -> CommonPoles {
    let gaps = count.saturating_sub(1).max(1) as f64;
    let pole = |k: usize| {
        let frequency = low_hz + (high_hz - low_hz) * k as f64 / gaps;
        (Complex64::new(-damping, 1.0) * (std::f64::consts::TAU * frequency / rate_hz)).exp()
    };
    CommonPoles { pairs: (0..count).map(pole).collect(), real: Vec::new() }
}

impl VectorFit {
    /// The entries of a frequency response, at `rate_hz` steps per second, with real poles `held`.
    pub fn new(response: &FrequencyMatrix, rate_hz: f64, held: Vec<f64>) -> Self {
        let z = response
            .frequency_hz
            .iter()
            .map(|f| Complex64::from_polar(1.0, std::f64::consts::TAU * f / rate_hz))
            .collect();
        let entries =
            DMatrix::from_fn(response.len(), response.inputs * response.outputs, |k, e| response.at(k)[e]);
        Self { z, entries: stacked(&entries), held }
    }

    /// Poles after at most `passes` relocations from `start`, by ascending angle: fewer where no pole moves any
    /// more, and once `go_on`, called before each, is false.
    ///
    /// # Errors
    /// [`AxesError::NoPoles`].
    pub fn poles(
        &self,
        start: CommonPoles,
        passes: usize,
        go_on: impl Fn() -> bool,
    ) -> Result<CommonPoles, AxesError> {
        let mut poles = start;
        poles.sort();
        let mut room = Vec::new();
        for _ in (0..passes).take_while(|_| go_on()) {
            let mut moved = self.relocate(&poles, &mut room).ok_or(AxesError::NoPoles)?;
            moved.sort();
            let is_settled = moved.is_near(&poles);
            poles = moved;
            if is_settled {
                break;
            }
        }
        Ok(poles)
    }

    /// Residues of the pairs, of the real poles and the held ones, and the constants: one list of complex
    /// numbers an entry, in this order (real poles and constants have no imaginary part). Linear least
    /// squares.
    ///
    /// # Errors
    /// [`AxesError::NoPoles`] where poles coincide.
    pub fn residues(&self, poles: &CommonPoles) -> Result<Vec<Vec<Complex64>>, AxesError> {
        let found = least_squares(self.basis(poles), self.entries.clone(), DEPENDENT);
        let solution = found.map_err(|_| AxesError::NoPoles)?.solution;
        let pairs = poles.pairs.len();
        let of = |entry: usize, row: usize| solution[(row, entry)];
        let entry = |e: usize| {
            let complex = (0..pairs).map(|k| Complex64::new(of(e, 2 * k), of(e, 2 * k + 1)));
            let real = (2 * pairs..solution.nrows()).map(|row| Complex64::new(of(e, row), 0.0));
            complex.chain(real).collect()
        };
        Ok((0..self.entries.ncols()).map(entry).collect())
    }

    /// rms difference of the entries and their fit by these poles.
    ///
    /// # Errors
    /// Those of [`Self::residues`].
    pub fn error(&self, poles: &CommonPoles) -> Result<f64, AxesError> {
        let basis = self.basis(poles);
        let q = basis.qr().q();
        let left = &self.entries - &q * (q.transpose() * &self.entries);
        Ok((2.0 * left.norm_squared() / self.entries.len().max(1) as f64).sqrt())
    }

    /// Real and imaginary parts below each other: 1/(z−p) + 1/(z−p̄), i/(z−p) − i/(z−p̄) of the pairs,
    /// 1/(z−p) of the real poles; then of the held ones, and a constant.
    fn basis(&self, poles: &CommonPoles) -> DMatrix<f64> {
        let one = Complex64::new(1.0, 0.0);
        let i = Complex64::new(0.0, 1.0);
        let mut columns: Vec<Vec<Complex64>> = Vec::new();
        for p in &poles.pairs {
            let both = |z: &Complex64| (one / (z - p), one / (z - p.conj()));
            columns.push(self.z.iter().map(|z| both(z).0 + both(z).1).collect());
            columns.push(self.z.iter().map(|z| i * (both(z).0 - both(z).1)).collect());
        }
        for p in poles.real.iter().chain(&self.held) {
            columns.push(self.z.iter().map(|z| one / (z - *p)).collect());
        }
        columns.push(vec![one; self.z.len()]);
        stacked(&DMatrix::from_fn(self.z.len(), columns.len(), |k, c| columns[c][k]))
    }

    /// The zeros of σ; `None` where an eigenvalue problem does not converge. `room` is kept from pass to pass.
    fn relocate(&self, poles: &CommonPoles, room: &mut Vec<Entry>) -> Option<CommonPoles> {
        let count = self.z.len();
        let basis = self.basis(poles);
        let own = basis.columns(0, 2 * poles.pairs.len() + poles.real.len()).transpose();
        let order = own.nrows();
        let across = basis.qr().q().transpose();
        let columns = order + 1;
        let entries = self.entries.ncols();
        self.explain(&own, &across, room);
        let mut normal =
            self.normal_by_difference(&own, room).unwrap_or_else(|| normal_by_projection(&across, room));
        // Relaxation: Re Σ σ = Σ 1, with the weight of the other equations.
        let weight = normal.trace() / (columns * entries) as f64;
        let mut sums: Vec<f64> =
            (0..order).map(|c| own.row(c).columns(0, count).sum() / count as f64).collect();
        sums.push(1.0);
        for (i, a) in sums.iter().enumerate() {
            for (j, b) in sums.iter().enumerate() {
                normal[(i, j)] += weight * a * b;
            }
        }
        let scale: Vec<f64> = (0..columns).map(|k| normal[(k, k)].sqrt().max(f64::MIN_POSITIVE)).collect();
        let scaled = DMatrix::from_fn(columns, columns, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        let target = nalgebra::DVector::from_fn(columns, |i, _| weight * sums[i] / scale[i]);
        let solution =
            scaled.clone().cholesky().map(|c| c.solve(&target)).or_else(|| scaled.lu().solve(&target))?;
        let sigma: Vec<f64> = solution.iter().zip(&scale).map(|(x, s)| x / s).collect();
        zeros_of_sigma(poles, &sigma)
    }

    /// Into `room` the equations of every entry, and what the entry's own coefficients explain of them.
    fn explain(&self, own: &DMatrix<f64>, across: &DMatrix<f64>, room: &mut Vec<Entry>) {
        let count = self.z.len();
        let (order, rows) = own.shape();
        let columns = order + 1;
        room.resize_with(self.entries.ncols(), Entry::default);
        room.par_iter_mut().enumerate().for_each(|(e, entry)| {
            if entry.equations.shape() != (columns, rows) {
                entry.equations = DMatrix::zeros(columns, rows);
            }
            let g = self.entries.column(e);
            let (g_re, g_im) = g.as_slice().split_at(count);
            let (left_re, left_im) = entry.equations.as_mut_slice().split_at_mut(columns * count);
            let (re, im) = own.as_slice().split_at(order * count);
            let lines = left_re.chunks_exact_mut(columns).zip(left_im.chunks_exact_mut(columns));
            let phi = re.chunks_exact(order).zip(im.chunks_exact(order));
            for (((to_re, to_im), (re, im)), (g_re, g_im)) in lines.zip(phi).zip(g_re.iter().zip(g_im)) {
                for ((to_re, to_im), (re, im)) in to_re.iter_mut().zip(&mut *to_im).zip(re.iter().zip(im)) {
                    *to_re = g_im * im - g_re * re;
                    *to_im = -g_re * im - g_im * re;
                }
                (to_re[order], to_im[order]) = (-g_re, -g_im);
            }
            entry.explained = &entry.equations * transposed(across);
        });
    }

    /// Products of the columns left in all equations: Σ LᵀL, which is Re Φᴴ diag(Σ |G|²) Φ with Φ = [φ, 1],
    /// without what is explained. `None` where the difference has lost too many digits.
    fn normal_by_difference(&self, own: &DMatrix<f64>, room: &[Entry]) -> Option<DMatrix<f64>> {
        let count = self.z.len();
        let (order, rows) = own.shape();
        let power =
            |k: usize| self.entries.row(k).norm_squared() + self.entries.row(count + k).norm_squared();
        let mut weighted = DMatrix::zeros(order + 1, rows);
        for k in 0..count {
            let root = power(k).sqrt();
            for row in [k, count + k] {
                weighted.view_mut((0, row), (order, 1)).copy_from(&(own.column(row) * root));
            }
            weighted[(order, k)] = root;
        }
        let whole = &weighted * transposed(&weighted);
        let explained: Vec<DMatrix<f64>> =
            room.par_iter().map(|e| &e.explained * transposed(&e.explained)).collect();
        let normal = explained.iter().fold(whole.clone(), |left, one| left - one);
        let scale = whole.diagonal().map(|x| x.sqrt().max(f64::MIN_POSITIVE));
        let scaled = DMatrix::from_fn(order + 1, order + 1, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
        let shares = scaled.cholesky()?.l_dirty().diagonal();
        (shares.min() >= KEPT).then_some(normal)
    }
}

/// An entry in a pass.
#[derive(Default)]
struct Entry {
    /// L = −G [φ, 1], transposed.
    equations: DMatrix<f64>,
    /// LᵀQ, by an orthonormal basis Q of the functions of the entry's own coefficients.
    explained: DMatrix<f64>,
}

/// The same as [`VectorFit::normal_by_difference`] from the columns L − Q QᵀL themselves: three times the work,
/// and all digits. What is explained is taken from the equations.
fn normal_by_projection(across: &DMatrix<f64>, room: &mut [Entry]) -> DMatrix<f64> {
    let of_entry = |entry: &mut Entry| {
        entry.equations.gemm(-1.0, &entry.explained, across, 1.0);
        &entry.equations * transposed(&entry.equations)
    };
    let products: Vec<DMatrix<f64>> = room.par_iter_mut().map(of_entry).collect();
    let columns = products.first().map_or(0, DMatrix::nrows);
    products.iter().fold(DMatrix::zeros(columns, columns), |sum, one| sum + one)
}

/// The transpose, for the right factor of a product: a left one must not have strides (nalgebra reads beyond its
/// end where the product has five rows or fewer).
fn transposed(matrix: &DMatrix<f64>) -> DMatrixView<'_, f64, Dyn, Dyn> {
    let (rows, columns) = matrix.shape();
    DMatrixView::from_slice_with_strides(matrix.as_slice(), columns, rows, rows, 1)
}

/// Real parts above imaginary parts.
fn stacked(complex: &DMatrix<Complex64>) -> DMatrix<f64> {
    let rows = complex.nrows();
    DMatrix::from_fn(2 * rows, complex.ncols(), |k, c| {
        if k < rows { complex[(k, c)].re } else { complex[(k - rows, c)].im }
    })
}

/// Eigenvalues of A − b c̃ᵀ/d̃, reflected into the unit circle where they are outside.
fn zeros_of_sigma(poles: &CommonPoles, sigma: &[f64]) -> Option<CommonPoles> {
    let order = 2 * poles.pairs.len() + poles.real.len();
    let constant = *sigma.get(order)?;
    let mut matrix = DMatrix::zeros(order, order);
    let mut drive = vec![1.0; order];
    for (k, p) in poles.pairs.iter().enumerate() {
        matrix[(2 * k, 2 * k)] = p.re;
        matrix[(2 * k + 1, 2 * k + 1)] = p.re;
        matrix[(2 * k, 2 * k + 1)] = p.im;
        matrix[(2 * k + 1, 2 * k)] = -p.im;
        (drive[2 * k], drive[2 * k + 1]) = (2.0, 0.0);
    }
    for (k, p) in poles.real.iter().enumerate() {
        let at = 2 * poles.pairs.len() + k;
        matrix[(at, at)] = *p;
    }
    for i in 0..order {
        for j in 0..order {
            matrix[(i, j)] -= drive[i] * sigma[j] / constant;
        }
    }
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let eigenvalues = nalgebra::linalg::Schur::try_new(matrix, f64::EPSILON, 10_000)?.complex_eigenvalues();
    let mut found = CommonPoles { pairs: Vec::new(), real: Vec::new() };
    for e in eigenvalues.iter() {
        let inside = if e.norm() > 1.0 { 1.0 / e.conj() } else { *e };
        if inside.im > REAL {
            found.pairs.push(inside);
        } else if inside.im.abs() <= REAL {
            found.real.push(inside.re);
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axes::{Mode, frequency, pole};

    const RATE: f64 = 4000.0;
    const MODES: [(f64, f64); 4] = [(120.0, 0.02), (300.0, 0.008), (310.0, 0.012), (800.0, 0.03)];

    fn residue(k: usize, e: usize) -> Complex64 {
        Complex64::from_polar(0.01 * (1.0 + (k + e) as f64), 0.7 * k as f64 - 1.1 * e as f64)
    }

    /// Four entries of [`MODES`], the pole 0.3 and a constant, plus `noise` that is no sum of poles.
    fn response(noise: f64) -> FrequencyMatrix {
        let poles = MODES.map(|(frequency_hz, damping)| pole(Mode { frequency_hz, damping }, RATE));
        let frequency_hz: Vec<f64> = (1..600).map(|k| 2.0 * f64::from(k)).collect();
        let mut values = Vec::new();
        for f in &frequency_hz {
            let z = Complex64::from_polar(1.0, std::f64::consts::TAU * f / RATE);
            for e in 0..4 {
                let pairs = poles
                    .iter()
                    .enumerate()
                    .map(|(k, p)| residue(k, e) / (z - p) + residue(k, e).conj() / (z - p.conj()));
                let rest = 0.05 * e as f64 / (z - 0.3) + 0.4;
                values.push(pairs.sum::<Complex64>() + rest + Complex64::from_polar(noise, f * f));
            }
        }
        FrequencyMatrix { inputs: 2, outputs: 2, frequency_hz, lines: (1..600).collect(), values }
    }

    /// Both sums of the products at these poles.
    fn both(fit: &VectorFit, poles: &CommonPoles) -> (Option<DMatrix<f64>>, DMatrix<f64>) {
        let basis = fit.basis(poles);
        let own = basis.columns(0, 2 * poles.pairs.len()).transpose();
        let across = basis.qr().q().transpose();
        let mut room = Vec::new();
        fit.explain(&own, &across, &mut room);
        let difference = fit.normal_by_difference(&own, &room);
        (difference, normal_by_projection(&across, &mut room))
    }

    #[test]
    fn the_difference_of_the_products_is_that_of_the_projected_columns_or_is_refused() {
        let start = spread_poles(5, (100.0, 1200.0), 0.01, RATE);
        let noisy = VectorFit::new(&response(1e-3), RATE, vec![0.3]);
        let (difference, exact) = both(&noisy, &start);
        let difference = difference.unwrap();
        for i in 0..exact.nrows() {
            for j in 0..exact.ncols() {
                let size = (exact[(i, i)] * exact[(j, j)]).sqrt();
                assert!((difference[(i, j)] - exact[(i, j)]).abs() < 1e-9 * size, "{i} {j}");
            }
        }
        // Without noise and at the poles of the response, all columns of σ but one are explained.
        let pairs = MODES.map(|(frequency_hz, damping)| pole(Mode { frequency_hz, damping }, RATE)).to_vec();
        let exact = VectorFit::new(&response(0.0), RATE, vec![0.3]);
        assert!(both(&exact, &CommonPoles { pairs, real: Vec::new() }).0.is_none());
    }

    #[test]
    fn known_poles_and_residues_are_found_from_a_spread_start() {
        let fit = VectorFit::new(&response(0.0), RATE, vec![0.3]);
        let start = spread_poles(4, (100.0, 1200.0), 0.01, RATE);
        let found = fit.poles(start, 20, || true).unwrap();
        assert!(found.real.is_empty() && found.pairs.len() == 4, "{found:?}");
        for (found, &(f, damping)) in found.pairs.iter().zip(&MODES) {
            let mode = frequency(*found, RATE);
            assert!((mode.frequency_hz / f - 1.0).abs() < 1e-8, "{mode:?} {f}");
            assert!((mode.damping / damping - 1.0).abs() < 1e-6, "{mode:?} {damping}");
        }
        let residues = fit.residues(&found).unwrap();
        for (e, found) in residues.iter().enumerate() {
            for (k, found) in found.iter().take(4).enumerate() {
                assert!((found - residue(k, e)).norm() < 1e-8, "{found} {}", residue(k, e));
            }
            assert!((found[4].re - 0.05 * e as f64).abs() < 1e-8 && (found[5].re - 0.4).abs() < 1e-8);
        }
    }
}
