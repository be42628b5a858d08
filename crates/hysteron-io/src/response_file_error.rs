//! Errors of a file of a frequency response.

use hysteron_model::Advice;
use hysteron_model::record::RecordError;
use hysteron_numeric::display::exact;

use crate::place::{FilePart, Place};

/// Why a file holds no usable frequency response.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResponseFileError {
    /// No frequency column where a frequency response is wanted.
    #[error(
        "{place}: no frequency among the columns {found}; expected columns such as `f_Hz,re,im` or \
         `f_Hz,magnitude,phase_deg`"
    )]
    NoFrequency {
        /// Place in the file.
        place: Place,
        /// The columns found.
        found: String,
    },
    /// Frequencies without a complex value.
    #[error(
        "{place}: no complex response among the columns {found}; expected real and imaginary part (`re,im`, \
         `stage_re,stage_im`) or magnitude and phase (`magnitude,phase_deg`, `magnitude_dB,phase_rad`)"
    )]
    NoResponse {
        /// Place in the file.
        place: Place,
        /// The columns found.
        found: String,
    },
    /// Several responses, or none of the name asked for.
    #[error("{place}: {problem}; the responses are {available}; choose one")]
    Choose {
        /// Place in the file.
        place: Place,
        /// The problem.
        problem: String,
        /// Names of the responses.
        available: String,
        /// Whether it is the response divided by.
        divisor: bool,
    },
    /// A frequency that is not positive.
    #[error("{place}: found `{found}`, expected a frequency above 0; delete the line")]
    BadFrequency {
        /// Place in the file.
        place: Place,
        /// The text found.
        found: String,
    },
    /// Two lines at one frequency.
    #[error(
        "`{file}`: two lines at {frequency_hz} Hz; average them or delete one",
        frequency_hz = exact(*.frequency_hz)
    )]
    RepeatedFrequency {
        /// The file.
        file: String,
        /// The frequency \[Hz\].
        frequency_hz: f64,
    },
    /// The data read do not make a usable frequency response.
    #[error("`{file}`: {source}")]
    Unusable {
        /// The file.
        file: String,
        /// The reason.
        source: Box<RecordError>,
    },
}

impl ResponseFileError {
    /// Where in which file.
    pub(crate) fn place(&self) -> Place {
        match self {
            Self::NoFrequency { place, .. }
            | Self::NoResponse { place, .. }
            | Self::Choose { place, .. }
            | Self::BadFrequency { place, .. } => place.clone(),
            Self::RepeatedFrequency { file, .. } | Self::Unusable { file, .. } => {
                Place::new(file, FilePart::Whole)
            }
        }
    }

    pub(crate) fn advice(&self) -> Option<Advice> {
        match self {
            Self::Choose { divisor, .. } => Some(Advice::ChooseResponse { divisor: *divisor }),
            _ => None,
        }
    }
}
