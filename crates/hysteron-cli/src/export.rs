//! `hysteron export`: a model as source code independent of Hysteron.

mod several;

use hysteron_io::IoError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hysteron_export::{
    ExportError, ExportRequest, ExportSummary, Exported, Form, Means, Precision, RUNTIME, export, name_of,
    write_folder,
};
use hysteron_identify::Listener;
use hysteron_model::axes::AxesError;
use hysteron_model::decoupling::DecouplingError;
use hysteron_model::invert::InversionError;
use hysteron_model::model::{Capability, InverseRequest};
use hysteron_model::record::Source;
use hysteron_model::tracking::Controller;

use crate::advice;
use crate::choices::one_of;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::invert::range;
use crate::maker;
use crate::model::{Loaded, LoadedModel};
use crate::numbers::{positive, share, whole};
use crate::output;
use crate::progress;

/// Write a model as C99 source, a Rust crate, an FMU, or for MATLAB and Simulink.
#[derive(Args)]
#[command(
    after_help = help()
)]
pub struct Export {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// Form of the export
    #[arg(long, value_name = "FORM", value_parser = one_of(Form::ALL, Form::name, Form::summary))]
    to: Form,

    /// Folder to write into
    #[arg(short, long, value_name = "DIR")]
    out_dir: PathBuf,

    /// Number type of the source
    #[arg(long, value_name = "TYPE", default_value = "f64")]
    float: Float,

    /// Sample rate of the controller [default: that of the model's records]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    sample_rate: Option<f64>,

    /// Maximum error of the realised dynamics, as a fraction of the range [default: a tenth of the model's
    /// least error on a record, 1e-5 to 1e-3]
    #[arg(long, value_name = "SHARE", value_parser = share, allow_hyphen_values = true)]
    accuracy: Option<f64>,

    /// Lowest frequency to realise, for a model with unbounded creep
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    lowest_frequency: Option<f64>,

    /// Prefix of every name in the source: a to z, digits, _ [default: from the name of the model file]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,

    /// Write the inverse too: reference in, voltage out, sample by sample
    #[arg(long)]
    inverse: bool,

    /// Minimum and maximum voltage of the inverse, or one per actuator [default: the range the model was
    /// identified in]
    #[arg(
        long, value_name = "LOW:HIGH", value_parser = range, allow_hyphen_values = true, requires = "inverse",
        value_delimiter = ',',
    )]
    range: Vec<[f64; 2]>,

    /// Maximum slew rate of the inverse's voltage, per second, or one per actuator [default: none]
    #[arg(
        long, value_name = "PER_SECOND", value_parser = positive, allow_hyphen_values = true,
        requires = "inverse", value_delimiter = ',',
    )]
    slew: Vec<f64>,

    /// Level of the drive (rms) at which the modes of a model of several axes are taken [default: the highest
    /// identified]
    #[arg(long, value_name = "VOLTS", value_parser = positive, allow_hyphen_values = true)]
    level: Option<f64>,

    /// Frequency up to which the inverse follows, in Hz [default: a twentieth of the sample rate, for
    /// several axes at most of the rate of the model's steps]
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true, requires = "inverse")]
    bandwidth: Option<f64>,

    /// Preview of the reference, in samples [default: as many as affect the drive; with --predict-to: 0]
    #[arg(
        long, value_name = "SAMPLES", value_parser = whole::<usize>, allow_hyphen_values = true,
        requires = "inverse",
    )]
    preview: Option<usize>,

    /// Predict the reference beyond the preview from its past, as a random motion band-limited to this
    /// frequency
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true, requires = "inverse")]
    predict_to: Option<f64>,

    /// Controller of `track` around the inverse, with feedback or an observer, as C99, Rust or FMUs
    #[arg(
        long, value_name = "NAME", requires = "inverse",
        value_parser = one_of(Controller::ALL, Controller::name, Controller::summary),
    )]
    controller: Option<Controller>,

    /// Day in the headers [default: that of SOURCE_DATE_EPOCH, else today]; `none` leaves it out
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = day_or_none)]
    date: Option<String>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Float {
    /// Single precision
    F32,
    /// Double precision
    F64,
}

impl Float {
    fn precision(self) -> Precision {
        match self {
            Self::F32 => Precision::F32,
            Self::F64 => Precision::F64,
        }
    }
}

