//! The versioned model file: a model is data.
//!
//! `MODEL.json` holds `"format": "hysteron-model"`, `"version": 2`, the `kind` of model ([`Kind`]), its
//! numbers, and how they were made. [`read`] takes every kind, and the files of version 1, which had one
//! format per kind. The keys of a Hammerstein model are those of [`ModelFile`]; of the other kinds
//! [`OscillatorFile`], [`ForceFile`], [`ModesFile`], [`CoupledFile`]. Every number of the model is a
//! [`Quantity`] `{"value": …, "unit": …, "std_error": …|null}`. Units are the suffixes of column headers
//! (`um`, `V`, `A_per_m`):
//!
//! | number | unit |
//! | --- | --- |
//! | `hysteresis.parameters.linear`, `quadratic`, `cubic`, `quartic`, `quintic`, `degree_6` … | `um/V`,
//! `um/V^2`, … |
//! | `alpha` | `um/V` |
//! | `beta`, `gamma` | `1/V` for n = 1, else `um^(1-n)/V` |
//! | `threshold_1`, `threshold_2`, … | `V` |
//! | `weight_1`, `weight_2`, … | `um/V` |
//! | `n`, every `order` | `1` |
//! | `coefficient` of sᵅ (`integer`, `fractional`) | `s^α` with the order as a number (`1`, `s`, `s^2.0384`):
//! a factor common to all of them drops out of G |
//! | `coefficient` of z⁻ⁱ (`arx`) | `1` |
//! | `delay` | `s` |
//! | `offset` | `um` |
//!
//! There is no constant term among the parameters: the one output offset is `offset`. For `"kind": "arx"` the
//! order is the power of z⁻¹: the numerator holds b₀, b₁, …, the denominator 1, a₁, a₂, …. For
//! `"kind": "none"` both lists are empty (or absent). Terms are in ascending order.
//!
//! Reading is strict: an unknown version, key, kind or parameter, a missing key, a wrong unit, a number that
//! is not finite or not allowed is a [`ModelFileError`] that names the place. Limits: 64 terms in s and 4096 in
//! 1/z a polynomial, 4096 numbers of the hysteresis, a polynomial of degree 32, 4096 paths between inputs and
//! outputs; magnitudes of at most 1e100, sample rates from 1e-9 to 1e12 Hz. Keys that are not part of the
//! mathematics (`name`, `units`, `normalisation`, `start`, `valid_range`, `provenance`, `scores`,
//! `correlation`, `misfit` and `std_error`) may be absent. Writing is atomic, and a file that could not be read back is
//! never written. Numbers survive writing and reading bit for bit. [`json_schema`] is the same in JSON
//! Schema.

mod check;
mod convert;
mod correlation;
mod coupled;
mod document;
mod error;
mod force;
mod hysteresis_kind;
mod json;
mod kind;
mod misfit;
mod modes;
mod oscillator;
mod parameters;
mod provenance;
mod quantity;
mod schema;
mod start;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::hysteresis::polynomial_name;
pub use correlation::{
    CorrelationEntry, CorrelationRow, MAX_CORRELATED, number_mut, transfer_function_numbers,
};
pub use coupled::{ActuatorEntry, CoupledFile, PathEntry};
pub use document::{Document, read};
pub use error::ModelFileError;
pub use force::{ForceFile, SaturationEntry};
pub use hysteresis_kind::HysteresisKind;
pub use kind::Kind;
pub use misfit::MisfitEntry;
pub use modes::{
    DerivedQuantity, HysteresisEntry, InfluenceEntry, LawEntry, LevelEntry, ModesFile, ModesScoreEntry,
};
pub use oscillator::{OscillatorFile, OscillatorParameters};
pub use parameters::Parameters;
pub use provenance::{Maker, Provenance, RecordEntry, RecordRole, ScoreEntry, ScoreRole, day, timestamp};
pub use quantity::{Interval, Quantity, typographic};
pub use schema::json_schema;
use start::StartEntry;

use crate::dynamics::Scheme;
use crate::record::{InterSample, Swings, TimeBase, Unit};
use hysteron_numeric::display::{short, short_to};

