//! Scores of a model on records.

use hysteron_identify::PredictionBand;
use hysteron_model::axes::AxesRecord;
use hysteron_model::force::with_rate;
use hysteron_model::model::{BandScore, Capability, Remark, Score as Found, Signals};
use hysteron_model::model_file::Kind as ModelKind;
use hysteron_model::record::{InputOutput, MeasurementRun, TimeBase};
use hysteron_model::validate::{OffsetTreatment, Scoring, definitions};
use hysteron_model::{Model, Start};
use hysteron_report::record_curves::is_simulated;

use crate::api::{Judged, Problem, Score, ScoreDefinition, Scored, ScoresRequest};
use crate::command;
use crate::problem::remedy;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Inputs and outputs of a record, in the order of the model.
///
/// # Errors
/// If the record is none for this model.
pub(super) fn signals(workspace: &Workspace, model: &Model, id: &str) -> Answer<Signals> {
    let read = workspace.read(id)?;
    Ok(match model.channels() {
        Some((inputs, outputs)) => {
            AxesRecord::new(&read.record, inputs, outputs).map_err(Refused::bad)?.into()
        }
        None => read.data()?.clone().into(),
    })
}

/// The API's score of a library's.
pub(super) fn score_of(record: &str, found: &Found) -> Score {
    let summary = found.summary();
    Score {
        record: record.to_owned(),
        unit: found.unit.to_string(),
        samples: summary.samples,
        rmse: summary.errors.rmse,
        max_abs_error: summary.errors.max_abs_error,
        rmse_percent_of_stroke: summary.errors.rmse_percent_of_stroke,
        max_percent_of_stroke: summary.errors.max_percent_of_stroke,
        fit_percent: summary.errors.fit_percent,
        offset: summary.errors.offset,
    }
}

/// Remarks of a simulation, in words.
pub(super) fn remarks(model: &Model, found: &Found) -> Vec<String> {
    found.simulation.remarks.iter().map(|remark| in_words(model, remark)).collect()
}

/// A remark with its remedy.
pub(super) fn in_words(model: &Model, remark: &Remark) -> String {
    let (text, advice) = remark.in_words(model);
    match advice {
        Some(advice) => format!("{}. {}", text.trim_end_matches('.'), remedy(&advice)),
        None => text,
    }
}

/// The band of the output, where the model file gives one.
pub(super) fn band(model: &Model, u: &[f64], time: &TimeBase, start: &Start) -> Option<PredictionBand> {
    let Model::Hammerstein(body) = model else { return None };
    body.data().correlation.as_ref()?;
    PredictionBand::of_file(body.data(), u, time, start).ok()
}

fn in_band(model: &Model, record: &InputOutput, found: &Found, skip_s: f64) -> Option<BandScore> {
    let band = band(model, &record.u, &record.time, &found.simulation.start)?;
    let band = if found.correction.is_some() { band.corrected() } else { band };
    (band.noise > 0.0).then(|| band.holds(record, found, skip_s))
}

fn judged(
    workspace: &Workspace,
    model: &Model,
    id: &str,
    request: &ScoresRequest,
    scoring: &Scoring,
) -> Answer<Judged> {
    let signals = match (signals(workspace, model, id)?, &request.rate) {
        (Signals::Single(data), Some(column)) => {
            let read = workspace.read(id)?;
            with_rate(data, &read.record, column).map_err(Refused::bad)?.into()
        }
        (signals, _) => signals,
    };
    let found = match request.correct {
        true => model.score_corrected(&signals, Start::AsIdentified, scoring),
        false => model.score(&signals, Start::AsIdentified, scoring),
    };
    let found = found.map_err(Refused::cannot)?;
    if let Some(file) = &request.save {
        if request.records.len() != 1 {
            return Err(Refused::bad("a file of scored samples is of one record, or of one run"));
        }
        write_series(workspace, file, &found, &signals)?;
    }
    let band = match &signals {
        Signals::Single(record) => in_band(model, record, &found, scoring.skip_s.unwrap_or(0.0)),
        Signals::Several(_) => None,
    };
    Ok(described(model, id, &found, band.as_ref()))
}

