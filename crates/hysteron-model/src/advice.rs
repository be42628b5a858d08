//! Typed remedies for findings and errors; each front end words them.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::model_file::Kind;

/// Remedy that a user can apply. Each front end names its own means: a flag, an argument, a field.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "do")]
pub enum Advice {
    /// Choose the column for a role.
    ChooseColumn {
        /// Role of the column.
        role: ColumnRole,
        /// A candidate column.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        example: Option<String>,
    },
    /// Choose which columns are read.
    ChooseColumns,
    /// Choose one of the responses of a file.
    ChooseResponse {
        /// True if it is the divisor of a ratio of responses.
        divisor: bool,
    },
    /// State the factor and the unit of a column.
    ScaleColumn {
        /// Its name.
        column: String,
    },
    /// Give the sample rate.
    GiveSampleRate,
    /// Resample the record to a uniform rate, or give the rate if the time stamps are merely imprecise.
    Resample,
    /// Take the records as parts of one run.
    ContinueRun,
    /// Crop the record differently.
    CutOtherwise,
    /// State the initial condition of the device.
    GiveStart {
        /// True if rest at a voltage is a possible initial condition.
        at_voltage: bool,
    },
    /// Score the beginning of the record, too.
    ScoreAll,
    /// Give the length of a period.
    GivePeriod,
    /// Name the record that identifies the dynamics.
    NameDynamicRecord,
    /// Give another range of the drive.
    DriveRange,
    /// Allow a higher rate of the drive.
    DriveRate,
    /// Correct the drive by the predicted misfit.
    CorrectDrive,
    /// Identify the model with bounded creep.
    CreepThatEnds,
    /// Restrict the frequency range.
    NarrowBand,
    /// Choose another hysteresis family.
    OtherHysteresis,
    /// Identify a model of another kind.
    OtherKind {
        /// The kind.
        kind: Kind,
    },
    /// Allow for a dead band of the drive.
    DeadBand {
        /// Threshold, in the unit of the drive.
        threshold: String,
        /// True if a larger drive counts by what exceeds the threshold.
        excess: bool,
    },
    /// Identify all actuators of the record together.
    SeveralAxes {
        /// Headers of their drives.
        inputs: Vec<String>,
        /// Headers of the positions.
        outputs: Vec<String>,
    },
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
    /// Give the lowest frequency to realise.
    GiveLowestFrequency,
    /// Give the exponent of the modes' dependence on drive level.
    GiveExponent,
}

/// Role of a column in a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
