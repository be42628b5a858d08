//! The drive for a reference, and controllers that follow it on a simulated plant.

use hysteron_identify::{ForecastDrive, Listener, drive_for};
use hysteron_io::{ReadOptions, read_reference, write_record};
use hysteron_model::Model;
use hysteron_model::control::Plant;
use hysteron_model::invert::{InverseDrive, LastRun};
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::record::{Channel, Record, Signal, TimeBase, Unit};
use hysteron_model::tracking::{ControllerRun, PlantDescription, track_told as play};
use hysteron_rig::{Dac, RigStage, Truth};

use crate::api::{
    FollowRequest, Followed, Problem, Reference, Role, TrackRequest, Tracked, TrackedController, TrackedCurve,
};
use crate::command;
use crate::draw::{Along, over_time};
use crate::problem::remedy;
use crate::refused::{Answer, Refused};
use crate::workspace::Workspace;

/// Width of drawings unless given \[pixels\].
const PIXELS: usize = 800;
/// Most samples of a reference.
const MOST_SAMPLES: usize = 10_000_000;

/// A reference, uniformly sampled and in the unit of the model's output.
struct Wanted {
    samples: Vec<f64>,
    rate: f64,
    unit: Unit,
    name: String,
    remarks: Vec<String>,
}

fn wanted(workspace: &Workspace, model: &Model, reference: &Reference) -> Answer<Wanted> {
    let own = Unit::new(&model.units().output);
    let of = |samples: Vec<f64>, rate: f64, name: &str| {
        if samples.is_empty() || samples.len() > MOST_SAMPLES {
            return Err(Refused::bad("a reference has 1 to 10 000 000 samples"));
        }
        if !(rate.is_finite() && rate > 0.0 && samples.iter().all(|x| x.is_finite())) {
            return Err(Refused::bad("rate and samples of a reference must be finite numbers"));
        }
        let name = name.to_owned();
        Ok(Wanted { samples, rate, unit: own.clone(), name, remarks: Vec::new() })
    };
    match reference {
        Reference::Waveform { specification } => {
            // The waveforms are those of drives; here their values are those of the output.
            let made = specification.generate().map_err(|e| {
                let said = e.to_string().replace("high_v", "the greatest value");
                let said = said.replace("low_v", "the least value").replace("voltage", "value");
                Refused::bad(format!("the reference: {said}"))
            })?;
            of(made.samples_v, made.sample_rate_hz, &made.name)
        }
        Reference::Samples { sample_rate_hz, values } => of(values.clone(), *sample_rate_hz, "reference"),
        Reference::Record { id, column } => {
            let path = workspace.existing(id)?;
            let options = ReadOptions { reference: column.clone(), ..ReadOptions::default() };
            let signal = read_reference(&path, &options)
                .map_err(|e| Refused::cannot(Problem::of_file(&e, &path, id)))?;
            let mut told = Vec::new();
            let unit =
                model.agreed_unit(SignalRole::Reference, &signal.unit, &mut told).map_err(Refused::cannot)?;
            let TimeBase::Uniform { sample_rate_hz, .. } = signal.time else {
                return Err(Refused::bad(
                    "the reference has no uniform sample rate, and the controller runs at one",
                )
                .hint(remedy(&hysteron_model::Advice::Resample)));
            };
            let remarks = told.iter().map(|remark| remark.in_words(model).0).collect();
            Ok(Wanted { unit, remarks, ..of(signal.samples, sample_rate_hz, id)? })
        }
    }
}

