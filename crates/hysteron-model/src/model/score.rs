//! How well a model describes a record, as numbers and as data whose keys name the units.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::Simulation;
use crate::record::{InputOutput, Unit, key_in};
use crate::start::Memory;
use crate::start::Start;
use crate::validate::Scores;

/// How well a model describes a record.
///
/// As JSON, quantities in the unit of the outputs have keys that end in it (`rmse_um`), and `unit` names it where it is not µm;
/// `start` is there where a hysteresis memory was estimated. Several outputs: the figures are pooled over them, then `outputs` has
/// each of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Name of the record: the path of its file, where it has one.
    pub record: String,
    /// Unit of the outputs.
    pub unit: Unit,
    /// √(mean e²) over all samples of all outputs, in `unit`.
    pub rmse: f64,
    /// Largest |e|, in `unit`.
    pub max_abs_error: f64,
    /// 100 · (1 − ‖e‖₂ / ‖y − ȳ‖₂) \[%\]; `None` for a constant record.
    pub fit_percent: Option<f64>,
    /// Scores of each output.
    pub outputs: Vec<Scores>,
    /// What a record of several axes has beside them.
    pub axes: Option<AxesScore>,
    /// How the 95 % band of a new measurement holds the record, where it was asked for.
    pub band: Option<BandScore>,
    /// The simulation that was scored.
    pub simulation: Simulation,
}

/// How well a model describes a run of several records, simulated at one go from the start of the first, with one offset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Each part of the run, with the offset of the whole.
    pub records: Vec<Score>,
    /// The whole run.
    pub whole: Score,
    /// The whole run from the start that the model file assumes, without the memory that the first record tells of; `None` where
    /// that is the same.
    pub whole_without_estimated_start: Option<Score>,
}

/// Scores that only a record of several axes has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxesScore {
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// rms of the inputs about their means, where the drive repeats.
    pub level: Option<f64>,
    /// RMSE of the mean period, means off, where the drive repeats.
    pub mean_period_rmse: Option<f64>,
}

/// How the 95 % band of a new measurement holds a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandScore {
    /// Share of the scored samples within the band \[%\].
    pub inside_percent: f64,
    /// Half of its width at its widest, in the unit of the output.
    pub measurement: f64,
    /// The same of the band of the model's output.
    pub model: f64,
}

impl Score {
    /// Scores of a record of one output.
    pub fn of_single(record: &InputOutput, unit: Unit, scores: Scores, simulation: Simulation) -> Self {
        Self {
            record: record.label().to_owned(),
            unit,
            rmse: scores.rmse,
            max_abs_error: scores.max_abs_error,
            fit_percent: scores.fit_percent,
            outputs: vec![scores],
            axes: None,
            band: None,
            simulation,
        }
    }

    /// The hysteresis memory estimated from the record, and the voltage before its first sample \[V\].
    pub fn estimated_memory(&self) -> Option<(f64, Memory)> {
        match self.simulation.start {
            Start::Remembering { voltage_v, memory } => Some((voltage_v, memory)),
            _ => None,
        }
    }
}

impl Serialize for Score {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let symbol = self.unit.symbol();
        let first = self.outputs.first();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("record", &self.record)?;
        map.serialize_entry("samples", &first.map(|s| s.samples))?;
        map.serialize_entry("skipped_samples", &first.map(|s| s.skipped_samples))?;
        if symbol != "um" {
            map.serialize_entry("unit", symbol)?;
        }
        let Some(axes) = &self.axes else {
            if let Some(scores) = first {
                of_output(&mut map, symbol, scores)?;
            }
            if let Some(band) = self.band {
                map.serialize_entry("within_band_percent", &band.inside_percent)?;
                map.serialize_entry(&key_in("band_of_measurement", symbol), &band.measurement)?;
                map.serialize_entry(&key_in("band_of_model", symbol), &band.model)?;
            }
            if let Some((voltage, memory)) = self.estimated_memory() {
                map.serialize_entry("start", &RememberingStart::new(voltage, memory))?;
            }
            return map.end();
        };
        map.serialize_entry("level", &axes.level)?;
        map.serialize_entry(&key_in("rmse", symbol), &self.rmse)?;
        map.serialize_entry(&key_in("rmse_mean_period", symbol), &axes.mean_period_rmse)?;
        map.serialize_entry(&key_in("max_abs_error", symbol), &self.max_abs_error)?;
        map.serialize_entry("fit_percent", &self.fit_percent)?;
        let outputs = axes.outputs.iter().zip(&self.outputs);
        let outputs: Vec<_> = outputs.map(|(name, scores)| NamedOutput { name, symbol, scores }).collect();
        map.serialize_entry("outputs", &outputs)?;
        map.end()
    }
}

