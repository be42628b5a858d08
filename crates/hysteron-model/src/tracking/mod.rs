//! A reference followed by several controllers on one plant, each with its error, bandwidths, margins and
//! adaptation.
//!
//! [`track`] designs every controller from the model ([`crate::control`]), plays it on the plant, scores its
//! tracking error and measures its bandwidth with sines.

mod controller;
mod options;
mod run;
mod summary;

use std::ops::Range;

use hysteron_numeric::Listener;
use rayon::prelude::*;

use crate::control::{ControlError, Loop, LoopSettings, Plant, Reach, Sines, reach};
use crate::hammerstein;
use crate::invert::InverseOptions;
use crate::model::Body;
use crate::model_file::ModelFile;
use crate::record::{Channel, Record, RecordError, Signal, TimeBase, Unit, range_of};
use run::Rehearsal;

pub use controller::{Controller, ControllerFamily, ReferenceKnowledge};
pub use options::TrackOptions;
pub use run::{Adaptation, ControllerRun, differ};
pub use summary::{AdaptationSummary, ControllerSummary, LoopAnswer, SineSummary, TrackingSummary, law};

/// Stages of tracking, and the share of the time that the first takes.
const DESIGN: &str = "design of the controllers";
const SIMULATION: &str = "simulation of the controllers";
const SHARE_OF_DESIGN: f64 = 0.3;
/// Shares of the stroke in the table of amplitudes.
const AMPLITUDES: [f64; 5] = [0.05, 0.1, 0.25, 0.5, 1.0];

/// A reference followed by several controllers. Everything is simulated unless the plant is not.
///
/// As JSON: every controller with errors, bandwidths, margins and adaptation, units in the keys.
#[derive(Debug)]
pub struct Tracking {
    /// Name of the reference.
    pub name: String,
    /// Plant that was driven.
    pub plant: PlantDescription,
    /// The controllers' rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Reference, in the unit of the output.
    pub reference: Vec<f64>,
    /// Samples that are scored.
    pub scored: Range<usize>,
    /// Limits and margins.
    pub settings: LoopSettings,
    /// Sines by which bandwidths were measured; `None` where the reference does not move.
    pub sines: Option<Sines>,
    /// Highest frequency against amplitude where the rate of the drive is limited.
    pub reach: Vec<Reach>,
    /// Every controller.
    pub runs: Vec<ControllerRun>,
    /// Controllers that could not be designed or played, where all were requested.
    pub left_out: Vec<(Controller, ControlError)>,
    /// Unit of the drive.
    pub input: Unit,
    /// Unit of the displacement.
    pub output: Unit,
}

impl Tracking {
    /// The samples as a record: reference, and drive and displacement by each controller.
    ///
    /// # Errors
    /// Those of [`Record::new`].
    pub fn to_record(&self, name: &str) -> Result<Record, RecordError> {
        let (input, output) = (self.input.symbol(), self.output.symbol());
        let mut channels = vec![Channel::new("reference", output, self.reference.clone())];
        for run in &self.runs {
            let name = run.controller.name();
            channels.push(Channel::new(&format!("u_{name}"), input, run.played.drive.clone()));
            channels.push(Channel::new(&format!("y_{name}"), output, run.played.displacement.clone()));
        }
        Record::new(name, TimeBase::uniform(self.sample_rate_hz), channels)
    }
}

/// Name and description of a plant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlantDescription {
    /// `rig`, `model`.
    pub name: &'static str,
    /// A description in words.
    pub words: String,
}

