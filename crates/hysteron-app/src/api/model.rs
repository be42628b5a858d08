//! Models, what they do on records, and their exports.

use hysteron_identify::{GainPhase, Interval};
use hysteron_model::Finding;
use hysteron_model::model::{DecouplingRequest, InverseRequest};
use hysteron_model::model_file::Kind;
use hysteron_model::tracking::Controller;
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use super::curve::pixels;
use super::{Command, Curve, Problem};

/// A model in the list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelEntry {
    /// Identifier: path relative to the workspace.
    pub id: String,
    /// Folder of it: the device.
    pub device: String,
    /// Name of the file without its ending.
    pub name: String,
    /// Size \[bytes\].
    pub bytes: u64,
    /// Last change (ISO 8601, UTC).
    pub modified: String,
    /// Kind of model; `null` where the file could not be read, as in the fields below.
    pub kind: Option<Kind>,
    /// Family of its hysteresis block.
    pub hysteresis: Option<String>,
    /// Kind of its dynamic block.
    pub dynamics: Option<String>,
    /// Unit of its output, as printed.
    pub unit: String,
    /// Unit of its input.
    pub input_unit: String,
    /// Records it was identified from, as its file names them.
    pub records: Vec<String>,
    /// When it was made (ISO 8601, UTC).
    pub made: Option<String>,
    /// Command that made it.
    pub command: Option<String>,
    /// Scores on the records of its identification.
    pub scores: Vec<Score>,
    /// One of its records comes from the simulated bench.
    pub simulated: bool,
    /// The best so far of an interrupted fit.
    pub interrupted: bool,
    /// Why the file is no model.
    pub error: Option<Problem>,
}

/// A model in full.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelDetail {
    /// As in the list.
    #[serde(flatten)]
    pub entry: ModelEntry,
    /// Its numbers.
    pub parameters: Vec<ParameterRow>,
    /// Verdicts, advice and warnings of the fit; empty for a model that another program made.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words; likewise.
    pub treatment: Vec<String>,
    /// Range in which it holds, in words.
    pub valid_range: Option<String>,
    /// Range of the drive it was identified with.
    pub drive_range: Option<[f64; 2]>,
    /// Sample rate of its records \[Hz\].
    pub sample_rate_hz: Option<f64>,
    /// Correcting the model by its predicted misfit pays.
    pub correctable: bool,
    /// The model file.
    pub file: Value,
}

/// A number of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterRow {
    /// Block, actuator or path it belongs to, where there are several.
    pub place: Option<String>,
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Value as printed, with the digits that its error allows.
    pub text: String,
    /// Symbol of its unit, as printed.
    pub unit: String,
    /// Standard error.
    pub std_error: Option<f64>,
    /// Standard error as printed.
    pub std_error_text: Option<String>,
    /// 95 % interval.
    pub interval: Option<Interval>,
    /// It was held.
    pub held: bool,
    /// It ended at a bound of its range.
    pub at_limit: bool,
}

/// New name of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelPatch {
    /// Name of the file, without folder and ending.
    pub name: String,
}

/// Scores on one record; errors in `unit`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Score {
    /// Record, by its identifier or as the model file names it.
    pub record: String,
    /// Unit of the errors, as printed.
    pub unit: String,
    /// Samples scored.
    pub samples: usize,
    /// √(mean e²).
    pub rmse: f64,
    /// Largest |e|.
    pub max_abs_error: f64,
    /// rms error over the stroke \[%\].
    pub rmse_percent_of_stroke: Option<f64>,
    /// Largest error over the stroke \[%\].
    pub max_percent_of_stroke: Option<f64>,
    /// 100 · (1 − ‖e‖₂ / ‖y − ȳ‖₂) \[%\].
    pub fit_percent: Option<f64>,
    /// Offset of the sensor that was estimated.
    pub offset: Option<f64>,
}

/// Records to score a model on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoresRequest {
    /// Identifiers of the records.
    pub records: Vec<String>,
    /// Seconds at the start of each that are not scored; left out: chosen by the model.
    #[serde(default)]
    pub skip_s: Option<f64>,
    /// Use the offset in the model instead of estimating that of each record's sensor.
    #[serde(default)]
    pub fixed_offset: bool,
    /// Score the model corrected by its predicted misfit, where that pays.
    #[serde(default)]
    pub correct: bool,
    /// The records are parts of runs: simulated without interruption from the start of the first, with one
    /// offset. Each run as a whole follows behind its parts, with the name `whole run`.
    #[serde(default)]
    pub continued: bool,
    /// Column of the rate of the input, for a model of the kind force.
    #[serde(default)]
    pub rate: Option<String>,
    /// File to write the scored samples to, of one record or one run: `scored.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
}

