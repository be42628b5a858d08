//! `hysteron design`: the next drive, by the information that its record will carry.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hysteron_identify::design::{Design, DesignBasis, DesignOptions, DesignSummary, Purpose, design};
use hysteron_identify::structure::Prospects;
use hysteron_identify::{CampaignRecord, FitRecords, IdentifyError, Listener, Task, fit};
use hysteron_io::write_record;
use hysteron_model::model::Capability;
use hysteron_model::model_file::Kind;
use hysteron_model::record::{InputOutput, ends_of};
use hysteron_numeric::display::short_to;
use hysteron_report::results::design::{expected, verdict};
use hysteron_report::shell::word;
use serde::Serialize;

use crate::advice;
use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::invert::range;
use crate::maker::maker;
use crate::model::Loaded;
use crate::numbers::{hertz, positive, seconds, whole};
use crate::output::{self, OutFile};
use crate::progress;

/// Design the next drive: the one of a given length after which the model is known best for a purpose.
#[derive(Args)]
// --time is the length of the drive.
#[command(mut_arg("time", |arg| arg.long("time-column")))]
#[command(
    after_help = "The model file holds the covariance of its numbers; records are identified first. The \
    drive is put together from loops, first-order reversals, sines, sweeps, multisines, random reversals and \
    holds, such that the standard error of what it is for becomes least; range and slew rate are kept \
    everywhere, and it begins and ends at rest (0 V, or the end of the range nearest to it). The table \
    compares it with a loop and a sweep of the same length.\n\n\
    The figures hold for a device in the model class near the present estimates: after the record, identify \
    from all records together, and design again. What a model does not have yet (a resonance, creep) is \
    assumed, and said.\n\n\
    Example: hysteron design model.json --for delay --time 20s --range 0:10 --slew 3000 -o next.csv\n\
    Example: hysteron design loop.csv sweep.csv --for minor-loops --time 30s --range 0:10 --slew 500 \
    -o next.csv"
)]
pub struct DesignCommand {
    /// The model file, or the records so far
    #[arg(value_name = "MODEL.json|RECORD", required = true)]
    files: Vec<PathBuf>,

    /// What the drive is for
    #[arg(long = "for", value_name = "PURPOSE", value_enum)]
    purpose: PurposeArg,

    /// Length of the drive, in seconds
    #[arg(long = "time", value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    seconds: f64,

    /// Lowest and highest voltage of the drive [default: those of the records]
    #[arg(long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,

    /// Largest slew rate of the drive per second [default: that of the records]
    #[arg(long, value_name = "PER_SECOND", value_parser = positive, allow_hyphen_values = true)]
    slew: Option<f64>,

    /// Sample rate of the drive [default: that of the records]
    #[arg(long, value_name = "HZ", value_parser = hertz, allow_hyphen_values = true)]
    rate: Option<f64>,

    /// Highest frequency excited, at most a tenth of the sample rate [default: that of the records, or 1.5
    /// times the resonance]
    #[arg(long, value_name = "HZ", value_parser = hertz, allow_hyphen_values = true)]
    highest: Option<f64>,

    /// Standard deviation of the noise, in the output's unit [default: the residual of the fit]
    #[arg(long, value_name = "SD", value_parser = positive, allow_hyphen_values = true)]
    noise: Option<f64>,

    /// Where a resonance is expected that the model does not have, for --for resonance
    #[arg(long, value_name = "HZ", value_parser = hertz, allow_hyphen_values = true)]
    resonance: Option<f64>,

    /// Seed of the random phases and levels
    #[arg(
        long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// File to write
    #[arg(short, long = "out", value_name = "NEXT.csv|npz|mat")]
    out: OutFile,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    columns: ColumnFlags,
}

#[derive(Clone, Copy, ValueEnum)]
enum PurposeArg {
    /// The dead time
    Delay,
    /// Frequency and gain of the resonance
    Resonance,
    /// Creep
    Creep,
    /// The output along slow minor loops
    MinorLoops,
    /// The output along random motion up to the highest frequency
    Prediction,
}

impl From<PurposeArg> for Purpose {
    fn from(purpose: PurposeArg) -> Self {
        match purpose {
            PurposeArg::Delay => Self::Delay,
            PurposeArg::Resonance => Self::Resonance,
            PurposeArg::Creep => Self::Creep,
            PurposeArg::MinorLoops => Self::MinorLoops,
            PurposeArg::Prediction => Self::Prediction,
        }
    }
}

