//! Sample spacing at which the residuals of a correction are white.

use nalgebra::{DMatrix, DVector};

use super::Regressors;
use crate::{IdentifyError, correlation_time};
use hysteron_model::record::InputOutput;

/// Number of segments of a record: a jump affects one of them, but not the median.
const PARTS: usize = 8;
/// Fewest samples of a part for each of its coefficients.
const FEWEST: usize = 20;

impl<const N: usize> Regressors<N> {
    /// Number of samples per independent sample of the unexplained residual: the integrated autocorrelation
    /// time of the least-squares residual, median over eighths of the record. At least 1; 1 for a record that
    /// is too short.
    ///
    /// # Errors
    /// [`IdentifyError::CorrectionLengths`].
    pub fn samples_per_independent_one(&self, record: &InputOutput) -> Result<f64, IdentifyError> {
        let (expected, found) = (self.len(), record.y.len());
        if expected != found {
            return Err(IdentifyError::CorrectionLengths { expected, found });
        }
        let is_valid = |k: usize| record.is_valid(k);
        let rows: Vec<_> = self
            .rows()
            .zip(&record.y)
            .enumerate()
            .filter(|(k, _)| is_valid(*k))
            .map(|(_, pair)| pair)
            .collect();
        let length = rows.len() / PARTS;
        if length < FEWEST * N {
            return Ok(1.0);
        }
        let mut times: Vec<f64> = rows
            .chunks_exact(length)
            .filter_map(|part| {
                let regressors = DMatrix::from_fn(part.len(), N, |k, i| part[k].0.regressors[i]);
                let output = DVector::from_fn(part.len(), |k, _| part[k].1 - part[k].0.fixed);
                // A regressor constant within the segment is collinear with the offset.
                let parameters = regressors.clone().svd(true, true).solve(&output, 1e-9).ok()?;
                Some(correlation_time((output - regressors * parameters).as_slice()))
            })
            .collect();
        times.sort_by(f64::total_cmp);
        Ok(times.get(times.len() / 2).copied().unwrap_or(1.0))
    }
}
