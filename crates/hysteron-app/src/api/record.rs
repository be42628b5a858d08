//! Records.

use hysteron_identify::RecordRole;
use hysteron_identify::structure::Prospects;
use hysteron_model::Finding;
use hysteron_model::model_file::Kind;
use hysteron_model::record::{DeadBand, DeadBandError, InspectionSummary};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Command, Problem};

/// A record in the list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordEntry {
    /// Identifier: path relative to the workspace.
    pub id: String,
    /// Folder of it, empty for the workspace itself: the device.
    pub device: String,
    /// Size of the file \[bytes\].
    pub bytes: u64,
    /// Last change of the file (ISO 8601, UTC).
    pub modified: String,
    /// It is being read: a `records` event follows, and what is below is not known yet.
    #[serde(default)]
    pub reading: bool,
    /// Samples; 0 where it could not be read.
    pub samples: usize,
    /// Duration \[s\].
    pub duration_s: Option<f64>,
    /// Sample rate \[Hz\]; `null` for stamps that are not uniform and for no time.
    pub rate_hz: Option<f64>,
    /// Uniformly sampled stretches of unlike rate or drive.
    pub segments: usize,
    /// Name of the input.
    pub input: Option<String>,
    /// Symbol of its unit.
    pub input_unit: String,
    /// Name of the output.
    pub output: Option<String>,
    /// Symbol of its unit.
    pub output_unit: String,
    /// Kind of model that its quantities call for; `null` where it could not be read.
    #[serde(default)]
    pub usual_kind: Option<Kind>,
    /// What the person says of the record.
    pub settings: RecordSettings,
    /// Small loop, each point (input, output) between 0 and 1.
    pub glyph: Vec<[f64; 2]>,
    /// The weightiest warning.
    pub warning: Option<String>,
    /// Why it is no usable record.
    pub error: Option<Problem>,
    /// Drive and output move over enough samples, so that something can be identified.
    #[serde(default = "yes")]
    pub usable: bool,
    /// It comes from the simulated bench.
    pub simulated: bool,
}

/// The kind of model that all of these records call for, else the usual one.
pub(crate) fn kind_for(records: &[RecordEntry]) -> Kind {
    let first = records.first().and_then(|record| record.usual_kind);
    first.filter(|_| records.iter().all(|record| record.usual_kind == first)).unwrap_or(Kind::Hammerstein)
}

fn yes() -> bool {
    true
}

/// What a person decided about a record. Kept in the workspace's history file, never in the record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecordSettings {
    /// Use of the record.
    pub role: Role,
    /// Record of the same run that this one continues; `null`: it begins a run.
    pub continues: Option<String>,
    /// Time column.
    pub time: Option<String>,
    /// Input column.
    pub input: Option<String>,
    /// Output column.
    pub output: Option<String>,
    /// Column of the rate of the input, for the force of a damper.
    pub rate: Option<String>,
    /// Sample rate \[Hz\], for a file without time.
    pub sample_rate_hz: Option<f64>,
    /// Scales of columns: `y=2.5um/V`.
    pub scales: Vec<String>,
    /// Dead band of the drive, in its unit: a smaller drive counts as 0.
    pub dead_band: Option<f64>,
    /// Dead zone of the drive, in its unit: a smaller drive counts as 0, a larger one by what exceeds it.
    pub dead_zone: Option<f64>,
    /// First time kept \[s\].
    pub from_s: Option<f64>,
    /// Last time kept \[s\].
    pub to_s: Option<f64>,
    /// Masked stretches \[s\]: simulated, not scored.
    pub masks: Vec<[f64; 2]>,
}

impl RecordSettings {
    /// What counts of the drive, where not all of it.
    pub(crate) fn band(&self) -> Result<Option<DeadBand>, DeadBandError> {
        DeadBand::given(self.dead_band, self.dead_zone)
    }
}

/// Use of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Fitted, its part in the fit recognised by its drive.
    #[default]
    Auto,
    /// Fitted as a quasi-static record.
    QuasiStatic,
    /// Fitted as a record that carries dynamics.
    Dynamic,
    /// Held out, to validate on.
    Validate,
    /// A reference to follow.
    Reference,
    /// Left out of everything.
    Unused,
}

/// A record in full.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RecordDetail {
    /// As in the list.
    #[serde(flatten)]
    pub entry: RecordEntry,
    /// Columns or arrays of the file.
    pub columns: Vec<Column>,
    /// What is in it; `null` where it could not be read.
    pub inspection: Option<InspectionSummary>,
    /// Gaps in the time stamps.
    pub gaps: Vec<Gap>,
    /// Choices made while it was read.
    pub notes: Vec<Finding>,
    /// What it determines alone.
    pub prospects: Option<Prospects>,
    /// Command that prints the same.
    pub command: Command,
}

/// A column or an array of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Column {
    /// Name, or path in the file.
    pub path: String,
    /// Shape of an array; empty for the columns of a text.
    pub shape: Vec<usize>,
    /// Symbol of the unit.
    pub unit: Option<String>,
    /// `numbers`, or what it is instead.
    pub kind: String,
    /// What it is taken for.
    pub used_as: Option<ColumnUse>,
}

/// Use of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ColumnUse {
    /// Drive.
    Input,
    /// Displacement.
    Output,
    /// Time.
    Time,
    /// Rate of the drive.
    Rate,
}

/// A gap in the time stamps.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Gap {
    /// Last stamp before it \[s\].
    pub from_s: f64,
    /// First stamp behind it \[s\].
    pub to_s: f64,
}

/// Query of an upload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UploadQuery {
    /// Path in the workspace: `run.csv`, `stage/run.csv`.
    pub name: String,
    /// `1`: replaces a file of this name, which goes to the trash folder.
    #[serde(default)]
    pub replace: u8,
}

/// Records to be judged together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProspectsRequest {
    /// Identifiers.
    pub records: Vec<String>,
}

/// What records can determine together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProspectsTogether {
    /// The statements.
    pub prospects: Prospects,
    /// Recognised role of each record, in their order.
    pub roles: Vec<RecordRole>,
    /// Command that prints the same.
    pub command: Command,
}
