//! Scores of a model on a record, as numbers and as data whose keys name the units.

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::{CorrectionScore, Signals, Simulation, Verdict};
use crate::Finding;
use crate::record::{Channel, InputOutput, Keyed, Record, RecordError, Unit};
use crate::start::Memory;
use crate::start::Start;
use crate::validate::Scores;

/// Scores of a model on a record.
///
/// As JSON, quantities in the unit of the outputs have keys that end in it (`rmse_um`), and `unit` names it
/// where it is not µm; `start` is there where a hysteresis memory was estimated, with the score from the
/// model file's own start in `without_estimated_start`; `left_out` and `without_correction` (the score of the
/// model alone) of a corrected one; `verdict` where the file holds scores of its training. Several outputs:
/// the figures are pooled over them, then `outputs` has each of them.
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
    /// Further figures of a record of several axes.
    pub axes: Option<AxesScore>,
    /// Coverage of the record by the 95 % band of a new measurement, where it was requested.
    pub band: Option<BandScore>,
    /// What a correction by the predicted misfit gained, where it was requested.
    pub correction: Option<CorrectionScore>,
    /// Scores from the start that the model file assumes, where a hysteresis memory was estimated from the
    /// record.
    pub without_estimated_start: Option<Box<Scores>>,
    /// Verdict on device and range, where the model file holds the scores of its training.
    pub verdict: Option<Verdict>,
    /// The simulation that was scored.
    pub simulation: Simulation,
}

/// Scores of a model on a run of several records, simulated in one pass from the start of the first, with one
/// offset.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunScore {
    /// Each part of the run, with the offset of the whole.
    pub records: Vec<Score>,
    /// The whole run.
    pub whole: Score,
    /// The whole run from the start that the model file assumes, without the memory estimated from the first
    /// record; `None` where that is the same.
    pub whole_without_estimated_start: Option<Score>,
}

/// Scores that only a record of several axes has.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxesScore {
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// rms of the inputs about their means, where the drive repeats.
    pub level: Option<f64>,
    /// RMSE of the mean period, means removed, where the drive repeats.
    pub mean_period_rmse: Option<f64>,
}

/// Coverage of a record by the 95 % band of a new measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandScore {
    /// Share of the scored samples within the band \[%\].
    pub inside_percent: f64,
    /// Its largest half-width, in the unit of the output.
    pub measurement: f64,
    /// Largest half-width of the band of the model's output.
    pub model: f64,
    /// What the band rests on, where that is not the training records alone.
    pub findings: Vec<Finding>,
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
            correction: None,
            without_estimated_start: None,
            verdict: None,
            simulation,
        }
    }

    /// Every sample of a scored record: drive, measured output `y`, the model's `y_model` with the offset,
    /// `residual` y − y_model. Samples that are not valid are marked.
    ///
    /// # Errors
    /// [`RecordError`] where the record is not that of the score.
    pub fn series(&self, signals: &Signals) -> Result<Record, RecordError> {
        let mut channels = Vec::new();
        let (drives, outputs, valid): (Vec<_>, Vec<_>, _) = match signals {
            Signals::Single(record) => {
                (vec![("u", &record.u)], vec![(String::new(), &record.y)], record.valid.clone())
            }
            Signals::Several(record) => {
                let names =
                    |names: &[String]| names.iter().map(|name| format!("_{name}")).collect::<Vec<_>>();
                let inputs = record.inputs.iter().map(String::as_str).zip(&record.u).collect();
                (inputs, names(&record.outputs).into_iter().zip(&record.y).collect(), None)
            }
        };
        let input_unit = self.simulation.input_unit.symbol();
        channels.extend(drives.into_iter().map(|(name, u)| Channel::new(name, input_unit, u.clone())));
        for (((name, y), model), scores) in
            outputs.into_iter().zip(&self.simulation.outputs).zip(&self.outputs)
        {
            let model: Vec<f64> = model.iter().map(|y| y + scores.offset).collect();
            let residual = y.iter().zip(&model).map(|(y, model)| y - model).collect();
            for (what, samples) in [("y", y.clone()), ("y_model", model), ("residual", residual)] {
                channels.push(Channel::new(&format!("{what}{name}"), self.unit.symbol(), samples));
            }
        }
        let series = Record { valid, ..Record::new(&self.record, signals.time().clone(), channels)? };
        series.check()?;
        Ok(series)
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
        self.summary().serialize(serializer)
    }
}

