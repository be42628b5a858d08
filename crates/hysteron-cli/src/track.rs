//! `hysteron track`: a reference followed sample by sample, without compensation, by feedforward, by feedback
//! and by both.

mod several;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hysteron_identify::Listener;
use hysteron_model::Advice;
use hysteron_model::control::{ControlError, Plant, RequiredMargins, slew_of_current};
use hysteron_model::invert::InversionError;
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::realise::{RealiseError, RealiseOptions};
use hysteron_model::record::{Signal, TimeBase, Unit};
use hysteron_model::tracking::{Controller, PlantDescription, TrackOptions, Tracking, track_told};
use hysteron_numeric::display::short;
use hysteron_report::tracking as report;
use hysteron_rig::{Dac, RigStage, Truth};

use crate::axes::AxesReferenceFlags;
use crate::choices::one_of;
use crate::columns::ReferenceFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::invert::range;
use crate::maker::maker;
use crate::model::{Loaded, LoadedModel};
use crate::numbers::{not_negative, number, positive, whole};
use crate::output::{self, OutFile};
use crate::outputs::Outputs;
use crate::progress;
use crate::remarks;
use crate::result_flags::ResultFlags;
use crate::rig::read_or_default;

/// Simulate tracking of a reference by each controller, on the simulated bench or on the model itself, and
/// compare errors
#[derive(Args)]
#[command(
    after_help = "Everything is simulated. The reference's sample rate is the controller's; each voltage is \
    held for one period, and the reading at the beginning of one period determines the drive of the next. \
    Before the reference the stage rests at its first value, where its sensor is zeroed; errors are those of \
    the true displacement, not of the reading, with their mean removed.\n\n\
    Feedback is tuned from the model: of the laws that keep --gain-margin, --phase-margin and a sensitivity \
    of at most 2, the one that best rejects a random-walk disturbance. Above the highest frequency in the \
    model's records, the loop gain stays below 1/(gain margin).\n\n\
    Example: hysteron track model.json scan.csv --plant rig --range 0:10.5 --report track.html\n\
    Example: hysteron track model.json scan.csv --controller feedforward --controller feedforward-pi \
    --current 100 --capacitance 10\n\n\
    With a model of several axes (modes) the bench is the one of rig --axes, and every axis' reference is \
    also played alone: the motion of the others is the cross-coupling."
)]
pub struct Track {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// File with the reference, in the unit of the model's output
    #[arg(value_name = "REFERENCE.csv")]
    reference_file: PathBuf,

    /// Plant: the simulated bench, or the model itself without noise
    #[arg(long, value_enum, default_value_t = PlantArg::Rig)]
    plant: PlantArg,

    /// True parameters of the simulated bench (JSON, as of hysteron rig); its converter is used
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,

    /// Seed of the bench's noise
    #[arg(
        long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// Controller to simulate (repeatable) [default: all]
    #[arg(long = "controller", value_parser = one_of(Controller::ALL, Controller::name, Controller::summary))]
    controllers: Vec<Controller>,

    /// Preview of the reference in samples, for the controllers that have one [default: as many as affect the
    /// drive]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true)]
    preview: Option<usize>,

    /// Highest frequency of the reference in Hz, for the controllers that predict it [default: that of its
    /// fastest swing]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    predict_to: Option<f64>,

    /// Frequency up to which the inverse follows, in Hz [default: a twentieth of the sample rate, for
    /// several axes at most of the rate of the model's steps]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    bandwidth: Option<f64>,