/// Writes the samples that were scored: drive, measured output, model, residual.
fn write_series(workspace: &Workspace, file: &str, found: &Found, signals: &Signals) -> Answer<()> {
    let series = found.series(signals).map_err(Refused::failed)?;
    workspace.keep_predicted(file, &series)?;
    workspace.look();
    Ok(())
}

/// Scores of a model on records. A record that cannot be scored does not stop the others.
///
/// # Errors
/// If the model is none.
pub(crate) fn scores(workspace: &Workspace, id: &str, request: &ScoresRequest) -> Answer<Scored> {
    let model = workspace.model(id)?;
    let offset = if request.fixed_offset { OffsetTreatment::Fixed } else { OffsetTreatment::Estimated };
    let scoring = Scoring { skip_s: request.skip_s, offset };
    if request.rate.is_some() && model.kind() != ModelKind::Force {
        return Err(Refused::bad("a column of the rate goes with a model of the kind force"));
    }
    if request.continued && request.correct {
        return Err(Refused::bad("the scores of parts of one run are not corrected"));
    }
    if request.continued {
        let records = of_runs(workspace, &model, request, &scoring)?;
        return answer(workspace, id, request, records);
    }
    let one = |record: &String| {
        judged(workspace, &model, record, request, &scoring)
            .unwrap_or_else(|refused| failed(record, refused.into_problem()))
    };
    let records = request.records.iter().map(one).collect();
    answer(workspace, id, request, records)
}

fn answer(workspace: &Workspace, id: &str, request: &ScoresRequest, records: Vec<Judged>) -> Answer<Scored> {
    let entries: Vec<_> = request.records.iter().filter_map(|id| workspace.entry(id).ok()).collect();
    let command = command::validate(id, &entries, request);
    workspace.history.add_action(&command)?;
    Ok(Scored { records, definitions: defined(), command })
}

/// Scores of the records as parts of runs: one that cannot be read leaves a gap, so nothing is scored.
fn of_runs(
    workspace: &Workspace,
    model: &Model,
    request: &ScoresRequest,
    scoring: &Scoring,
) -> Answer<Vec<Judged>> {
    model.hammerstein(Capability::Runs).map_err(Refused::cannot)?;
    let read = |id: &String| Ok(workspace.read(id)?.data()?.clone());
    let data = request.records.iter().map(read).collect::<Answer<Vec<_>>>()?;
    let (mut judged, mut runs) = (Vec::new(), Vec::new());
    for run in MeasurementRun::of(&data).map_err(Refused::cannot)? {
        let found = model.score_run(&run, Start::AsIdentified, scoring).map_err(Refused::cannot)?;
        for part in &found.records {
            judged.push(described(model, &part.record, part, None));
        }
        judged.push(described(model, "whole run", &found.whole, None));
        runs.push((run, found));
    }
    match (&request.save, runs.as_slice()) {
        (None, _) => {}
        (Some(file), [(run, found)]) => {
            write_series(workspace, file, &found.whole, &run.data.clone().into())?;
        }
        _ => return Err(Refused::bad("a file of scored samples is of one record, or of one run")),
    }
    Ok(judged)
}

fn described(model: &Model, record: &str, found: &Found, band: Option<&BandScore>) -> Judged {
    let rests_on = band.iter().flat_map(|band| &band.findings).map(|finding| finding.text.clone());
    Judged {
        record: record.to_owned(),
        score: Some(score_of(record, found)),
        verdict: found.verdict.as_ref().map(|v| format!("{}: {}", v.judgement.name(), v.why)),
        remarks: remarks(model, found)
            .into_iter()
            .chain(found.correction_in_words())
            .chain(rests_on)
            .collect(),
        in_band_percent: band.map(|band| band.inside_percent),
        simulated: is_simulated(record),
        error: None,
    }
}

fn failed(record: &str, problem: Problem) -> Judged {
    Judged {
        record: record.to_owned(),
        score: None,
        verdict: None,
        remarks: Vec::new(),
        in_band_percent: None,
        simulated: is_simulated(record),
        error: Some(problem),
    }
}

fn defined() -> Vec<ScoreDefinition> {
    let each = definitions().iter();
    each.map(|d| ScoreDefinition { name: d.key.to_owned(), text: format!("{}: {}", d.name, d.meaning) })
        .collect()
}