/// The object of `--json`.
#[derive(Serialize)]
struct Written {
    file: String,
    #[serde(flatten)]
    design: DesignSummary,
}

impl DesignCommand {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the drive", &self.out)?;
        let interrupt = Interrupt::listen("no drive is written")?;
        let basis = self.basis(&interrupt)?;
        let options = DesignOptions {
            range: self.range,
            slew_per_s: self.slew,
            sample_rate_hz: self.rate,
            highest_hz: self.highest,
            noise: self.noise,
            resonance_hz: self.resonance,
            seed: self.seed,
            ..DesignOptions::new(self.purpose.into(), self.seconds)
        };
        let watch = progress::watch(&interrupt);
        let teller = watch.teller();
        let found = design(&basis, &options, Listener::new(&teller));
        drop(teller);
        drop(watch);
        let found = found.map_err(|e| interrupt.told(explain(&e)))?;
        write_record(&self.out, &found.record()).map_err(|e| {
            Failure::new(format!("cannot write the drive to {}", self.out.display())).because(e)
        })?;
        self.say(&found)
    }

    fn say(&self, found: &Design) -> Result<(), Failure> {
        let design = found.summary();
        design.findings.iter().for_each(|finding| console::note(&advice::text(finding)));
        let file = self.out.display().to_string();
        let written = format!("wrote {file}: {} samples, {} s", design.samples, design.time_s);
        if self.json {
            console::json(&Written { file, design })?;
        } else {
            let segments: String = design.segments.iter().map(|words| format!("- {words}\n")).collect();
            let table = console::listed(&expected(&design));
            console::result(&format!("{table}\n\n{segments}\nverdict: {}\n", verdict(&design)))?;
        }
        console::message(&written);
        Ok(())
    }

    /// The model in the one file given, or the fit of the records.
    fn basis(&self, interrupt: &Interrupt) -> Result<DesignBasis, Failure> {
        let is_model = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        if let [path] = &self.files[..]
            && is_model(path)
        {
            let loaded = Loaded::read(path)?;
            return Ok(DesignBasis::from(loaded.hammerstein(Capability::Design)?.data()));
        }
        if let Some(path) = self.files.iter().find(|path| is_model(path)) {
            return Err(Failure::usage(format!("{} is a model file among other files", path.display()))
                .hint("give one model file, or records alone"));
        }
        let records = self.columns.read_all(&self.files)?.into_iter();
        let records = records.map(|data| CampaignRecord { data, role: None }).collect();
        let watch = progress::watch(interrupt);
        let fit = fit(&FitRecords::Single(records), &Task::of(Kind::Hammerstein), &watch, None, &maker());
        let cannot = |e: &IdentifyError| Failure::new("the records give no model").because(e);
        let fit = fit.map_err(|e| {
            interrupt.told(match e {
                // A remedy of `identify`: the drive is designed for a Hammerstein model.
                IdentifyError::OtherKind { .. } => cannot(&e).hint(
                    "drives are designed for models of Hammerstein's kind alone: hysteron excite multisine",
                ),
                _ => cannot(&e).advised(e.advice()),
            })
        })?;
        if fit.interrupted {
            return Err(interrupt.told(Failure::new("the fit of the records was interrupted")));
        }
        DesignBasis::of_fit(&fit).map_err(|e| cannot(&e))
    }
}

fn explain(error: &IdentifyError) -> Failure {
    let failure = Failure::new("no drive was designed").because(error);
    match error {
        IdentifyError::NoCorrelation => {
            failure.hint("identify the model again: only a joint fit writes the covariance")
        }
        IdentifyError::NoScores => failure.hint("give the noise: --noise SD"),
        IdentifyError::Stopped => Failure::new("the design was interrupted"),
        IdentifyError::Option { option: "range", .. } => failure.hint("--range LOW:HIGH"),
        IdentifyError::Option { option: "slew rate", .. } => failure.hint("--slew PER_SECOND"),
        IdentifyError::Option { option: "sample rate", .. } => failure.hint("--rate HZ"),
        IdentifyError::Option { option: "time", .. } => failure.hint("--time SECONDS, --rate HZ"),
        IdentifyError::Option { option: "highest frequency", .. } => failure.hint("--highest HZ, --rate HZ"),
        error => failure.advised(error.advice()),
    }
}

/// How much faster than the records so far a drive is that is to find the resonance.
const FASTER: f64 = 10.0;

