//! Operations that answer with tables, sentences, figures and files.

use hysteron_identify::design::DesignOptions;
use hysteron_identify::online::FollowMethod;
use hysteron_model::model::DecouplingRequest;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Command, Series};

/// What an operation found and wrote.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Outcome {
    /// Verdicts and remarks, the weightiest first.
    pub sentences: Vec<String>,
    /// Tables.
    pub tables: Vec<Listed>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// Identifiers of the files that were written.
    pub files: Vec<String>,
    /// Command that does the same.
    pub command: Command,
}

/// A table of text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Listed {
    /// What it shows.
    pub title: String,
    /// Headings, with units in square brackets.
    pub columns: Vec<String>,
    /// Rows.
    pub rows: Vec<Vec<String>>,
}

/// A figure of curves over one axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figure {
    /// What it shows.
    pub title: String,
    /// Its curves.
    pub series: Vec<Series>,
    /// The axis across is logarithmic.
    pub log_across: bool,
    /// The axis upwards is logarithmic.
    pub log_up: bool,
}

/// What is done with records before they are joined and after, in this order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PrepareOptions {
    /// New names of columns: `ch1=u_V`.
    pub rename: Vec<String>,
    /// Columns to leave out, by their new names.
    pub drop: Vec<String>,
    /// Samples kept by the values of columns: `segment=2..7`.
    #[serde(rename = "where")]
    pub conditions: Vec<String>,
    /// Samples kept between turning points of the drive, counted from 1: `1:5`.
    pub turns: Option<String>,
    /// Scales of columns: `y=2.5um/V`.
    pub scales: Vec<String>,
    /// Columns whose mean is removed.
    pub remove_mean: Vec<String>,
    /// Columns whose linear trend is removed, with the mean.
    pub detrend: Vec<String>,
    /// New sample rate \[Hz\], behind an anti-aliasing low-pass.
    pub sample_rate_hz: Option<f64>,
}

/// Records to be cut as their settings say, prepared, and joined in the order of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrepareRequest {
    /// Identifiers.
    pub records: Vec<String>,
    /// What is done with them.
    #[serde(default)]
    pub options: PrepareOptions,
    /// File to write: `.csv`, `.npz`, `.mat`.
    pub save: String,
}

/// Band about a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BandOf {
    /// None.
    #[default]
    None,
    /// 95 % band of the output of the model with the true parameters.
    Model,
    /// 95 % band of a new measurement.
    Measurement,
}

/// Options of a simulation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SimulateOptions {
    /// Band to draw and to write.
    pub band: BandOf,
    /// Add the predicted misfit of a device outside the model class, where that pays.
    pub correct: bool,
    /// Voltage at rest before the drive; left out: as the model file assumes.
    pub rest_voltage: Option<f64>,
    /// Column of the measured rate of the input, for a force; left out: that of the record's settings.
    pub rate: Option<String>,
}

/// A drive to be simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulateRequest {
    /// Record that holds the drive; several: parts of one run, in the order of their time.
    pub records: Vec<String>,
    /// Options.
    #[serde(default)]
    pub options: SimulateOptions,
    /// File to write: `.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
}

/// The next drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignRequest {
    /// Options.
    #[serde(default)]
    pub options: DesignOptions,
    /// File to write: `.csv`, `.npz`, `.mat`.
    pub save: String,
}

/// References of several axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DecoupleRequest {
    /// Record with a column for every output of the model, named as the model names it.
    pub references: String,
    /// Options.
    #[serde(default)]
    pub options: DecouplingRequest,
    /// File to write: `.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
}

/// Options of controllers of several axes on the simulated bench.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackAxesOptions {
    /// Least and greatest drive, one for all actuators or one each; left out: the range that the model was
    /// identified in.
    pub ranges: Vec<[f64; 2]>,
    /// Largest slew rate in the unit of the drive per second, one for all actuators or one each; left out:
    /// none.
    pub slews_per_s: Vec<f64>,
    /// Frequency up to which the inverse follows \[Hz\]; left out: a twentieth of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Samples of the references known ahead by the controller that runs sample by sample; left out: as many
    /// as are useful.
    pub preview: Option<usize>,
    /// Seconds at the beginning that are not scored; left out: a quarter of the references.
    pub skip_s: Option<f64>,
    /// Seed of the bench's noise.
    pub seed: u64,
}

