//! Following a reference.

use hysteron_model::Finding;
use hysteron_model::model::InverseRequest;
use hysteron_model::tracking::TrackOptions;
use hysteron_rig::Truth;
use hysteron_rig::excitation::ExcitationSpec;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Command, Curve, Score};

/// A reference in the unit of the model's output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "from", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Reference {
    /// A waveform: `low_v` and `high_v` are its least and greatest value, in the unit of the output.
    Waveform {
        /// Waveform, range, sample rate.
        specification: Box<ExcitationSpec>,
    },
    /// A column of a file in the workspace.
    Record {
        /// Identifier.
        id: String,
        /// Column; left out: recognised.
        #[serde(default)]
        column: Option<String>,
    },
    /// Samples.
    Samples {
        /// Sample rate \[Hz\].
        sample_rate_hz: f64,
        /// Values in the unit of the output.
        values: Vec<f64>,
    },
}

/// A drive to be computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FollowRequest {
    /// Reference.
    pub reference: Reference,
    /// Limits and knowledge of the reference.
    #[serde(default)]
    pub inverse: InverseRequest,
    /// Record of a run with the same reference, whose error corrects the drive.
    #[serde(default)]
    pub learn_from: Option<String>,
    /// File to write the drive to: `drive.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
    /// Width of the drawing in pixels.
    #[serde(default)]
    pub pixels: Option<usize>,
}

/// A drive with its predicted error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Followed {
    /// Reference over time.
    pub reference: Curve,
    /// Drive over time.
    pub drive: Curve,
    /// Reference − predicted output over time.
    pub error: Curve,
    /// Unit of the drive, as printed.
    pub input_unit: String,
    /// Unit of the output, as printed.
    pub output_unit: String,
    /// Samples.
    pub samples: usize,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Voltage at which the device rests before; `null` for a periodic reference.
    pub rest: Option<f64>,
    /// Least drive.
    pub drive_low: f64,
    /// Greatest drive.
    pub drive_high: f64,
    /// Samples limited by the range.
    pub samples_at_range: usize,
    /// Samples limited by the slew rate.
    pub samples_at_slew: usize,
    /// Samples known ahead by a law that works sample by sample.
    pub preview_samples: Option<usize>,
    /// Predicted error, rms, of the model with itself.
    pub predicted_rms_error: f64,
    /// Largest predicted error.
    pub predicted_max_error: f64,
    /// Predicted error in percent of the stroke.
    pub predicted_rms_percent_of_stroke: f64,
    /// Half the width of the 95 % band from the uncertainty of the parameters.
    pub band: Option<f64>,
    /// Half the width of the 95 % band of a new measurement, at its widest.
    pub band_of_measurement: Option<f64>,
    /// Error to expect on the device, rms.
    pub expected_rms_error: Option<f64>,
    /// What a record showed: scores on the records of the identification.
    pub shown: Vec<Score>,
    /// Warnings.
    pub findings: Vec<Finding>,
    /// Where the model extrapolates.
    pub remarks: Vec<String>,
    /// File that was written.
    pub file: Option<String>,
    /// Commands that write the same.
    pub command: Command,
}

/// Controllers to be simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackRequest {
    /// Reference.
    pub reference: Reference,
    /// Options of the library.
    #[serde(default)]
    pub options: TrackOptions,
    /// Truth of the bench; left out: its defaults.
    #[serde(default)]
    pub truth: Option<Truth>,
    /// File to write reference, drives and displacements to: `track.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
    /// Simulate on the model itself instead of the bench.
    #[serde(default)]
    pub on_model: bool,
    /// Seed of the bench's noise.
    #[serde(default)]
    pub seed: u64,
    /// Width of the drawing in pixels.
    #[serde(default)]
    pub pixels: Option<usize>,
}

/// Controllers on a simulated plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Tracked {
    /// The plant, in words.
    pub plant: String,
    /// Unit of the output, as printed.
    pub output_unit: String,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Part of the reference that is scored \[s\].
    pub scored_s: [f64; 2],
    /// Each controller, in the order of the library.
    pub controllers: Vec<TrackedController>,
    /// Controllers that could not be simulated, with the reason.
    pub left_out: Vec<String>,
    /// File that was written.
    pub file: Option<String>,
    /// Commands that write the same.
    pub command: Command,
}

/// A controller on a simulated plant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackedController {
    /// Its name.
    pub name: String,
    /// What it is, in a line.
    pub summary: String,
    /// Rms error, in the unit of the output.
    pub rms: Option<f64>,
    /// Largest error.
    pub max: Option<f64>,
    /// Rms error in percent of the stroke.
    pub rms_percent_of_stroke: Option<f64>,
    /// The stage fails to follow.
    pub runs_away: bool,
    /// Measured bandwidth, −3 dB \[Hz\].
    pub bandwidth_hz: Option<f64>,
    /// Gain margin of the feedback, a factor; `null` without feedback.
    pub gain_margin: Option<f64>,
    /// Phase margin \[°\].
    pub phase_margin_deg: Option<f64>,
    /// Samples limited by range or slew rate.
    pub samples_held_back: usize,
    /// Drive and error over time.
    pub curves: TrackedCurve,
}

/// Curves of a controller.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrackedCurve {
    /// Drive over time.
    pub drive: Curve,
    /// Reference − displacement over time.
    pub error: Curve,
}
