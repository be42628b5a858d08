//! `hysteron track`: a reference followed sample by sample, without compensation, by feedforward, by feedback and by both.

mod controllers;
mod report;
mod runs;
mod sheets;
mod summary;
mod text;

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hysteron_io::write_csv;
use hysteron_model::compensator::CompensatorError;
use hysteron_model::control::{
    ControlError, Loop, LoopSettings, Plant, Reach, Sines, TuningError, Wanted, reach, slew_of_current,
};
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::realise::{RealiseError, RealiseOptions};
use hysteron_model::record::{Channel, Record, TimeBase, Unit, shortest_swing};
use hysteron_numeric::display::short;
use hysteron_rig::{Dac, RigStage, Truth};
use rayon::prelude::*;
use serde::Serialize;

use crate::columns::ReferenceFlags;
use crate::console;
use crate::failure::Failure;
use crate::invert::range;
use crate::model::LoadedModel;
use crate::numbers::{ends, not_negative, number, positive, whole};
use crate::output::{self, OutFile};
use crate::realise::where_creep_stops;
use crate::result_flags::ResultFlags;
use crate::rig::read_or_default;
use controllers::{Controller, Known};
use runs::{Rehearsal, Run};

/// Follow a reference in closed loop on the simulated bench or on the model itself, and say what each controller leaves
#[derive(Args)]
#[command(
    after_help = "Everything is simulated. The reference's sample rate is the controller's; each voltage is held for one period, and the reading at the \
    beginning of one period makes the drive of the next. Before the reference the stage rests at its first value, where its sensor is zeroed; errors are \
    those of the displacement, not of the reading, their mean taken off.\n\n\
    Feedback is tuned from the model: of the laws that keep --gain-margin, --phase-margin and a sensitivity of at most 2, the one that leaves least of a \
    wandering disturbance. Where the model was identified up to a frequency only, the loop's gain stays below 1/(gain margin) above it.\n\n\
    Example: hysteron track model.json scan.csv --plant rig --range 0:10.5 --report track.html\n\
    Example: hysteron track model.json scan.csv --controller feedforward --controller feedforward-pi --current 100 --capacitance 10"
)]
pub struct Track {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// File with the reference, in the unit of the model's output
    #[arg(value_name = "REFERENCE.csv")]
    reference_file: PathBuf,

    /// What is driven: the simulated bench, or the model itself without noise
    #[arg(long, value_enum, default_value_t = PlantArg::Rig)]
    plant: PlantArg,

    /// What the bench really is: JSON, as of hysteron rig; its converter holds here
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,

    /// Seed of the bench's noise
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_hyphen_values = true)]
    seed: u64,

    /// Controller to play (repeatable) [default: all]
    #[arg(long = "controller", value_enum)]
    controllers: Vec<Controller>,

    /// Samples of the reference known ahead, for the controllers that are given some [default: as many as make a difference]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true)]
    preview: Option<usize>,

    /// Highest frequency of the reference in Hz, for the controllers that predict it [default: that of its fastest swing]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    predict_to: Option<f64>,

    /// Frequency up to which the inverse follows, in Hz [default: a twentieth of the sample rate]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    bandwidth: Option<f64>,

    /// Least and largest drive [default: the range the model was identified in]
    #[arg(long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,

    /// Largest rate of the drive, in its unit per second [default: none]
    #[arg(long, value_name = "PER_SECOND", value_parser = positive, allow_hyphen_values = true)]
    slew: Option<f64>,

    /// The amplifier's largest current in mA, which limits the rate of the drive by --capacitance
    #[arg(long, value_name = "MA", value_parser = positive, allow_hyphen_values = true, requires = "capacitance", conflicts_with = "slew")]
    current: Option<f64>,

    /// The actuator's capacitance in µF
    #[arg(long, value_name = "UF", value_parser = positive, allow_hyphen_values = true, requires = "current")]
    capacitance: Option<f64>,

    /// Voltage at which the device was without hysteresis memory before it was driven to where it rests [default: 0, where
    /// --range holds it, else where it rests]
    #[arg(long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true)]
    virgin_voltage: Option<f64>,

    /// Least gain margin of the feedback, a factor
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0, value_parser = factor, allow_hyphen_values = true)]
    gain_margin: f64,

    /// Least phase margin of the feedback, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = positive, allow_hyphen_values = true)]
    phase_margin: f64,

    /// Lowest frequency in Hz of creep that never ends, below which it stops [default: a thousandth of the lowest of the model's records]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    lowest_frequency: Option<f64>,

    /// Seconds at the beginning that are not scored [default: a quarter of the reference]; at the end it is what is known ahead
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    skip: Option<f64>,

    /// Lowest and highest of the sines by which the bandwidths are measured, in Hz; they have the stroke and the middle of the reference where it is scored [default: 1e-4 to
    /// 0.1 of the sample rate]
    #[arg(long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true)]
    sines: Option<[f64; 2]>,

    /// File to write: reference, and drive and displacement by each controller
    #[arg(short, long = "out", value_name = "TRACK.csv")]
    out: Option<OutFile>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    columns: ReferenceFlags,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