impl Export {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_folder("the source", &self.out_dir)?;
        if matches!(self.float, Float::F32) && !self.to.has_single_precision() {
            return Err(Failure::usage(format!("--float f32 does not go with --to {}", self.to.name()))
                .because(ExportError::MatlabPrecision)
                .hint("leave --float out"));
        }
        let loaded = Loaded::read(&self.model)?;
        if loaded.model().channels().is_some() {
            return self.several_axes(&loaded);
        }
        if self.range.len() > 1 || self.slew.len() > 1 || self.level.is_some() {
            return Err(Failure::usage("several limits and --level go with models of several axes"));
        }
        let loaded = LoadedModel::of(loaded, Capability::Export)?;
        let interrupt = Interrupt::listen("no file is written")?;
        let watch = progress::watch(&interrupt);
        let teller = watch.teller();
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let means = Means { compiler: &compiler, listener: Listener::new(&teller) };
        let exported = export(loaded.body(), &self.request(loaded.source()), means);
        drop(teller);
        drop(watch);
        let Exported { subject, files, findings } = exported.map_err(|e| match e {
            ExportError::Stopped => interrupt.told(Failure::new("the export was interrupted")),
            e => self.cannot(&e),
        })?;
        for finding in &findings {
            console::note(&advice::text(finding));
        }
        write_folder(&self.out_dir, &files).map_err(|e| self.cannot(&e))?;
        if let Some(range) = loaded.model().valid_range() {
            console::note(&range.in_words());
        }
        let summary = ExportSummary::new(&self.out_dir, &subject, &files);
        if self.json {
            return console::json(&summary);
        }
        let runtime = self.out_dir.join(RUNTIME);
        let (runtime_files, own): (Vec<_>, Vec<_>) =
            summary.files.iter().partition(|file| Path::new(&file.path).starts_with(&runtime));
        let mut lines: Vec<String> =
            own.iter().map(|f| format!("wrote {} ({} bytes)\n", f.path, f.bytes)).collect();
        if !runtime_files.is_empty() {
            let (count, folder) = (runtime_files.len(), runtime.display());
            lines.push(format!("wrote {folder} ({count} files, the source of hysteron-rt)\n"));
        }
        console::result(&lines.concat())
    }

    fn request(&self, source: &Source) -> ExportRequest {
        let inverse = self.inverse.then(|| InverseRequest {
            range: self.range.first().copied(),
            slew_per_s: self.slew.first().copied(),
            bandwidth_hz: self.bandwidth,
            preview: self.preview,
            predict_to_hz: self.predict_to,
            ..InverseRequest::default()
        });
        ExportRequest {
            form: self.to,
            float: self.float.precision(),
            name: self.name(),
            sample_rate_hz: self.sample_rate,
            accuracy: self.accuracy,
            lowest_frequency_hz: self.lowest_frequency,
            inverse,
            controller: self.controller,
            model_sha256: Some(source.sha256.clone()),
            date: self.date(),
        }
    }

    /// Beginning of every name in the source: given, else from the file's name.
    fn name(&self) -> String {
        let stem = || self.model.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        self.name.clone().unwrap_or_else(|| name_of(&stem().unwrap_or_default()))
    }

    /// Day in the headers.
    fn date(&self) -> Option<String> {
        match self.date.as_deref() {
            Some("none") => None,
            Some(date) => Some(date.to_owned()),
            None => Some(maker::day()),
        }
    }

    fn cannot(&self, error: &ExportError) -> Failure {
        let failure = Failure::new(format!("cannot export {}", self.model.display())).because(error);
        match error {
            ExportError::SampleRate => failure.hint("give the controller's with --sample-rate HZ"),
            ExportError::Inverse(InversionError::RangeUnknown) => {
                failure.hint("give the amplifier's with --range LOW:HIGH")
            }
            ExportError::Decoupling(e) if matches!(**e, DecouplingError::Limits { .. }) => {
                Failure::usage(error.to_string())
                    .hint("give one for all actuators, or one per actuator, separated by commas")
            }
            ExportError::Decoupling(e) if matches!(**e, DecouplingError::RangeUnknown) => {
                failure.hint("e.g. --range=-1:1")
            }
            ExportError::Realise(error) => crate::realise::with_remedy(failure, error),
            ExportError::Name { .. } if self.name.is_some() => {
                Failure::usage("--name is no name of the source").because(error).hint("e.g. --name stage")
            }
            ExportError::Name { .. } => failure.hint("name it with --name, e.g. --name stage"),
            ExportError::Compiler { .. } => failure
                .hint("install a C compiler (e.g. apt-get install gcc), or name one in the variable CC"),
            ExportError::Folder(IoError::Foreign { .. }) => {
                failure.hint("name another folder, or another --name")
            }
            ExportError::Folder(IoError::Folder { source, .. }) => failure.hint(match source.kind() {
                ErrorKind::IsADirectory | ErrorKind::NotADirectory => {
                    "name another folder, or another --name"
                }
                ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                    "choose a folder that you may write to"
                }
                _ => "choose another folder, or make room on the disk",
            }),
            ExportError::Rounding { what: "voltage", .. } => failure
                .hint("export it with --float f64, for a lower --sample-rate, or for a lower --bandwidth"),
            ExportError::Rounding { .. } => {
                failure.hint("export it with --float f64, or for a lower --sample-rate")
            }
            ExportError::Still { .. } => {
                failure.hint("check it with hysteron simulate: an exported model must respond to a voltage")
            }
            ExportError::Departs { .. } => failure
                .hint("export it with --float f64, for a lower --sample-rate, or for another --bandwidth"),
            ExportError::Prediction { .. } => failure.hint("give the frequency with --predict-to HZ"),
            ExportError::AxesController { .. } => failure.hint("leave --controller out"),
            ExportError::ControllerForm { .. } => failure.hint("export it with --to c, rust or fmu"),
            ExportError::ControllerAlone => failure.hint("add --inverse"),
            ExportError::Decoupling(e) if matches!(**e, DecouplingError::Axes(AxesError::RunsAway)) => {
                failure.hint("another --sample-rate")
            }
            ExportError::MatlabName { .. } => failure.hint("name it with --name, e.g. --name stage"),
            _ => failure,
        }
    }
}