/// The drive for a reference with its predicted error.
///
/// # Errors
/// If the model has no inverse, or the reference cannot be followed at all.
pub(crate) fn follow(
    workspace: &Workspace,
    id: &str,
    request: &FollowRequest,
    listener: Listener<'_>,
) -> Answer<Followed> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Inversion).map_err(Refused::cannot)?;
    let mut wanted = wanted(workspace, &model, &request.reference)?;
    let told = body.remarks_on_reference(&wanted.samples, wanted.rate);
    wanted.remarks.extend(told.iter().map(|remark| remark.in_words(&model).0));
    let units = &body.data().units;
    let run = request.learn_from.as_deref().map(|id| workspace.read(id)).transpose()?;
    let run = run.as_ref().map(|run| run.data()).transpose()?;
    let last = run.map(|run| LastRun { drive: &run.u, measured: &run.y });
    let found = drive_for(body, &wanted.samples, wanted.rate, &request.inverse, last, listener);
    let ForecastDrive { drive: found, summary } = found.map_err(|e| {
        let (output, input) = (Unit::new(&units.output), Unit::new(&units.input));
        Refused::cannot(Problem::new(e.in_units(&input, &output), None))
    })?;
    let (band, band_of_measurement, expected_rms_error) = match &summary.forecast {
        Some(f) => (Some(f.band_of_model), f.band_of_measurement, f.expected_rms),
        None => (None, None, None),
    };
    let command = match &request.reference {
        Reference::Record { id: reference, .. } => command::invert(id, request, reference),
        _ => {
            let drive = request.save.as_deref().unwrap_or("drive.csv");
            command::invert(id, request, &reference_beside(drive))
        }
    };
    if let Some(file) = &request.save {
        save(workspace, file, &wanted, &found, units.input.as_str(), request)?;
        workspace.history.add_action(&command)?;
    }
    let input = Unit::new(&units.input);
    let time = TimeBase::uniform(wanted.rate);
    let pixels = request.pixels.unwrap_or(PIXELS);
    let error: Vec<f64> = wanted.samples.iter().zip(&found.predicted).map(|(r, y)| r - y).collect();
    let draw = |name: &str, unit: &Unit, samples: &[f64]| {
        over_time(&time, &Along::new(name, unit, samples), 0..samples.len(), pixels)
    };
    Ok(Followed {
        reference: draw("reference", &wanted.unit, &wanted.samples),
        drive: draw("drive", &input, &found.drive),
        error: draw("reference − predicted", &wanted.unit, &error),
        input_unit: input.to_string(),
        output_unit: wanted.unit.to_string(),
        samples: summary.samples,
        sample_rate_hz: summary.sample_rate_hz,
        rest: summary.rest,
        drive_low: summary.drive_low,
        drive_high: summary.drive_high,
        samples_at_range: summary.samples_at_range,
        samples_at_slew: summary.samples_at_slew,
        preview_samples: summary.preview.map(|preview| preview.samples),
        predicted_rms_error: summary.predicted_rms_error,
        predicted_max_error: summary.predicted_max_error,
        predicted_rms_percent_of_stroke: summary.predicted_rms_percent_of_stroke,
        band,
        band_of_measurement,
        expected_rms_error,
        shown: super::scores_of_training(&model),
        findings: summary.findings,
        remarks: wanted.remarks,
        file: request.save.clone(),
        command,
    })
}

/// File of a reference that was drawn, beside its drive.
fn reference_beside(drive: &str) -> String {
    let stem = drive.rsplit_once('.').map_or(drive, |(stem, _)| stem);
    format!("{stem}-reference.csv")
}

fn save(
    workspace: &Workspace,
    file: &str,
    wanted: &Wanted,
    found: &InverseDrive,
    input: &str,
    request: &FollowRequest,
) -> Answer<()> {
    let time = TimeBase::uniform(wanted.rate);
    let symbol = wanted.unit.symbol();
    let channels = vec![
        Channel::new("u", input, found.drive.clone()),
        Channel::new("y", symbol, found.predicted.clone()),
        Channel::new("reference", symbol, wanted.samples.clone()),
    ];
    let record = Record::new(file, time, channels).map_err(Refused::cannot)?;
    workspace.keep_predicted(file, &record)?;
    if !matches!(request.reference, Reference::Record { .. }) {
        write_reference(workspace, &reference_beside(file), wanted)?;
    }
    workspace.look();
    Ok(())
}