/// Controllers of several axes to be simulated on the bench.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackAxesRequest {
    /// Record with a column for every output of the model, named as the model names it.
    pub references: String,
    /// Options.
    #[serde(default)]
    pub options: TrackAxesOptions,
    /// File to write: `.csv`, `.npz`, `.mat`.
    #[serde(default)]
    pub save: Option<String>,
}

/// Options of a recalibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecalibrateOptions {
    /// The records are consecutive parts of one run: memory and offset carry over.
    pub continued: bool,
    /// Least fit of each record by the new model \[%\]; it is refused below that.
    pub least_fit_percent: f64,
}

impl Default for RecalibrateOptions {
    fn default() -> Self {
        Self { continued: false, least_fit_percent: 75.0 }
    }
}

/// A recalibration: gain, delay and offset from short records, the rest held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecalibrateRequest {
    /// Identifiers of the records.
    pub records: Vec<String>,
    /// Options.
    #[serde(default)]
    pub options: RecalibrateOptions,
    /// Identifier of the new model.
    pub save: String,
}

/// Options of an adaptation over a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AdaptOptions {
    /// Estimator of the coefficients.
    pub method: FollowMethod,
    /// Coefficients, up to six: `offset`, `gain`, `power=N`, `creep=SECONDS`.
    pub terms: Vec<String>,
    /// Standard deviation of the residual of a valid model, in the output's unit; left out: from the model
    /// file, else from the record.
    pub noise: Option<f64>,
    /// Use one of so many samples; left out: by the correlation of the residual.
    pub every: Option<usize>,
    /// Least mean number of samples to a false alarm.
    pub run_length: f64,
    /// Start anew after an alarm, so that a jump is followed at once.
    pub reopen: bool,
}

impl Default for AdaptOptions {
    fn default() -> Self {
        Self {
            method: FollowMethod::LeastSquares { memory_s: None },
            terms: vec!["offset".to_owned(), "gain".to_owned()],
            noise: None,
            every: None,
            run_length: 1e6,
            reopen: false,
        }
    }
}

/// A model that is corrected over a record, sample by sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AdaptRequest {
    /// Record.
    pub record: String,
    /// Options.
    #[serde(default)]
    pub options: AdaptOptions,
    /// Identifier of the new model; left out: none is written.
    #[serde(default)]
    pub save: Option<String>,
}

/// A realisation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RealiseRequest {
    /// Options.
    pub options: RealiseOptions,
}

/// Options of a realisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RealiseOptions {
    /// Sample rate of the controller \[Hz\]; left out: that of the model's records.
    pub sample_rate_hz: Option<f64>,
    /// Largest error, a fraction of the range.
    pub accuracy: f64,
    /// Lowest frequency, for a model that creeps for ever \[Hz\].
    pub lowest_frequency_hz: Option<f64>,
}

impl Default for RealiseOptions {
    fn default() -> Self {
        Self { sample_rate_hz: None, accuracy: 1e-5, lowest_frequency_hz: None }
    }
}

/// Options of a fit of structures to a frequency response.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ResponseFitOptions {
    /// Structures by name; none: those usual for this kind of response.
    pub structures: Vec<String>,
    /// Number of modes; left out: as many as the response supports.
    pub modes: Option<usize>,
    /// Lowest frequency that is fitted \[Hz\].
    pub low_hz: Option<f64>,
    /// Highest frequency that is fitted \[Hz\].
    pub high_hz: Option<f64>,
    /// Response to fit, where the file has several.
    pub response: Option<String>,
    /// Response of the same file to divide by, for example the amplifier's.
    pub over: Option<String>,
    /// Unit of the response, where the file gives none: `um_per_V`.
    pub unit: Option<String>,
    /// Records: length of a period \[s\]; left out: by the input.
    pub period_s: Option<f64>,
    /// Records: periods left out at the start of each; left out: until the output has settled.
    pub settling_periods: Option<usize>,
}

/// Structures to be fitted to a frequency response: of a file, or of records of periodic multisines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResponseFitRequest {
    /// One file with a response, or records.
    pub files: Vec<String>,
    /// Options.
    #[serde(default)]
    pub options: ResponseFitOptions,
    /// Identifier of the model to write: the structure of lowest AIC that a model file can hold.
    #[serde(default)]
    pub save: Option<String>,
    /// Name of the report to write, `.html`.
    #[serde(default)]
    pub report: Option<String>,
}
