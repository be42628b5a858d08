//! `hysteron recalibrate`: gain, delay and offset of an existing model from short records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::IdentifyError;
use hysteron_identify::recalibrate::{Prior, Recalibration, RecalibrationSummary, Recording, recalibrate};
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::record::{InputOutput, MeasurementRun, Unit};
use hysteron_model::{Model, Start};
use hysteron_report::results::recalibration::{numbers, offset, scores, verdicts};
use serde::Serialize;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::LoadedModel;
use crate::numbers::number;
use crate::output::{self, OutFile};
use crate::start::StartFlags;

/// Re-estimate gain, delay and offset of a model from short records, with all other parameters held.
#[derive(Args)]
#[command(
    after_help = "y = offset + g * model(u, delay): g scales the hysteresis block's output, the shape of the \
    loop stays. The old model is the prior: the covariance in its file says how well gain and delay are \
    known with the rest held (without one, the standard errors of `linear` and of the delay). A gain or \
    delay that differs by more than 3 combined standard errors has changed, and is taken from the records \
    alone. The offset is that of the first record.\n\n\
    Example: hysteron recalibrate model.json today.csv -o model-today.json\n\
    Example: hysteron recalibrate model.json part1.csv part2.csv --continued -o model-today.json"
)]
pub struct Recalibrate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The records; one second with some turning points of the drive is enough
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Model file to write
    #[arg(short, long = "output-model", value_name = "NEW.json")]
    out: OutFile,

    /// The records are consecutive parts of one run on one clock: memory and offset carry over
    #[arg(long)]
    continued: bool,

    /// Minimum fit of each record by the recalibrated model, in %; it is refused below that
    #[arg(
        long, value_name = "PERCENT", default_value_t = 75.0, value_parser = number,
        allow_hyphen_values = true,
    )]
    least_fit: f64,

    /// Print one JSON object
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    start: StartFlags,

    #[command(flatten)]
    columns: ColumnFlags,
}

impl Recalibrate {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_file("the model", &self.out)?;
        let old = LoadedModel::read(&self.model, Capability::Recalibration)?;
        let recordings = self.recordings(&old)?;
        let prior = Prior::of(old.body().data());
        let found = recalibrate(old.law(), prior, &recordings, self.least_fit).map_err(|e| explain(&e))?;
        let file = found.model_file(old.body().data(), old.source(), prior, &maker());
        let written = crate::model::write(&self.out, file.clone())?;
        if self.json {
            let model = self.out.display().to_string();
            return console::json(&Outcome { model, found: found.summary(&file) });
        }
        console::result(&text(&found, &written))?;
        console::message(&format!("model written to {}", self.out.display()));
        Ok(())
    }

    /// The records, or the runs they form, each with its start.
    fn recordings(&self, model: &LoadedModel) -> Result<Vec<Recording>, Failure> {
        let read = |path: &PathBuf| {
            let mut data = self.columns.read(path)?;
            model.agreed_unit(path, SignalRole::Input, &data.u_unit)?;
            data.y_unit = model.agreed_unit(path, SignalRole::Output, &data.y_unit)?;
            Ok(data)
        };
        let records = self.records.iter().map(read).collect::<Result<Vec<InputOutput>, Failure>>()?;
        let recording = |path: &Path, data: InputOutput, beginning: Option<InputOutput>| {
            let start = match self.start.start(path, &data.time)? {
                Start::AsIdentified => model.expected_start(path, beginning.as_ref().unwrap_or(&data)),
                given => given,
            };
            Ok(Recording { data, start, start_is_known: self.start.are_given(), beginning })
        };
        if !self.continued {
            return self
                .records
                .iter()
                .zip(records)
                .map(|(path, data)| recording(path, data, None))
                .collect();
        }
        let runs =
            MeasurementRun::of(&records).map_err(|e| Failure::new("the records are no runs").because(e))?;
        let of_run = |run: MeasurementRun| {
            let beginning = run.beginning();
            recording(&self.records[0], run.data, Some(beginning))
        };
        runs.into_iter().map(of_run).collect()
    }
}

/// The object of `--json`.
#[derive(Serialize)]
struct Outcome {
    model: String,
    #[serde(flatten)]
    found: RecalibrationSummary,
}

fn text(found: &Recalibration, model: &Model) -> String {
    let units = model.units();
    let unit = Unit::new(&units.output).to_string();
    let starts: String = found
        .records
        .iter()
        .map(|r| {
            format!("data: {}: simulated {}.\n", r.data.name, r.start.in_words(&units.input, &units.output))
        })
        .collect();
    let verdicts: String = verdicts(found).iter().map(|verdict| format!("verdict: {verdict}\n")).collect();
    format!(
        "{}\n\n{}\n\n{}\n\n{verdicts}{starts}",
        console::listed(&numbers(found)),
        offset(found, &unit),
        console::listed(&scores(found, &unit))
    )
}

fn explain(error: &IdentifyError) -> Failure {
    let failure = Failure::new("the model was not recalibrated").because(error);
    match error {
        IdentifyError::OtherDevice { .. } => failure.hint(
            "check the columns (--input, --output) and that it is the same device; identify it anew with \
             hysteron identify; --least-fit 0 returns the model regardless",
        ),
        error => failure.advised(error.advice()),
    }
}
