//! Where correcting a model by the predicted misfit pays.

use hysteron_numeric::display::short;

use super::{MisfitError, MisfitModel};
use crate::hammerstein::SimulationError;

/// Left-out parts of the training records must be predicted with less than this share of the model's error.
const GAIN: f64 = 0.9;

/// Reason why a model is not corrected by its misfit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotCorrected {
    /// The model has no misfit.
    #[error("the records show no device outside the model class")]
    InClass,
    /// The correction does not carry over to other records.
    #[error(
        "on left-out parts of the training records it gains nothing: the corrected model leaves {} % of the \
         error",
        short((100.0 * left_out).round())
    )]
    NoGain {
        /// Error of the corrected model there, over that of the model alone.
        left_out: f64,
    },
    /// Nothing tells how the misfit depends on the amplitude.
    #[error(
        "the training records hold loops of one amplitude, and how the misfit changes with it is unknown; add \
         nested loops of at least four amplitudes over the whole range"
    )]
    OneAmplitude,
    /// The model file is older than the test.
    #[error("its file does not say whether that pays; identify the model again")]
    Unknown,
    /// The misfit of dynamics that are valid at one sample rate is not modelled.
    #[error("its dynamics belong to one sample rate")]
    OneRate,
    /// The misfit is a function of time.
    #[error("the samples have no times")]
    NoTimes,
    /// A controller knows the past only, and computes one sample at a time.
    #[error("a controller's law has no corrected form")]
    Controller,
    /// Learning removes the error of the last run whatever its origin.
    #[error("a drive that learns from its last run is corrected by that")]
    Learnt,
}

impl MisfitModel {
    /// Error of the model corrected by this misfit, over that of the model alone, on left-out parts of the
    /// training records, where it is small enough for a correction to pay.
    ///
    /// # Errors
    /// [`NotCorrected::OneAmplitude`], [`NotCorrected::NoGain`], [`NotCorrected::Unknown`].
    pub fn correction_left_out(&self) -> Result<f64, NotCorrected> {
        match self.left_out {
            _ if self.one_amplitude => Err(NotCorrected::OneAmplitude),
            Some(left_out) if left_out <= GAIN => Ok(left_out),
            Some(left_out) => Err(NotCorrected::NoGain { left_out }),
            None => Err(NotCorrected::Unknown),
        }
    }
}

impl MisfitError {
    /// The same as a reason not to correct a model, or the error of the simulation.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub(crate) fn not_corrected(self) -> Result<NotCorrected, SimulationError> {
        match self {
            Self::NoTimes => Ok(NotCorrected::NoTimes),
            Self::OneRate => Ok(NotCorrected::OneRate),
            Self::Simulation(error) => Err(error),
            Self::Dynamics(error) => Err(error.into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::misfit::{Basis, COLUMNS};

    #[test]
    fn a_correction_pays_where_left_out_parts_gain_a_tenth() {
        let of = |left_out: Option<f64>| MisfitModel {
            basis: Basis { low_v: 0.0, high_v: 1.0, frequency_hz: 1.0 },
            noise: 1.0,
            explained: 0.5,
            left_out,
            mean: vec![0.0; COLUMNS],
            directions: vec![vec![0.0; COLUMNS]; COLUMNS],
            information: vec![0.0; COLUMNS],
            one_amplitude: false,
        };
        assert_eq!(of(Some(0.4)).correction_left_out(), Ok(0.4));
        assert_eq!(of(Some(0.93)).correction_left_out(), Err(NotCorrected::NoGain { left_out: 0.93 }));
        assert_eq!(of(None).correction_left_out(), Err(NotCorrected::Unknown));
        let one = MisfitModel { one_amplitude: true, ..of(Some(0.4)) };
        assert_eq!(one.correction_left_out(), Err(NotCorrected::OneAmplitude));
        assert!(NotCorrected::NoGain { left_out: 0.93 }.to_string().ends_with("leaves 93 % of the error"));
    }
}
