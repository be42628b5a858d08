//! Where an error stands, for front ends that show file, line and column apart.

use crate::IoError;
use crate::place::{Part, Place};

impl IoError {
    /// Where in which file, but for model files and for what is written.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Read { place, .. }
            | Self::NoSamples { place, .. }
            | Self::HeaderOnly { place, .. }
            | Self::NoHeader { place, .. }
            | Self::OneSample { place, .. }
            | Self::LengthMismatch { place, .. }
            | Self::Malformed { place, .. }
            | Self::ArrayType { place, .. }
            | Self::ArrayShape { place, .. }
            | Self::NoNames { place, .. }
            | Self::BadRate { place, .. }
            | Self::RateContradictsTime { place, .. }
            | Self::TooLarge { place, .. }
            | Self::TooManyValues { place, .. }
            | Self::TooManyColumns { place, .. }
            | Self::LineTooLong { place, .. }
            | Self::BareCarriageReturn { place, .. }
            | Self::NotUtf8 { place, .. }
            | Self::UnclosedQuote { place, .. }
            | Self::UnnamedColumn { place, .. }
            | Self::DuplicateColumn { place, .. }
            | Self::NoSuchColumn { place, .. }
            | Self::AmbiguousColumn { place, .. }
            | Self::NotTime { place, .. }
            | Self::FrequencyResponse { place, .. }
            | Self::NoFrequency { place, .. }
            | Self::NoResponse { place, .. }
            | Self::ChooseResponse { place, .. }
            | Self::BadFrequency { place, .. }
            | Self::NoChannels { place, .. }
            | Self::NotANumber { place, .. }
            | Self::MissingValue { place, .. }
            | Self::NotFinite { place, .. }
            | Self::DecimalCommas { place, .. }
            | Self::MixedDecimalMarks { place, .. }
            | Self::Ragged { place, .. }
            | Self::Truncated { place, .. }
            | Self::BadMask { place, .. }
            | Self::TimeDecreases { place, .. }
            | Self::TextCondition { place, .. }
            | Self::RenamedUnit { place, .. } => Some(place.clone()),
            Self::Open { file, .. }
            | Self::Empty { file, .. }
            | Self::RepeatedFrequency { file, .. }
            | Self::Response { file, .. }
            | Self::Record { file, .. } => Some(Place::new(file, Part::Whole)),
            _ => None,
        }
    }
}
