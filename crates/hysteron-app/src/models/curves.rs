//! Curves and frequency response of a model on a record.

use std::sync::{Arc, OnceLock};

use hysteron_identify::SineResponse;
use hysteron_model::model::Signals;
use hysteron_model::record::{InputOutput, Unit};
use hysteron_model::validate::Scoring;
use hysteron_model::{Model, Start};

use super::score::{band, remarks, score_of, signals};
use super::training_scores;
use crate::api::{
    Command, ModelCurves, ModelCurvesQuery, ResponseRow, Responses, ScoresRequest, Series, View,
};
use crate::command;
use crate::draw::{Along, between, over, over_time};
use crate::refused::{Answer, Refused};
use crate::workspace::{Simulated, Workspace, device_of};

/// Curves of a model on a record of one input and one output, with the scores of the same series.
///
/// # Errors
/// If model or record are none, or do not go together.
pub(crate) fn curves(workspace: &Workspace, id: &str, query: &ModelCurvesQuery) -> Answer<ModelCurves> {
    let model = workspace.model(id)?;
    let scored = scored(workspace, &model, id, &query.record)?;
    let Simulated { signals, score: found, half_width } = &*scored;
    let Signals::Single(record) = signals else {
        return Err(Refused::bad("curves are drawn of models of one input and one output"));
    };
    // What is drawn is what was scored: the library returns both together.
    let series = found.series(signals).map_err(Refused::failed)?;
    let channel = |name: &str| {
        let channel = series.channel(name).map(|channel| channel.samples.as_slice());
        channel.ok_or_else(|| Refused::failed("the simulation has no such series"))
    };
    let (simulated, residual) = (channel("y_model")?, channel("residual")?);
    let part = between(&record.time, record.len(), query.from, query.to);
    let periods = workspace.read(&query.record)?.periods();
    let drawn = Drawn { record, part, pixels: query.pixels, periods };
    let series = match query.view {
        View::Loop => vec![drawn.over_input("measured", &record.y), drawn.over_input("model", simulated)],
        View::ResidualLoop => vec![drawn.over_input("residual", residual)],
        View::Time | View::Residual => {
            let is_residual = query.view == View::Residual;
            let mut all = if is_residual {
                vec![drawn.in_time("residual", residual)]
            } else {
                vec![drawn.in_time("measured", &record.y), drawn.in_time("model", simulated)]
            };
            let width = half_width.get_or_init(|| {
                let band = band(&model, &record.u, &record.time, &found.simulation.start);
                band.filter(|band| band.noise > 0.0).map(|band| band.of_measurement())
            });
            if let Some(width) = width {
                let edge = |sign: f64| -> Vec<f64> {
                    let middle = |y: &f64| if is_residual { 0.0 } else { *y };
                    simulated.iter().zip(width).map(|(y, width)| middle(y) + sign * width).collect()
                };
                all.push(drawn.in_time("band-low", &edge(-1.0)));
                all.push(drawn.in_time("band-high", &edge(1.0)));
            }
            all
        }
    };
    let scores = score_of(&query.record, found);
    let fitted_on = training_scores(&super::data(&model), "");
    let is_same = |name: &str| {
        let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
        let of_its_device = device_of(id) == device_of(&query.record);
        name == query.record || (of_its_device && last(name) == last(&query.record))
    };
    Ok(ModelCurves {
        record: query.record.clone(),
        view: query.view,
        series,
        scores,
        fitted: fitted_on.iter().any(|score| is_same(&score.record)),
        remarks: remarks(&model, found),
        command: command_of(workspace, id, &query.record)?,
    })
}

/// A model on a record with its scores: one simulation for all that is drawn of it, at every zoom.
fn scored(workspace: &Workspace, model: &Model, id: &str, record: &str) -> Answer<Arc<Simulated>> {
    let key = format!("{} on {}", workspace.stamp_of(id)?, workspace.stamp_of(record)?);
    workspace.scored.get(key, || {
        let signals = signals(workspace, model, record)?;
        let found = model.score(&signals, Start::AsIdentified, &Scoring::default());
        let score = found.map_err(Refused::cannot)?;
        Ok(Simulated { signals, score, half_width: OnceLock::new() })
    })
}

/// Command that scores the model on the record.
fn command_of(workspace: &Workspace, id: &str, record: &str) -> Answer<Command> {
    let entry = workspace.entry(record)?;
    let request = ScoresRequest { records: vec![record.to_owned()], ..ScoresRequest::default() };
    Ok(command::validate(id, &[entry], &request))
}

struct Drawn<'a> {
    record: &'a InputOutput,
    part: std::ops::Range<usize>,
    pixels: usize,
    periods: Option<(f64, usize)>,
}

impl Drawn<'_> {
    fn output<'a>(&'a self, y: &'a [f64]) -> Along<'a> {
        Along::new(&self.record.output, &self.record.y_unit, y)
    }

    fn over_input(&self, name: &str, y: &[f64]) -> Series {
        let u = Along::new(&self.record.input, &self.record.u_unit, &self.record.u);
        let curve = over(&u, &self.output(y), self.part.clone(), self.pixels, self.periods);
        Series { name: name.to_owned(), curve }
    }

    fn in_time(&self, name: &str, y: &[f64]) -> Series {
        let curve = over_time(&self.record.time, &self.output(y), self.part.clone(), self.pixels);
        Series { name: name.to_owned(), curve }
    }
}

/// Gain and phase at the oscillations of a record, measured and of the model.
///
/// # Errors
/// Those of [`curves`].
pub(crate) fn response(workspace: &Workspace, id: &str, record_id: &str) -> Answer<Responses> {
    let model = workspace.model(id)?;
    let scored = scored(workspace, &model, id, record_id)?;
    let Simulated { signals: Signals::Single(record), score: found, .. } = &*scored else {
        return Err(Refused::bad("gain and phase are of models of one input and one output"));
    };
    let simulated = found.simulation.outputs.first().map_or(&[][..], Vec::as_slice);
    let mut rows = SineResponse::of_record(record, simulated);
    if rows.is_empty() {
        rows.extend(SineResponse::of_fundamental(record, simulated));
    }
    let unit = match (record.y_unit.symbol(), record.u_unit.symbol()) {
        ("", _) | (_, "") => Unit::new("").to_string(),
        _ => format!("{}/{}", record.y_unit, record.u_unit),
    };
    Ok(Responses {
        record: record_id.to_owned(),
        unit,
        rows: rows
            .into_iter()
            .map(|row| ResponseRow {
                frequency_hz: row.frequency_hz,
                measured: row.measured,
                model: row.model,
            })
            .collect(),
    })
}
