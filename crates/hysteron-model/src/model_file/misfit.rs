//! The model of the misfit in a model file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::allowed;
use super::correlation::{CorrelationRow, bounded};
use super::{ModelFile, ModelFileError};
use crate::misfit::{Basis, COLUMNS, MisfitModel};

/// Largest magnitude of its numbers: their products stay finite.
const LARGEST: f64 = 1e60;

/// Gaussian model of the difference between the device and the model ([`MisfitModel`]), for bands of new
/// measurements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys of a misfit model")]
pub struct MisfitEntry {
    /// Columns that the numbers belong to; always 1.
    #[schemars(extend("const" = 1))]
    pub basis: u64,
    /// Lowest drive of the training records, in the input unit.
    pub low: f64,
    /// Highest drive of the training records, in the input unit.
    pub high: f64,
    /// Reference frequency of the columns, in Hz.
    pub frequency_hz: f64,
    /// Standard deviation of the residual that the columns do not explain, in the output unit.
    pub noise: f64,
    /// Share of the power of the training residual that the columns explain.
    pub explained: f64,
    /// The training records hold loops of one amplitude only.
    pub one_amplitude: bool,
    /// Error with the predicted misfit over that without it, on parts of the training records that were left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out: Option<f64>,
    /// Mean of the coefficients, one a column.
    pub mean: CorrelationRow,
    /// Information of the training records on each direction, in units of the prior's.
    pub information: CorrelationRow,
    /// Deviations of the coefficients: a row a direction, one coefficient a column.
    #[serde(deserialize_with = "bounded")]
    pub directions: Vec<CorrelationRow>,
}

impl From<&MisfitModel> for MisfitEntry {
    fn from(of: &MisfitModel) -> Self {
        let row = |values: &Vec<f64>| CorrelationRow(values.clone());
        Self {
            basis: 1,
            low: of.basis.low_v,
            high: of.basis.high_v,
            frequency_hz: of.basis.frequency_hz,
            noise: of.noise,
            explained: of.explained,
            one_amplitude: of.one_amplitude,
            left_out: of.left_out,
            mean: row(&of.mean),
            information: row(&of.information),
            directions: of.directions.iter().map(row).collect(),
        }
    }
}

impl MisfitEntry {
    /// The model; valid where [`ModelFile::check`] accepts the file.
    pub fn model(&self) -> MisfitModel {
        MisfitModel {
            basis: Basis { low_v: self.low, high_v: self.high, frequency_hz: self.frequency_hz },
            noise: self.noise,
            explained: self.explained,
            one_amplitude: self.one_amplitude,
            left_out: self.left_out,
            mean: self.mean.0.clone(),
            directions: self.directions.iter().map(|row| row.0.clone()).collect(),
            information: self.information.0.clone(),
        }
    }

    /// Checks counts and magnitudes.
    pub(super) fn check(&self) -> Result<(), ModelFileError> {
        allowed("misfit.basis", self.basis as f64, self.basis == 1, "1")?;
        let all = [("misfit.low", self.low), ("misfit.high", self.high)];
        for (path, value) in all {
            allowed(path, value, value.abs() <= LARGEST, "a finite number")?;
        }
        allowed("misfit.high", self.high, self.high > self.low, "a number above misfit.low")?;
        let positive = [("misfit.frequency_hz", self.frequency_hz), ("misfit.noise", self.noise)];
        for (path, value) in positive {
            allowed(path, value, value > 0.0 && value <= LARGEST, "a finite number above 0")?;
        }
        let share = (0.0..=1.0 + 1e-6).contains(&self.explained);
        allowed("misfit.explained", self.explained, share, "a share between 0 and 1")?;
        if let Some(left) = self.left_out {
            allowed(
                "misfit.left_out",
                left,
                (0.0..=LARGEST).contains(&left),
                "a finite number of at least 0",
            )?;
        }
        let count = |path: &str, found: usize| {
            let right = found == COLUMNS;
            allowed(path, found as f64, right, "a number a column of the basis, 71 of them")
        };
        count("misfit.mean", self.mean.0.len())?;
        count("misfit.information", self.information.0.len())?;
        count("misfit.directions", self.directions.len())?;
        for (path, row) in [("misfit.mean", &self.mean), ("misfit.information", &self.information)] {
            magnitudes(path, &row.0)?;
        }
        for (k, row) in self.directions.iter().enumerate() {
            let path = format!("misfit.directions[{k}]");
            count(&path, row.0.len())?;
            magnitudes(&path, &row.0)?;
        }
        match self.information.0.iter().enumerate().find(|(_, value)| **value < 0.0) {
            Some((k, value)) => {
                allowed(&format!("misfit.information[{k}]"), *value, false, "a number of at least 0")
            }
            None => Ok(()),
        }
    }
}

fn magnitudes(path: &str, values: &[f64]) -> Result<(), ModelFileError> {
    values.iter().enumerate().try_for_each(|(k, value)| {
        allowed(&format!("{path}[{k}]"), *value, value.abs() <= LARGEST, "a finite number")
    })
}

impl ModelFile {
    /// The model of the misfit, if the file has one.
    pub fn misfit_model(&self) -> Option<MisfitModel> {
        self.misfit.as_ref().map(MisfitEntry::model)
    }
}
