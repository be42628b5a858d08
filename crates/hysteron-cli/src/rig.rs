//! `hysteron rig`: the simulated test bench.

mod several;

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_io::{IoError, JsonFileError, NamedFile, load_json, write_csv_to, write_folder};
use hysteron_model::Advice;
use hysteron_model::record::{Driven, Quantity, TimeBase};
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{CampaignPlan, RigRun, Truth, measure, run_campaign};
use serde::de::DeserializeOwned;

use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::numbers::whole;
use crate::output;

/// Largest truth or plan file read, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Measure on a simulated test bench with known truth: records to try the other commands on.
#[derive(Args)]
#[command(
    after_help = "Plays the article's campaign (1 Hz loop, 1-100 Hz sweep, sines of 10, 20, 50 and 100 Hz), \
    or the drives given with --drive, and writes one record each, with the truth and the plan used, into the \
    folder. The default truth lies outside every model class that hysteron identifies.\n\nExample: hysteron \
    rig --out-dir bench --seed 1\nExample: hysteron rig --axes 3 --out-dir bench3"
)]
pub struct Rig {
    /// True parameters of the simulated bench: JSON, all keys optional (truth.json of an earlier run, edited)
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,

    /// Output folder; made if it does not exist
    #[arg(long, value_name = "DIR")]
    out_dir: PathBuf,

    /// Seed of the noise
    #[arg(
        long, value_name = "N", default_value_t = 0, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// Which records are made: JSON, all keys optional (plan.json of an earlier run, edited)
    #[arg(long, value_name = "FILE", conflicts_with = "drives")]
    plan: Option<PathBuf>,

    /// Play the drive in this file, e.g. one written by hysteron excite, instead of the campaign; may be
    /// repeated
    #[arg(long = "drive", value_name = "FILE")]
    drives: Vec<PathBuf>,

    /// Bench of this many actuators and axes, 2 to 6, coupled: multisines of several levels, all inputs at
    /// once, to identify a model of several axes on
    #[arg(
        long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true,
        conflicts_with_all = ["drives", "with_truth"],
    )]
    axes: Option<usize>,

    /// Write the true displacement and the output of the hysteresis block beside the sensor reading
    #[arg(long)]
    with_truth: bool,

    #[command(flatten)]
    columns: InputFlags,
}