/// Plays every controller of `options` on `plant`. `reference` is in the unit of the model's output and
/// uniformly sampled.
///
/// # Errors
/// [`ControlError`]: a reference or options that leave nothing to play; a requested controller that cannot be
/// designed or played (where all are requested, it is left out instead, unless none remains).
pub fn track(
    model: &Body<ModelFile, hammerstein::Model>,
    reference: &Signal,
    options: &TrackOptions,
    plant: (Plant<'_>, PlantDescription),
) -> Result<Tracking, ControlError> {
    track_told(model, reference, options, plant, Listener::silent())
}

/// [`track`], with its progress told to `listener`.
///
/// # Errors
/// Those of [`track`]; [`ControlError::Stopped`] where the listener ends it.
pub fn track_told(
    model: &Body<ModelFile, hammerstein::Model>,
    reference: &Signal,
    options: &TrackOptions,
    (plant, description): (Plant<'_>, PlantDescription),
    listener: Listener<'_>,
) -> Result<Tracking, ControlError> {
    let TimeBase::Uniform { sample_rate_hz, .. } = reference.time else {
        return Err(ControlError::NoSampleRate);
    };
    let samples = &reference.samples;
    let settings = options.settings(model, sample_rate_hz)?;
    let knowledge = options.knowledge(samples, sample_rate_hz);
    let all = options.controllers.is_empty();
    let asked = if all { &Controller::ALL[..] } else { &options.controllers };
    let mut left_out = Vec::new();
    let designs = listener.part(0.0, SHARE_OF_DESIGN).meter(DESIGN, asked.len());
    listener.tell(DESIGN, 0.0)?;
    let made = |c: &Controller| {
        // A design takes seconds: it asks on its way whether to go on.
        let made = Loop::new_while(&|| designs.add(0), model.law(), &settings, &c.strategy(&knowledge));
        (*c, designs.add(1).map_err(ControlError::from).and(made))
    };
    let loops = sorted_out(asked.par_iter().map(made).collect(), all, &mut left_out)?;
    let scored = options.scored(&loops, samples.len(), sample_rate_hz)?;
    let sines = options.sines(&samples[scored.clone()], sample_rate_hz)?;
    let [low, high] = settings.range_v;
    let rehearsal = Rehearsal {
        plant,
        virgin_v: options.virgin_v.or(InverseOptions::switched_on([low, high])),
        reference: samples,
        scored: &scored,
        sines,
    };
    let work = loops.iter().map(|(_, made)| rehearsal.samples(made)).sum();
    let meter = listener.part(SHARE_OF_DESIGN, 1.0).meter(SIMULATION, work);
    let played = |(c, made): &(Controller, Loop)| (*c, rehearsal.run(*c, made, &meter));
    let runs = sorted_out(loops.par_iter().map(played).collect(), all, &mut left_out)?;
    let runs: Vec<ControllerRun> = runs.into_iter().map(|(_, run)| run).collect();
    Ok(Tracking {
        name: reference.name.clone(),
        plant: description,
        sample_rate_hz,
        reach: reaches(&runs, samples, &settings),
        reference: samples.clone(),
        scored,
        settings,
        sines,
        runs,
        left_out,
        input: Unit::new(&model.data().units.input),
        output: reference.unit.clone(),
    })
}

/// The successful ones; none after a stop. Where all controllers were requested, failed ones are left out, unless none remains;
/// else the first error.
fn sorted_out<T>(
    outcomes: Vec<(Controller, Result<T, ControlError>)>,
    all: bool,
    left_out: &mut Vec<(Controller, ControlError)>,
) -> Result<Vec<(Controller, T)>, ControlError> {
    let mut sound = Vec::new();
    for (controller, outcome) in outcomes {
        match outcome {
            Ok(one) => sound.push((controller, one)),
            Err(ControlError::Stopped) => return Err(ControlError::Stopped),
            Err(e) if all => left_out.push((controller, e)),
            Err(e) => return Err(e),
        }
    }
    match left_out.pop() {
        Some((_, e)) if sound.is_empty() => Err(e),
        last => {
            left_out.extend(last);
            Ok(sound)
        }
    }
}

fn reaches(runs: &[ControllerRun], reference: &[f64], settings: &LoopSettings) -> Vec<Reach> {
    let Some(run) = runs.first().filter(|_| settings.slew_v_per_s.is_finite()) else { return Vec::new() };
    let (low, high) = range_of(reference);
    let (line, dynamics) = (&run.made.line, &run.made.dynamics);
    let of = |share: &f64| {
        let amplitude = 0.5 * share * (high - low);
        reach(line, dynamics, settings.sample_rate_hz, settings.range_v, settings.slew_v_per_s, amplitude)
    };
    AMPLITUDES.iter().map(of).collect()
}
