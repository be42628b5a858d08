//! Records: read, made of arrays, written, prepared, inspected.

use std::path::PathBuf;

use hysteron::{ReadOptions, Rename};
use hysteron_identify::structure::prospects;
use hysteron_io::read_part;
use hysteron_model::force::with_rate;
use hysteron_model::hammerstein::SimulationError;
use hysteron_model::record::{Channel, ChannelChoice, Cut, DeadBand, InputOutput, Prepare, TimeBase, Turns};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::errors::{from_json, option, raised, to_json};
use crate::signals::samples;
use crate::work;

/// Named channels with units on a time base.
#[pyclass(frozen, module = "hysteron_models._native")]
pub struct Record {
    pub inner: hysteron::Record,
    /// Column of the measured rate of the input.
    rate: Option<String>,
}

impl From<hysteron::Record> for Record {
    fn from(inner: hysteron::Record) -> Self {
        Self { inner, rate: None }
    }
}

impl Record {
    /// The input and output, with the measured rate of the input where its column is named.
    pub fn rated(&self, data: InputOutput) -> PyResult<InputOutput> {
        match &self.rate {
            Some(column) => with_rate(data, &self.inner, column)
                .map_err(|e| raised(hysteron_model::Error::from(SimulationError::from(e)))),
            None => Ok(data),
        }
    }
}

#[pymethods]
impl Record {
    /// A record of channels `(name, unit, samples)` at a sample rate [Hz] from `start_s` on, at times [s], or
    /// without times.
    #[new]
    #[pyo3(signature = (name, channels, sample_rate_hz=None, start_s=0.0, times_s=None, valid=None))]
    fn new(
        name: &str,
        channels: Vec<(String, String, PyReadonlyArray1<'_, f64>)>,
        sample_rate_hz: Option<f64>,
        start_s: f64,
        times_s: Option<PyReadonlyArray1<'_, f64>>,
        valid: Option<PyReadonlyArray1<'_, bool>>,
    ) -> PyResult<Self> {
        let times_s = times_s.as_ref().map(samples).transpose()?;
        let time = match (sample_rate_hz, times_s) {
            (None, None) => TimeBase::Unknown,
            (Some(sample_rate_hz), None) => {
                TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples: 0.0 }
            }
            (None, Some(times_s)) => TimeBase::from_times(name, times_s).map_err(raised)?,
            (Some(rate), Some(times_s)) => {
                TimeBase::from_times_at_rate(name, &times_s, rate).map_err(raised)?
            }
        };
        let channel = |(name, unit, values): (String, String, PyReadonlyArray1<'_, f64>)| {
            Ok(Channel::new(&name, &unit, samples(&values)?))
        };
        let channels = channels.into_iter().map(channel).collect::<PyResult<Vec<_>>>()?;
        let valid = valid.map(|mask| mask.as_slice().map(<[bool]>::to_vec)).transpose()?;
        let inner = hysteron::Record { name: name.to_owned(), time, channels, valid, source: None };
        inner.check().map_err(raised)?;
        Ok(inner.into())
    }

    /// The record with the measured rate of its input in this column.
    fn with_rate(&self, column: String) -> Self {
        Self { inner: self.inner.clone(), rate: Some(column) }
    }

    /// The record with what counts of its input, by a dead band or a dead zone.
    #[pyo3(signature = (dead_band, dead_zone, input=None, output=None))]
    fn with_dead_band(
        &self,
        dead_band: Option<f64>,
        dead_zone: Option<f64>,
        input: Option<String>,
        output: Option<String>,
    ) -> PyResult<Self> {
        let Some(band) = DeadBand::given(dead_band, dead_zone).map_err(option)? else {
            return Ok(Self { inner: self.inner.clone(), rate: self.rate.clone() });
        };
        let (inner, _) = self.inner.with_dead_band(band, &ChannelChoice { input, output }).map_err(raised)?;
        Ok(Self { inner, rate: self.rate.clone() })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// Path of the file that it was read from.
    #[getter]
    fn path(&self) -> Option<&str> {
        self.inner.source.as_ref().map(|source| source.path.as_str())
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    /// `(name, unit)` of every channel.
    #[getter]
    fn channels(&self) -> Vec<(String, String)> {
        self.inner.channels.iter().map(|c| (c.name.clone(), c.unit.symbol().to_owned())).collect()
    }

    /// Samples of a channel.
    fn samples<'py>(&self, py: Python<'py>, channel: usize) -> PyResult<Bound<'py, PyArray1<f64>>> {
        match self.inner.channels.get(channel) {
            Some(channel) => Ok(PyArray1::from_slice(py, &channel.samples)),
            None => Err(option(format!("there is no channel {channel}"))),
        }
    }

    /// Sample rate [Hz] where there is one.
    #[getter]
    fn sample_rate_hz(&self) -> Option<f64> {
        match self.inner.time {
            TimeBase::Uniform { sample_rate_hz, .. } => Some(sample_rate_hz),
            TimeBase::NonUniform { .. } | TimeBase::Unknown => None,
        }
    }