/// The reference of a waveform or a drawing as a record, for the commands that repeat what was done.
fn write_reference(workspace: &Workspace, name: &str, wanted: &Wanted) -> Answer<()> {
    workspace.history.say_role(name, Role::Reference)?;
    let channels = vec![Channel::new("reference", wanted.unit.symbol(), wanted.samples.clone())];
    let record = Record::new(name, TimeBase::uniform(wanted.rate), channels).map_err(Refused::cannot)?;
    write_record(&workspace.path(name)?, &record).map_err(Refused::failed)
}

/// Controllers that follow a reference on the simulated bench or the model itself.
///
/// # Errors
/// If the model or the reference leave nothing to simulate.
pub(crate) fn track(
    workspace: &Workspace,
    id: &str,
    request: &TrackRequest,
    listener: Listener<'_>,
) -> Answer<Tracked> {
    let model = workspace.model(id)?;
    let body = model.hammerstein(Capability::Tracking).map_err(Refused::cannot)?;
    let wanted = wanted(workspace, &model, &request.reference)?;
    let time = TimeBase::uniform(wanted.rate);
    let reference = Signal {
        samples: wanted.samples.clone(),
        unit: wanted.unit.clone(),
        name: wanted.name.clone(),
        time: time.clone(),
        notes: Vec::new(),
    };
    let truth = Truth { dac: Dac::Hold, ..request.truth.clone().unwrap_or_default() };
    let bench = RigStage { truth: &truth, seed: request.seed, stream: 0 };
    let plant = if request.on_model {
        let words = "the model itself, simulated without noise".to_owned();
        (Plant::Model, PlantDescription { name: "model", words })
    } else {
        let words = format!("the simulated bench ({})", truth.describe());
        (Plant::Stage(&bench), PlantDescription { name: "rig", words })
    };
    let input = Unit::new(&body.data().units.input);
    let found = play(body, &reference, &request.options, plant, listener)
        .map_err(|e| Refused::cannot(Problem::new(e.in_units(&input, &reference.unit), None)))?;
    let summary = found.summary();
    let pixels = request.pixels.unwrap_or(PIXELS);
    let draw = |name: &str, unit: &Unit, samples: &[f64]| {
        over_time(&time, &Along::new(name, unit, samples), 0..samples.len(), pixels)
    };
    let controllers = found.runs.iter().zip(&summary.controllers).map(|(run, about)| {
        let ControllerRun { controller, played, .. } = run;
        let error: Vec<f64> = found.reference.iter().zip(&played.displacement).map(|(r, y)| r - y).collect();
        TrackedController {
            name: controller.name().to_owned(),
            summary: controller.summary().to_owned(),
            rms: about.rms,
            max: about.max,
            rms_percent_of_stroke: about.rms_percent_of_stroke,
            runs_away: about.runs_away,
            bandwidth_hz: about.answer.minus_3_db_played_hz,
            gain_margin: about.answer.gain_margin,
            phase_margin_deg: about.answer.phase_margin_deg,
            samples_held_back: about.answer.samples_at_range + about.answer.samples_at_slew,
            curves: TrackedCurve {
                drive: draw("drive", &found.input, &played.drive),
                error: draw("reference − displacement", &found.output, &error),
            },
        }
    });
    let left_out = found.left_out.iter().map(|(controller, e)| format!("{}: {e}", controller.name()));
    let file = request.save.as_deref().unwrap_or("track.csv");
    let reference = match &request.reference {
        Reference::Record { id, .. } => id.clone(),
        _ => reference_beside(file),
    };
    let command = command::track(id, request, &reference);
    if let Some(file) = &request.save {
        workspace.keep_predicted(file, &found.to_record(file).map_err(Refused::cannot)?)?;
        if !matches!(request.reference, Reference::Record { .. }) {
            write_reference(workspace, &reference, &wanted)?;
        }
        workspace.history.add_action(&command)?;
        workspace.look();
    }
    Ok(Tracked {
        plant: found.plant.words.clone(),
        output_unit: found.output.to_string(),
        sample_rate_hz: wanted.rate,
        scored_s: [summary.scored_from_s, summary.scored_to_s],
        controllers: controllers.collect(),
        left_out: left_out.collect(),
        file: request.save.clone(),
        command,
    })
}
