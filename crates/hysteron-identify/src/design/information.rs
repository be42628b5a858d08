//! Fisher information of a record about the directions of the prior.
//!
//! With G the derivatives of the output with respect to the directions z, about their mean (the sensor's
//! offset is free), and noise of standard deviation σ, F = GᵀG/σ². Where the residual of the training records
//! is coloured, least squares has the covariance A⁻¹ B A⁻¹ with A = GᵀG and B = GᵀΩG, Ω the residual's
//! covariance ([`coloured_square`], as in the standard errors of a fit), and F = A B⁻¹ A. The prior has the
//! information I, so that the covariance after the record is (I + F)⁻¹.
//!
//! The fit does not know σ: it weights each record by the noise floor that it finds in it, which is too large
//! where the motion itself is rough within a few samples. With the share w of its due weight the covariance
//! is (I + wF)⁻¹ (I + w²F) (I + wF)⁻¹.

use hysteron_numeric::dot;
use nalgebra::{Cholesky, DMatrix};

use crate::joint::coloured_square;

/// Share of the largest eigenvalue of B below which a direction carries no information but rounding.
const ROUNDING: f64 = 1e-12;

/// Noise of a measurement about the model.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Noise {
    /// White, of this standard deviation.
    White(f64),
    /// With the spectrum of this residual, at the sample rate of the drive.
    Like(Vec<f64>),
}

impl Noise {
    /// Standard deviation.
    pub(super) fn deviation(&self) -> f64 {
        match self {
            Self::White(deviation) => *deviation,
            Self::Like(residual) => (dot(residual, residual) / residual.len().max(1) as f64).sqrt(),
        }
    }

    /// Noise of a drive sampled more coarsely by a whole factor: for white noise, that of the means of as
    /// many samples.
    pub(super) fn coarser(&self, factor: usize) -> Self {
        match self {
            Self::White(deviation) => Self::White(deviation / (factor as f64).sqrt()),
            Self::Like(residual) => Self::Like(
                residual.chunks_exact(factor).map(|part| part.iter().sum::<f64>() / factor as f64).collect(),
            ),
        }
    }
}

/// Information matrix F of the derivatives `columns` of the output, about their means.
pub(super) fn information(columns: &[Vec<f64>], noise: &Noise) -> DMatrix<f64> {
    let count = columns.len();
    let gram = DMatrix::from_fn(count, count, |i, j| dot(&columns[i], &columns[j]));
    let residual = match noise {
        Noise::White(deviation) => return gram / deviation.powi(2),
        Noise::Like(residual) => residual,
    };
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let eigen = coloured_square(&slices, residual).symmetric_eigen();
    let floor = ROUNDING * eigen.eigenvalues.max();
    let inverse = eigen.eigenvalues.map(|value| if value > floor { 1.0 / value } else { 0.0 });
    let rows = eigen.eigenvectors.transpose() * gram;
    rows.transpose() * DMatrix::from_diagonal(&inverse) * rows
}

/// `information` with its last parameter, which every record has anew, eliminated.
pub(super) fn without_last(information: &DMatrix<f64>) -> DMatrix<f64> {
    let count = information.nrows().saturating_sub(1);
    let own = information.view((0, 0), (count, count)).into_owned();
    let along = information.view((0, count), (count, 1)).into_owned();
    let last = information[(count, count)];
    if last > 0.0 { own - &along * along.transpose() / last } else { own }
}

/// Information of a record, and the share of its due weight that the fit gives it.
#[derive(Clone, Debug)]
pub(super) struct Weighted {
    /// Information matrix F.
    pub(super) matrix: DMatrix<f64>,
    /// w: its weight in the fit over 1/σ².
    pub(super) weight: f64,
}

impl Weighted {
    /// No record.
    pub(super) fn nothing(count: usize) -> Self {
        Self { matrix: DMatrix::zeros(count, count), weight: 1.0 }
    }

    /// The record repeated.
    pub(super) fn repeated(&self, times: f64) -> Self {
        Self { matrix: &self.matrix * times, weight: self.weight }
    }

    /// Covariance of the directions after the record; `None` where rounding leaves none.
    pub(super) fn covariance(&self) -> Option<DMatrix<f64>> {
        let count = self.matrix.nrows();
        let symmetric = 0.5 * (&self.matrix + self.matrix.transpose());
        let whole = |share: f64| DMatrix::identity(count, count) + &symmetric * share;
        let bread = Cholesky::new(whole(self.weight))?.inverse();
        Some(&bread * whole(self.weight.powi(2)) * &bread)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns() -> Vec<Vec<f64>> {
        let of = |speed: f64| {
            let wave: Vec<f64> = (0..4000).map(|k| (f64::from(k) * speed).sin()).collect();
            let mean = wave.iter().sum::<f64>() / wave.len() as f64;
            wave.iter().map(|x| x - mean).collect()
        };
        vec![of(0.05), of(0.9)]
    }

    #[test]
    fn the_information_of_a_straight_line_is_that_of_the_textbook() {
        // y = c u + e: the variance of c falls from 1 to 1/(1 + Σ(u − ū)²/σ²).
        let u = vec![vec![-1.0, 0.0, 2.0, -1.0]];
        let matrix = information(&u, &Noise::White(0.5));
        let found = Weighted { matrix: matrix.clone(), weight: 1.0 }.covariance().unwrap();
        assert!((found[(0, 0)] - 1.0 / (1.0 + 6.0 / 0.25)).abs() < 1e-15);
        // Of half its weight: (1 + 24/4)/(1 + 24/2)².
        let less = Weighted { matrix, weight: 0.5 }.covariance().unwrap();
        assert!((less[(0, 0)] - 7.0 / 169.0).abs() < 1e-15);
    }

    #[test]
    fn a_parameter_of_the_record_alone_takes_information_away() {
        let both = DMatrix::from_row_slice(2, 2, &[5.0, 2.0, 2.0, 4.0]);
        assert_eq!(without_last(&both), DMatrix::from_element(1, 1, 4.0));
        let none = DMatrix::from_row_slice(2, 2, &[5.0, 0.0, 0.0, 0.0]);
        assert_eq!(without_last(&none)[(0, 0)], 5.0);
    }

    #[test]
    fn coloured_noise_hides_slow_derivatives_and_white_noise_none_more_than_others() {
        // First-order autoregression of coefficient 0.9 and unit variance, by a congruential generator.
        let (mut state, mut e) = (1u64, 0.0);
        let mut white = || {
            let mut sum = -6.0;
            for _ in 0..12 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                sum += (state >> 11) as f64 / (1u64 << 53) as f64;
            }
            sum
        };
        let residual: Vec<f64> = (0..4000)
            .map(|_| {
                e = 0.9 * e + (1.0f64 - 0.81).sqrt() * white();
                e
            })
            .collect();
        let of_white = information(&columns(), &Noise::White(1.0));
        let coloured = information(&columns(), &Noise::Like(residual));
        // The spectrum is (1 − a²)/(1 − 2a cos ω + a²) times that of white noise.
        let spectrum = |speed: f64| 0.19 / (1.81 - 1.8 * speed.cos());
        for (k, speed) in [(0, 0.05), (1, 0.9)] {
            let found = of_white[(k, k)] / coloured[(k, k)];
            assert!((found / spectrum(speed)).ln().abs() < 0.3, "{found} {}", spectrum(speed));
        }
    }
}
