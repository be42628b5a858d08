//! The file of scheduled modes: several inputs and outputs, hysteresis in feedback.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{self, allowed};
use super::convert::Units;
use super::json;
use super::{FORMAT, Kind, ModelFileError, Provenance, SignalUnits, VERSION, ValidRange};
use crate::axes::{FeedbackStrain, InfluenceMatrix, LevelLaw, ScheduledModes, StrainLaw};

/// A file of the format `hysteron-model`, kind `modes`: the numbers of [`ScheduledModes`], whose
/// documentation has the equations.
///
/// Matrices are lists row by row. Units: inputs in `units.input`, outputs in `units.output`; strains, strokes
/// and stresses in the unit of the inputs; states are numbers without a unit of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "the file of scheduled modes (a JSON object)")]
pub struct ModesFile {
    /// Always `hysteron-model`.
    #[schemars(extend("const" = "hysteron-model"))]
    pub format: String,
    /// Always 2.
    #[schemars(extend("const" = 2))]
    pub version: u64,
    /// Always `modes`.
    #[serde(default = "modes")]
    #[schemars(required, extend("const" = "modes"))]
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
    /// Sample rate the model holds for, in Hz.
    pub sample_rate_hz: f64,
    /// Steps of the simulation a sample.
    pub steps: usize,
    /// Number of modes K; there are 2K states of modes, then one lag an input.
    pub modes: usize,
    /// Schedule of S over the level of the drive.
    pub level: LevelEntry,
    /// Re p, Im p of every mode, then the lags.
    pub transition: Vec<f64>,
    /// Their change with S.
    pub transition_slopes: Vec<f64>,
    /// States × inputs.
    pub input: Vec<f64>,
    /// States × inputs, for the strains.
    pub strain_input: Vec<f64>,
    /// Outputs × states.
    pub output: Vec<f64>,
    /// Its change with S.
    pub output_slopes: Vec<f64>,
    /// Outputs × inputs.
    pub feedthrough: Vec<f64>,
    /// Its change with S.
    pub feedthrough_slopes: Vec<f64>,
    /// Outputs × inputs, for the strains.
    pub strain_feedthrough: Vec<f64>,
    /// The hysteresis; null: linear modes.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(required)]
    pub hysteresis: Option<HysteresisEntry>,
    /// Physical quantities with standard errors: frequencies, dampings, gains, weights of the hysteresis.
    /// They follow from the lists above, whose states have no scale of their own and so no standard errors.
    #[serde(default)]
    pub quantities: Vec<DerivedQuantity>,
    /// Influence matrices, of the levels whose records determine one.
    #[serde(default)]
    pub influence: Vec<InfluenceEntry>,
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

/// Schedule over the level of the drive, the rms of the inputs about their means:
/// S = (level/reference)^exponent − 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of the level's numbers")]
pub struct LevelEntry {
    /// Level at which S = 0, in the unit of the inputs, as the following two.
    pub reference: f64,
    /// Lowest level identified; below it S stays.
    pub lowest: f64,
    /// Highest level identified; above it S stays.
    pub highest: f64,
    /// Exponent; 1: linear in amplitude.
    pub exponent: f64,
    /// Time constant of the running rms, in s.
    pub time_constant_s: f64,
}

/// Strains of the actuators, of their free strokes and of their stresses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of the hysteresis")]
pub struct HysteresisEntry {
    /// Inputs × (states, inputs): what each actuator would do freely.
    pub drive_rows: Vec<f64>,
    /// Inputs × (states, inputs): its stress.
    pub stress_rows: Vec<f64>,
    /// The law of free strokes, shared by the actuators.
    pub drive: LawEntry,
    /// The laws of stress, one an input.
    pub stress: Vec<LawEntry>,
}

/// c₂ (z² − s²) + c₃ (z³ − 3 s² z) + Σ c_j (P_j\[z\] − γ_j z).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of a law of strain")]
pub struct LawEntry {
    /// c₂, c₃, then a weight a play.
    pub coefficients: Vec<f64>,
    /// Radii of the plays.
    pub radii: Vec<f64>,
    /// γ, one a play.
    pub slopes: Vec<f64>,
    /// s².
    pub variance: f64,
    /// Largest |z|; beyond it the law stays. Null: none, of files before there was one.
    #[serde(default)]
    pub reach: Option<f64>,
}

/// A quantity that follows from a model, with its standard error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of a quantity: of, name, value, unit")]
pub struct DerivedQuantity {
    /// Part of the model: `mode 2`, `u1 to y2`, `stress of u1`.
    pub of: String,
    /// Name of the quantity.
    pub name: String,
    /// The value, finite.
    pub value: f64,
    /// Its unit; `1` for a pure number.
    pub unit: String,
    /// Standard error in the same unit, ≥ 0; null where the records do not determine the quantity.
    #[serde(default)]
    pub std_error: Option<f64>,
}

/// An influence matrix and its conditioning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of an influence matrix")]
pub struct InfluenceEntry {
    /// Level, rms of the inputs.
    pub level: f64,
    /// Outputs × inputs, in output units per input unit.
    pub matrix: Vec<f64>,
    /// Singular values, descending.
    pub singular_values: Vec<f64>,
    /// Largest over smallest; null where it is infinite.
    pub condition_number: Option<f64>,
}

/// Scores of the model on a record it was fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object of scores")]
pub struct ModesScoreEntry {
    /// The record.
    pub record: String,
    /// Level, rms of the inputs.
    pub level: f64,
    /// rms error of its mean period, pooled over the outputs, in the unit of the outputs.
    pub rmse: f64,
    /// Scores of every output.
    pub output_rmse: Vec<f64>,
    /// 100 · (1 − rms error / rms output).
    pub fit_percent: f64,
}

impl From<&StrainLaw> for LawEntry {
    fn from(law: &StrainLaw) -> Self {
        let StrainLaw { coefficients, radii, slopes, variance, reach } = law.clone();
        Self { coefficients, radii, slopes, variance, reach: Some(reach).filter(|reach| reach.is_finite()) }
    }
}

impl From<&LawEntry> for StrainLaw {
    fn from(law: &LawEntry) -> Self {
        let LawEntry { coefficients, radii, slopes, variance, reach } = law.clone();
        Self { coefficients, radii, slopes, variance, reach: reach.unwrap_or(f64::INFINITY) }
    }
}

impl InfluenceEntry {
    /// Entry of a matrix at a level.
    pub fn new(level: f64, matrix: &InfluenceMatrix) -> Self {
        Self {
            level,
            matrix: matrix.values.clone(),
            singular_values: matrix.singular_values.clone(),
            condition_number: Some(matrix.condition_number()).filter(|c| c.is_finite()),
        }
    }
}

impl ModesFile {
    /// File of a model whose channels have these names and units; without influence, range, provenance or
    /// scores.
    pub fn new(
        model: &ScheduledModes,
        units: SignalUnits,
        inputs: Vec<String>,
        outputs: Vec<String>,
    ) -> Self {
        let m = model.clone();
        let level = LevelEntry {
            reference: m.level.reference,
            lowest: m.level.lowest,
            highest: m.level.highest,
            exponent: m.level.exponent,
            time_constant_s: m.level.time_constant_s,
        };
        let hysteresis = m.feedback.map(|f| HysteresisEntry {
            drive: (&f.drive).into(),
            stress: f.stress.iter().map(LawEntry::from).collect(),
            drive_rows: f.drive_rows,
            stress_rows: f.stress_rows,
        });
        Self {
            format: FORMAT.into(),
            version: VERSION,
            kind: Kind::Modes,
            name: None,
            units,
            inputs,
            outputs,
            sample_rate_hz: m.sample_rate_hz,
            steps: m.steps,
            modes: m.modes,
            level,
            transition: m.transition,
            transition_slopes: m.transition_slopes,
            input: m.input,
            strain_input: m.strain_input,
            output: m.output,
            output_slopes: m.output_slopes,
            feedthrough: m.feedthrough,
            feedthrough_slopes: m.feedthrough_slopes,
            strain_feedthrough: m.strain_feedthrough,
            hysteresis,
            quantities: Vec::new(),
            influence: Vec::new(),
            valid_range: None,
            provenance: None,
            scores: Vec::new(),
        }
    }

