//! `hysteron adapt`: a model corrected over a record, sample by sample, as a controller would.

mod file;
mod follow;
mod text;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use hysteron_identify::online::Term;
use hysteron_model::hammerstein::{Model, Start};
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::model_file::ScoreRole;
use hysteron_model::record::{InputOutput, find_periods, noise_floor};
use hysteron_model::validate::Scoring;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::model::LoadedModel;
use crate::numbers::{count, positive};
use crate::output::{self, OutFile};
use crate::start::StartFlags;
use follow::Followed;

/// Memory of least squares where none is given, as a share of the record.
const MEMORY: f64 = 0.2;

/// Follow a drifting device: correct a model over a record sample by sample, and say when it no longer fits.
#[derive(Args)]
#[command(
    after_help = "y = fixed + sum of coefficient * regressor; the regressors follow from the drive alone. Terms are offset, gain (of the model's \
    output), power=N (change of the coefficient of u^N) and creep=SECONDS (the model's output behind a lag); the rest of the model is held. Recursive least squares \
    (rls) forgets with the memory given; nlms moves by a share of every error. Each coefficient starts as uncertain as moves the output by a tenth of \
    its stroke.\n\n\
    The monitor sums what the corrected model leaves, in units of --noise, and alarms where the mean has moved by half of it or the spread grown by a half. \
    For residuals that are not white learn from fewer samples (--every), or state a noise that covers them.\n\n\
    Example: hysteron adapt model.json today.csv -o model-today.json\n\
    Example: hysteron adapt model.json day.csv --terms offset,gain,power=2 --memory 2 --json"
)]
pub struct Adapt {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The record to run through
    #[arg(value_name = "RECORD")]
    record: PathBuf,

    /// How coefficients are moved
    #[arg(long, value_enum, default_value_t = Method::Rls)]
    method: Method,

    /// Coefficients that may move, up to six, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = term, default_value = "offset,gain")]
    terms: Vec<Term>,

    /// Memory of rls in s (a fifth of the record if not given)
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    memory: Option<f64>,

    /// Step of nlms, below 2
    #[arg(long, value_name = "SHARE", value_parser = positive, allow_hyphen_values = true, default_value_t = 0.05)]
    step: f64,

    /// Standard deviation of a residual where the model fits, in the output's unit (the largest training RMSE
    /// in the model file if not given, else the record's noise floor)
    #[arg(long, value_name = "SIZE", value_parser = positive, allow_hyphen_values = true)]
    noise: Option<f64>,

    /// Learn from every K-th sample (if not given 40 to the period of the fastest drive, fewer where what no coefficients explain stays
    /// alike for longer): what a model leaves of samples close together is no noise
    #[arg(long, value_name = "K", value_parser = count::<usize>, allow_hyphen_values = true)]
    every: Option<usize>,

    /// Mean number of samples learnt from to a false alarm, at least
    #[arg(long, value_name = "SAMPLES", value_parser = positive, allow_hyphen_values = true, default_value_t = 1e6)]
    run_length: f64,

    /// After an alarm, be as uncertain as at the start: a jump is followed at once
    #[arg(long)]
    reopen: bool,

    /// Model file to write, with the coefficients of the last sample
    #[arg(short, long = "output-model", value_name = "NEW.json")]
    out: Option<OutFile>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,
}

/// How coefficients are moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Recursive least squares with forgetting
    Rls,
    /// Normalised least mean squares
    Nlms,
}

fn term(text: &str) -> Result<Term, String> {
    let unknown = || "expected offset, gain, power=N or creep=SECONDS".to_owned();
    match text.trim().split_once('=') {
        None if text.trim() == "offset" => Ok(Term::Offset),
        None if text.trim() == "gain" => Ok(Term::Gain),
        Some(("power", n)) => n.parse().map(Term::Power).map_err(|_| unknown()),
        Some(("creep", s)) => positive(s).map(|lag_s| Term::Creep { lag_s }).map_err(|_| unknown()),
        _ => Err(unknown()),
    }
}

/// The model before, the record, and how it is followed.
struct Task<'a> {
    model: &'a Model,
    data: &'a InputOutput,
    start: Start,
    terms: &'a [Term],
    method: Method,
    memory_s: f64,
    sample_rate_hz: f64,
    /// One of so many samples is learnt from; `None`: as the record asks.
    every: Option<usize>,
    step: f64,
    noise: f64,
    run_length: f64,
    reopen: bool,
}

impl Adapt {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(path) = &self.out {
            if self.terms.iter().any(|t| matches!(t, Term::Creep { .. })) {
                return Err(Failure::usage("a creep term does not go with --output-model")
                    .because("a model file has no place for its coefficient"));
            }
            output::check_file("the model", path)?;
        }
        let old = LoadedModel::read(&self.model, Capability::Adaptation)?;
        let mut data = self.columns.read(&self.record)?;
        old.agreed_unit(&self.record, SignalRole::Input, &data.u_unit)?;
        data.y_unit = old.agreed_unit(&self.record, SignalRole::Output, &data.y_unit)?;
        let sample_rate_hz = data.sample_rate_hz().ok_or_else(|| {
            Failure::new(format!("cannot follow {}", self.record.display()))
                .because("it has no uniform sample rate, and a memory is a number of samples")
                .hint("give the sample rate with --sample-rate HZ")
        })?;
        let signals = data.clone().into();
        let start = old.score(&self.record, &signals, &self.start, &Scoring::default())?.simulation.start;
        let noise = self.noise.or_else(|| known_noise(&old, &data)).ok_or_else(|| {
            Failure::new("the size of a residual where the model fits is not known")
                .because("the model file holds no scores and the record shows no noise")
                .hint("give it with --noise")
        })?;
        let task = Task {
            model: old.model(),
            data: &data,
            start,
            terms: &self.terms,
            method: self.method,
            memory_s: self.memory.unwrap_or(MEMORY * data.len() as f64 / sample_rate_hz),
            sample_rate_hz,
            every: self.every,
            step: self.step,
            noise,
            run_length: self.run_length,
            reopen: self.reopen,
        };
        let found = task.followed().map_err(|e| self.refused(&e))?;
        if let Some(path) = &self.out {
            self.write(path, &old, &task, &found)?;
        }
        if self.json {
            console::json(&text::outcome(&task, &found, self.out.as_deref()))?;
        } else {
            console::result(&text::text(&task, &found))?;
        }
        if let Some(path) = &self.out {
            console::message(&format!("model written to {}", path.display()));
        }
        Ok(())
    }

    fn write(&self, path: &Path, old: &LoadedModel, task: &Task, found: &Followed) -> Result<(), Failure> {
        let file = file::corrected(self, old, task, found)?;
        crate::model::write(path, file).map(|_| ())
    }

    fn refused(&self, because: &dyn std::fmt::Display) -> Failure {
        Failure::new(format!("cannot follow {}", self.record.display())).because(because)
    }
}

/// The largest training RMSE in the model file, else the noise floor of the record.
fn known_noise(old: &LoadedModel, data: &InputOutput) -> Option<f64> {
    let training = old.file().scores.iter().filter(|s| s.role == ScoreRole::Training).map(|s| s.rmse);
    let floor = || noise_floor(data, find_periods(data).ok().as_ref()).map(|floor| floor.rms);
    training.reduce(f64::max).or_else(floor).filter(|noise| *noise > 0.0)
}