/// Scores of a model on records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scored {
    /// Each record, in the order asked for.
    pub records: Vec<Judged>,
    /// Definition of each score.
    pub definitions: Vec<ScoreDefinition>,
    /// Command that prints the same.
    pub command: Command,
}

/// A record that was scored, or could not be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// Identifier of the record.
    pub record: String,
    /// Its scores.
    pub score: Option<Score>,
    /// Comparison with the error of the training, in words.
    pub verdict: Option<String>,
    /// Where the model extrapolates, and what was assumed.
    pub remarks: Vec<String>,
    /// Scored samples within the 95 % band of a new measurement \[%\].
    pub in_band_percent: Option<f64>,
    /// The record was made by the simulated bench.
    pub simulated: bool,
    /// Why it could not be scored.
    pub error: Option<Problem>,
}

/// Definition of a score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScoreDefinition {
    /// Its name.
    pub name: String,
    /// Its definition.
    pub text: String,
}

/// What is drawn of a record and a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// Output over input, measured and model.
    #[default]
    Loop,
    /// Output over time, measured and model, with the band.
    Time,
    /// Measured − model over time, with the band about 0.
    Residual,
    /// Measured − model over input.
    ResidualLoop,
}

/// Query of the curves of a model on a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelCurvesQuery {
    /// Identifier of the record.
    pub record: String,
    /// What is drawn.
    #[serde(default)]
    pub view: View,
    /// First time shown \[s\].
    pub from: Option<f64>,
    /// Last time shown \[s\].
    pub to: Option<f64>,
    /// Width of the drawing in pixels.
    #[serde(default = "pixels")]
    pub pixels: usize,
}

/// Curves of a model on a record, with the scores of exactly this series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelCurves {
    /// Identifier of the record.
    pub record: String,
    /// What is drawn.
    pub view: View,
    /// The curves.
    pub series: Vec<Series>,
    /// Scores of the whole series.
    pub scores: Score,
    /// The record was part of the identification.
    pub fitted: bool,
    /// Start that was assumed, and where the model extrapolates.
    pub remarks: Vec<String>,
    /// Command that scores the same.
    pub command: Command,
}

/// A named curve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Series {
    /// `measured`, `model`, `residual`, `band-low`, `band-high`.
    pub name: String,
    /// Its points.
    pub curve: Curve,
}

/// Query of the frequency response on a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseQuery {
    /// Identifier of the record.
    pub record: String,
}

/// Gain and phase at the oscillations of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Responses {
    /// Identifier of the record.
    pub record: String,
    /// Unit of the gain, as printed.
    pub unit: String,
    /// Each oscillation, in the order of time.
    pub rows: Vec<ResponseRow>,
}

/// Gain and phase at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResponseRow {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Measured, with the standard error of the scatter about the sine.
    pub measured: GainPhase,
    /// Of the model's free run.
    pub model: GainPhase,
}

/// Form of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// The model file.
    Json,
    /// The report, a self-contained HTML page.
    Report,
    /// C99 source, as a zip archive.
    C,
    /// A `no_std` crate, as a zip archive.
    Rust,
    /// FMI 2.0 and 3.0, as a zip archive.
    Fmu,
    /// Functions of MATLAB and GNU Octave, as a zip archive.
    Matlab,
    /// C99 with a Simulink S-function, as a zip archive.
    Simulink,
}

impl Form {
    /// The form of source code; `None` for the model file and the report.
    pub fn source(self) -> Option<hysteron_export::Form> {
        match self {
            Self::Json | Self::Report => None,
            Self::C => Some(hysteron_export::Form::C),
            Self::Rust => Some(hysteron_export::Form::Rust),
            Self::Fmu => Some(hysteron_export::Form::Fmu),
            Self::Matlab => Some(hysteron_export::Form::Matlab),
            Self::Simulink => Some(hysteron_export::Form::Simulink),
        }
    }
}

