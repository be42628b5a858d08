//! Relaxations at fixed rates that fit the remainder of G beside its resonances.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use super::super::{DynamicsError, TransferFunction};
use super::Tangents;
use super::resonant_poles::ResonantPole;
use hysteron_numeric::{Complex64, PER_OCTAVE, relaxation_rate};

/// The rates reach from this over the duration to this over the shortest step. They are h = ½ ln 2 apart in
/// ln λ: a single relaxation between two of them is met to about e^(−π²/2h) = 7e-7 of its size.
const RATES: (f64, f64) = (0.02, 60.0);
/// The angular frequencies of the fit reach from this over the duration to this over the shortest step.
const FREQUENCIES: (f64, f64) = (0.1, 4.0 * PI);
/// Frequencies per decade.
const PER_DECADE: usize = 16;
/// Singular values below this share of the largest are left out: they gain accuracy by weights that cancel.
const SMALLEST: f64 = 1e-9;
/// Largest deviation from a constant, as a share of the largest response, that needs no relaxations:
/// resonances and real poles describe the rest.
const CONSTANT: f64 = 1e-12;
/// Largest error of the response over the fit, as a share of the largest response.
const ACCURACY: f64 = 1e-5;

/// The fixed part of the fit G(iω) ≈ d + Σ wₖ λₖ/(iω + λₖ), of a duration and a shortest step.
#[derive(Clone, Debug)]
pub(super) struct RelaxationFit {
    /// λₖ \[rad/s\], ascending.
    pub rates: Vec<f64>,
    omegas: Vec<f64>,
    /// Columns: the relaxations, then the constant; rows: real parts, then imaginary ones.
    matrix: DMatrix<f64>,
    /// Its pseudo-inverse.
    inverse: DMatrix<f64>,
}

/// Weights of the relaxations and the direct term.
#[derive(Clone, Debug, Default)]
pub(super) struct Weights {
    pub relaxations: Vec<f64>,
    pub direct: f64,
}

impl RelaxationFit {
    pub fn new(duration_s: f64, shortest_step_s: f64) -> Result<Self, DynamicsError> {
        let between = |(low, high): (f64, f64)| (low / duration_s, high / shortest_step_s);
        let (slowest, fastest) = between(RATES);
        let count = (PER_OCTAVE as f64 * (fastest / slowest).log2()).ceil() as usize;
        let rates: Vec<f64> = (0..=count).map(|k| relaxation_rate(slowest, k)).collect();
        let (lowest, highest) = between(FREQUENCIES);
        let decades = (highest / lowest).log10();
        let omegas = spread(lowest, highest, (decades * PER_DECADE as f64).ceil() as usize);
        let rows = omegas.len();
        let matrix = DMatrix::from_fn(2 * rows, rates.len() + 1, |row, column| {
            let Some(&rate) = rates.get(column) else { return f64::from(u8::from(row < rows)) };
            let value = rate / Complex64::new(rate, omegas[row % rows]);
            if row < rows { value.re } else { value.im }
        });
        let svd =
            matrix.clone().try_svd(true, true, f64::EPSILON, 2000).ok_or(DynamicsError::OutputNotFinite)?;
        let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
        let inverse = svd.pseudo_inverse(SMALLEST * largest).map_err(|_| DynamicsError::OutputNotFinite)?;
        Ok(Self { rates, omegas, matrix, inverse })
    }

    /// Weights for `tf` without its `resonances`, and for its derivatives.
    ///
    /// # Errors
    /// [`DynamicsError::OutputNotFinite`] where relaxations do not describe it.
    pub fn weights(
        &self,
        tf: &TransferFunction,
        linearised: Tangents<'_>,
        resonances: &[ResonantPole],
    ) -> Result<(Weights, Vec<Weights>), DynamicsError> {
        let rows = self.omegas.len();
        let parameters = linearised.map_or(0, |linearised| linearised.parameters());
        let mut value = DVector::zeros(2 * rows);
        let mut tangents = vec![DVector::zeros(2 * rows); parameters];
        let put = |to: &mut DVector<f64>, row: usize, z: Complex64| (to[row], to[rows + row]) = (z.re, z.im);
        let mut largest: f64 = 0.0;
        let mut largest_tangents = vec![0.0_f64; parameters];
        for (row, &omega) in self.omegas.iter().enumerate() {
            let s = Complex64::new(0.0, omega);
            let log = Complex64::new(omega.ln(), 0.5 * PI);
            let power = |order: f64| (log * order).exp();
            let sum = |terms: &[super::super::Term]| -> Complex64 {
                terms.iter().map(|term| power(term.order) * term.coefficient).sum()
            };
            let (numerator, denominator) = (sum(&tf.numerator), sum(&tf.denominator));
            let g = numerator / denominator;
            largest = largest.max(g.norm());
            let paired: Complex64 = resonances.iter().map(|pole| pole.response(s)).sum();
            put(&mut value, row, g - paired);
            let Some(linearised) = linearised else { continue };
            for (which, tangent) in tangents.iter_mut().enumerate() {
                let moved = |terms: &[super::super::Term],
                             of: &dyn Fn(usize) -> super::super::TermTangent| {
                    let each = terms.iter().enumerate().map(|(index, term)| {
                        let t = of(index);
                        power(term.order) * (log * t.weighted_order + t.coefficient)
                    });
                    each.sum::<Complex64>()
                };
                let nth = |of: &[super::super::TermTangent]| of.get(which).copied().unwrap_or_default();
                let above = moved(&tf.numerator, &|term| nth(linearised.numerator_term(term)));
                let below = moved(&tf.denominator, &|term| nth(linearised.denominator_term(term)));
                let paired: Complex64 = resonances.iter().map(|pole| pole.response_tangent(s, which)).sum();
                let whole = (above - g * below) / denominator;
                largest_tangents[which] = largest_tangents[which].max(whole.norm());
                put(tangent, row, whole - paired);
            }
        }
        let fitted = &self.inverse * &value;
        let left = &self.matrix * &fitted - &value;
        let error = left.amax();
        if error.is_nan() || error > ACCURACY * largest {
            return Err(DynamicsError::OutputNotFinite);
        }
        let tangents = tangents.iter().zip(largest_tangents).map(|(tangent, largest)| {
            self.constant(tangent, largest).unwrap_or_else(|| self.split(&(&self.inverse * tangent)))
        });
        let tangents = tangents.collect();
        Ok((self.constant(&value, largest).unwrap_or_else(|| self.split(&fitted)), tangents))
    }

    /// No relaxations, where a response is the same real number at every frequency.
    fn constant(&self, response: &DVector<f64>, largest: f64) -> Option<Weights> {
        let rows = self.omegas.len();
        let direct = response.rows(0, rows).mean();
        let expected = |row: usize| if row < rows { direct } else { 0.0 };
        let left = response.iter().enumerate().map(|(row, x)| (x - expected(row)).abs()).fold(0.0, f64::max);
        (left <= CONSTANT * largest).then(|| Weights { relaxations: vec![0.0; self.rates.len()], direct })
    }

    fn split(&self, solution: &DVector<f64>) -> Weights {
        let count = self.rates.len();
        Weights { relaxations: solution.iter().take(count).copied().collect(), direct: solution[count] }
    }
}

/// `count` + 1 numbers from `low` to `high` on a logarithmic scale.
fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| low * (high / low).powf(k as f64 / count as f64)).collect()
}