/// Value of the key `format`.
pub const FORMAT: &str = "hysteron-model";
/// The version this program writes; version 1 is read.
pub const VERSION: u64 = 2;
/// Largest file read \[bytes\]; a model takes a few kilobytes.
pub const MAX_BYTES: u64 = 16 << 20;

/// The file of a Hammerstein model, kind `hammerstein`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a model file (a JSON object)")]
pub struct ModelFile {
    /// Always `hysteron-model`.
    #[schemars(extend("const" = "hysteron-model"))]
    pub format: String,
    /// Always 2.
    #[schemars(extend("const" = 2))]
    pub version: u64,
    /// Always `hammerstein`.
    #[serde(default = "hammerstein")]
    #[schemars(required, extend("const" = "hammerstein"))]
    pub kind: Kind,
    /// A name for people, of the device or the experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Units of the model's input and output.
    #[serde(default)]
    pub units: SignalUnits,
    /// Static block.
    pub hysteresis: HysteresisBlock,
    /// Dynamic block.
    pub dynamics: DynamicsBlock,
    /// Pure delay, in s.
    pub delay: Quantity,
    /// Output offset, the model's only constant term; in the output unit.
    pub offset: Quantity,
    /// Discretisation of the dynamic block on sampled data.
    pub scheme: Scheme,
    /// Inter-sample behaviour of the drive.
    #[serde(default, skip_serializing_if = "is_default")]
    pub inter_sample: InterSample,
    /// Sample rate the model was identified at, in Hz; null for a static model of records without one.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(required)]
    pub sample_rate_hz: Option<f64>,
    /// Normalisation of the gain that is redundant between the blocks.
    #[serde(default)]
    pub normalisation: Normalisation,
    /// Default assumption about the history of the device before a record's first sample.
    #[serde(default)]
    start: StartEntry,
    /// Range that the records covered; outside of it the model extrapolates.
    #[serde(default)]
    pub valid_range: Option<ValidRange>,
    /// Provenance of the model.
    #[serde(default)]
    pub provenance: Option<Provenance>,
    /// Scores of the model on its records.
    #[serde(default)]
    pub scores: Vec<ScoreEntry>,
    /// Correlation matrix of the estimates; with their standard errors it gives their covariance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<CorrelationEntry>,
    /// Difference between the device and the model, where the device is outside the model's class.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub misfit: Option<MisfitEntry>,
}

/// Units of the model's signals, as the suffixes of column headers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `input` and `output`")]
pub struct SignalUnits {
    /// Unit of the input, `V` for a drive voltage.
    pub input: String,
    /// Unit of the output, `um` for a displacement.
    pub output: String,
}

impl Default for SignalUnits {
    /// V and µm.
    fn default() -> Self {
        SignalUnits { input: "V".into(), output: "um".into() }
    }
}

/// Static block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `kind` and `parameters`")]
pub struct HysteresisBlock {
    /// Which model.
    pub kind: HysteresisKind,
    /// Its parameters by name: `linear`, `quadratic`, …, then the numbers of its kind: shape
    /// numbers, and weights, for most kinds `weight_1`, `weight_2`, ….
    pub parameters: Parameters,
}

/// Dynamic block.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `kind`, `numerator` and `denominator`")]
pub struct DynamicsBlock {
    /// Which model.
    pub kind: DynamicsKind,
    /// Numerator terms, orders ascending; empty for `none`.
    #[serde(default)]
    pub numerator: Vec<TermEntry>,
    /// Denominator terms, orders ascending; empty for `none`.
    #[serde(default)]
    pub denominator: Vec<TermEntry>,
}

/// Models of the dynamic block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DynamicsKind {
    /// The output is the hysteresis block's.
    None,
    /// Transfer function in s with whole orders.
    Integer,
    /// Difference equation: orders are powers of z⁻¹, the denominator begins with 1.
    Arx,
    /// Transfer function in s with real orders.
    Fractional,
}