    /// Minimum and maximum drive, or one per actuator: LOW:HIGH,LOW:HIGH… [default: the range the model was
    /// identified in]
    #[arg(
        long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true,
        value_delimiter = ',',
    )]
    range: Vec<[f64; 2]>,

    /// Maximum slew rate of the drive, in its unit per second [default: none]
    #[arg(long, value_name = "PER_SECOND", value_parser = positive, allow_hyphen_values = true)]
    slew: Option<f64>,

    /// Maximum current of the amplifier in mA, which with --capacitance limits the slew rate of the drive
    #[arg(
        long, value_name = "MA", value_parser = positive, allow_hyphen_values = true,
        requires = "capacitance", conflicts_with = "slew",
    )]
    current: Option<f64>,

    /// The actuator's capacitance in µF
    #[arg(long, value_name = "UF", value_parser = positive, allow_hyphen_values = true, requires = "current")]
    capacitance: Option<f64>,

    /// Voltage at which the device was last demagnetised, before it moved to the voltage at rest [default: 0
    /// where --range contains it, else the voltage at rest]
    #[arg(long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true)]
    virgin_voltage: Option<f64>,

    /// Minimum gain margin of the feedback, as a factor
    #[arg(
        long, value_name = "FACTOR", default_value_t = 2.0, value_parser = factor, allow_hyphen_values = true,
    )]
    gain_margin: f64,

    /// Minimum phase margin of the feedback, in degrees
    #[arg(
        long, value_name = "DEGREES", default_value_t = 60.0, value_parser = positive,
        allow_hyphen_values = true,
    )]
    phase_margin: f64,

    /// Lowest frequency in Hz to realise, for unbounded creep [default: a thousandth of the lowest in the
    /// model's records]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    lowest_frequency: Option<f64>,

    /// Seconds at the beginning that are not scored [default: a quarter of the reference]; at the end the
    /// preview is not scored
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_hyphen_values = true)]
    skip: Option<f64>,

    /// Lowest and highest frequency of the sines by which bandwidths are measured, in Hz; their stroke and
    /// mean are those of the scored reference [default: 1e-4 to 0.1 of the sample rate]
    #[arg(long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true)]
    sines: Option<[f64; 2]>,

    /// File to write: reference, and drive and displacement by each controller
    #[arg(short, long = "out", value_name = "TRACK.csv")]
    out: Option<OutFile>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    columns: ReferenceFlags,

    #[command(flatten)]
    axes: AxesReferenceFlags,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PlantArg {
    Rig,
    Model,
}

fn factor(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|x| *x > 1.0).ok_or_else(|| "expected a number above 1".into())
}