/// A [`Score`] without the simulation: its JSON, to be written and read back.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreSummary {
    /// Name of the record: the path of its file, where it has one.
    pub record: String,
    /// Samples that were scored.
    pub samples: usize,
    /// Samples that were not.
    pub skipped_samples: usize,
    /// Symbol of the unit of the outputs.
    pub unit: String,
    /// Errors, of one output or pooled over several.
    pub errors: ErrorSummary,
    /// Band of a new measurement, where it was requested.
    pub band: Option<BandScore>,
    /// Share of the error that a correction leaves on left-out parts of the training records, and the errors
    /// of the model alone, where it was requested.
    pub correction: Option<(f64, ErrorSummary)>,
    /// Start with an estimated memory.
    pub start: Option<RememberingStart>,
    /// Errors from the start that the model file assumes, where a memory was estimated from the record.
    pub without_estimated_start: Option<ErrorSummary>,
    /// Verdict on device and range.
    pub verdict: Option<Verdict>,
    /// Further figures of a record of several axes, with the errors of each output.
    pub axes: Option<(AxesScore, Vec<ErrorSummary>)>,
}

/// Errors of one output or of several together, in the unit of the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorSummary {
    /// Constant added to the simulation; `None` for several outputs together.
    pub offset: Option<f64>,
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
}

impl From<&Scores> for ErrorSummary {
    fn from(s: &Scores) -> Self {
        Self {
            offset: Some(s.offset),
            rmse: s.rmse,
            max_abs_error: s.max_abs_error,
            rmse_percent_of_stroke: s.rmse_percent_of_stroke,
            max_percent_of_stroke: s.max_percent_of_stroke,
            fit_percent: s.fit_percent,
        }
    }
}

impl Score {
    /// Everything but the simulation.
    pub fn summary(&self) -> ScoreSummary {
        let first = self.outputs.first();
        let pooled = ErrorSummary {
            offset: None,
            rmse: self.rmse,
            max_abs_error: self.max_abs_error,
            rmse_percent_of_stroke: None,
            max_percent_of_stroke: None,
            fit_percent: self.fit_percent,
        };
        let single = first.filter(|_| self.axes.is_none());
        ScoreSummary {
            record: self.record.clone(),
            samples: first.map_or(0, |s| s.samples),
            skipped_samples: first.map_or(0, |s| s.skipped_samples),
            unit: self.unit.symbol().to_owned(),
            errors: single.map_or(pooled, ErrorSummary::from),
            band: self.band.clone(),
            correction: self
                .correction
                .as_ref()
                .map(|correction| (correction.left_out, ErrorSummary::from(&*correction.without))),
            start: self.estimated_memory().map(|(voltage, memory)| RememberingStart::new(voltage, memory)),
            without_estimated_start: self.without_estimated_start.as_deref().map(ErrorSummary::from),
            verdict: self.verdict.clone(),
            axes: self.axes.clone().map(|axes| (axes, self.outputs.iter().map(ErrorSummary::from).collect())),
        }
    }
}

impl ErrorSummary {
    fn told(&self, keyed: Keyed, unit: &str) -> Keyed {
        keyed
            .in_unit("offset", unit, self.offset)
            .in_unit("rmse", unit, self.rmse)
            .in_unit("max_abs_error", unit, self.max_abs_error)
            .with("rmse_percent_of_stroke", self.rmse_percent_of_stroke)
            .with("max_percent_of_stroke", self.max_percent_of_stroke)
            .with("fit_percent", self.fit_percent)
    }

