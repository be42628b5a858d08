//! `hysteron identify --inputs … --outputs …`: scheduled modes with hysteresis in feedback.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use hysteron_identify::modes::{
    ModesFitError, ModesIdentification, ModesProgress, ModesRecordFit, Options, identify,
};
use hysteron_model::Start;
use hysteron_model::axes::{AxesRecord, InfluenceMatrix};
use hysteron_model::model::Score;
use hysteron_model::model_file::ModesFile;
use hysteron_report::number::significant;
use serde_json::{Value, json};

use super::{AxesFlags, score_axes};
use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::{ANEW, Interrupt, partial};
use crate::maker::maker;
use crate::model;
use crate::numbers::{count, positive, whole};
use crate::progress::Progress;
use crate::result_flags::ResultFlags;
use crate::scores::table;

/// What can be said about scheduled modes.
#[derive(Args, Clone, Debug)]
pub struct ModesFlags {
    /// Pairs of poles the modes are looked for from [default: as many as follow the response]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true, help_heading = "Several axes")]
    modes: Option<usize>,

    /// Plays of each hysteresis; 0: polynomials alone [default: 6]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true, help_heading = "Several axes")]
    plays: Option<usize>,

    /// Leave the hysteresis out: linear modes at each level
    #[arg(long, help_heading = "Several axes")]
    linear: bool,

    /// Steps of the simulation a sample, 1 to 8 [default: 2]
    #[arg(long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true, help_heading = "Several axes")]
    steps: Option<usize>,

    /// Most iterations of the last search [default: 12]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true, help_heading = "Several axes")]
    iterations: Option<usize>,

    /// Exponent with which the modes follow the level of the drive [default: 1]
    #[arg(long, value_name = "P", value_parser = positive, allow_hyphen_values = true, help_heading = "Several axes")]
    exponent: Option<f64>,
}

impl ModesFlags {
    /// The first flag given, if one is.
    pub fn given(&self) -> Option<&'static str> {
        [
            ("--modes", self.modes.is_some()),
            ("--plays", self.plays.is_some()),
            ("--linear", self.linear),
            ("--steps", self.steps.is_some()),
            ("--iterations", self.iterations.is_some()),
            ("--exponent", self.exponent.is_some()),
        ]
        .into_iter()
        .find_map(|(flag, given)| given.then_some(flag))
    }

    fn options(&self, whole_records: bool, least_fit_percent: f64) -> Options {
        let defaults = Options::default();
        Options {
            modes: self.modes,
            plays: self.plays.unwrap_or(defaults.plays),
            hysteresis: !self.linear,
            steps: self.steps.unwrap_or(defaults.steps),
            iterations: self.iterations.unwrap_or(defaults.iterations),
            exponent: self.exponent.unwrap_or(defaults.exponent),
            whole_records,
            least_fit_percent,
            ..defaults
        }
    }

    /// Identifies the model of the records and writes its file; prints what was found.
    ///
    /// # Errors
    /// If the records cannot be read or used, or the file cannot be written.
    pub fn run(
        &self,
        (paths, axes, columns): (&[PathBuf], &AxesFlags, &InputFlags),
        (out, result): (&Path, &ResultFlags),
        (whole_records, least_fit_percent): (bool, f64),
    ) -> Result<(), Failure> {
        if axes.outputs.is_empty() {
            return Err(Failure::usage("several axes need their outputs")
                .hint("name them in order, e.g. --outputs y1_nm,y2_nm,y3_nm"));
        }
        let records = axes.read_all(paths, columns)?;
        let options = self.options(whole_records, least_fit_percent);
        let stop = Interrupt::listen("the best so far is kept")?;
        let mut watcher = Watcher { stop: &stop, bar: None };
        let found = identify(&records, &options, &mut |progress| watcher.tell(progress));
        drop(watcher);
        let found = found.map_err(|e| explain(&e))?;
        let file = found.model_file(&records, &options, &maker());
        let written = if found.interrupted { partial(out) } else { out.to_path_buf() };
        let loaded = model::write(&written, file.clone())?;
        let start = |record: &AxesRecord| whole_period(record, &found);
        let scored = score_axes(&loaded, &records, paths, start)?;
        if result.has_report() {
            let page = loaded.report(&found.findings)?;
            result.write(|| page)?;
        }
        if result.json {
            console::json(&object(&found, &scored, &written, &file))?;
        } else {
            console::result(&text(&found, &scored, &file))?;
            console::message(&format!("model written to {}", written.display()));
        }
        if found.interrupted { Err(stop.failure(&written, ANEW)) } else { Ok(()) }
    }
}

