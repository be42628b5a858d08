//! `hysteron recalibrate`: gain, delay and offset of an existing model from short records.

use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_identify::IdentifyError;
use hysteron_identify::recalibrate::{
    Change, Prior, Recalibration, RecalibrationSummary, Recording, SIGNIFICANT, recalibrate,
};
use hysteron_model::model::{Capability, SignalRole};
use hysteron_model::record::Unit;
use hysteron_model::{Model, Start};
use hysteron_report::number::{significant, with_std_error};
use serde::Serialize;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::LoadedModel;
use crate::numbers::number;
use crate::output::{self, OutFile};
use crate::start::StartFlags;

/// Find gain, delay and offset of a model again from short records, and hold the rest of it.
#[derive(Args)]
#[command(
    after_help = "y = offset + g * model(u, delay): g scales the hysteresis block's output, the shape of the loop stays. The \
    old model is the prior: the covariance in its file says how well gain and delay are known with the rest held (without one, the \
    standard errors of `linear` and of the delay). A gain or delay that differs by more than 3 combined standard errors has changed, and is taken from \
    the records alone. The offset is that of the first record.\n\n\
    Example: hysteron recalibrate model.json today.csv -o model-today.json"
)]
pub struct Recalibrate {
    /// The model file
    #[arg(value_name = "MODEL.json")]
    model: PathBuf,

    /// The records; a second with some turns of the drive is enough
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Model file to write
    #[arg(short, long = "output-model", value_name = "NEW.json")]
    out: OutFile,

    /// Refuse records of which the recalibrated model explains less than this share, in %
    #[arg(long, value_name = "PERCENT", default_value_t = 75.0, value_parser = number, allow_hyphen_values = true)]
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
        let recordings =
            self.records.iter().map(|path| self.recording(&old, path)).collect::<Result<Vec<_>, _>>()?;
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

    fn recording(&self, model: &LoadedModel, path: &Path) -> Result<Recording, Failure> {
        let mut data = self.columns.read(path)?;
        model.agreed_unit(path, SignalRole::Input, &data.u_unit)?;
        data.y_unit = model.agreed_unit(path, SignalRole::Output, &data.y_unit)?;
        let start = match self.start.start(path, &data.time)? {
            Start::AsIdentified => model.expected_start(path, &data),
            given => given,
        };
        Ok(Recording { data, start, start_is_known: self.start.are_given() })
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
    let mut numbers = console::table(&["", "old", "± ", "from the records", "±", "new", "±", "unit"]);
    for (name, change, unit) in [("gain", &found.gain, ""), ("delay", &found.delay, "s")] {
        let mut row = vec![name.to_owned()];
        for (value, error) in [
            (change.old, change.old_std_error),
            (change.measured, change.measured_std_error),
            (change.value, change.std_error),
        ] {
            let (value, shown) = with_std_error(value, error);
            row.extend([value, if error.is_some() { shown } else { "-".to_owned() }]);
        }
        row.push(unit.to_owned());
        numbers.add_row(row);
    }
    let unit = Unit::new(&units.output).to_string();
    let rmse = console::in_unit("RMSE", &unit);
    let mut scores = console::table(&[
        "record",
        "samples",
        &format!("{rmse} before"),
        &format!("{rmse} after"),
        "fit [%]",
    ]);
    let mut starts = String::new();
    for r in &found.records {
        scores.add_row([
            r.data.name.clone(),
            r.after.samples.to_string(),
            significant(r.before.rmse, 4),
            significant(r.after.rmse, 4),
            r.after.fit_percent.map_or("-".to_owned(), |fit| format!("{fit:.2}")),
        ]);
        let start = r.start.in_words(&units.input, &units.output);
        starts += &format!("data: {}: simulated {start}.\n", r.data.name);
    }
    let offset = significant(found.model.offset, 6);
    format!(
        "{numbers}\n\noffset: {offset} {unit} (of the first record)\n\n{scores}\n\n{}{}{starts}",
        verdict("gain", &found.gain),
        verdict("delay", &found.delay)
    )
}

/// Whether a number has changed, in a line.
fn verdict(name: &str, change: &Change) -> String {
    let Some(times) = change.in_standard_errors() else {
        return format!("verdict: the records do not determine the {name}; it is held at its value.\n");
    };
    let prior = match (change.old_std_error, change.measured_std_error) {
        (None, _) => {
            " (the model file gives no standard error of the old value: that of the records alone)".to_owned()
        }
        // The old model's ignorance must not pass for the device's constancy.
        (Some(old), Some(measured)) if old > SIGNIFICANT * measured => format!(
            " (the old value is known to ± {} only, the records' own to ± {})",
            significant(old, 2),
            significant(measured, 2)
        ),
        _ => String::new(),
    };
    let times = significant(times, 2);
    if change.is_significant() {
        format!(
            "verdict: {name}: the device has changed: {times} combined standard errors from the old value, more than {SIGNIFICANT}{prior}; \
             the new value is that of the records alone.\n"
        )
    } else {
        format!(
            "verdict: {name}: no significant change: {times} combined standard errors from the old value{prior}.\n"
        )
    }
}

fn explain(error: &IdentifyError) -> Failure {
    let failure = Failure::new("the model was not recalibrated").because(error);
    match error {
        IdentifyError::OtherDevice { .. } => failure.hint(
            "check the columns (--input, --output) and that it is the same device; identify it anew with hysteron identify; \
             --least-fit 0 hands the model out all the same",
        ),
        error => failure.advised(error.advice()),
    }
}
