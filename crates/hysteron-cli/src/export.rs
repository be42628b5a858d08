//! `hysteron export`: a model as source code independent of Hysteron.

mod several;

use hysteron_io::IoError;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hysteron_export::{
    ExportError, ExportSummary, Form, Inverse, Means, NamedFile, Precision, RUNTIME, Rounding, Subject,
    write_folder,
};
use hysteron_identify::Listener;
use hysteron_model::compensator::{Compensation, CompensatorOptions, Prediction};
use hysteron_model::model::Capability;
use hysteron_model::realise::RealiseOptions;
use hysteron_report::number::significant;

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
use crate::realise::{along_sweep, realised, where_creep_stops};

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

    /// Maximum error of the realised dynamics, as a fraction of the range
    #[arg(
        long, value_name = "SHARE", default_value_t = 1e-5, value_parser = share, allow_hyphen_values = true,
    )]
    accuracy: f64,

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

    /// Frequency up to which the inverse follows, in Hz [default: a twentieth of the sample rate]
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

    /// Day in the headers [default: that of SOURCE_DATE_EPOCH, else today]; `none` leaves it out
    #[arg(long, value_name = "DATE")]
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
        let rate = self.sample_rate.or(loaded.body().data().sample_rate_hz).ok_or_else(|| {
            Failure::new(format!("cannot export {}", self.model.display()))
                .because("it was identified from records without a sample rate, and the source runs at one")
                .hint("give the controller's with --sample-rate HZ")
        })?;
        let options = RealiseOptions { accuracy: self.accuracy, lowest_frequency_hz: self.lowest_frequency };
        let realisation = realised(&self.model, &loaded, rate, &options)?;
        let precision = match self.float {
            Float::F32 => Precision::F32,
            Float::F64 => Precision::F64,
        };
        let name = self.name.clone().unwrap_or_else(|| name_of(&self.model));
        let mut subject = Subject::new(&name, precision, loaded.body().data(), realisation, self.accuracy)
            .map_err(|e| self.cannot(&e))?;
        subject.origin.model_sha256.clone_from(&loaded.source().sha256);
        subject.origin.date = match self.date.as_deref() {
            Some("none") => None,
            Some(date) => Some(date.to_owned()),
            None => Some(maker::day()),
        };
        remark_rounding("displacement", &subject.output_unit, subject.rounding);
        subject.along_sweep = Some(along_sweep(&self.model, &loaded, &subject.realisation, self.accuracy)?);
        let inverse = if self.inverse { Some(self.inverted(&loaded, &subject, &options)?) } else { None };
        let interrupt = Interrupt::listen("no file is written")?;
        let watch = progress::watch(&interrupt);
        let teller = watch.teller();
        let files = self.files(&subject, inverse.as_ref(), Listener::new(&teller));
        drop(teller);
        drop(watch);
        let files = files.map_err(|e| match e {
            ExportError::Stopped => interrupt.told(Failure::new("the export was interrupted")),
            e => self.cannot(&e),
        })?;
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

    fn files(
        &self,
        subject: &Subject,
        inverse: Option<&Inverse>,
        listener: Listener<'_>,
    ) -> Result<Vec<NamedFile>, ExportError> {
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        self.to.files(subject, inverse, Means { compiler: &compiler, listener })
    }

    /// The inverse of the model within its limits.
    fn inverted(
        &self,
        loaded: &LoadedModel,
        subject: &Subject,
        realise: &RealiseOptions,
    ) -> Result<Inverse, Failure> {
        let range = self.range.first().copied().or(loaded.body().drive_range()).ok_or_else(|| {
            Failure::new(format!("cannot invert {}", self.model.display()))
                .because("the model file does not say which range it was identified in")
                .hint("give the amplifier's with --range LOW:HIGH")
        })?;
        let rate = subject.realisation.sample_rate_hz;
        let options = CompensatorOptions {
            bandwidth_hz: self.bandwidth,
            preview: self.preview.or(self.predict_to.map(|_| 0)),
            prediction: Prediction::up_to(self.predict_to),
            realise: where_creep_stops(loaded, rate, *realise),
            ..CompensatorOptions::default()
        };
        let compensation = Compensation::new(loaded.law(), rate, &options);
        let compensation = compensation.map_err(|e| self.cannot(&e.into()))?;
        if let Some(wanted) = self.preview.filter(|wanted| *wanted > compensation.preview) {
            let used = compensation.preview;
            console::note(&format!(
                "of the preview of {wanted} samples {used} are used, beyond which no voltage depends on the \
                 reference: give the reference {used} samples ahead, not {wanted} (the source names the \
                 number)"
            ));
        }
        let inverse =
            Inverse::new(subject, compensation, range, self.slew.first().copied().unwrap_or(f64::INFINITY))
                .map_err(|e| self.cannot(&e))?;
        remark_rounding("voltage", &subject.input_unit, inverse.rounding);
        Ok(inverse)
    }

    fn cannot(&self, error: &ExportError) -> Failure {
        let failure = Failure::new(format!("cannot export {}", self.model.display())).because(error);
        match error {
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
         --range and --slew for any input; in C with an example loop.\n\n\
         Example: hysteron export model.json --to c -o firmware/stage --float f32 --sample-rate 10000",
        forms.join("\n")
    )
}

/// Prints a note if single precision costs much accuracy.
fn remark_rounding(what: &str, unit: &str, rounding: Rounding) {
    if rounding.share > Rounding::NOTED {
        console::note(&format!(
            "single precision may move the {what} by {} {unit}, {} % of its range (--float f64 does not)",
            significant(rounding.bound, 2),
            significant(100.0 * rounding.share, 2)
        ));
    }
}

/// Name in the source derived from a file name: lower case, _ for all but letters and digits.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|s| s.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}
