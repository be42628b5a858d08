//! Records cut, joined, scaled, detrended and resampled into one new record.

use hysteron_io::{ReadOptions, read_part, write_record};
use hysteron_model::Advice;
use hysteron_model::record::{Cut, Prepare, Turns};
use hysteron_report::results::preparation::lines;

use crate::api::{Outcome, PrepareOptions, PrepareRequest, Problem, RecordSettings};
use crate::command;
use crate::refused::{Answer, Refused};
use crate::workspace::{Kind, Workspace};

/// Prepares records and writes the new one.
///
/// # Errors
/// If a record cannot be read so, or they cannot be joined.
pub(crate) fn prepare(workspace: &Workspace, request: &PrepareRequest) -> Answer<Outcome> {
    if request.records.is_empty() {
        return Err(Refused::bad("no record is given"));
    }
    let asked = &request.options;
    if asked.sample_rate_hz.is_some_and(|rate| !(rate.is_finite() && rate > 0.0)) {
        return Err(Refused::bad("the sample rate must be positive"));
    }
    let mut sentences = Vec::new();
    let mut scales = parsed(&asked.scales)?;
    let mut records = Vec::new();
    for id in &request.records {
        let settings = workspace.history.settings(id)?;
        for scale in parsed(&settings.scales)? {
            if !scales.contains(&scale) {
                scales.push(scale);
            }
        }
        let path = workspace.existing(id)?;
        let part = read_part(&path, &reading(asked, &settings)?)
            .map_err(|e| Refused::cannot(Problem::of_file(&e, &path, id)))?;
        if part.record.len() < part.file_samples {
            sentences.push(format!("kept {} of {} samples of {id}", part.record.len(), part.file_samples));
        }
        records.push(part.record);
    }
    let prepare = Prepare {
        scales,
        remove_mean: asked.remove_mean.clone(),
        detrend: asked.detrend.clone(),
        sample_rate_hz: asked.sample_rate_hz,
    };
    let advised = |e: &hysteron_model::record::RecordError| {
        Problem::new(e, e.advice().filter(|a| *a != Advice::Resample))
    };
    let prepared = prepare.run(&records).map_err(|e| Refused::cannot(advised(&e)))?;
    let entries = request.records.iter().map(|id| workspace.entry(id)).collect::<Answer<Vec<_>>>()?;
    let command = command::prepare(&entries, asked, &request.save);
    let path = workspace.to_write(&request.save, Kind::Record)?;
    write_record(&path, &prepared.record).map_err(Refused::failed)?;
    workspace.history.add_action(&command)?;
    workspace.look();
    sentences.extend(lines(&prepared.summary(), &request.save));
    Ok(Outcome { sentences, files: vec![request.save.clone()], command, ..Outcome::default() })
}

fn parsed<T: std::str::FromStr<Err: std::fmt::Display>>(texts: &[String]) -> Answer<Vec<T>> {
    texts.iter().map(|text| text.parse().map_err(Refused::bad)).collect()
}

fn reading(asked: &PrepareOptions, settings: &RecordSettings) -> Answer<ReadOptions> {
    let turns: Option<Turns> =
        asked.turns.as_ref().map(|text| text.parse().map_err(Refused::bad)).transpose()?;
    Ok(ReadOptions {
        time: settings.time.clone(),
        sample_rate_hz: settings.sample_rate_hz,
        rename: parsed(&asked.rename)?,
        leave_out: asked.drop.clone(),
        cut: Cut {
            from_s: settings.from_s,
            to_s: settings.to_s,
            conditions: parsed(&asked.conditions)?,
            turns: turns.map(|turns| Turns { column: settings.input.clone(), ..turns }),
        },
        ..ReadOptions::default()
    })
}
