//! A model of any kind: loaded, simulated, scored, recalibrated.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use hysteron_identify::PredictionBand;
use hysteron_identify::online::{FollowMethod, FollowOptions, Followed, Term, known_noise};
use hysteron_identify::recalibrate::{Prior, Recording, recalibrate};
use hysteron_io::{load_model, save_model, sha256};
use hysteron_model::axes::AxesRecord;
use hysteron_model::model::{Capability, Remark, RunError, Score, SignalRole, Signals};
use hysteron_model::model_file::{Maker, timestamp};
use hysteron_model::record::{ChannelChoice, Driven, InputOutput, MeasurementRun, Source};
use hysteron_model::validate::{Scoring, residual_whiteness, scored_samples};
use hysteron_model::{Model as Core, Start};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::{from_json, option, raised, to_json};
use crate::record::{Record, single};
use crate::signals::Samples;
use crate::work;

/// An identified model.
#[pyclass(frozen, module = "hysteron_models._native")]
pub struct Model {
    inner: Core,
    /// Path of the file that it came from.
    path: Option<PathBuf>,
}

impl From<Core> for Model {
    fn from(inner: Core) -> Self {
        Self { inner, path: None }
    }
}

/// This package, now.
pub fn maker() -> Maker {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    Maker {
        program: concat!("hysteron_models ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: Some(timestamp(seconds)),
        command: None,
    }
}

impl Model {
    pub fn core(&self) -> &Core {
        &self.inner
    }

    /// The channels of a record that the model takes, outputs too where they were measured.
    fn signals(&self, record: &Record, input: Option<&str>) -> PyResult<Signals> {
        let Record { inner: core, .. } = record;
        let Some((inputs, outputs)) = self.inner.channels() else {
            let driven = core.driven(input).map_err(raised)?;
            let own = |measured: &InputOutput| {
                let unit = &measured.y_unit;
                self.inner.agreed_unit(SignalRole::Output, unit, &mut Vec::new()).is_ok()
            };
            let measured = driven.measured.filter(own);
            return match Signals::from(Driven { drive: driven.drive, measured }) {
                Signals::Single(data) => Ok(record.rated(data)?.into()),
                several => Ok(several),
            };
        };
        let axes = AxesRecord::new(core, inputs, outputs).or_else(|_| AxesRecord::new(core, inputs, &[]));
        Ok(axes.map_err(raised)?.into())
    }

    /// Input and output of a record, in units that agree with the model's.
    fn in_agreed_units(&self, record: &Record, choice: &ChannelChoice) -> PyResult<InputOutput> {
        let mut data = record.inner.input_output(choice).map_err(raised)?;
        let told = &mut Vec::new();
        self.inner.agreed_unit(SignalRole::Input, &data.u_unit, told).map_err(raised)?;
        data.y_unit = self.inner.agreed_unit(SignalRole::Output, &data.y_unit, told).map_err(raised)?;
        Ok(data)
    }

    fn scored(&self, record: &Record, choice: &ChannelChoice) -> PyResult<Signals> {
        let Record { inner: core, .. } = record;
        Ok(match self.inner.channels() {
            Some((inputs, outputs)) => AxesRecord::new(core, inputs, outputs).map_err(raised)?.into(),
            None => record.rated(core.input_output(choice).map_err(raised)?)?.into(),
        })
    }
}

/// Start from JSON, `None`: as the model was identified.
fn start(json: Option<&str>) -> PyResult<Start> {
    json.map_or(Ok(Start::AsIdentified), from_json)
}

/// Outputs of a simulation: an array each, half the widths of its bands, the start in words, and remarks.
type Simulated<'py> = (Vec<Samples<'py>>, Option<HalfWidths<'py>>, String, Vec<(String, Option<String>)>);

/// Half the width of the band of a measurement and of that of the model's output, at each sample, and what the
/// first rests on, where that is not the training records alone.
type HalfWidths<'py> = (Samples<'py>, Samples<'py>, Vec<String>);

/// Unit, RMSE, largest error, fit in %, samples, and the offset of each output.
pub type Figures = (String, f64, f64, Option<f64>, usize, Vec<f64>);

/// Figures of a score.
pub fn figures(score: &Score) -> Figures {
    let unit = score.unit.symbol().to_owned();
    let samples = score.outputs.first().map_or(0, |output| output.samples);
    let offsets = score.outputs.iter().map(|output| output.offset).collect();
    (unit, score.rmse, score.max_abs_error, score.fit_percent, samples, offsets)
}

/// A score: its JSON, figures, the start in words, and the record of its samples.
type Scored = (String, Figures, String, Record);

#[pymethods]
impl Model {
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let inner = work::run(py, || load_model(&path))?.map_err(raised)?;
        Ok(Self { inner, path: Some(path) })
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, || save_model(&path, &self.inner))?.map_err(raised)
    }

    /// Reads the text of a model file.
    #[staticmethod]
    fn from_json(json: &str) -> PyResult<Self> {
        Ok(Core::from_json(json.as_bytes()).map_err(raised)?.into())
    }

    /// Text of the model file.
    fn to_json(&self) -> PyResult<String> {
        self.inner.to_json().map_err(raised)
    }

    #[getter]
    fn kind(&self) -> &'static str {
        self.inner.kind().name()
    }

    #[getter]
    fn name(&self) -> Option<&str> {
        self.inner.name()
    }

    /// Units of input and output.
    #[getter]
    fn units(&self) -> (String, String) {
        let units = self.inner.units();
        (units.input.clone(), units.output.clone())
    }

    /// Names of inputs and outputs of a model of several axes.
    #[getter]
    fn channels(&self) -> Option<(Vec<String>, Vec<String>)> {
        self.inner.channels().map(|(inputs, outputs)| (inputs.to_vec(), outputs.to_vec()))
    }

    #[getter]
    fn sample_rate_hz(&self) -> Option<f64> {
        self.inner.sample_rate_hz()
    }

    /// Range that the records of the identification covered, in words.
    #[getter]
    fn valid_range(&self) -> Option<String> {
        self.inner.valid_range().map(|range| range.in_words())
    }

    /// Least and largest drive of the identification.
    #[getter]
    fn drive_range(&self) -> Option<(f64, f64)> {
        let body = self.inner.hammerstein(Capability::Inversion).ok()?;
        body.drive_range().map(|[low, high]| (low, high))
    }

    /// The output for the drive of a record, in free run.
    #[pyo3(signature = (record, input=None, from_start=None, band=None, correct=false))]
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        record: &Record,
        input: Option<String>,
        from_start: Option<&str>,
        band: Option<f64>,
        correct: bool,
    ) -> PyResult<Simulated<'py>> {
        let signals = self.signals(record, input.as_deref())?;
        let from = start(from_start)?;
        let simulated = || match correct {
            true => self.inner.simulate_corrected(&signals, from),
            false => self.inner.simulate(&signals, from),
        };
        let found = work::run(py, simulated)?.map_err(raised)?;
        let band = band.map(|level| self.band(py, (&signals, &found.start), level, correct)).transpose()?;
        let outputs = found.outputs.iter().map(|y| PyArray1::from_slice(py, y)).collect();
        Ok((outputs, band, self.in_words(&found.start), self.remarks(&found.remarks)?))
    }

    /// Score on a record, from the start that fits it best unless one is given.
    #[pyo3(signature = (record, scoring, input=None, output=None, from_start=None, correct=false))]
    #[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
    fn score(
        &self,
        py: Python<'_>,
        record: &Record,
        scoring: &str,
        input: Option<String>,
        output: Option<String>,
        from_start: Option<&str>,
        correct: bool,
    ) -> PyResult<Scored> {
        let scoring: Scoring = from_json(scoring)?;
        let signals = self.scored(record, &ChannelChoice { input, output })?;
        let from = start(from_start)?;
        let score = work::run(py, || self.scored_from(&signals, from, &scoring, correct))?.map_err(raised)?;
        Ok((
            to_json(&score)?,
            figures(&score),
            self.in_words(&score.simulation.start),
            score.series(&signals).map_err(raised)?.into(),
        ))
    }

    /// Prediction of the measurement from the start of [`Self::score`]: the output with its offset, the band
    /// and the start in words.
    #[pyo3(signature = (record, input=None, output=None, from_start=None, band=None, correct=false))]
    #[allow(clippy::too_many_arguments, reason = "keywords of a call from Python")]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        record: &Record,
        input: Option<String>,
        output: Option<String>,
        from_start: Option<&str>,
        band: Option<f64>,
        correct: bool,
    ) -> PyResult<(Simulated<'py>, Vec<f64>, Option<Samples<'py>>)> {
        let signals = self.scored(record, &ChannelChoice { input, output })?;
        let from = start(from_start)?;
        let scoring = Scoring::default();
        let score = work::run(py, || self.scored_from(&signals, from, &scoring, correct))?.map_err(raised)?;
        let offsets: Vec<f64> = score.outputs.iter().map(|output| output.offset).collect();
        let found = &score.simulation;
        let with_offset = found.outputs.iter().zip(&offsets);
        let outputs = with_offset.map(|(y, offset)| PyArray1::from_iter(py, y.iter().map(|y| y + offset)));
        let band = band.map(|level| self.band(py, (&signals, &found.start), level, correct)).transpose()?;
        let words = self.in_words(&found.start);
        let measured = match &signals {
            Signals::Single(record) => Some(PyArray1::from_slice(py, &record.y)),
            Signals::Several(_) => None,
        };
        Ok(((outputs.collect(), band, words, self.remarks(&found.remarks)?), offsets, measured))
    }

    /// Scores on consecutive records of one run, as JSON, with the samples of each run.
    #[pyo3(signature = (records, scoring, input=None, output=None, from_start=None))]
    fn score_continued(
        &self,
        py: Python<'_>,
        records: Vec<PyRef<'_, Record>>,
        scoring: &str,
        input: Option<String>,
        output: Option<String>,
        from_start: Option<&str>,
    ) -> PyResult<Vec<Scored>> {
        self.inner.hammerstein(Capability::Runs).map_err(raised)?;
        let scoring: Scoring = from_json(scoring)?;
        let from = start(from_start)?;
        let data = single(&records, &ChannelChoice { input, output })?;
        let runs = MeasurementRun::of(&data).map_err(raised)?;
        let score = |run: MeasurementRun| {
            let score = work::run(py, || self.inner.score_run(&run, from, &scoring))?;
            let score = score.map_err(raised)?;
            let (json, whole) = (to_json(&score)?, &score.whole);
            let series = whole.series(&Signals::Single(run.data)).map_err(raised)?;
            Ok((json, figures(whole), self.in_words(&whole.simulation.start), series.into()))
        };
        runs.into_iter().map(score).collect()
    }

    /// Adapts the model over a record, sample by sample: the result as JSON, and the new model where a model
    /// file can hold its terms.
    #[pyo3(signature = (record, options, input=None, output=None))]
    fn adapt(
        &self,
        py: Python<'_>,
        record: &Record,
        options: &str,
        input: Option<String>,
        output: Option<String>,
    ) -> PyResult<(String, Option<Self>)> {
        let asked: Adapting = from_json(options)?;
        let body = self.inner.hammerstein(Capability::Adaptation).map_err(raised)?;
        let data = self.in_agreed_units(record, &ChannelChoice { input, output })?;
        let unknown = "the size of a residual where the model fits is not known: give it with noise=…";
        let noise = asked.noise.or_else(|| known_noise(body.data(), &data)).ok_or_else(|| option(unknown))?;
        let terms = asked.terms.iter().map(|term| term.parse::<Term>()).collect::<Result<_, _>>();
        let options = FollowOptions {
            method: asked.method,
            terms: terms.map_err(option)?,
            noise,
            every: asked.every,
            run_length: asked.run_length,
            reopen: asked.reopen,
        };
        let found = work::run(py, || {
            let signals = data.clone().into();
            let score = self.inner.score(&signals, Start::AsIdentified, &Scoring::default())?;
            let start = score.simulation.start;
            Ok::<_, hysteron::Error>(Followed::over(&data, body.law(), &start, &options)?)
        })?;
        let found = found.map_err(raised)?;
        let holds = !options.terms.iter().any(|term| matches!(term, Term::Creep { .. }));
        let source = self.source()?;
        let file = holds.then(|| found.model_file(&data, &options, (body.data(), &source), &maker()).ok());
        let model = file.flatten().map(|file| Core::try_from(file).map_err(raised)).transpose()?;
        Ok((to_json(&found.summary(&data, &options))?, model.map(Self::from)))
    }

    /// Re-identifies gain, delay and offset from short records, the rest held: the new model, and the result
    /// as JSON.
    #[pyo3(signature = (records, input=None, output=None, continued=false, least_fit_percent=75.0))]
    fn recalibrate(
        &self,
        py: Python<'_>,
        records: Vec<PyRef<'_, Record>>,
        input: Option<String>,
        output: Option<String>,
        continued: bool,
        least_fit_percent: f64,
    ) -> PyResult<(Self, String)> {
        let body = self.inner.hammerstein(Capability::Recalibration).map_err(raised)?;
        let choice = ChannelChoice { input, output };
        let data = records.iter().map(|record| self.in_agreed_units(record, &choice));
        let data = data.collect::<PyResult<Vec<_>>>()?;
        let recordings = Recording::of(&self.inner, data, continued, &mut Vec::new()).map_err(raised)?;
        let prior = Prior::of(body.data());
        let found = work::run(py, || recalibrate(body.law(), prior, &recordings, least_fit_percent))?;
        let found = found.map_err(raised)?;
        let file = found.model_file(body.data(), &self.source()?, prior, &maker());
        let summary = to_json(&found.summary(&file))?;
        let model = Core::try_from(file).map_err(raised)?;
        Ok((model.into(), summary))
    }
}

