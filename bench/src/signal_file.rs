//! Samples as raw little-endian doubles, the one format both sides read without a parser.

use std::path::Path;

use crate::error::BenchError;

/// Reads samples.
pub fn read(path: &Path) -> Result<Vec<f64>, BenchError> {
    let bytes =
        std::fs::read(path).map_err(|source| BenchError::SignalFile { path: path.to_owned(), source })?;
    let (samples, _) = bytes.as_chunks::<8>();
    Ok(samples.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

/// Writes samples.
pub fn write(path: &Path, samples: &[f64]) -> Result<(), BenchError> {
    let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::write(path, bytes).map_err(|source| BenchError::SignalFile { path: path.to_owned(), source })
}