impl Rig {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_folder("the records", &self.out_dir)?;
        if let Some(axes) = self.axes {
            return self.several_axes(axes);
        }
        let truth: Truth = read_or_default(self.truth.as_deref(), "truth")?;
        let plan: CampaignPlan = read_or_default(self.plan.as_deref(), "plan")?;
        let runs = self.measure(&truth, &plan)?;
        let mut files = vec![settings("truth.json", &truth)?];
        if self.drives.is_empty() {
            files.push(settings("plan.json", &plan)?);
        }
        for run in &runs {
            files.push(self.file(run)?);
        }
        self.write(&files)?;
        for run in &runs {
            self.tell(run);
        }
        Ok(())
    }

    fn measure(&self, truth: &Truth, plan: &CampaignPlan) -> Result<Vec<RigRun>, Failure> {
        let failure = || Failure::new("cannot simulate the bench");
        if self.drives.is_empty() {
            let runs = run_campaign(truth, plan, self.seed).map_err(|e| failure().because(e))?;
            return Ok(runs.into_iter().map(|r| r.run).collect());
        }
        let drives = self.drives.iter().map(|path| self.drive(path)).collect::<Result<Vec<_>, _>>()?;
        for (i, drive) in drives.iter().enumerate() {
            output::keep_input(&self.record_of(&drive.name), &self.drives)?;
            if drives[..i].iter().any(|d| d.name == drive.name) {
                return Err(Failure::usage(format!("two drives are called {}", drive.name))
                    .because("each record is named after its drive, and one would overwrite the other"));
            }
        }
        let measured =
            |(stream, drive)| measure(truth, drive, self.seed, stream).map_err(|e| failure().because(e));
        drives.iter().enumerate().map(measured).collect()
    }

    /// Writes the records, with truth and plan. Those in the folder that were edited, and are not what was
    /// simulated, are kept.
    fn write(&self, files: &[NamedFile]) -> Result<(), Failure> {
        let failure = || Failure::new("cannot write the records");
        for (name, given) in [("truth.json", &self.truth), ("plan.json", &self.plan)] {
            let path = self.out_dir.join(name);
            let own = files.iter().find(|file| file.name == name);
            let is_other = |found: Vec<u8>| own.is_some_and(|own| own.bytes != found);
            if given.is_none() && std::fs::read(&path).is_ok_and(is_other) {
                let flag = name.trim_end_matches(".json");
                return Err(failure()
                    .because(format!("{} is not what was simulated, and would be replaced", path.display()))
                    .hint(format!("--{flag} {} simulates it; or another --out-dir", path.display())));
            }
        }
        write_folder(&self.out_dir, files, None).map_err(|e| failure().because(e))
    }

    /// The record of a drive, named after it.
    fn record_of(&self, name: &str) -> PathBuf {
        self.out_dir.join(format!("{name}.csv"))
    }

    /// The drive in a file, as an excitation of the bench.
    fn drive(&self, path: &Path) -> Result<Excitation, Failure> {
        let failure = || Failure::new(format!("cannot play the drive {}", path.display()));
        let Driven { drive, .. } = self.columns.read_drive(path)?;
        let TimeBase::Uniform { sample_rate_hz, .. } = drive.time else {
            return Err(failure().because("it has no uniform sample rate").advised(Some(Advice::Resample)));
        };
        if !matches!(drive.unit.base().0, Quantity::Voltage) && !drive.unit.symbol().is_empty() {
            return Err(failure().because(format!("its unit is {}, the bench is driven in V", drive.unit)));
        }
        let name = path.file_stem().map_or("drive".into(), |s| s.to_string_lossy().into_owned());
        Ok(Excitation::of_samples(
            name,
            format!("drive of {}", path.display()),
            drive.samples,
            sample_rate_hz,
        ))
    }

    /// The file of a record, with what it is in comments.
    fn file(&self, run: &RigRun) -> Result<NamedFile, Failure> {
        let with_truth = self.with_truth.then(|| run.record_with_truth());
        let record = with_truth.as_ref().unwrap_or(&run.record);
        let mut text: Vec<u8> =
            run.comments.iter().flat_map(|comment| format!("# {comment}\n").into_bytes()).collect();
        write_csv_to(&mut text, record)
            .map_err(|e| Failure::new(format!("cannot write the record {}", run.record.name)).because(e))?;
        Ok(NamedFile::new(format!("{}.csv", run.record.name), text))
    }

    fn tell(&self, run: &RigRun) {
        let path = self.record_of(&run.record.name);
        console::message(&format!("wrote {} ({} samples)", path.display(), run.record.len()));
        if run.clipped_samples > 0 {
            console::note(&format!(
                "{}: {} samples saturate the converter",
                path.display(),
                run.clipped_samples
            ));
        }
    }
}

/// A file of settings, as JSON to be edited.
fn settings(name: &str, value: &impl serde::Serialize) -> Result<NamedFile, Failure> {
    let failure = |e| Failure::new(format!("cannot write {name}")).because(e);
    let text = serde_json::to_string_pretty(value).map_err(failure)?;
    Ok(NamedFile::new(name, text + "\n"))
}

/// Reads a JSON file of settings; without a file, the defaults.
pub fn read_or_default<T: DeserializeOwned + Default>(path: Option<&Path>, what: &str) -> Result<T, Failure> {
    path.map_or_else(|| Ok(T::default()), |path| read_settings(path, what))
}

/// Reads a JSON file of settings.
pub fn read_settings<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T, Failure> {
    load_json(path, MAX_BYTES).map_err(|e| {
        let failure = Failure::new(format!("cannot read the {what} {}", path.display()));
        let hint = format!("hysteron rig --out-dir DIR writes the {what} in force to DIR/{what}.json");
        if matches!(e, IoError::Json(JsonFileError::Content { .. })) {
            failure.because(e).hint(hint)
        } else {
            failure.because(e)
        }
    })
}