/// Autocorrelation of a residual at lags from the first on, and its 99 % bound; `None` for too short or zero
/// residuals.
#[pyfunction]
#[pyo3(signature = (series, skip_s=0.0))]
pub fn residual_correlation<'py>(
    py: Python<'py>,
    series: &Record,
    skip_s: f64,
) -> PyResult<Option<(i64, Samples<'py>, f64)>> {
    let choice = ChannelChoice { input: Some("u".to_owned()), output: Some("residual".to_owned()) };
    let data = series.inner.input_output(&choice).map_err(raised)?;
    let scored = scored_samples(&data, skip_s).map_err(hysteron_model::Error::from).map_err(raised)?;
    let found = residual_whiteness(&data.y, &scored);
    Ok(found.map(|c| (c.first_lag, PyArray1::from_vec(py, c.coefficients), c.bound)))
}

impl Model {
    /// The score, of the model alone or `correct`ed by its predicted misfit.
    fn scored_from(
        &self,
        signals: &Signals,
        from: Start,
        scoring: &Scoring,
        correct: bool,
    ) -> Result<Score, RunError> {
        match correct {
            true => self.inner.score_corrected(signals, from, scoring),
            false => self.inner.score(signals, from, scoring),
        }
    }

    fn band<'py>(
        &self,
        py: Python<'py>,
        (signals, start): (&Signals, &Start),
        level: f64,
        correct: bool,
    ) -> PyResult<HalfWidths<'py>> {
        let body = self.inner.hammerstein(Capability::Bands).map_err(raised)?;
        let Signals::Single(drive) = signals else {
            return Err(option("a band is of a model of one input and one output"));
        };
        let band = work::run(py, || PredictionBand::of_file(body.data(), &drive.u, &drive.time, start))?;
        let band = band.map_err(raised)?;
        let band = if correct { band.corrected() } else { band };
        let [measurement, model] = band.at_level(level).map_err(raised)?;
        let rests_on = band.findings.into_iter().map(|finding| finding.text).collect();
        Ok((PyArray1::from_vec(py, measurement), PyArray1::from_vec(py, model), rests_on))
    }

    /// Provenance of the model, for models derived from it.
    fn source(&self) -> PyResult<Source> {
        let path = self.path.as_deref().unwrap_or(Path::new("")).display().to_string();
        Ok(Source { path, sha256: sha256(self.to_json()?.as_bytes()) })
    }

    /// Remarks with their advice as JSON.
    fn remarks(&self, remarks: &[Remark]) -> PyResult<Vec<(String, Option<String>)>> {
        let told = |remark: &Remark| {
            let (text, advice) = remark.in_words(&self.inner);
            Ok((text, advice.as_ref().map(to_json).transpose()?))
        };
        remarks.iter().map(told).collect()
    }

    fn in_words(&self, start: &Start) -> String {
        let units = self.inner.units();
        start.in_words(&units.input, &units.output)
    }
}

/// Options of an adaptation over a record.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Adapting {
    method: FollowMethod,
    terms: Vec<String>,
    noise: Option<f64>,
    every: Option<usize>,
    run_length: f64,
    reopen: bool,
}
