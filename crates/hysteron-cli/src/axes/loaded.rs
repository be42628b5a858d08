//! The file of a model of several axes read for use with records.

use std::path::{Path, PathBuf};

use hysteron_model::axes::{
    AxesRecord, AxesScores, CoupledHammerstein, LevelLaw, ModesStart, ScheduledModes, SteadyPeriod,
};
use hysteron_model::model_file::ModelFileError;
use hysteron_model::model_file::{SignalUnits, StoredModel};
use hysteron_model::record::{InterSample, Unit};
use hysteron_model::validate::Scoring;
use hysteron_numeric::display::short;

use super::AxesScored;
use crate::console;
use crate::failure::Failure;
use crate::model::cannot_read;

/// A level beyond those identified by this share deserves a remark.
const LEVEL_SLACK: f64 = 0.02;

/// A file of a model of several axes and what is in it.
pub struct LoadedAxes {
    path: PathBuf,
    /// Columns of the inputs.
    pub inputs: Vec<String>,
    /// Columns of the outputs.
    pub outputs: Vec<String>,
    /// Their units.
    pub units: SignalUnits,
    model: AxesModel,
}

enum AxesModel {
    Modes(Box<ScheduledModes>),
    Branches(CoupledHammerstein),
}

impl LoadedAxes {
    /// The model in the file at `path`; `None` where it holds another kind.
    ///
    /// # Errors
    /// If it cannot be read or is not sound.
    pub fn recognise(path: &Path) -> Result<Option<Self>, Failure> {
        let stored =
            hysteron_io::read_model_file(path, StoredModel::from_slice).map_err(|e| cannot_read(path, e))?;
        let bad = |e: ModelFileError| cannot_read(path, e);
        let (model, inputs, outputs, units) = match stored {
            StoredModel::Modes(file) => (
                AxesModel::Modes(Box::new(file.to_model().map_err(bad)?)),
                file.inputs,
                file.outputs,
                file.units,
            ),
            StoredModel::Coupled(file) => {
                (AxesModel::Branches(file.to_model().map_err(bad)?), file.inputs, file.outputs, file.units)
            }
            StoredModel::Hammerstein(_) | StoredModel::Oscillator(_) => return Ok(None),
        };
        Ok(Some(Self { path: path.to_owned(), inputs, outputs, units, model }))
    }

    /// Outputs simulated for the record, one list an output, and its period where it repeats.
    ///
    /// A drive that repeats is in its steady state, on `settled_s` where that is given; another one starts at rest.
    ///
    /// # Errors
    /// If units, channels or sample rate do not match, or the motion cannot be simulated.
    pub fn simulate(
        &self,
        path: &Path,
        record: &AxesRecord,
        settled_s: Option<f64>,
    ) -> Result<(Vec<Vec<f64>>, Option<SteadyPeriod>), Failure> {
        let failure =
            || Failure::new(format!("cannot simulate {} on {}", self.path.display(), path.display()));
        self.check_unit(path, "input", "--inputs", &self.units.input, &record.u_unit)?;
        if !record.y.is_empty() {
            self.check_unit(path, "output", "--outputs", &self.units.output, &record.y_unit)?;
        }
        let period = match settled_s {
            Some(seconds) => {
                let samples = (seconds * record.sample_rate_hz).round() as usize;
                let whole = record.len() / samples.max(1);
                Some(SteadyPeriod::mean(record, samples, 0, whole.max(1)).map_err(|e| failure().because(e))?)
            }
            None => SteadyPeriod::find(record, false).ok(),
        };
        let simulated = match &self.model {
            AxesModel::Modes(model) => {
                let start = match &period {
                    Some(period) => {
                        self.remark_level(&model.level, path, period.level);
                        ModesStart::Settled { period_samples: period.samples() }
                    }
                    None => {
                        console::note(&format!(
                            "{}: this drive does not repeat and is taken to start at rest, its inputs held before (--settled says \
                             otherwise)",
                            path.display()
                        ));
                        ModesStart::Rest { level: None }
                    }
                };
                model.simulate(&record.u, record.sample_rate_hz, InterSample::BandLimited, start)
            }
            AxesModel::Branches(model) => {
                // A drive whose outputs still settle began at rest.
                let settled = period.as_ref().filter(|p| settled_s.is_some() || p.settling == 0);
                model.simulate(&record.u, record.sample_rate_hz, settled.map(SteadyPeriod::samples))
            }
        };
        let simulated = simulated.map_err(|e| failure().because(e))?;
        Ok((simulated, period))
    }

    /// The record's scores under the model.
    ///
    /// # Errors
    /// As [`Self::simulate`], and if it cannot be scored.
    pub fn score(
        &self,
        path: &Path,
        record: &AxesRecord,
        scoring: &Scoring,
        settled_s: Option<f64>,
    ) -> Result<AxesScored, Failure> {
        let (simulated, period) = self.simulate(path, record, settled_s)?;
        let scores = AxesScores::new(record, &simulated, scoring, period.as_ref())
            .map_err(|e| Failure::new(format!("cannot score {}", path.display())).because(e))?;
        Ok(AxesScored::new(record, scores, period.map(|p| p.level)))
    }

    fn remark_level(&self, law: &LevelLaw, path: &Path, level: f64) {
        if level < (1.0 - LEVEL_SLACK) * law.lowest || level > (1.0 + LEVEL_SLACK) * law.highest {
            console::note(&format!(
                "{}: the inputs have {} {unit} rms, the model was identified from {} to {} {unit}: it extrapolates, with the modes of the \
                 nearest level",
                path.display(),
                short(level),
                short(law.lowest),
                short(law.highest),
                unit = Unit::new(&self.units.input),
            ));
        }
    }

    fn check_unit(
        &self,
        path: &Path,
        role: &str,
        flag: &str,
        own: &str,
        found: &Unit,
    ) -> Result<(), Failure> {
        let own = Unit::new(own);
        if own == *found || own.symbol().is_empty() || found.symbol().is_empty() {
            return Ok(());
        }
        Err(Failure::new(format!("cannot run {} on {}", self.path.display(), path.display()))
            .because(format!("the model's {role}s are in {own}, the record's in {found}"))
            .hint(format!("choose the columns with {flag}, or correct the units in their headers")))
    }
}