    /// Whether the times are known.
    #[getter]
    fn has_times(&self) -> bool {
        self.inner.time != TimeBase::Unknown
    }

    /// Times [s] where they are known.
    fn times<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let times: Option<Vec<f64>> = (0..self.inner.len()).map(|k| self.inner.time.time_s(k)).collect();
        times.map(|times| PyArray1::from_vec(py, times))
    }

    /// Which samples are valid, where some are not.
    fn valid<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        self.inner.valid.as_ref().map(|mask| PyArray1::from_slice(py, mask))
    }

    /// Numbers of the channels that are input and output.
    #[pyo3(signature = (input=None, output=None))]
    fn select(&self, input: Option<String>, output: Option<String>) -> PyResult<(usize, usize)> {
        let found = self.inner.select(&ChannelChoice { input, output }).map_err(raised)?;
        Ok((found.input, found.output))
    }
}

/// Input and output of each record.
pub fn single(records: &[PyRef<'_, Record>], choice: &ChannelChoice) -> PyResult<Vec<InputOutput>> {
    records.iter().map(|record| record.rated(record.inner.input_output(choice).map_err(raised)?)).collect()
}

/// Name and unit of the header of a column.
#[pyfunction]
pub fn split_header(header: &str) -> (String, String) {
    let (name, unit) = hysteron_model::record::split_header(header);
    (name, unit.symbol().to_owned())
}

/// Options for reading files from Python: [`ReadOptions`] and more.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Reading {
    #[serde(default)]
    options: ReadOptions,
    /// `OLD=NEW`.
    #[serde(default)]
    rename: Vec<String>,
    /// `segment=2..7`.
    #[serde(default)]
    conditions: Vec<String>,
    /// `FIRST:LAST`.
    turns: Option<String>,
}

impl Reading {
    fn options(self) -> PyResult<ReadOptions> {
        let conditions = self.conditions.iter().map(|text| text.parse()).collect::<Result<_, _>>();
        let turns = self.turns.map(|text| text.parse::<Turns>()).transpose().map_err(option)?;
        let rename = self.rename.iter().map(|text| text.parse::<Rename>()).collect::<Result<_, _>>();
        let cut = Cut { conditions: conditions.map_err(option)?, turns, ..self.options.cut };
        Ok(ReadOptions { rename: rename.map_err(option)?, cut, ..self.options })
    }
}

/// A record, with the names in it of the input and the output that the options name.
type Found = (Record, Option<String>, Option<String>);

/// Records of files of any format, each with the names in it of the input and the output that the options
/// name.
#[pyfunction]
pub fn read(py: Python<'_>, paths: Vec<PathBuf>, options: &str) -> PyResult<Vec<Found>> {
    let options = from_json::<Reading>(options)?.options()?;
    let read = |path: &PathBuf| read_part(path, &options);
    let parts = work::run(py, || paths.par_iter().map(read).collect::<Result<Vec<_>, _>>())?;
    let parts = parts.map_err(raised)?.into_iter();
    Ok(parts.map(|part| (part.record.into(), part.chosen.input, part.chosen.output)).collect())
}

/// Contents of a file, as JSON.
#[pyfunction]
pub fn contents(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let held = work::run(py, || hysteron::contents(&path, &ReadOptions::default()))?;
    to_json(&held.map_err(raised)?)
}

/// Writes a record, by the extension of the file.
#[pyfunction]
pub fn write(py: Python<'_>, path: PathBuf, record: &Record) -> PyResult<()> {
    work::run(py, || hysteron::write(&path, &record.inner))?.map_err(raised)
}

/// One record of several: joined, scaled, detrended, resampled; and the steps as JSON.
#[pyfunction]
pub fn prepare(py: Python<'_>, records: Vec<PyRef<'_, Record>>, options: &str) -> PyResult<(Record, String)> {
    let prepare: Prepare = from_json(options)?;
    let records: Vec<_> = records.iter().map(|record| record.inner.clone()).collect();
    let prepared = work::run(py, || prepare.run(&records))?.map_err(raised)?;
    let summary = to_json(&prepared.summary())?;
    Ok((prepared.record.into(), summary))
}

/// Inspection of records, and what they determine together, as JSON.
#[pyfunction]
#[pyo3(signature = (records, input=None, output=None))]
pub fn inspect(
    py: Python<'_>,
    records: Vec<PyRef<'_, Record>>,
    input: Option<String>,
    output: Option<String>,
) -> PyResult<String> {
    #[derive(Serialize)]
    struct Inspected {
        records: Vec<hysteron_model::record::InspectionSummary>,
        campaign: hysteron_identify::structure::Prospects,
    }
    let data = single(&records, &ChannelChoice { input, output })?;
    let found = work::run(py, || Inspected {
        records: data.iter().map(|data| hysteron_model::record::inspect(data).summary(data)).collect(),
        campaign: prospects(&data),
    })?;
    to_json(&found)
}
