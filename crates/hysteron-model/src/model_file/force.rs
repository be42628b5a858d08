//! The file of a force against a displacement and its rate.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{self, allowed, quantity, score};
use super::convert::{Units, operator, parameters};
use super::json;
use super::{
    FORMAT, HysteresisBlock, HysteresisKind, Kind, ModelFileError, Parameters, Provenance, Quantity,
    ScoreEntry, SignalUnits, VERSION, ValidRange,
};
use crate::force::{ForceModel, Saturation};

/// A file of the format `hysteron-model`, kind `force`: F = F₀ + H\[x\] + c v + Σⱼ dⱼ sⱼ, ρⱼ ṡⱼ = v − νⱼ
/// artanh sⱼ, v = ẋ, and how it was made.
///
/// Every number is a [`Quantity`]; units follow from those of the signals, e.g. `N*s/um` for `viscous`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "the file of a force (a JSON object)")]
pub struct ForceFile {
    /// Always `hysteron-model`.
    #[schemars(extend("const" = "hysteron-model"))]
    pub format: String,
    /// Always 2.
    #[schemars(extend("const" = 2))]
    pub version: u64,
    /// Always `force`.
    #[serde(default = "force")]
    #[schemars(required, extend("const" = "force"))]
    pub kind: Kind,
    /// A name for people, of the device or the experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Units of displacement and force.
    pub units: SignalUnits,
    /// H\[x\]: the force that follows the displacement. `linear` is the stiffness.
    pub hysteresis: HysteresisBlock,
    /// Viscous coefficient c, e.g. in `N*s/um`.
    pub viscous: Quantity,
    /// Forces that saturate with the rate.
    #[serde(default)]
    pub saturating: Vec<SaturationEntry>,
    /// Constant force F₀, in the output unit.
    pub offset: Quantity,
    /// Time over which the rate is averaged where a record has none, in s.
    pub rate_window: Quantity,
    /// Sample rate the model was identified at, in Hz; null for records with other time stamps.
    #[serde(default)]
    pub sample_rate_hz: Option<f64>,
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

/// The force d s, ρ ṡ = v − ν artanh s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `force`, `rate` and `reach`")]
pub struct SaturationEntry {
    /// d, at which it saturates, in the output unit.
    pub force: Quantity,
    /// ν > 0, the rate of the dashpot, e.g. in `um/s`.
    pub rate: Quantity,
    /// ρ ≥ 0, the displacement over which the compliance yields, in the input unit.
    pub reach: Quantity,
}

impl SaturationEntry {
    /// Its numbers with their names.
    fn named(&self) -> [(&'static str, &Quantity); 3] {
        [("force", &self.force), ("rate", &self.rate), ("reach", &self.reach)]
    }

    fn named_mut(&mut self) -> [(&'static str, &mut Quantity); 3] {
        [("force", &mut self.force), ("rate", &mut self.rate), ("reach", &mut self.reach)]
    }
}

/// Unit of c.
fn viscous_unit(units: &Units) -> String {
    format!("{}*s/{}", units.output, units.input)
}

impl ForceFile {
    /// File of a force whose signals have the given units; without standard errors, range, provenance or
    /// scores.
    pub fn new(model: &ForceModel, signals: SignalUnits, sample_rate_hz: Option<f64>) -> Self {
        let units = Units::new(&signals);
        let entry = |s: &Saturation| SaturationEntry {
            force: Quantity::new(s.force, units.output.clone()),
            rate: Quantity::new(s.rate, units.rate()),
            reach: Quantity::new(s.reach, units.input.clone()),
        };
        Self {
            format: FORMAT.into(),
            version: VERSION,
            kind: Kind::Force,
            name: None,
            hysteresis: HysteresisBlock {
                kind: HysteresisKind::of(&model.hysteresis),
                parameters: parameters(&model.hysteresis, &units),
            },
            viscous: Quantity::new(model.viscous, viscous_unit(&units)),
            saturating: model.saturating.iter().map(entry).collect(),
            offset: Quantity::new(model.offset, units.output.clone()),
            rate_window: Quantity::new(model.rate_window_s, "s"),
            sample_rate_hz,
            units: signals,
            valid_range: None,
            provenance: None,
            scores: Vec::new(),
        }
    }

    /// The model in the file.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn to_model(&self) -> Result<ForceModel, ModelFileError> {
        self.check()?;
        let saturation = |entry: &SaturationEntry| Saturation {
            force: entry.force.value,
            rate: entry.rate.value,
            reach: entry.reach.value,
        };
        Ok(ForceModel {
            offset: self.offset.value,
            hysteresis: operator(self.hysteresis.kind.family(), &self.hysteresis.parameters)?,
            viscous: self.viscous.value,
            saturating: self.saturating.iter().map(saturation).collect(),
            rate_window_s: self.rate_window.value,
        })
    }

    /// The quantity of this name, as in [`ForceModel::numbers`].
    pub fn quantity_mut(&mut self, name: &str) -> Option<&mut Quantity> {
        match name {
            "offset" => return Some(&mut self.offset),
            "viscous" => return Some(&mut self.viscous),
            _ => {}
        }
        for (index, entry) in self.saturating.iter_mut().enumerate() {
            let mut numbers = entry.named_mut().into_iter();
            if let Some((_, quantity)) = numbers.find(|(number, _)| Saturation::name(number, index) == name) {
                return Some(quantity);
            }
        }
        let parameters: &mut Parameters = &mut self.hysteresis.parameters;
        parameters.get_mut(name)
    }

    /// Checks everything that is not a matter of types: format and version, finite numbers, ranges, units.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        check::header(&self.format, self.version, (self.kind, Kind::Force))?;
        let units = Units::new(&self.units);
        check::family(self.hysteresis.kind.family(), &self.hysteresis.parameters, &units)?;
        quantity("viscous", &self.viscous, &viscous_unit(&units), None)?;
        let terms = self.saturating.len();
        allowed("saturating", terms as f64, terms <= check::MOST_SATURATING, "at most 64 terms")?;
        for (index, entry) in self.saturating.iter().enumerate() {
            let own = [(&units.output, None), (&units.rate(), Some(0.0)), (&units.input, Some(0.0))];
            for ((name, found), (unit, least)) in entry.named().into_iter().zip(own) {
                quantity(&format!("saturating[{index}].{name}"), found, unit, least)?;
            }
            let rate = entry.rate.value;
            allowed(&format!("saturating[{index}].rate.value"), rate, rate > 0.0, "a number above 0")?;
        }
        quantity("offset", &self.offset, &units.output, None)?;
        quantity("rate_window", &self.rate_window, "s", Some(0.0))?;
        if let Some(rate) = self.sample_rate_hz {
            check::sample_rate(rate)?;
        }
        check::valid_range(self.valid_range.as_ref(), &units)?;
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

fn force() -> Kind {
    Kind::Force
}

#[cfg(test)]
mod tests;
