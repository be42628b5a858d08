//! The drive for a reference on a device outside the model class, whose misfit is predicted.
//!
//! With the model m and the predicted discrepancy μ of the drive ([`crate::misfit`]), the drive is sought for
//! which m(u) + μ(u) − μ(u)₀ is the reference r, μ₀ being its first value: u ← m⁻¹(r − μ(u) + μ₀(u)), from the
//! drive of the model alone. What is left contracts by the ratio of the slopes of μ and m at each repetition.

use super::Hammerstein;
use crate::invert::{InverseDrive, InverseOptions, InversionError};
use crate::misfit::{MisfitError, MisfitModel};
use crate::record::Timing;
use crate::start::Start;
use hysteron_numeric::Listener;

/// Most repetitions, and the change of the drive in units of the first at which they end.
const MOST: usize = 8;
const SETTLED: f64 = 0.01;
/// Left-out parts of the training records must be predicted with less than this share of the model's error.
const GAIN: f64 = 0.9;

impl Hammerstein {
    /// The model of the misfit, where correcting by it pays: the device is outside the model class, and on
    /// left-out parts of the training records the corrected model errs less.
    ///
    /// # Errors
    /// [`InversionError::NotCorrected`].
    pub fn correction(&self) -> Result<MisfitModel, InversionError> {
        let refused = |because| InversionError::NotCorrected { because };
        let misfit = self.data().misfit_model();
        let misfit = misfit.ok_or(refused("the records show no device outside the model class"))?;
        match misfit.left_out {
            Some(left) if left <= GAIN => Ok(misfit),
            Some(_) => Err(refused("on left-out parts of the training records it gains nothing")),
            None => Err(refused("its file does not say whether that pays; identify the model again")),
        }
    }

    /// The drive for a reference by model and misfit together; `predicted` is the output of both.
    ///
    /// # Errors
    /// [`InversionError`].
    pub(super) fn corrected_drive(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
        options: &InverseOptions,
        listener: Listener<'_>,
    ) -> Result<InverseDrive, InversionError> {
        let misfit = self.correction()?;
        let shift = |found: &InverseDrive| -> Result<Vec<f64>, InversionError> {
            let start = found.rest.unwrap_or(Start::settled(found.drive.len()));
            let timing = Timing::Rate(sample_rate_hz);
            let told = misfit.predict(self.law(), &found.drive, timing, &start).map_err(failed)?;
            let first = told.discrepancy.first().copied().unwrap_or(0.0);
            Ok(told.discrepancy.iter().map(|x| x - first).collect())
        };
        let part = |k: usize| k as f64 / (MOST + 1) as f64;
        let told = listener.part(0.0, part(1));
        let mut found = self.law().invert_told(reference, sample_rate_hz, options, told)?;
        let mut discrepancy = shift(&found)?;
        let mut first_move = None;
        for repetition in 1..=MOST {
            let wanted: Vec<f64> = reference.iter().zip(&discrepancy).map(|(r, d)| r - d).collect();
            let told = listener.part(part(repetition), part(repetition + 1));
            let next = self.law().invert_told(&wanted, sample_rate_hz, options, told)?;
            let squares = next.drive.iter().zip(&found.drive).map(|(to, from)| (to - from).powi(2));
            let moved = squares.sum::<f64>().sqrt();
            found = next;
            discrepancy = shift(&found)?;
            if moved <= SETTLED * *first_move.get_or_insert(moved) {
                break;
            }
        }
        found.predicted.iter_mut().zip(&discrepancy).for_each(|(y, d)| *y += d);
        Ok(found)
    }
}

fn failed(error: MisfitError) -> InversionError {
    match error {
        MisfitError::Simulation(error) => InversionError::Simulation(error),
        MisfitError::Dynamics(error) => InversionError::Dynamics(error),
        MisfitError::NoTimes | MisfitError::OneRate => {
            InversionError::NotCorrected { because: "its dynamics belong to one sample rate" }
        }
    }
}
