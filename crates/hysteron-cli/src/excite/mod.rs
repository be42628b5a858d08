//! `hysteron excite`: drive waveforms for an identification campaign.

mod waves;

use clap::Args;
use hysteron_io::write_record;
use hysteron_numeric::display::short;
use hysteron_rig::excitation::{AmplifierLimits, ExcitationSpec, ExcitationSummary};
use serde::Serialize;

use crate::console;
use crate::failure::Failure;
use crate::numbers::{not_negative, number, positive, whole};
use crate::output::{self, OutFile};
use waves::Wave;

/// Write a drive waveform as a record t_s,u_V ready for a DAQ.
#[derive(Args)]
#[command(
    after_help = "Example: hysteron excite sweep --from 1 --to 100 --duration 10 --sample-rate 10000 --high \
    10 -o sweep.csv\n\n\
    A campaign needs at least a slow loop (nested-loops) and something fast (sweep or multisine). hysteron \
    excite WAVEFORM --help explains each waveform."
)]
pub struct Excite {
    #[command(subcommand)]
    wave: Wave,
}

/// Options common to all waveforms.
#[derive(Args, Clone, Debug)]
pub struct Drive {
    /// Sample rate in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    sample_rate: f64,

    /// Lowest voltage
    #[arg(
        long, value_name = "VOLTS", default_value_t = 0.0, value_parser = number, allow_hyphen_values = true,
    )]
    low: f64,

    /// Highest voltage
    #[arg(long, value_name = "VOLTS", value_parser = number, allow_hyphen_values = true)]
    high: f64,

    /// Seconds of smooth lead-in from 0 V to the first sample
    #[arg(
        long, value_name = "SECONDS", default_value_t = 0.0, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    soft_start: f64,

    /// Seconds of smooth lead-out from the last sample to 0 V
    #[arg(
        long, value_name = "SECONDS", default_value_t = 0.0, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    soft_end: f64,

    /// Seed of the random numbers
    #[arg(
        long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// File to write
    #[arg(short, long = "out", value_name = "OUT.csv|npz|mat")]
    out: OutFile,

    /// Print what was written as one JSON object: length, range, slew, excited and detection lines
    #[arg(long)]
    json: bool,

    /// Lowest voltage of the amplifier
    #[arg(
        long,
        value_name = "VOLTS",
        value_parser = number, allow_hyphen_values = true,
        help_heading = "Limits of the amplifier"
    )]
    amplifier_low: Option<f64>,

    /// Highest voltage of the amplifier
    #[arg(
        long,
        value_name = "VOLTS",
        value_parser = number, allow_hyphen_values = true,
        help_heading = "Limits of the amplifier"
    )]
    amplifier_high: Option<f64>,

    /// Largest slew rate of the amplifier in V/s
    #[arg(
        long, value_name = "V/S", value_parser = positive, allow_hyphen_values = true,
        help_heading = "Limits of the amplifier",
    )]
    max_slew: Option<f64>,

    /// Largest current of the amplifier in A; needs --capacitance
    #[arg(
        long, value_name = "AMPERES", value_parser = positive, allow_hyphen_values = true,
        requires = "capacitance", help_heading = "Limits of the amplifier",
    )]
    max_current: Option<f64>,

    /// Capacitance of the actuator in F
    #[arg(
        long, value_name = "FARADS", value_parser = positive, allow_hyphen_values = true,
        help_heading = "Limits of the amplifier",
    )]
    capacitance: Option<f64>,
}

/// JSON output: the file written and a summary of its drive.
#[derive(Serialize)]
struct Written {
    file: String,
    #[serde(flatten)]
    drive: ExcitationSummary,
}

impl Excite {
    pub fn run(&self) -> Result<(), Failure> {
        let (waveform, drive) = self.wave.waveform();
        output::check_file("the waveform", &drive.out)?;
        let spec = ExcitationSpec {
            soft_start_s: drive.soft_start,
            soft_end_s: drive.soft_end,
            seed: drive.seed,
            ..ExcitationSpec::new(drive.sample_rate, drive.low, drive.high, waveform)
        };
        let excitation = spec.generate().map_err(|e| {
            Failure::new("cannot make the waveform")
                .because(e)
                .hint("hysteron excite WAVEFORM --help explains what each number means")
        })?;
        drive.limits().check(&excitation).map_err(|e| {
            Failure::new("the amplifier cannot play the waveform")
                .because(e)
                .hint("slow it down, or make the range smaller")
        })?;
        write_record(&drive.out, &excitation.to_record()).map_err(|e| {
            Failure::new(format!("cannot write the waveform to {}", drive.out.display())).because(e)
        })?;
        let written = Written { file: drive.out.display().to_string(), drive: excitation.summary() };
        let summary = &written.drive;
        console::message(&format!(
            "wrote {}: {}; {} samples, {} s, {} V to {} V, at most {} V/s, crest factor {:.3}",
            written.file,
            summary.description,
            summary.samples,
            summary.duration_s,
            short(summary.low_v),
            short(summary.high_v),
            short(summary.max_slew_v_per_s),
            summary.crest_factor,
        ));
        if drive.json { console::json(&written) } else { Ok(()) }
    }
}

impl Drive {
    fn limits(&self) -> AmplifierLimits {
        let none = AmplifierLimits::default();
        AmplifierLimits {
            low_v: self.amplifier_low.unwrap_or(none.low_v),
            high_v: self.amplifier_high.unwrap_or(none.high_v),
            slew_v_per_s: self.max_slew,
            current_a: self.max_current,
            capacitance_f: self.capacitance,
        }
    }
}
