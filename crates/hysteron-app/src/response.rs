//! Structures fitted to a frequency response, of a file or of records of periodic multisines.

use hysteron_identify::frequency_response::empirical::{EmpiricalOptions, empirical_response};
use hysteron_identify::frequency_response::{
    Explained, Family, FrequencyResponse, Weighting, compare, unwrapped_phase_deg,
};
use hysteron_io::{IoError, ReadOptions, ResponseOptions, read_frequency_response, read_record};
use hysteron_model::UnknownName;
use hysteron_model::record::range_of;
use hysteron_report::frequency_response::{nearest_turn, page, shown};
use hysteron_report::results::response::{ABOUT_AIC, parameters, structures};
use hysteron_report::write_page;

use crate::api::{Axis, Curve, Figure, Outcome, Problem, ResponseFitOptions, ResponseFitRequest, Series};
use crate::clock::maker;
use crate::command;
use crate::models::listed;
use crate::refused::{Answer, Refused};
use crate::workspace::{Kind, Workspace};

/// Fits structures; writes the model of lowest AIC and the report where asked.
///
/// # Errors
/// If there is no response in the files, or no structure can be fitted.
pub(crate) fn explain(workspace: &Workspace, request: &ResponseFitRequest) -> Answer<Outcome> {
    let options = &request.options;
    let found = fitted(workspace, &request.files, options)?;
    let command = command::frequency_response(request);
    let made = maker(&command.shell);
    let mut sentences = vec![found.what()];
    sentences.extend(found.findings().into_iter().map(|finding| finding.text));
    sentences.extend(found.empirical.as_ref().map(|measured| measured.in_words()));
    sentences.extend(found.candidates.iter().map(|c| format!("{}: {}", c.name, c.explanation)));
    sentences.push(ABOUT_AIC.to_owned());
    let mut files = Vec::new();
    if let Some(save) = &request.save {
        let written = found.model_file(&made).map_err(Refused::cannot)?;
        workspace.keep_model(save, written.file)?;
        files.push(save.clone());
    }
    if let Some(report) = &request.report {
        write_page(&workspace.to_write(report, Kind::Report)?, &page(&found, &made))
            .map_err(Refused::failed)?;
        files.push(report.clone());
    }
    workspace.history.add_action(&command)?;
    workspace.look();
    Ok(Outcome {
        sentences,
        tables: vec![listed("Structures", structures(&found)), listed("Parameters", parameters(&found))],
        figures: bode(&found),
        files,
        command,
    })
}

fn fitted(workspace: &Workspace, files: &[String], options: &ResponseFitOptions) -> Answer<Explained> {
    let (mut measured, empirical) = match files {
        [] => return Err(Refused::bad("no file is given")),
        [file] if is_response(workspace, file, options)? => {
            let path = workspace.existing(file)?;
            let named = ResponseOptions {
                response: options.response.clone(),
                over: options.over.clone(),
                max_bytes: None,
            };
            let read = read_frequency_response(&path, &named);
            (read.map_err(|e| Refused::cannot(Problem::of_file(&e, &path, file)))?, None)
        }
        files => {
            let read = |id: &String| Ok(workspace.read(id)?.data()?.clone());
            let records = files.iter().map(read).collect::<Answer<Vec<_>>>()?;
            let options =
                EmpiricalOptions { period_s: options.period_s, settling_periods: options.settling_periods };
            let found = empirical_response(&records, &options).map_err(|e| {
                Refused::cannot(e)
                    .hint("Play a multisine of at least two periods, and again with other seeds.")
            })?;
            (found.response.clone(), Some(found))
        }
    };
    if let Some(unit) = &options.unit {
        measured.unit.clone_from(unit);
    }
    let (lowest, highest) = measured.range_hz();
    let given = (options.low_hz.is_some() || options.high_hz.is_some())
        .then(|| (options.low_hz.unwrap_or(lowest), options.high_hz.unwrap_or(highest)));
    let response = match given.or(measured.band_above_noise()) {
        Some((low, high)) => measured.band(low, high),
        None => measured,
    };
    if response.is_empty() {
        return Err(Refused::bad(format!(
            "no point of the response lies in the band: {lowest} to {highest} Hz"
        )));
    }
    let named = |name: &String| UnknownName::find("structure", name, Family::ALL, Family::name);
    let families = options.structures.iter().map(named).collect::<Result<Vec<_>, _>>();
    let families = families.map_err(Refused::bad)?;
    let families = if families.is_empty() { Family::for_response(&response) } else { families };
    let candidates = compare(&response, Weighting::of(&response), &families, options.modes);
    Ok(Explained { candidates: candidates.map_err(Refused::cannot)?, response, empirical })
}

fn is_response(workspace: &Workspace, file: &str, options: &ResponseFitOptions) -> Answer<bool> {
    let named = options.response.is_some() || options.over.is_some();
    let read = read_record(&workspace.existing(file)?, &ReadOptions::default());
    Ok(named || matches!(read, Err(IoError::FrequencyResponse { .. })))
}

/// Gain and phase, measured and of each structure.
fn bode(found: &Explained) -> Vec<Figure> {
    let FrequencyResponse { frequency_hz, values, unit, .. } = &found.response;
    let of = |name: &str, y: Vec<f64>, axis: &str, unit: &str| {
        let axis_of = |name: &str, unit: &str, samples: &[f64]| {
            let (low, high) = range_of(samples);
            Axis { name: name.to_owned(), unit: unit.to_owned(), low, high }
        };
        let curve = Curve {
            across: axis_of("frequency", "Hz", frequency_hz),
            up: axis_of(axis, unit, &y),
            samples: y.len(),
            x: frequency_hz.clone(),
            shown: format!("all {} points", y.len()),
            breaks: Vec::new(),
            y,
        };
        Series { name: name.to_owned(), curve }
    };
    let unit = shown(unit);
    let measured = found.response.phase_deg();
    let mut gains = vec![of("measured", values.iter().map(|g| g.norm()).collect(), "gain", &unit)];
    let mut phases = vec![of("measured", measured.clone(), "phase", "°")];
    for candidate in &found.candidates {
        let values = candidate.fit.response_at(frequency_hz);
        gains.push(of(&candidate.name, values.iter().map(|g| g.norm()).collect(), "gain", &unit));
        let phase = nearest_turn(&unwrapped_phase_deg(&values), &measured);
        phases.push(of(&candidate.name, phase, "phase", "°"));
    }
    let figure =
        |title: &str, series, log_up| Figure { title: title.to_owned(), series, log_across: true, log_up };
    vec![figure("Gain", gains, true), figure("Phase", phases, false)]
}
