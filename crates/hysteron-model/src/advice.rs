//! Remedies for findings and errors, typed, for a front end to word.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Remedy that a user can apply. Each front end names its own means: a flag, an argument, a field.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "do")]
pub enum Advice {
    /// Choose the column for a role.
    ChooseColumn {
        /// Role of the column.
        role: ColumnRole,
        /// A column that could be meant.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        example: Option<String>,
    },
    /// Choose which columns are read.
    ChooseColumns,
    /// Choose one of the responses of a file.
    ChooseResponse {
        /// Whether it is the response divided by.
        divisor: bool,
    },
    /// State the factor and the unit of a column.
    ScaleColumn {
        /// Its name.
        column: String,
    },
    /// Give the sample rate.
    GiveSampleRate,
    /// Resample the record to a uniform rate, or give the rate if its stamps are only badly written.
    Resample,
    /// Take the records as parts of one run.
    ContinueRun,
    /// Keep another part of the record.
    CutOtherwise,
    /// Say what the device did before the record.
    GiveStart {
        /// Whether it may have rested at a voltage.
        at_voltage: bool,
    },
    /// Score the beginning of the record, too.
    ScoreAll,
    /// Give the length of a period.
    GivePeriod,
    /// Name the record that carries dynamics.
    NameDynamicRecord,
    /// Give another range of the drive.
    DriveRange,
    /// Allow a higher rate of the drive.
    DriveRate,
    /// Identify the model with creep that ends.
    CreepThatEnds,
    /// Take points between two frequencies only.
    NarrowBand,
    /// Take another hysteresis family.
    OtherHysteresis,
    /// Take the joint fit.
    FitJointly,
    /// Leave the dynamics out.
    NoDynamics,
    /// Widen the search range of a parameter.
    Widen {
        /// Its name.
        parameter: String,
    },
    /// Hold a parameter at a known value.
    Hold {
        /// Its name; `None`: any that is known.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        parameter: Option<String>,
    },
    /// Let the search run longer, or leave the choice of the optimiser to the program.
    SearchLonger,
    /// Give the exponent with which modes follow the level.
    GiveExponent,
}

/// Role of a column in a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColumnRole {
    /// Drive.
    Input,
    /// Displacement.
    Output,
    /// Trajectory to follow.
    Reference,
    /// Time.
    Time,
    /// One of several drives.
    Inputs,
    /// A column to be scaled.
    Scaled,
    /// A column whose values decide which samples are kept.
    Condition,
    /// A column whose mean or trend is removed.
    Detrended,
    /// A column to be renamed.
    Renamed,
    /// A column that is left out.
    LeftOut,
}

impl ColumnRole {
    /// `input`, `output`, …
    pub fn name(self) -> &'static str {
        match self {
            Self::Input | Self::Inputs => "input",
            Self::Output => "output",
            Self::Reference => "reference",
            Self::Time => "time",
            Self::Scaled => "scaled channel",
            Self::Condition => "channel of a condition",
            Self::Detrended => "detrended channel",
            Self::Renamed => "renamed channel",
            Self::LeftOut => "channel left out",
        }
    }
}

impl fmt::Display for ColumnRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