fn help() -> String {
    let forms: Vec<String> =
        Form::ALL.iter().map(|form| format!("  --to {:<9} {}", form.name(), form.contents())).collect();
    format!(
        "The model is realised at the sample rate (see hysteron realise) and written into the folder:\n\n\
         {}\n\n\
         A folder that does not exist is made; files of other names in it are left alone, and a file of the \
         same name is replaced only where an export wrote it.\n\n\
         --inverse adds the inverse in the same form, as NAME_inverse: reference in, voltage out, within \
         --range and --slew for any input; in C with an example loop. --controller adds NAME_controller \
         around it: a feedback law or an observer, tuned with the margins of hysteron track.\n\n\
         Example: hysteron export model.json --to c -o firmware/stage --float f32 --sample-rate 10000",
        forms.join("\n")
    )
}

/// `none` or a day of the calendar.
fn day_or_none(text: &str) -> Result<String, String> {
    let number = |part: &str, digits: usize| -> Option<u32> {
        (part.len() == digits && part.bytes().all(|b| b.is_ascii_digit())).then(|| part.parse().ok())?
    };
    let mut parts = text.splitn(3, '-');
    let (year, month, day) = (parts.next(), parts.next(), parts.next());
    let of = |part: Option<&str>, digits: usize| part.and_then(|part| number(part, digits));
    let days = match (of(year, 4), of(month, 2)) {
        (Some(year), Some(2)) if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        (Some(_), Some(2)) => 28,
        (Some(_), Some(4 | 6 | 9 | 11)) => 30,
        (Some(_), Some(1..=12)) => 31,
        _ => 0,
    };
    let is_day = of(day, 2).is_some_and(|day| (1..=days).contains(&day));
    if text == "none" || is_day {
        return Ok(text.to_owned());
    }
    Err("expected a day as YYYY-MM-DD, e.g. 2026-01-31, or none".to_owned())
}

#[cfg(test)]
mod tests {
    use super::day_or_none;

    #[test]
    fn a_day_is_one_of_the_calendar() {
        for day in ["none", "2026-01-31", "2024-02-29", "2000-02-29", "2026-12-01"] {
            assert_eq!(day_or_none(day).unwrap(), day);
        }
        for day in
            ["", "2024-13-45", "2026-02-29", "1900-02-29", "2026-00-01", "x*/", "2026-1-31", "2026-01-00"]
        {
            assert!(day_or_none(day).is_err(), "{day}");
        }
    }
}