/// One term of the transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `coefficient` and `order`")]
pub struct TermEntry {
    /// Factor of the power.
    pub coefficient: Quantity,
    /// Power of s, or of z⁻¹ for `arx`.
    pub order: Quantity,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Normalisation of the gain that is redundant between the two blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Normalisation {
    /// Each block was identified on its own data, as in the two-step procedure: G(0) is whatever came out.
    #[default]
    Free,
    /// G(0) = 1: the hysteresis block's output reads as the quasi-static displacement.
    UnitDcGain,
    /// |G(2πi · 1 Hz)| = 1, where the lowest order of the denominator is free.
    #[serde(rename = "unit-gain-at-1-hz")]
    UnitGainAt1Hz,
}

/// Range that the records of the identification covered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `input`, `frequency` and `rate`")]
pub struct ValidRange {
    /// Range of the input, in the input's unit.
    pub input: Interval,
    /// Range of frequencies excited, in Hz; null where the records have no time.
    #[serde(default)]
    pub frequency: Option<Interval>,
    /// Range of |du/dt|, in the input's unit per second; null where the records have no time.
    #[serde(default)]
    pub rate: Option<Interval>,
}

/// Excess over the range of the identification, as a share of it, that does not count.
const RANGE_SLACK: f64 = 0.01;

impl ValidRange {
    /// True if inputs of this range, least and largest, go beyond it by more than a hundredth of its width.
    pub fn is_left_by(&self, input: (f64, f64)) -> bool {
        let Interval { low, high, .. } = self.input;
        let slack = RANGE_SLACK * (high - low);
        input.0 < low - slack || input.1 > high + slack
    }
}

impl SignalUnits {
    /// Of an input and an output in these units.
    pub fn of(input: &Unit, output: &Unit) -> Self {
        Self { input: input.symbol().to_owned(), output: output.symbol().to_owned() }
    }
}

impl ValidRange {
    /// Range of the samples of the inputs, in `unit` (a header symbol), and the frequencies excited \[Hz\].
    pub fn of_inputs<'a>(
        inputs: impl IntoIterator<Item = &'a f64>,
        unit: &str,
        excited_hz: Option<(f64, f64)>,
    ) -> Self {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = inputs.into_iter().fold(ends, |(low, high), &u| (low.min(u), high.max(u)));
        let unit = if unit.is_empty() { "1" } else { unit };
        Self {
            input: Interval { low, high, unit: unit.to_owned() },
            frequency: excited_hz.map(|(low, high)| Interval { low, high, unit: "Hz".to_owned() }),
            rate: None,
        }
    }

    /// The range in a sentence.
    pub fn in_words(&self) -> String {
        let unit = if self.input.unit == "1" { String::new() } else { Unit::new(&self.input.unit).spaced() };
        let frequency = match &self.frequency {
            Some(f) if f.low < f.high => {
                format!(", its swings from {} to {} Hz", short_to(f.low, 3), short_to(f.high, 3))
            }
            Some(f) => format!(", its swings at {} Hz", short_to(f.high, 3)),
            None => "; the records say nothing of frequency".to_owned(),
        };
        format!(
            "The model holds for an input from {} to {}{unit}{frequency}: beyond that it extrapolates.",
            short(self.input.low),
            short(self.input.high)
        )
    }

    /// Highest frequency of the swings of a signal, where it is beyond those covered, and the highest covered
    /// \[Hz\].
    pub fn exceeded_by(&self, signal: &[f64], time: &TimeBase) -> Option<(f64, f64)> {
        /// Excess that is worth a remark.
        const FASTER: f64 = 1.1;
        let covered = self.frequency.as_ref()?.high;
        let fastest = Swings::of(signal, time)?.fastest_hz;
        (fastest > FASTER * covered).then_some((fastest, covered))
    }

    /// This range with the largest rate of the input per second.
    #[must_use]
    pub fn with_rate(self, largest: f64) -> Self {
        let unit = match self.input.unit.as_str() {
            "1" => "1/s".to_owned(),
            unit => format!("{unit}/s"),
        };
        Self { rate: Some(Interval { low: 0.0, high: largest, unit }), ..self }
    }
}

impl ModelFile {
    /// The file's text: indented JSON with a final newline.
    ///
    /// # Errors
    /// [`ModelFileError`] if the content would not be accepted by [`read`].
    pub fn to_json(&self) -> Result<String, ModelFileError> {
        self.check()?;
        json::text(self)
    }
}

fn hammerstein() -> Kind {
    Kind::Hammerstein
}

#[cfg(test)]
mod tests;