    fn read<E: Error>(keyed: &Keyed, unit: &str) -> Result<Self, E> {
        Ok(Self {
            offset: keyed.get_in_unit("offset", unit)?,
            rmse: keyed.get_in_unit("rmse", unit)?,
            max_abs_error: keyed.get_in_unit("max_abs_error", unit)?,
            rmse_percent_of_stroke: keyed.get("rmse_percent_of_stroke")?,
            max_percent_of_stroke: keyed.get("max_percent_of_stroke")?,
            fit_percent: keyed.get("fit_percent")?,
        })
    }
}

impl Serialize for ScoreSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let unit = self.unit.as_str();
        let mut told = Keyed::default()
            .with("record", &self.record)
            .with("samples", self.samples)
            .with("skipped_samples", self.skipped_samples);
        if unit != "um" {
            told = told.with("unit", unit);
        }
        let Some((axes, outputs)) = &self.axes else {
            told = self.errors.told(told, unit);
            if let Some(band) = &self.band {
                told = told
                    .with("within_band_percent", band.inside_percent)
                    .in_unit("band_of_measurement", unit, band.measurement)
                    .in_unit("band_of_model", unit, band.model);
                if !band.findings.is_empty() {
                    told = told.with("band_findings", &band.findings);
                }
            }
            if let Some((left_out, without)) = &self.correction {
                told = told
                    .with("left_out", left_out)
                    .with("without_correction", without.told(Keyed::default(), unit));
            }
            if let Some(start) = &self.start {
                told = told.with("start", start);
            }
            if let Some(without) = self.without_estimated_start {
                told = told.with("without_estimated_start", without.told(Keyed::default(), unit));
            }
            if let Some(verdict) = &self.verdict {
                told = told.with("verdict", verdict);
            }
            return told.serialize(serializer);
        };
        let named = axes.outputs.iter().zip(outputs);
        let outputs: Vec<Keyed> =
            named.map(|(name, errors)| errors.told(Keyed::default().with("output", name), unit)).collect();
        told.with("level", axes.level)
            .in_unit("rmse", unit, self.errors.rmse)
            .in_unit("rmse_mean_period", unit, axes.mean_period_rmse)
            .in_unit("max_abs_error", unit, self.errors.max_abs_error)
            .with("fit_percent", self.errors.fit_percent)
            .with("outputs", outputs)
            .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ScoreSummary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keyed = Keyed::deserialize(deserializer)?;
        let unit: String = keyed.get::<Option<String>, _>("unit")?.unwrap_or_else(|| "um".to_owned());
        let inside: Option<f64> = keyed.get("within_band_percent")?;
        let band = inside.map(|inside_percent| {
            let measurement = keyed.get_in_unit("band_of_measurement", &unit)?;
            let findings = keyed.get::<Option<_>, _>("band_findings")?.unwrap_or_default();
            let model = keyed.get_in_unit("band_of_model", &unit)?;
            Ok(BandScore { inside_percent, measurement, model, findings })
        });
        let correction = keyed
            .get::<Option<Keyed>, _>("without_correction")?
            .map(|without| Ok((keyed.get("left_out")?, ErrorSummary::read(&without, &unit)?)));
        let without = keyed.get::<Option<Keyed>, _>("without_estimated_start")?;
        let without = without.map(|errors| ErrorSummary::read(&errors, &unit));
        let axes = keyed.get::<Option<Vec<Keyed>>, _>("outputs")?.map(|outputs| {
            let names = outputs.iter().map(|output| output.get("output"));
            let axes = AxesScore {
                outputs: names.collect::<Result<_, _>>()?,
                level: keyed.get("level")?,
                mean_period_rmse: keyed.get_in_unit("rmse_mean_period", &unit)?,
            };
            let errors = outputs.iter().map(|output| ErrorSummary::read(output, &unit));
            Ok((axes, errors.collect::<Result<_, _>>()?))
        });
        Ok(Self {
            record: keyed.get("record")?,
            samples: keyed.get("samples")?,
            skipped_samples: keyed.get("skipped_samples")?,
            errors: ErrorSummary::read(&keyed, &unit)?,
            band: band.transpose()?,
            correction: correction.transpose()?,
            start: keyed.get("start")?,
            without_estimated_start: without.transpose()?,
            verdict: keyed.get("verdict")?,
            axes: axes.transpose()?,
            unit,
        })
    }
}

