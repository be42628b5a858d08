//! The file of coupled Hammerstein branches: hysteresis of each actuator, dynamics of each path.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{self, allowed, quantity};
use super::convert::Units;
use super::json;
use super::{
    FORMAT, Kind, ModelFileError, ModesScoreEntry, Provenance, Quantity, SignalUnits, VERSION, ValidRange,
};
use crate::axes::{CoupledErrors, CoupledHammerstein, Path};
use crate::hysteresis::ArticleOperator;

/// A file of the format `hysteron-model`, kind `branches`: y_m = offset_m + Σ_n K_mn (G_mn ∗ v_n)(t − τ_mn),
/// v_n = u_n − z_n, ż_n = α u̇_n − β |u̇_n| z_n − γ u̇_n |z_n|, G_mn a pair of poles of gain 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "the file of coupled branches (a JSON object)")]
pub struct CoupledFile {
    /// Always `hysteron-model`.
    #[schemars(extend("const" = "hysteron-model"))]
    pub format: String,
    /// Always 2.
    #[schemars(extend("const" = 2))]
    pub version: u64,
    /// Always `branches`.
    #[serde(default = "branches")]
    #[schemars(required, extend("const" = "branches"))]
    pub kind: Kind,
    /// A name for people, of the device or the experiment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Units of the inputs and of the outputs.
    pub units: SignalUnits,
    /// Columns of the inputs.
    pub inputs: Vec<String>,
    /// Columns of the outputs.
    pub outputs: Vec<String>,
    /// Sample rate the model was identified at, in Hz.
    pub sample_rate_hz: f64,
    /// One an input.
    pub actuators: Vec<ActuatorEntry>,
    /// A list an output, of one path an input.
    pub paths: Vec<Vec<PathEntry>>,
    /// Offset of each output's sensor, in the output unit.
    pub offsets: Vec<Quantity>,
    /// Range that the records covered; outside of it the model extrapolates.
    #[serde(default)]
    pub valid_range: Option<ValidRange>,
    /// Provenance of the model.
    #[serde(default)]
    pub provenance: Option<Provenance>,
    /// Scores of the model on its records.
    #[serde(default)]
    pub scores: Vec<ModesScoreEntry>,
}

/// Hysteresis of an actuator, z in the unit of the input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of an actuator's parameters")]
pub struct ActuatorEntry {
    /// α, a number without unit.
    pub alpha: Quantity,
    /// β, e.g. in `1/V`.
    pub beta: Quantity,
    /// γ, in the unit of β.
    pub gamma: Quantity,
}

/// Dynamics of a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of a path's parameters")]
pub struct PathEntry {
    /// K, e.g. in `um/V`.
    pub gain: Quantity,
    /// Natural frequency, in Hz.
    pub natural_frequency: Quantity,
    /// Damping ratio.
    pub damping: Quantity,
    /// Delay, in s.
    pub delay: Quantity,
}

impl CoupledFile {
    /// Every parameter with where it belongs.
    pub fn parameters(&self) -> Vec<(String, &'static str, &Quantity)> {
        let mut all = Vec::new();
        for (name, a) in self.inputs.iter().zip(&self.actuators) {
            all.extend(
                [("alpha", &a.alpha), ("beta", &a.beta), ("gamma", &a.gamma)]
                    .map(|(p, q)| (name.clone(), p, q)),
            );
        }
        for (output, row) in self.outputs.iter().zip(&self.paths) {
            for (input, p) in self.inputs.iter().zip(row) {
                let path = format!("{input} to {output}");
                let numbers = [
                    ("gain", &p.gain),
                    ("natural_frequency", &p.natural_frequency),
                    ("damping", &p.damping),
                    ("delay", &p.delay),
                ];
                all.extend(numbers.map(|(name, q)| (path.clone(), name, q)));
            }
        }
        all
    }

