//! Quasi-static gain of each actuator at each sensor.

use nalgebra::DMatrix;

use super::FrequencyMatrix;

/// Quasi-static band, as shares of the highest excited frequency: above the drift, below the modes.
const BAND: (f64, f64) = (1.0 / 600.0, 1.0 / 50.0);

/// Quasi-static gain matrix with its singular values.
#[derive(Clone, Debug, PartialEq)]
pub struct InfluenceMatrix {
    /// Number of inputs.
    pub inputs: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// Outputs × inputs, row by row \[µm/V\].
    pub values: Vec<f64>,
    /// Singular values, descending \[µm/V\].
    pub singular_values: Vec<f64>,
}

impl InfluenceMatrix {
    /// From outputs × inputs numbers, row by row.
    pub fn new(inputs: usize, outputs: usize, values: Vec<f64>) -> Self {
        let matrix = DMatrix::from_row_slice(outputs, inputs, &values);
        let mut singular_values: Vec<f64> = matrix.singular_values().iter().copied().collect();
        singular_values.sort_by(|a, b| b.total_cmp(a));
        Self { inputs, outputs, values, singular_values }
    }

    /// Mean real part of a frequency response over its slow lines, from 1/600 to 1/50 of its highest
    /// frequency.
    pub fn of_response(response: &FrequencyMatrix) -> Self {
        let top = response.frequency_hz.last().copied().unwrap_or(1.0);
        Self::new(response.inputs, response.outputs, response.mean_real(BAND.0 * top, BAND.1 * top))
    }

    /// Largest over smallest singular value; infinite where the matrix is rank deficient.
    pub fn condition_number(&self) -> f64 {
        match (self.singular_values.first(), self.singular_values.last()) {
            (Some(largest), Some(smallest)) => largest / smallest,
            _ => f64::INFINITY,
        }
    }

    /// Inputs × outputs, row by row: the drives for a unit of each output, by the pseudo-inverse (inverse
    /// where it is square). `None` where it is singular.
    pub fn inverse(&self) -> Option<Vec<f64>> {
        /// Singular value over the largest that counts as zero.
        const SINGULAR: f64 = 1e-9;
        let condition = self.condition_number();
        if condition.is_nan() || condition >= 1.0 / SINGULAR {
            return None;
        }
        let matrix = DMatrix::from_row_slice(self.outputs, self.inputs, &self.values);
        let inverse = matrix.pseudo_inverse(0.0).ok()?;
        Some(inverse.transpose().as_slice().to_vec())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditioning_and_inverse_by_hand() {
        // diag(3, 4) turned: singular values 4 and 3.
        let m = InfluenceMatrix::new(2, 2, vec![0.0, 4.0, -3.0, 0.0]);
        assert!(
            (m.singular_values[0] - 4.0).abs() < 1e-15 && (m.condition_number() - 4.0 / 3.0).abs() < 1e-14
        );
        let inverse = m.inverse().unwrap();
        for (found, truth) in inverse.iter().zip([0.0, -1.0 / 3.0, 0.25, 0.0]) {
            assert!((found - truth).abs() < 1e-15, "{inverse:?}");
        }
        assert!(InfluenceMatrix::new(2, 2, vec![1.0, 2.0, 2.0, 4.0]).inverse().is_none());
        // Two sensors, one actuator: least squares.
        let tall = InfluenceMatrix::new(1, 2, vec![3.0, 4.0]);
        assert!(tall.inverse().unwrap().iter().zip([0.12, 0.16]).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