enum PlantArg {
    Rig,
    Model,
}

fn factor(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|x| *x > 1.0).ok_or_else(|| "expected a number above 1".into())
}

/// Stroke shares of the table of amplitudes.
const AMPLITUDES: [f64; 5] = [0.05, 0.1, 0.25, 0.5, 1.0];
/// Highest frequency that is predicted, as a share of the sample rate.
const MOST_PREDICTED: f64 = 0.25;
/// Samples that are scored, at least.
const LEAST_SCORED: usize = 10;
/// Lowest and highest sine, as shares of the sample rate.
const SINES: [f64; 2] = [1e-4, 0.1];

/// All there is to say.
pub struct Found {
    name: String,
    plant: PlantArg,
    plant_words: String,
    sample_rate_hz: f64,
    reference: Vec<f64>,
    scored: Range<usize>,
    settings: LoopSettings,
    sines: Option<Sines>,
    reach: Vec<Reach>,
    runs: Vec<Run>,
    input: Unit,
    output: Unit,
}

impl Track {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(out) = &self.out {
            output::check_file("the samples", out)?;
        }
        self.result.check()?;
        let model = LoadedModel::read(&self.model, Capability::Tracking)?;
        let reference = self.columns.read(&self.reference_file)?;
        let unit = model.agreed_unit(&self.reference_file, SignalRole::Reference, &reference.unit)?;
        let TimeBase::Uniform { sample_rate_hz, .. } = reference.time else {
            return Err(self
                .failure()
                .because("the reference has no uniform sample rate, which is to be the controller's")
                .hint("give the sample rate with --sample-rate HZ, or a time column of even steps"));
        };
        let settings = self.settings(&model, sample_rate_hz)?;
        let loops = self.loops(&model, &reference.samples, &settings)?;
        let scored = self.scored(&loops, reference.samples.len(), sample_rate_hz)?;
        let sines = self.sines(&reference.samples[scored.clone()], sample_rate_hz)?;
        let runs = self.play_all(&loops, &reference.samples, &settings, &scored, sines)?;
        let found = Found {
            name: self.reference_file.display().to_string(),
            plant: self.plant,
            plant_words: self.plant_words()?,
            sample_rate_hz,
            scored,
            reach: self.reaches(&runs, &reference.samples, &settings),
            reference: reference.samples,
            sines,
            settings,
            runs,
            input: Unit::new(&model.file().units.input),
            output: unit,
        };
        self.write(reference.time, &found)?;
        self.result.write(|| report::page(&found))?;
        if self.result.json {
            console::json(&summary::summary(&found))
        } else {
            console::result(&text::text(&found))
        }
    }

    fn failure(&self) -> Failure {
        Failure::new(format!("cannot follow {} with {}", self.reference_file.display(), self.model.display()))
    }

    fn settings(&self, model: &LoadedModel, sample_rate_hz: f64) -> Result<LoopSettings, Failure> {
        let valid = model.file().valid_range.as_ref();
        let range_v = match (self.range, valid) {
            (Some(range), _) => range,
            (None, Some(valid)) => [valid.input.low, valid.input.high],
            (None, None) => {
                return Err(self
                    .failure()
                    .because("the model file does not say which voltages it was identified with")
                    .hint("give the range of the drive, e.g. --range 0:100"));
            }
        };
        let of_current =
            self.current.zip(self.capacitance).map(|(ma, uf)| slew_of_current(1e-3 * ma, 1e-6 * uf));
        let trusted_to_hz = valid.and_then(|valid| valid.frequency.as_ref()).map(|f| f.high);
        Ok(LoopSettings {
            sample_rate_hz,
            range_v,
            slew_v_per_s: self.slew.or(of_current).unwrap_or(f64::INFINITY),
            wanted: Wanted {
                gain: self.gain_margin,
                phase_deg: self.phase_margin,
                trusted_to_hz,
                ..Wanted::default()
            },
            realise: where_creep_stops(
                model,
                sample_rate_hz,
                RealiseOptions { lowest_frequency_hz: self.lowest_frequency, ..RealiseOptions::default() },
            ),
        })
    }

    fn truth(&self) -> Result<Truth, Failure> {
        let truth: Truth = read_or_default(self.truth.as_deref(), "truth")?;
        Ok(Truth { dac: Dac::Hold, ..truth })
    }

    fn plant_words(&self) -> Result<String, Failure> {
        Ok(match self.plant {
            PlantArg::Rig => format!("the simulated bench ({})", self.truth()?.describe()),
            PlantArg::Model => "the model itself, simulated without noise".to_owned(),
        })
    }

    /// The samples that are scored: behind --skip, and before the end by what is known ahead, as what comes behind the end is known to no one.
    fn scored(
        &self,
        loops: &[(Controller, Loop)],
        samples: usize,
        sample_rate_hz: f64,
    ) -> Result<Range<usize>, Failure> {
        let from = self.skip.map_or(samples / 4, |seconds| (seconds * sample_rate_hz) as usize);
        let ahead = loops.iter().filter_map(|(_, made)| made.inverse.as_ref()).map(|inverse| inverse.preview);
        let to = samples - ahead.max().unwrap_or(0).min(samples);
        if from + LEAST_SCORED > to {
            return Err(Failure::usage(format!(
                "nothing is left to score: the reference has {samples} samples, {from} of them skipped at its beginning (--skip) and {} at its end, where \
                 what is to be known ahead (--preview) is not there",
                samples - to
            )));
        }
        Ok(from..to)
    }

    /// The sines that are played, about the middle of what is scored of the reference and as large; none where it does not move.
    fn sines(&self, reference: &[f64], sample_rate_hz: f64) -> Result<Option<Sines>, Failure> {
        let range_hz = self.sines.unwrap_or(SINES.map(|share| share * sample_rate_hz));
        if !(range_hz[0] > 0.0 && range_hz[1] < 0.5 * sample_rate_hz) {
            return Err(Failure::usage(format!(
                "--sines must lie above 0 and below half the sample rate, {} Hz",
                short(0.5 * sample_rate_hz)
            )));
        }
        let lowest_hz = Sines::lowest_hz(sample_rate_hz);
        if range_hz[0] < lowest_hz {
            return Err(Failure::usage(format!(
                "--sines begins at {} Hz: at {} Hz the lowest that is played is {} Hz",
                short(range_hz[0]),
                short(sample_rate_hz),
                short(lowest_hz)
            ))
            .because("its period has a million samples"));
        }
        let (low, high) = ends(reference);
        let (level, amplitude) = (0.5 * (low + high), 0.5 * (high - low));
        Ok((amplitude > 0.0).then_some(Sines { level, amplitude, range_hz }))
    }

    /// Every controller made ready. One that cannot be made is an error where it was asked for, a remark where all were.
    fn loops(
        &self,
        model: &LoadedModel,
        reference: &[f64],
        settings: &LoopSettings,
    ) -> Result<Vec<(Controller, Loop)>, Failure> {
        let fastest_hz = settings.sample_rate_hz / (2.0 * shortest_swing(reference).max(1) as f64);
        let predict_to_hz =
            self.predict_to.unwrap_or(fastest_hz.min(MOST_PREDICTED * settings.sample_rate_hz));
        let known = Known { preview: self.preview, predict_to_hz, bandwidth_hz: self.bandwidth };
        let asked =
            if self.controllers.is_empty() { Controller::value_variants() } else { &self.controllers };
        let made = |c: &Controller| Loop::new(model.model(), settings, &c.strategy(&known));
        self.sorted_out(asked.par_iter().map(|c| (*c, made(c))).collect())
    }

    /// Every controller on the same plant.
    fn play_all(
        &self,
        loops: &[(Controller, Loop)],
        reference: &[f64],
        settings: &LoopSettings,
        scored: &Range<usize>,
        sines: Option<Sines>,
    ) -> Result<Vec<Run>, Failure> {
        let [low, high] = settings.range_v;
        let truth = self.truth()?;
        let bench = RigStage { truth: &truth, seed: self.seed, stream: 0 };
        let rehearsal = Rehearsal {
            plant: match self.plant {
                PlantArg::Rig => Plant::Stage(&bench),
                PlantArg::Model => Plant::Model,
            },
            virgin_v: self.virgin_voltage.or((low <= 0.0 && 0.0 <= high).then_some(0.0)),
            reference,
            scored,
            sines,
        };
        let outcomes = loops.par_iter().map(|(c, made)| (*c, rehearsal.run(*c, made))).collect();
        Ok(self.sorted_out(outcomes)?.into_iter().map(|(_, run)| run).collect())
    }

    fn sorted_out<T>(
        &self,
        outcomes: Vec<(Controller, Result<T, ControlError>)>,
    ) -> Result<Vec<(Controller, T)>, Failure> {
        let mut sound = Vec::new();
        let mut last = None;
        for (controller, outcome) in outcomes {
            match outcome {
                Ok(one) => sound.push((controller, one)),
                Err(e) if self.controllers.is_empty() => {
                    console::note(&format!("{} is left out: {e}", controller.name()));
                    last = Some(e);
                }
                Err(e) => return Err(self.explained(&e)),
            }
        }
        match last {
            Some(e) if sound.is_empty() => Err(self.explained(&e)),
            _ => Ok(sound),
        }
    }

    fn explained(&self, error: &ControlError) -> Failure {
        let failure = self.failure().because(error);
        let realise = match error {
            ControlError::Begins(_) => {
                return failure.hint("change the reference's offset, or widen --range");
            }
            ControlError::Realise(e)
            | ControlError::Compensator(CompensatorError::Realise(e))
            | ControlError::Tuning(TuningError::Realise(e)) => e,
            _ => return failure,
        };
        if matches!(realise, RealiseError::LowestFrequency) {
            failure.hint("say where creep stops with --lowest-frequency HZ, e.g. 0.01")
        } else {
            failure
        }
    }

    fn reaches(&self, runs: &[Run], reference: &[f64], settings: &LoopSettings) -> Vec<Reach> {
        let Some(run) = runs.first().filter(|_| settings.slew_v_per_s.is_finite()) else { return Vec::new() };
        let (low, high) = ends(reference);
        let own = |share: &f64| {
            let amplitude = 0.5 * share * (high - low);
            let (line, dynamics) = (&run.made.line, &run.made.dynamics);
            reach(line, dynamics, settings.sample_rate_hz, settings.range_v, settings.slew_v_per_s, amplitude)
        };
        AMPLITUDES.iter().map(own).collect()
    }

    fn write(&self, time: TimeBase, found: &Found) -> Result<(), Failure> {
        let Some(out) = &self.out else { return Ok(()) };
        let failure = || Failure::new(format!("cannot write the samples to {}", out.display()));
        let (input, output) = (found.input.symbol(), found.output.symbol());
        let mut channels = vec![Channel::new("reference", output, found.reference.clone())];
        for run in &found.runs {
            let name = run.controller.name();
            channels.push(Channel::new(&format!("u_{name}"), input, run.played.drive.clone()));
            channels.push(Channel::new(&format!("y_{name}"), output, run.played.displacement.clone()));
        }
        let record =
            Record::new(&out.display().to_string(), time, channels).map_err(|e| failure().because(e))?;
        write_csv(out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!(
            "wrote {} simulated samples of {} controllers to {}",
            short(record.len() as f64),
            found.runs.len(),
            out.display()
        ));
        Ok(())
    }
}