fn of_output<M: SerializeMap>(map: &mut M, symbol: &str, s: &Scores) -> Result<(), M::Error> {
    map.serialize_entry(&key_in("offset", symbol), &s.offset)?;
    map.serialize_entry(&key_in("rmse", symbol), &s.rmse)?;
    map.serialize_entry(&key_in("max_abs_error", symbol), &s.max_abs_error)?;
    map.serialize_entry("rmse_percent_of_stroke", &s.rmse_percent_of_stroke)?;
    map.serialize_entry("max_percent_of_stroke", &s.max_percent_of_stroke)?;
    map.serialize_entry("fit_percent", &s.fit_percent)
}

/// One of several outputs.
struct NamedOutput<'a> {
    name: &'a str,
    symbol: &'a str,
    scores: &'a Scores,
}

impl Serialize for NamedOutput<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("output", self.name)?;
        of_output(&mut map, self.symbol, self.scores)?;
        map.end()
    }
}

/// A start with an estimated memory, in the model's units.
#[derive(serde::Serialize)]
struct RememberingStart {
    kind: &'static str,
    voltage: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    z: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    virgin_at: Option<f64>,
}

impl RememberingStart {
    fn new(voltage: f64, memory: Memory) -> Self {
        let (z, virgin_at) = match memory {
            Memory::Displacement(z) => (Some(z), None),
            Memory::VirginAt(voltage) => (None, Some(voltage)),
        };
        Self { kind: "remembering", voltage, z, virgin_at }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::record::TimeBase;
    use crate::validate::{Scoring, score};

    fn scored(unit: &str, start: Start) -> Score {
        let (u, y) = (vec![0.0, 1.0, 2.0, 1.0, 0.0], vec![0.0, 2.0, 5.0, 3.0, 0.5]);
        let simulated = vec![0.0, 2.1, 4.8, 3.0, 0.5];
        let data = InputOutput::new("r", TimeBase::uniform(10.0), u, y).unwrap();
        let scores = score(&data, &simulated, &Scoring::default()).unwrap();
        Score::of_single(
            &data,
            Unit::new(unit),
            scores,
            Simulation::of_single(simulated, start, Unit::new("V")),
        )
    }

    #[test]
    fn keys_end_in_the_unit_of_the_output_and_a_unit_other_than_micrometres_is_named() {
        let found = scored("um", Start::AsIdentified);
        let json = serde_json::to_value(&found).unwrap();
        assert_eq!(json["rmse_um"], found.rmse);
        assert_eq!(json["samples"], 5);
        assert!(
            json.get("unit").is_none() && json.get("start").is_none() && json.get("outputs").is_none(),
            "{json}"
        );
        let json = serde_json::to_value(scored("urad", Start::AsIdentified)).unwrap();
        assert_eq!(json["unit"], "urad");
        assert!(json["max_abs_error_urad"].is_f64(), "{json}");
    }

    #[test]
    fn an_estimated_memory_is_told_with_its_voltage() {
        let memory = Memory::Displacement(0.25);
        let json = serde_json::to_value(scored("um", Start::Remembering { voltage_v: 3.0, memory })).unwrap();
        assert_eq!(json["start"], serde_json::json!({"kind": "remembering", "voltage": 3.0, "z": 0.25}));
    }

    #[test]
    fn several_outputs_are_pooled_and_each_of_them_is_told() {
        let one = scored("um", Start::AsIdentified);
        let outputs = vec![one.outputs[0].clone(), one.outputs[0].clone()];
        let axes =
            AxesScore { outputs: vec!["y1".into(), "y2".into()], level: Some(0.5), mean_period_rmse: None };
        let json = serde_json::to_value(Score { outputs, axes: Some(axes), ..one }).unwrap();
        assert_eq!(json["level"], 0.5);
        assert_eq!(json["outputs"][1]["output"], "y2");
        assert_eq!(json["outputs"][1]["rmse_um"], json["rmse_um"]);
    }
}
