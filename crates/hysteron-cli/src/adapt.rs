//! `hysteron adapt`: a model corrected over a record, sample by sample, as a controller would.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use hysteron_identify::online::FollowedSummary;
use hysteron_identify::online::{FollowMethod, FollowOptions, Followed, Term, known_noise};
use hysteron_model::Advice;
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::Scoring;
use hysteron_report::results::adaptation::{coefficients, errors, method, verdict};
use serde::Serialize;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::LoadedModel;
use crate::numbers::{count, positive};
use crate::output::{self, OutFile};
use crate::start::StartFlags;

/// Track a drifting device: correct a model sample by sample by recursive estimation, with a monitor of the
/// residual.
#[derive(Args)]
#[command(
    after_help = "y = fixed + sum of coefficient * regressor; the regressors follow from the drive alone. \
    Terms are offset, gain (of the model's output), power=N (change of the coefficient of u^N) and \
    creep=SECONDS (the model's output through a first-order lag); the rest of the model is held. rls is \
    recursive least squares with exponential forgetting, nlms the normalised LMS gradient. The initial \
    standard deviation of each coefficient corresponds to a change of the output by a tenth of its \
    stroke.\n\n\
    The monitor is a cumulative-sum test of the residual over --noise: it raises an alarm where the mean has \
    shifted by half a standard deviation or the standard deviation has grown by a half. For coloured \
    residuals use fewer samples (--every) or a larger --noise.\n\n\
    Example: hysteron adapt model.json today.csv -o model-today.json\n\
    Example: hysteron adapt model.json day.csv --terms offset,gain,power=2 --memory 2 --json"
)]
pub struct Adapt {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The record
    #[arg(value_name = "RECORD")]
    record: PathBuf,

    /// Estimator of the coefficients
    #[arg(long, value_enum, default_value_t = Method::Rls)]
    method: Method,

    /// Coefficients to estimate, up to six, separated by commas
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', value_parser = Term::from_str,
        default_value = "offset,gain",
    )]
    terms: Vec<Term>,

    /// Memory of rls in s, the time constant of forgetting [default: a fifth of the record]
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    memory: Option<f64>,

    /// Step size of nlms, below 2
    #[arg(
        long, value_name = "SHARE", value_parser = positive, allow_hyphen_values = true,
        default_value_t = 0.05,
    )]
    step: f64,

    /// Standard deviation of the residual of a valid model, in the output's unit [default: the largest
    /// training RMSE in the model file, else the record's noise floor]
    #[arg(long, value_name = "SIZE", value_parser = positive, allow_hyphen_values = true)]
    noise: Option<f64>,

    /// Use every K-th sample, because residuals of neighbouring samples are correlated [default: 40 samples
    /// per period of the fastest drive, fewer where the residual stays correlated for longer]
    #[arg(long, value_name = "K", value_parser = count::<usize>, allow_hyphen_values = true)]
    every: Option<usize>,

    /// Minimum average run length to a false alarm, in samples used
    #[arg(
        long, value_name = "SAMPLES", value_parser = positive, allow_hyphen_values = true,
        default_value_t = 1e6,
    )]
    run_length: f64,

    /// Reset the covariance to its initial value after an alarm, so that a jump is followed at once
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

/// Adaptation law of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Recursive least squares with forgetting
    Rls,
    /// Normalised least mean squares
    Nlms,
}

/// The record and the options of the estimation.
struct Task<'a> {
    data: &'a InputOutput,
    options: FollowOptions,
}

/// The object of `--json`.
#[derive(Serialize)]
struct Outcome {
    model: Option<String>,
    #[serde(flatten)]
    found: FollowedSummary,
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
        if data.sample_rate_hz().is_none() {
            return Err(Failure::new(format!("cannot follow {}", self.record.display()))
                .because("it has no uniform sample rate, and a memory is a number of samples")
                .advised(Some(Advice::Resample)));
        }
        let signals = data.clone().into();
        let start =
            old.score(&self.record, &signals, &self.start, &Scoring::default(), false)?.simulation.start;
        let noise = self.noise.or_else(|| known_noise(old.body().data(), &data)).ok_or_else(|| {
            Failure::new("the standard deviation of the residual is not known")
                .because("the model file holds no scores and the record shows no noise")
                .hint("give it with --noise")
        })?;
        let options = FollowOptions {
            method: match self.method {
                Method::Rls => FollowMethod::LeastSquares { memory_s: self.memory },
                Method::Nlms => FollowMethod::Gradient { step: self.step },
            },
            terms: self.terms.clone(),
            noise,
            every: self.every,
            run_length: self.run_length,
            reopen: self.reopen,
        };
        let found = Followed::over(&data, old.law(), &start, &options).map_err(|e| self.refused(&e))?;
        let task = Task { data: &data, options };
        if let Some(path) = &self.out {
            self.write(path, &old, &task, &found)?;
        }
        if self.json {
            let model = self.out.as_deref().map(|path| path.display().to_string());
            console::json(&Outcome { model, found: found.summary(task.data, &task.options) })?;
        } else {
            console::result(&text(&task, &found))?;
        }
        if let Some(path) = &self.out {
            console::message(&format!("model written to {}", path.display()));
        }
        Ok(())
    }

    fn write(&self, path: &Path, old: &LoadedModel, task: &Task, found: &Followed) -> Result<(), Failure> {
        let file = found
            .model_file(task.data, &task.options, (old.body().data(), old.source()), &maker())
            .map_err(|e| Failure::new("the corrected coefficients make no model").because(e))?;
        crate::model::write(path, file).map(|_| ())
    }

    fn refused(&self, because: &dyn std::fmt::Display) -> Failure {
        Failure::new(format!("cannot follow {}", self.record.display())).because(because)
    }
}

fn text(task: &Task, found: &Followed) -> String {
    let unit = task.data.y_unit.to_string();
    format!(
        "{}\n\n{}\n\n{}\n{}\n",
        console::listed(&coefficients(found)),
        console::listed(&errors(found, &unit)),
        method(found, &task.options, &unit),
        verdict(found, task.data, &task.options).join("\n")
    )
}
