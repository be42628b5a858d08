//! The file of an oscillator: hysteresis in feedback.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{self, allowed, quantity, score};
use super::convert::Units;
use super::json;
use super::start::StartKind;
use super::{
    FORMAT, Kind, ModelFileError, Provenance, Quantity, ScoreEntry, SignalUnits, VERSION, ValidRange,
};
use crate::oscillator::Oscillator;
use crate::record::InterSample;

/// A file of the format `hysteron-model`, kind `oscillator`: m ÿ + c ẏ + k y + z = u,
/// ż = α ẏ − β |ẏ| z |z|ⁿ⁻¹ − γ ẏ |z|ⁿ, and how it was made.
///
/// Every number is a [`Quantity`]; units follow from those of the signals, e.g. `N*s^2/um` for the mass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "the file of an oscillator (a JSON object)")]
pub struct OscillatorFile {
    /// Always `hysteron-model`.
    #[schemars(extend("const" = "hysteron-model"))]
    pub format: String,
    /// Always 2.
    #[schemars(extend("const" = 2))]
    pub version: u64,
    /// Always `oscillator`.
    #[serde(default = "oscillator")]
    #[schemars(required, extend("const" = "oscillator"))]
    pub kind: Kind,
    /// A name for people, of the device or the experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Units of force and displacement.
    pub units: SignalUnits,
    /// The parameters.
    pub parameters: OscillatorParameters,
    /// Offset of the sensor, in the output unit.
    pub offset: Quantity,
    /// Inter-sample behaviour of the force.
    pub inter_sample: InterSample,
    /// Sample rate the oscillator was identified at, in Hz.
    pub sample_rate_hz: f64,
    /// Default assumption about its history before a record's first sample: `rest` without memory, or
    /// `settled` on the record's period.
    #[serde(default)]
    pub(super) start: StartKind,
    /// Range that the records covered; outside of it the model extrapolates.
    #[serde(default)]
    pub valid_range: Option<ValidRange>,
    /// Provenance of the model.
    #[serde(default)]
    pub provenance: Option<Provenance>,
    /// Scores of the model on its records.
    #[serde(default)]
    pub scores: Vec<ScoreEntry>,
}

/// Parameters of an oscillator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of the oscillator's parameters")]
pub struct OscillatorParameters {
    /// m > 0, e.g. in `N*s^2/um`.
    pub mass: Quantity,
    /// c, e.g. in `N*s/um`.
    pub damping: Quantity,
    /// k, e.g. in `N/um`.
    pub stiffness: Quantity,
    /// α, e.g. in `N/um`.
    pub alpha: Quantity,
    /// β, e.g. in `1/um` for n = 1, else `N^(1-n)/um`.
    pub beta: Quantity,
    /// γ, in the unit of β.
    pub gamma: Quantity,
    /// n ≥ 1.
    pub n: Quantity,
}

impl OscillatorParameters {
    /// The parameters in the order of [`Oscillator::NAMES`].
    pub fn all(&self) -> [&Quantity; 7] {
        [&self.mass, &self.damping, &self.stiffness, &self.alpha, &self.beta, &self.gamma, &self.n]
    }

    /// The parameters, mutable, to set their standard errors.
    pub fn all_mut(&mut self) -> [&mut Quantity; 7] {
        [
            &mut self.mass,
            &mut self.damping,
            &mut self.stiffness,
            &mut self.alpha,
            &mut self.beta,
            &mut self.gamma,
            &mut self.n,
        ]
    }
}

/// Units of the parameters in the order of [`Oscillator::NAMES`].
fn units(signals: &SignalUnits, n: f64) -> [String; 7] {
    let Units { input, output } = Units::new(signals);
    let shape = if n == 1.0 { format!("1/{output}") } else { shape_of_any_n(signals) };
    [
        format!("{input}*s^2/{output}"),
        format!("{input}*s/{output}"),
        format!("{input}/{output}"),
        format!("{input}/{output}"),
        shape.clone(),
        shape,
        "1".to_owned(),
    ]
}

fn shape_of_any_n(signals: &SignalUnits) -> String {
    let Units { input, output } = Units::new(signals);
    format!("{input}^(1-n)/{output}")
}

impl OscillatorFile {
    /// File of an oscillator whose signals have the given units; without standard errors, range, provenance
    /// or scores.
    pub fn new(
        oscillator: &Oscillator,
        signals: SignalUnits,
        inter_sample: InterSample,
        sample_rate_hz: f64,
    ) -> Self {
        let units = units(&signals, oscillator.n);
        let mut of_units = oscillator.values().into_iter().zip(units);
        let mut next = || of_units.next().map_or(Quantity::new(0.0, "1"), |(v, unit)| Quantity::new(v, unit));
        Self {
            format: FORMAT.into(),
            version: VERSION,
            kind: Kind::Oscillator,
            name: None,
            parameters: OscillatorParameters {
                mass: next(),
                damping: next(),
                stiffness: next(),
                alpha: next(),
                beta: next(),
                gamma: next(),
                n: next(),
            },
            offset: Quantity::new(0.0, Units::new(&signals).output),
            units: signals,
            inter_sample,
            sample_rate_hz,
            start: StartKind::Rest,
            valid_range: None,
            provenance: None,
            scores: Vec::new(),
        }
    }

    /// The oscillator in the file.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn to_oscillator(&self) -> Result<Oscillator, ModelFileError> {
        self.check()?;
        Ok(Oscillator::from_values(self.parameters.all().map(|quantity| quantity.value)))
    }

    /// Checks everything that is not a matter of types: format and version, finite numbers, ranges, units.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        check::header(&self.format, self.version, (self.kind, Kind::Oscillator))?;
        // The unit of the shape depends on n, which has to be right first.
        quantity("parameters.n", &self.parameters.n, "1", Some(1.0))?;
        let n = self.parameters.n.value;
        let any = shape_of_any_n(&self.units);
        for ((name, found), unit) in
            Oscillator::NAMES.into_iter().zip(self.parameters.all()).zip(units(&self.units, n))
        {
            let path = format!("parameters.{name}");
            // The general form of the shape's unit is right for n = 1 as well.
            let unit = if matches!(name, "beta" | "gamma") && found.unit == any { &any } else { &unit };
            quantity(&path, found, unit, None)?;
        }
        let mass = self.parameters.mass.value;
        allowed("parameters.mass.value", mass, mass > 0.0, "a number above 0")?;
        let signals = Units::new(&self.units);
        quantity("offset", &self.offset, &signals.output, None)?;
        check::sample_rate(self.sample_rate_hz)?;
        check::valid_range(self.valid_range.as_ref(), &signals)?;
        self.scores.iter().enumerate().try_for_each(|(i, s)| score(i, s))
    }

    /// The file's text: indented JSON with a final newline.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn to_json(&self) -> Result<String, ModelFileError> {
        self.check()?;
        json::text(self)
    }
}

fn oscillator() -> Kind {
    Kind::Oscillator
}

#[cfg(test)]
mod tests;