/// Query of a download or a preview.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DownloadQuery {
    /// Form.
    #[serde(rename = "as")]
    pub form: Form,
    /// Sample rate of the controller \[Hz\]; left out: that of the model's records.
    pub sample_rate_hz: Option<f64>,
    /// Single precision instead of double.
    #[serde(default)]
    pub single: bool,
    /// With the inverse: reference in, voltage out.
    #[serde(default)]
    pub inverse: bool,
    /// Controller around the inverse, by its name; left out: none.
    pub controller: Option<Controller>,
    /// Lowest voltage of the inverse; left out: of the model's records.
    pub low: Option<f64>,
    /// Highest voltage of the inverse.
    pub high: Option<f64>,
    /// Largest slew rate of the inverse's voltage \[V/s\].
    pub slew_per_s: Option<f64>,
    /// Ranges of the actuators of several axes in place of `low` and `high`: `LOW:HIGH` for all of them, or
    /// one each, separated by commas.
    #[serde(default, deserialize_with = "ranges_in_text", serialize_with = "text_of_ranges")]
    #[schemars(with = "Option<String>")]
    pub ranges: Vec<[f64; 2]>,
    /// Level of the drive (rms) at which the modes of several axes are taken; left out: the highest
    /// identified.
    pub level: Option<f64>,
    /// Frequency up to which the inverse follows \[Hz\].
    pub bandwidth_hz: Option<f64>,
    /// Samples of the reference that the inverse knows ahead; left out: as many as affect the drive.
    pub preview: Option<usize>,
    /// Frequency up to which the reference is predicted from its past \[Hz\].
    pub predict_to_hz: Option<f64>,
    /// Largest error of the realised dynamics, as a share of the gain at rest; left out: what the model's own
    /// error is worth.
    pub accuracy: Option<f64>,
    /// Lowest frequency to realise, for unbounded creep \[Hz\].
    pub lowest_frequency_hz: Option<f64>,
    /// Beginning of every name in the source; left out: from the model's name.
    pub name: Option<String>,
}

impl DownloadQuery {
    /// The inverse that is asked for.
    pub(crate) fn inverse_request(&self) -> InverseRequest {
        InverseRequest {
            range: self.low.zip(self.high).map(|(low, high)| [low, high]),
            slew_per_s: self.slew_per_s,
            bandwidth_hz: self.bandwidth_hz,
            preview: self.preview,
            predict_to_hz: self.predict_to_hz,
            ..InverseRequest::default()
        }
    }

    /// The inverse of several axes that is asked for.
    pub(crate) fn decoupling_request(&self) -> DecouplingRequest {
        let one = self.inverse_request();
        DecouplingRequest {
            ranges: if self.ranges.is_empty() {
                one.range.into_iter().collect()
            } else {
                self.ranges.clone()
            },
            slews_per_s: one.slew_per_s.into_iter().collect(),
            bandwidth_hz: one.bandwidth_hz,
            preview: one.preview,
            level: self.level,
            ..DecouplingRequest::default()
        }
    }
}

/// Ranges in a query, which has text alone.
fn ranges_in_text<'de, D: Deserializer<'de>>(query: D) -> Result<Vec<[f64; 2]>, D::Error> {
    let given = Option::<String>::deserialize(query)?.unwrap_or_default();
    let range = |one: &str| {
        let (low, high) = one.split_once(':')?;
        Some([low.trim().parse::<f64>().ok()?, high.trim().parse::<f64>().ok()?])
    };
    let ranges = given.split(',').filter(|one| !one.trim().is_empty()).map(range);
    let words = "ranges are LOW:HIGH, one for all actuators or one each, separated by commas";
    ranges.collect::<Option<_>>().ok_or_else(|| D::Error::custom(words))
}

fn text_of_ranges<S: Serializer>(ranges: &[[f64; 2]], to: S) -> Result<S::Ok, S::Error> {
    let texts: Vec<String> = ranges.iter().map(|[low, high]| format!("{low}:{high}")).collect();
    to.serialize_str(&texts.join(","))
}

/// The files of an export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Preview {
    /// The files.
    pub files: Vec<ExportFile>,
    /// States of the realised dynamics.
    pub states: Option<usize>,
    /// Error of the realised dynamics over the range.
    pub error: Option<f64>,
    /// What was decided, and what to know of the source.
    pub findings: Vec<Finding>,
    /// Command that writes the same.
    pub command: Command,
}

/// A file of an export.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExportFile {
    /// Its name.
    pub name: String,
    /// Size \[bytes\].
    pub bytes: usize,
    /// Its text; `null` where it is binary.
    pub text: Option<String>,
}