/// The start of a record that was taken for one period as a whole.
fn whole_period(record: &AxesRecord, found: &ModesIdentification) -> Start {
    let whole = |fit: &&ModesRecordFit| fit.record == record.label() && fit.period_samples == record.len();
    match found.records.iter().find(whole) {
        Some(fit) => Start::Settled { period_samples: fit.period_samples },
        None => Start::AsIdentified,
    }
}

/// Progress bar and Ctrl-C.
struct Watcher<'a> {
    stop: &'a AtomicBool,
    bar: Option<Progress>,
}

impl Watcher<'_> {
    fn tell(&mut self, progress: &ModesProgress) -> ControlFlow<()> {
        let bar = self.bar.get_or_insert_with(|| Progress::new("modes", progress.whole));
        bar.set_length(progress.whole);
        let error = progress.rmse.map_or_else(String::new, |rmse| format!(", RMSE {}", significant(rmse, 4)));
        bar.set(progress.done, format!("{}{error}", progress.step));
        if self.stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The object of `--json`.
fn object(found: &ModesIdentification, scored: &[Score], out: &Path, file: &ModesFile) -> Value {
    let mode = |m: &hysteron_model::axes::Mode| json!({"frequency_hz": m.frequency_hz, "damping": m.damping});
    json!({
        "model": out.display().to_string(),
        "structure": "modes",
        "parameters": found.parameters,
        "interrupted": found.interrupted,
        "records": scored,
        "modes": found.modes.iter()
            .map(|m| json!({"lowest_level": mode(&m.low), "highest_level": mode(&m.high)}))
            .collect::<Vec<_>>(),
        "influence": file.influence,
        "findings": found.findings,
    })
}

/// The result for people.
fn text(found: &ModesIdentification, scored: &[Score], file: &ModesFile) -> String {
    let mut modes = console::table(&[
        "mode",
        "lowest level [Hz]",
        "highest level [Hz]",
        "fall [%]",
        "damping, lowest [%]",
        "damping, highest [%]",
    ]);
    for (k, m) in found.modes.iter().enumerate() {
        modes.add_row(vec![
            (k + 1).to_string(),
            significant(m.low.frequency_hz, 5),
            significant(m.high.frequency_hz, 5),
            significant(100.0 * (1.0 - m.high.frequency_hz / m.low.frequency_hz), 2),
            significant(100.0 * m.low.damping, 3),
            significant(100.0 * m.high.damping, 3),
        ]);
    }
    let mut text = format!("{modes}\n\n");
    for level in &found.influence {
        text += &format!(
            "influence at {} {} rms\n{}\n\n",
            significant(level.level, 4),
            file.units.input,
            influence(&level.matrix, file)
        );
    }
    text += &format!("{}\n\n", table(scored));
    for finding in &found.findings {
        text += &format!("{finding}\n");
    }
    for line in &found.treatment {
        text += &format!("data: {line}\n");
    }
    text + &format!("data: {} parameters were fitted\n", found.parameters)
}

fn influence(matrix: &InfluenceMatrix, file: &ModesFile) -> comfy_table::Table {
    let unit = format!("{}/{}", hysteron_model::record::Unit::new(&file.units.output), file.units.input);
    let mut header = vec![format!("[{unit}]")];
    header.extend(file.inputs.iter().cloned());
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let mut table = console::table(&header);
    for (name, row) in file.outputs.iter().zip(matrix.values.chunks(matrix.inputs.max(1))) {
        let numbers = row.iter().map(|g| significant(*g, 4));
        table.add_row(std::iter::once(name.clone()).chain(numbers));
    }
    table
}

/// The library's error with what to do about it.
fn explain(error: &ModesFitError) -> Failure {
    const TITLE: &str = "no modes were identified";
    let failure = Failure::new(TITLE).because(error);
    match error {
        ModesFitError::Option { .. } => Failure::usage(TITLE).because(error),
        ModesFitError::ModelClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); --least-fit 0 hands the model out all the same",
        ),
        ModesFitError::Axes(hysteron_model::axes::AxesError::NotPeriodic { .. }) => failure.hint(
            "drive the inputs with periodic multisines of different phases, two periods or more; --initial periodic takes each record for \
             one period of a steady state; --structure hammerstein fits records that do not repeat",
        ),
        ModesFitError::Axes(hysteron_model::axes::AxesError::Dependent { .. }) => {
            failure.hint("add records whose inputs have other phases, at the same level")
        }
        _ => failure,
    }
}
