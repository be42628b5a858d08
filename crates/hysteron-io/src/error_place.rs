//! Place of an error (file, line and column, for front ends), and its remedy.

use hysteron_model::Advice;
use hysteron_model::advice::ColumnRole;

use crate::IoError;
use crate::place::{FilePart, Place};

impl IoError {
    /// Place in the file; `None` for model files and files written.
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
            Self::Open { file, .. } | Self::Empty { file, .. } | Self::Record { file, .. } => {
                Some(Place::new(file, FilePart::Whole))
            }
            Self::ResponseFile(error) => Some(error.place()),
            _ => None,
        }
    }

    /// Remedy, where there is one that the user can choose.
    pub fn advice(&self) -> Option<Advice> {
        let column = |role| Some(Advice::ChooseColumn { role, example: None });
        match self {
            Self::NoSuchColumn { role, .. } | Self::AmbiguousColumn { role, .. } => column(*role),
            Self::NotTime { .. } => column(ColumnRole::Time),
            Self::ResponseFile(error) => error.advice(),
            Self::LengthMismatch { .. }
            | Self::ArrayType { .. }
            | Self::ArrayShape { .. }
            | Self::ChooseArrays { .. } => Some(Advice::ChooseColumns),
            Self::ChooseRate { .. } => Some(Advice::GiveSampleRate),
            Self::NotANumber { .. } | Self::TooManyValues { .. } => Some(Advice::ChooseColumns),
            Self::Record { source, .. } => source.advice(),
            _ => None,
        }
    }
}