    /// The model in the file.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn to_model(&self) -> Result<ScheduledModes, ModelFileError> {
        self.check()?;
        Ok(self.unchecked())
    }

    fn unchecked(&self) -> ScheduledModes {
        let LevelEntry { reference, lowest, highest, exponent, time_constant_s } = self.level;
        ScheduledModes {
            inputs: self.inputs.len(),
            outputs: self.outputs.len(),
            modes: self.modes,
            sample_rate_hz: self.sample_rate_hz,
            steps: self.steps,
            level: LevelLaw { reference, exponent, lowest, highest, time_constant_s },
            transition: self.transition.clone(),
            transition_slopes: self.transition_slopes.clone(),
            input: self.input.clone(),
            strain_input: self.strain_input.clone(),
            output: self.output.clone(),
            output_slopes: self.output_slopes.clone(),
            feedthrough: self.feedthrough.clone(),
            feedthrough_slopes: self.feedthrough_slopes.clone(),
            strain_feedthrough: self.strain_feedthrough.clone(),
            feedback: self.hysteresis.as_ref().map(|h| FeedbackStrain {
                drive_rows: h.drive_rows.clone(),
                stress_rows: h.stress_rows.clone(),
                drive: (&h.drive).into(),
                stress: h.stress.iter().map(StrainLaw::from).collect(),
            }),
        }
    }

    /// Checks everything that is not a matter of types: format and version, names, lengths of lists, finite
    /// numbers, ranges, stable poles.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        check::header(&self.format, self.version, (self.kind, Kind::Modes))?;
        check::channels(&self.inputs, &self.outputs)?;
        // Lengths are products of these: they have to be sensible before they are multiplied.
        let most = [self.inputs.len(), self.outputs.len(), self.modes, self.steps].into_iter().max();
        let most = most.unwrap_or(0) as f64;
        allowed("modes", most, most <= 512.0, "at most 512 modes, inputs, outputs and steps")?;
        self.unchecked().validate()?;
        let entries = self.inputs.len() * self.outputs.len();
        for (i, influence) in self.influence.iter().enumerate() {
            let path = format!("influence[{i}].matrix");
            let found = influence.matrix.len();
            allowed(&path, found as f64, found == entries, "outputs × inputs numbers")?;
            let numbers = influence.matrix.iter().chain(&influence.singular_values);
            let numbers = numbers.chain(&influence.condition_number).chain([&influence.level]);
            numbers.copied().try_for_each(|x| allowed(&path, x, x.is_finite(), "finite numbers"))?;
        }
        for (i, quantity) in self.quantities.iter().enumerate() {
            let path = format!("quantities[{i}]");
            allowed(&path, quantity.value, quantity.value.is_finite(), "finite numbers")?;
            let error = quantity.std_error.unwrap_or(0.0);
            allowed(&format!("{path}.std_error"), error, error.is_finite() && error >= 0.0, "at least 0")?;
        }
        check::valid_range(self.valid_range.as_ref(), &Units::new(&self.units))?;
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

fn modes() -> Kind {
    Kind::Modes
}

#[cfg(test)]
mod tests;