/// What a drive is designed from.
#[derive(Clone, Copy)]
pub enum DesignFrom<'a> {
    /// A model file.
    Model(&'a Path),
    /// Records, read with the flags of their columns.
    Records(&'a [PathBuf], &'a ColumnFlags),
}

/// The command that makes the next drive, from a model or records whose drives are those of `records`.
pub fn command(from: DesignFrom<'_>, records: &[InputOutput], purpose: Purpose) -> String {
    let file = |path: &Path| word(&path.display().to_string());
    let words: Vec<String> = match from {
        DesignFrom::Model(path) => vec![file(path)],
        DesignFrom::Records(paths, columns) => {
            let flags = columns.typed_for_design().into_iter();
            let flags = flags.map(|(flag, value)| format!("{flag}={}", word(&value)));
            paths.iter().map(|path| file(path)).chain(flags).collect()
        }
    };
    let (low, high) = ends_of(records.iter().map(|data| &data.u)).unwrap_or_default();
    let rate = |data: &InputOutput, k: usize| {
        let seconds = data.time.time_s(k)? - data.time.time_s(k - 1)?;
        (seconds > 0.0).then(|| (data.u[k] - data.u[k - 1]).abs() / seconds)
    };
    let fastest = |data: &InputOutput| (1..data.len()).filter_map(|k| rate(data, k)).fold(0.0, f64::max);
    let slew = records.iter().map(fastest).fold(0.0, f64::max);
    let slew = if purpose == Purpose::Resonance { FASTER * slew } else { slew };
    let mut limits = String::new();
    if low < high {
        limits += &format!(" --range {}:{}", short_to(low, 4), short_to(high, 4));
    }
    if slew > 0.0 {
        limits += &format!(" --slew {}", short_to(slew, 2));
    }
    format!("hysteron design {} --for {} --time 20s{limits} -o next.csv", words.join(" "), purpose.name())
}

/// The line that ends a result: what to measure next, and the command that makes the drive.
pub fn measure_next(prospects: &Prospects, command: &str) -> String {
    let what = prospects
        .next
        .as_deref()
        .unwrap_or("a record for validation, of another amplitude and other frequencies");
    format!(
        "Measure next: {what}.\nThe drive for it (--range and --slew as amplifier and device allow):\n  \
         {command}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use hysteron_model::record::TimeBase;

    #[test]
    fn the_command_quotes_what_a_shell_would_read_otherwise() {
        let files = ["loop 1.csv", "a'b.csv", "runs/sweep.csv"].map(PathBuf::from);
        let drive = vec![0.0, 5.0, 10.0, 5.0];
        let data = InputOutput::new("loop", TimeBase::uniform(10.0), drive.clone(), drive).unwrap();
        let plain = Flags::parse_from(["program"]).columns;
        assert_eq!(
            command(DesignFrom::Records(&files, &plain), &[data], Purpose::MinorLoops),
            "hysteron design 'loop 1.csv' 'a'\\''b.csv' runs/sweep.csv --for minor-loops --time 20s --range \
             0:10 --slew 50 -o next.csv"
        );
    }

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        columns: ColumnFlags,
    }

    #[derive(Parser)]
    struct Design {
        #[command(flatten)]
        command: DesignCommand,
    }

    /// The records are read there as here: every flag of the columns comes back from the command that is printed.
    #[test]
    fn the_command_reads_the_records_as_they_were_read() {
        let typed = [
            "program",
            "--time",
            "t s",
            "--input",
            "drive",
            "--output",
            "2",
            "--sample-rate",
            "1e4",
            "--max-bytes",
            "123",
            "--scale",
            "u=15V/V",
            "--scale",
            "y=-2.5um/V",
            "--dead-zone",
            "0.25",
            "--from",
            "300ms",
            "--to",
            "7.5",
            "--where",
            "segment=2..7",
            "--where",
            "kind=ramp up",
            "--where",
            "on=1",
            "--where",
            "k=..3",
        ];
        let given = Flags::parse_from(typed).columns;
        let printed = given.typed_for_design();
        let words = printed.iter().map(|(flag, value)| format!("{flag}={value}"));
        let rest =
            ["design", "a.csv", "--for", "delay", "--time", "20s", "-o", "next.csv"].map(str::to_owned);
        let read = Design::parse_from(rest.into_iter().chain(words)).command;
        assert_eq!(format!("{:?}", read.columns), format!("{given:?}"));
        let band = Flags::parse_from(["program", "--dead-band", "0.5"]).columns;
        assert_eq!(band.typed_for_design(), [("--dead-band", "0.5".to_owned())]);
    }
}