/// A start with an estimated memory, in the model's units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RememberingStart {
    /// `remembering`.
    pub kind: String,
    /// Input before the first sample.
    pub voltage: f64,
    /// Hysteretic displacement there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Input at which the device was virgin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub virgin_at: Option<f64>,
}

impl RememberingStart {
    fn new(voltage: f64, memory: Memory) -> Self {
        let (z, virgin_at) = match memory {
            Memory::Displacement(z) => (Some(z), None),
            Memory::VirginAt(voltage) => (None, Some(voltage)),
        };
        Self { kind: "remembering".to_owned(), voltage, z, virgin_at }
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

    /// Read back and written again, the JSON of a score is the same.
    fn comes_back(score: &Score) {
        let text = serde_json::to_string(score).unwrap();
        let read: ScoreSummary = serde_json::from_str(&text).unwrap();
        assert_eq!(read, score.summary());
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
    }

    #[test]
    fn the_summary_of_a_score_comes_back() {
        let memory = Memory::VirginAt(-1.5);
        comes_back(&scored("urad", Start::Remembering { voltage_v: 3.0, memory }));
        let one = scored("um", Start::AsIdentified);
        let band = BandScore { inside_percent: 94.5, measurement: 0.1, model: 0.05, findings: Vec::new() };
        comes_back(&Score { band: Some(band.clone()), ..one.clone() });
        let findings = vec![Finding::new(crate::FindingKind::Advice, "band", "A sweep would change that.")];
        let band = BandScore { findings, ..band };
        comes_back(&Score { band: Some(band), ..one.clone() });
        let without = Box::new(one.outputs[0].clone());
        let correction = Some(CorrectionScore { left_out: 0.3, without });
        comes_back(&Score { correction, ..one.clone() });
        let axes = AxesScore { outputs: vec!["y".into()], level: None, mean_period_rmse: Some(0.25) };
        comes_back(&Score { axes: Some(axes), ..one });
        let missing = serde_json::from_str::<ScoreSummary>(r#"{"record":"r"}"#).unwrap_err().to_string();
        assert!(missing.contains("rmse_um") || missing.contains("samples"), "{missing}");
    }

    #[test]
    fn an_estimated_memory_is_told_with_its_voltage() {
        let memory = Memory::Displacement(0.25);
        let json = serde_json::to_value(scored("um", Start::Remembering { voltage_v: 3.0, memory })).unwrap();
        assert_eq!(json["start"], serde_json::json!({"kind": "remembering", "voltage": 3.0, "z": 0.25}));
    }

    #[test]
    fn the_series_is_what_was_scored() {
        let score = scored("urad", Start::AsIdentified);
        let (u, y) = (vec![0.0, 1.0, 2.0, 1.0, 0.0], vec![0.0, 2.0, 5.0, 3.0, 0.5]);
        let data = InputOutput::new("r", TimeBase::uniform(10.0), u, y).unwrap();
        let series = score.series(&Signals::Single(data)).unwrap();
        let residual = &series.channel("residual").unwrap().samples;
        let rmse = (residual.iter().map(|r| r * r).sum::<f64>() / residual.len() as f64).sqrt();
        assert!((rmse - score.rmse).abs() < 1e-15, "{rmse} {}", score.rmse);
        assert_eq!(series.channel("y_model").unwrap().unit.symbol(), "urad");
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