impl Track {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(out) = &self.out {
            output::check_file("the samples", out)?;
        }
        self.result.check()?;
        let loaded = Loaded::read(&self.model)?;
        if loaded.model().channels().is_some() {
            return self.several_axes(&loaded);
        }
        self.refuse_flags_of_axes()?;
        let model = LoadedModel::of(loaded, Capability::Tracking)?;
        let reference = self.columns.read(&self.reference_file)?;
        let unit = model.agreed_unit(&self.reference_file, SignalRole::Reference, &reference.unit)?;
        if let TimeBase::Uniform { sample_rate_hz, .. } = reference.time {
            let told = model.body().remarks_on_reference(&reference.samples, sample_rate_hz);
            remarks::tell(&self.reference_file, model.model(), &told);
        }
        let name = self.reference_file.display().to_string();
        let reference = Signal { name, unit, ..reference };
        let truth: Truth = read_or_default(self.truth.as_deref(), "truth")?;
        let truth = Truth { dac: Dac::Hold, ..truth };
        let bench = RigStage { truth: &truth, seed: self.seed, stream: 0 };
        let plant = match self.plant {
            PlantArg::Rig => {
                let words = format!("the simulated bench ({})", truth.describe());
                (Plant::Stage(&bench), PlantDescription { name: "rig", words })
            }
            PlantArg::Model => {
                let words = "the model itself, simulated without noise".to_owned();
                (Plant::Model, PlantDescription { name: "model", words })
            }
        };
        let interrupt = Interrupt::listen("nothing is written")?;
        let watch = progress::watch(&interrupt);
        let found =
            track_told(model.body(), &reference, &self.options(), plant, Listener::new(&watch.teller()));
        drop(watch);
        let found = found.map_err(|e| match e {
            ControlError::Stopped => interrupt.told(Failure::new("the simulation was interrupted")),
            e => {
                self.explained(&e, &e.in_units(&Unit::new(&model.body().data().units.input), &reference.unit))
            }
        })?;
        for (controller, error) in &found.left_out {
            console::note(&format!("{} is left out: {error}", controller.name()));
        }
        let mut outputs = Outputs::default();
        self.add_samples(&mut outputs, &found)?;
        self.result.add(&mut outputs, || report::page(&found, &maker()))?;
        outputs.finish()?;
        if self.result.json { console::json(&found) } else { console::result(&text(&found)) }
    }

    fn options(&self) -> TrackOptions {
        let of_current =
            self.current.zip(self.capacitance).map(|(ma, uf)| slew_of_current(1e-3 * ma, 1e-6 * uf));
        TrackOptions {
            controllers: self.controllers.clone(),
            preview: self.preview,
            predict_to_hz: self.predict_to,
            bandwidth_hz: self.bandwidth,
            range: self.range.first().copied(),
            slew_per_s: self.slew.or(of_current).unwrap_or(f64::INFINITY),
            virgin_v: self.virgin_voltage,
            margins: RequiredMargins {
                gain: self.gain_margin,
                phase_deg: self.phase_margin,
                ..RequiredMargins::default()
            },
            realise: RealiseOptions {
                lowest_frequency_hz: self.lowest_frequency,
                ..RealiseOptions::default()
            },
            skip_s: self.skip,
            sines_hz: self.sines,
        }
    }

    fn explained(&self, error: &ControlError, words: &str) -> Failure {
        let because = |failure: Failure| failure.because(words);
        let failure = because(Failure::new(format!(
            "cannot follow {} with {}",
            self.reference_file.display(),
            self.model.display()
        )));
        let realise = match error {
            ControlError::NoSampleRate => return failure.advised(Some(Advice::Resample)),
            ControlError::NoRange => return failure.hint("give the range of the drive, e.g. --range 0:100"),
            ControlError::NothingScored { .. } => {
                return because(Failure::usage("cannot score the motion")).hint("reduce --skip or --preview");
            }
            ControlError::Sines { .. } | ControlError::SlowSines { .. } => {
                return because(Failure::usage("--sines cannot be simulated"));
            }
            ControlError::Inversion(InversionError::Begins { .. } | InversionError::Falls { .. }) => {
                return failure.hint("change the reference's offset, or widen --range");
            }
            ControlError::Realise(e) | ControlError::Inversion(InversionError::Realise(e)) => e,
            _ => return failure,
        };
        if matches!(realise, RealiseError::LowestFrequency) {
            failure.hint("give the lowest frequency of creep with --lowest-frequency HZ, e.g. 0.01")
        } else {
            failure
        }
    }

    fn add_samples(&self, outputs: &mut Outputs, found: &Tracking) -> Result<(), Failure> {
        let Some(out) = &self.out else { return Ok(()) };
        let failure = || Failure::new(format!("cannot write the samples to {}", out.display()));
        let record = found.to_record(&out.display().to_string()).map_err(|e| failure().because(e))?;
        outputs.add_record("the samples", out, &record)?;
        outputs.tell(format!(
            "wrote {} simulated samples of {} controllers to {}",
            short(record.len() as f64),
            found.runs.len(),
            out.display()
        ));
        Ok(())
    }
}

fn text(found: &Tracking) -> String {
    let mut out = format!("{}\n\n", report::introduction(found));
    let put = |out: &mut String, words: &str, table: Option<report::TextTable>| {
        if let Some(table) = table {
            if !words.is_empty() {
                *out += &format!("\n{words}\n\n");
            }
            *out += &format!("{}\n", for_terminal(table));
        }
    };
    put(&mut out, "", report::errors(found));
    if let Some(words) = report::of_runaways(found) {
        out += &format!("\nverdict: {words} (--gain-margin)\n");
    }
    put(&mut out, &report::of_bandwidths(found), report::bandwidths(found));
    put(&mut out, "Margins of the feedback on the identified model:", report::margins(found));
    put(&mut out, report::OF_ADAPTATIONS, report::adaptations(found));
    put(&mut out, "Highest sine frequency within the slew-rate limit, by formula:", report::reaches(found));
    out
}

fn for_terminal(table: report::TextTable) -> String {
    let header: Vec<String> = table.columns.iter().map(|(name, unit)| console::in_unit(name, unit)).collect();
    let mut shown = console::table(&header.iter().map(String::as_str).collect::<Vec<_>>());
    shown.add_rows(table.rows);
    shown.to_string()
}