    /// File of a model whose channels have these names and units; without range, provenance or scores.
    pub fn new(
        model: &CoupledHammerstein,
        errors: Option<&CoupledErrors>,
        units: SignalUnits,
        (inputs, outputs): (Vec<String>, Vec<String>),
    ) -> Self {
        let Units { input, output } = Units::new(&units);
        let number = |value, unit: &str, std_error| Quantity { value, unit: unit.to_owned(), std_error };
        let per_input = format!("1/{input}");
        let actuator = |(n, a): (usize, &ArticleOperator)| {
            let error = |k: usize| errors.and_then(|e| e.actuators.get(n)).map(|e| e[k]);
            ActuatorEntry {
                alpha: number(a.alpha, "1", error(0)),
                beta: number(a.beta, &per_input, error(1)),
                gamma: number(a.gamma, &per_input, error(2)),
            }
        };
        let path = |(k, p): (usize, &Path)| {
            let error = |which: usize| errors.and_then(|e| e.paths.get(k)).map(|e| e[which]);
            PathEntry {
                gain: number(p.gain, &format!("{output}/{input}"), error(0)),
                natural_frequency: number(p.natural_frequency_hz, "Hz", error(1)),
                damping: number(p.damping, "1", error(2)),
                delay: number(p.delay_s, "s", error(3)),
            }
        };
        let paths: Vec<PathEntry> = model.paths.iter().enumerate().map(path).collect();
        Self {
            format: FORMAT.into(),
            version: VERSION,
            kind: Kind::Branches,
            name: None,
            inputs,
            outputs,
            sample_rate_hz: model.sample_rate_hz,
            actuators: model.actuators.iter().enumerate().map(actuator).collect(),
            paths: paths.chunks(model.inputs().max(1)).map(<[PathEntry]>::to_vec).collect(),
            offsets: model.offsets.iter().map(|o| Quantity::new(*o, output.clone())).collect(),
            units,
            valid_range: None,
            provenance: None,
            scores: Vec::new(),
        }
    }

    /// The model in the file.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn to_model(&self) -> Result<CoupledHammerstein, ModelFileError> {
        self.check()?;
        let actuator = |a: &ActuatorEntry| ArticleOperator {
            polynomial: vec![1.0],
            alpha: a.alpha.value,
            beta: a.beta.value,
            gamma: a.gamma.value,
            n: 1.0,
        };
        let path = |p: &PathEntry| Path {
            gain: p.gain.value,
            natural_frequency_hz: p.natural_frequency.value,
            damping: p.damping.value,
            delay_s: p.delay.value,
        };
        Ok(CoupledHammerstein {
            actuators: self.actuators.iter().map(actuator).collect(),
            paths: self.paths.iter().flatten().map(path).collect(),
            offsets: self.offsets.iter().map(|o| o.value).collect(),
            sample_rate_hz: self.sample_rate_hz,
        })
    }

    /// Checks everything that is not a matter of types: format and version, names, lengths of lists, finite
    /// numbers, ranges, units.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        check::header(&self.format, self.version, (self.kind, Kind::Branches))?;
        check::channels(&self.inputs, &self.outputs)?;
        let count = |path: &str, found: usize, expected: usize, what| {
            allowed(path, found as f64, found == expected && expected > 0, what)
        };
        let paths = self.inputs.len().saturating_mul(self.outputs.len());
        allowed("paths", paths as f64, paths <= check::MOST_PATHS, "at most 4096 paths")?;
        count("actuators", self.actuators.len(), self.inputs.len(), "one entry an input")?;
        count("paths", self.paths.len(), self.outputs.len(), "one list an output")?;
        count("offsets", self.offsets.len(), self.outputs.len(), "one entry an output")?;
        let units = Units::new(&self.units);
        let Units { input, output } = &units;
        for (n, actuator) in self.actuators.iter().enumerate() {
            let path = |name: &str| format!("actuators[{n}].{name}");
            quantity(&path("alpha"), &actuator.alpha, "1", None)?;
            quantity(&path("beta"), &actuator.beta, &format!("1/{input}"), None)?;
            quantity(&path("gamma"), &actuator.gamma, &format!("1/{input}"), None)?;
        }
        for (m, row) in self.paths.iter().enumerate() {
            count(&format!("paths[{m}]"), row.len(), self.inputs.len(), "one entry an input")?;
            for (n, entry) in row.iter().enumerate() {
                let path = |name: &str| format!("paths[{m}][{n}].{name}");
                quantity(&path("gain"), &entry.gain, &format!("{output}/{input}"), None)?;
                quantity(&path("natural_frequency"), &entry.natural_frequency, "Hz", Some(0.0))?;
                quantity(&path("damping"), &entry.damping, "1", Some(0.0))?;
                quantity(&path("delay"), &entry.delay, "s", Some(0.0))?;
                for (name, value) in
                    [("natural_frequency", entry.natural_frequency.value), ("damping", entry.damping.value)]
                {
                    allowed(&path(name), value, value > 0.0, "a number above 0")?;
                }
            }
        }
        for (m, offset) in self.offsets.iter().enumerate() {
            quantity(&format!("offsets[{m}]"), offset, output, None)?;
        }
        check::sample_rate(self.sample_rate_hz)?;
        check::valid_range(self.valid_range.as_ref(), &units)?;
        self.scores.iter().enumerate().try_for_each(|(i, score)| check::axes_score(i, score))
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

fn branches() -> Kind {
    Kind::Branches
}

#[cfg(test)]
mod tests;
