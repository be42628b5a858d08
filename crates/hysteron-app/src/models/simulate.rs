//! A model's output for a drive.

use hysteron_model::axes::AxesRecord;
use hysteron_model::force::with_rate;
use hysteron_model::model::{Capability, SignalRole, Signals, Simulation};
use hysteron_model::model_file::Kind;
use hysteron_model::record::{Driven, InputOutput, MeasurementRun, Unit};
use hysteron_model::{Model, Start};

use super::score::{band, in_words};
use crate::api::{BandOf, Figure, Outcome, Series, SimulateOptions, SimulateRequest};
use crate::command;
use crate::draw::{Along, over_time};
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Width of drawings \[pixels\].
const PIXELS: usize = 1000;

/// Simulates a model for the drive of a record, beside what was measured where the record holds that.
///
/// # Errors
/// If model and record do not go together, or the file cannot be written.
pub(crate) fn simulate(workspace: &Workspace, id: &str, request: &SimulateRequest) -> Answer<Outcome> {
    let model = workspace.model(id)?;
    let options = &request.options;
    let signals = drive(workspace, &model, &request.records, options.rate.as_deref())?;
    let start = options.rest_voltage.map_or(Start::AsIdentified, |voltage_v| Start::Rest { voltage_v });
    let found = match options.correct {
        true => model.simulate_corrected(&signals, start),
        false => model.simulate(&signals, start),
    };
    let found = found.map_err(Refused::cannot)?;
    let ends = ends(&model, &signals, &found, options)?;
    let names: Vec<String> = match model.channels() {
        Some((_, outputs)) => outputs.to_vec(),
        None => vec!["y".to_owned()],
    };
    let units = model.units();
    let figures = figures(&signals, &found, &names, &Unit::new(&units.output), ends.as_ref());
    let file = request.save.as_deref().unwrap_or("simulated.csv");
    let entries = request.records.iter().map(|id| workspace.entry(id)).collect::<Answer<Vec<_>>>()?;
    let command = command::simulate((id, model.kind() == Kind::Force), &entries, options, file);
    if let Some(save) = &request.save {
        let record = found.to_record(save, &signals, &names, &units.output, ends).map_err(Refused::failed)?;
        workspace.keep_predicted(save, &record)?;
        workspace.history.add_action(&command)?;
        workspace.look();
    }
    let mut sentences = vec![format!("Simulated {}.", found.start.in_words(&units.input, &units.output))];
    sentences.extend(found.remarks.iter().map(|remark| in_words(&model, remark)));
    Ok(Outcome {
        sentences,
        figures,
        files: request.save.iter().cloned().collect(),
        command,
        ..Outcome::default()
    })
}

/// The drive of a record or of the run that several form, with the output that was measured beside it where it
/// has the model's unit.
fn drive(workspace: &Workspace, model: &Model, ids: &[String], rate: Option<&str>) -> Answer<Signals> {
    let [one] = ids else {
        let part = |id: &String| match drive_of(workspace, model, id, rate)? {
            Signals::Single(part) => Ok(part),
            Signals::Several(_) => {
                Err(Refused::bad("a record of several inputs and outputs is simulated by itself"))
            }
        };
        let parts = ids.iter().map(part).collect::<Answer<Vec<_>>>()?;
        let runs = MeasurementRun::of(&parts).map_err(Refused::cannot)?;
        let [run] = <[MeasurementRun; 1]>::try_from(runs)
            .map_err(|_| Refused::bad("the records are no run: each begins where the one before it ended"))?;
        return Ok(Signals::Single(run.data));
    };
    drive_of(workspace, model, one, rate)
}

fn drive_of(workspace: &Workspace, model: &Model, id: &str, rate: Option<&str>) -> Answer<Signals> {
    let is_force = model.kind() == Kind::Force;
    if rate.is_some() && !is_force {
        return Err(Refused::bad("a column of the rate goes with a model of the kind \"force\""));
    }
    let read = workspace.read(id)?;
    if let Some((inputs, _)) = model.channels() {
        return Ok(AxesRecord::new(&read.record, inputs, &[]).map_err(Refused::bad)?.into());
    }
    let settings = workspace.history.settings(id)?;
    let Driven { drive, measured } =
        read.record.driven(settings.input.as_deref()).map_err(Refused::cannot)?;
    let agrees = |m: &InputOutput| model.agreed_unit(SignalRole::Output, &m.y_unit, &mut Vec::new()).is_ok();
    let signals = Signals::from(Driven { drive, measured: measured.filter(agrees) });
    match (signals, rate.or(settings.rate.as_deref())) {
        (Signals::Single(data), Some(column)) if is_force => {
            Ok(with_rate(data, &read.record, column).map_err(Refused::bad)?.into())
        }
        (signals, _) => Ok(signals),
    }
}

/// Ends of the band about the output.
fn ends(
    model: &Model,
    signals: &Signals,
    found: &Simulation,
    options: &SimulateOptions,
) -> Answer<Option<[Vec<f64>; 2]>> {
    let of = options.band;
    let (Signals::Single(drive), Some(y)) = (signals, found.outputs.first()) else { return Ok(None) };
    if of == BandOf::None {
        return Ok(None);
    }
    model.hammerstein(Capability::Bands).map_err(Refused::cannot)?;
    let unknown = || Refused::bad("the model file does not say how sure its numbers are");
    let band = band(model, &drive.u, &drive.time, &found.start).ok_or_else(unknown)?;
    let band = if options.correct { band.corrected() } else { band };
    let half = match of {
        BandOf::Measurement if band.noise > 0.0 => band.of_measurement(),
        BandOf::Measurement => return Err(Refused::bad("the model file holds no scores of its records")),
        BandOf::Model | BandOf::None => band.of_output(),
    };
    Ok(Some([-1.0, 1.0].map(|sign| y.iter().zip(&half).map(|(y, h)| y + sign * h).collect())))
}

/// Output and drive over time.
fn figures(
    signals: &Signals,
    found: &Simulation,
    names: &[String],
    unit: &Unit,
    ends: Option<&[Vec<f64>; 2]>,
) -> Vec<Figure> {
    let time = signals.time();
    let draw = |name: &str, unit: &Unit, samples: &[f64]| Series {
        name: name.to_owned(),
        curve: over_time(time, &Along::new(name, unit, samples), 0..samples.len(), PIXELS),
    };
    let figure =
        |title: &str, series| Figure { title: title.to_owned(), series, log_across: false, log_up: false };
    let mut outputs = Vec::new();
    let drives = match signals {
        Signals::Single(record) => {
            if !record.y.is_empty() {
                outputs.push(draw("measured", unit, &record.y));
            }
            vec![draw("drive", &found.input_unit, &record.u)]
        }
        Signals::Several(record) => {
            let inputs = record.inputs.iter().zip(&record.u);
            inputs.map(|(name, u)| draw(name, &found.input_unit, u)).collect()
        }
    };
    for (name, y) in names.iter().zip(&found.outputs) {
        outputs.push(draw(if names.len() == 1 { "model" } else { name }, unit, y));
    }
    for (name, end) in ["band-low", "band-high"].into_iter().zip(ends.into_iter().flatten()) {
        outputs.push(draw(name, unit, end));
    }
    vec![figure("Output", outputs), figure("Drive", drives)]
}
