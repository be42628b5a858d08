//! `hysteron identify --structure hammerstein --inputs … --outputs …`: a sum of branches.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use hysteron_identify::coupled::{CoupledFitError, CoupledIdentification, identify};
use hysteron_model::Start;
use hysteron_model::model::Score;
use hysteron_model::model_file::{CoupledFile, Quantity};
use hysteron_optimize::Progress as SearchProgress;
use hysteron_report::number::with_std_error;
use serde_json::{Value, json};

use super::{AxesFlags, score_axes};
use crate::columns::InputFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::{ANEW, Interrupt, partial};
use crate::maker::maker;
use crate::model;
use crate::progress::Progress;
use crate::result_flags::ResultFlags;
use crate::scores::table;

/// Identifies the branches of the records and writes their file; prints what was found.
///
/// # Errors
/// If the records cannot be read or used, or the file cannot be written.
pub fn identify_branches(
    (paths, axes, columns): (&[PathBuf], &AxesFlags, &InputFlags),
    (out, result): (&Path, &ResultFlags),
    least_fit_percent: f64,
) -> Result<(), Failure> {
    if axes.outputs.is_empty() {
        return Err(Failure::usage("several axes need their outputs")
            .hint("name them in order, e.g. --outputs y1_nm,y2_nm,y3_nm"));
    }
    let records = axes.read_all(paths, columns)?;
    let stop = Interrupt::listen("the best so far is kept")?;
    let mut bar: Option<Progress> = None;
    let mut watch = |progress: &SearchProgress<'_>| {
        let bar = bar.get_or_insert_with(|| Progress::new("branches", progress.generations as u64));
        bar.set(progress.generation as u64, format!("best RMSE {:.5}", progress.best_cost));
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found = identify(&records, least_fit_percent, &mut watch);
    drop(bar);
    let found = found.map_err(|e| explain(&e))?;
    let file = found.model_file(&records, &maker());
    let interrupted = stop.load(Ordering::Relaxed);
    let written = if interrupted { partial(out) } else { out.to_path_buf() };
    let loaded = model::write(&written, file.clone())?;
    let scored = score_axes(&loaded, &records, paths, |_| Start::AsIdentified)?;
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
    if interrupted { Err(stop.failure(&written, ANEW)) } else { Ok(()) }
}

/// Every parameter with where it belongs.
fn parameters(file: &CoupledFile) -> Vec<(String, &'static str, &Quantity)> {
    let mut all = Vec::new();
    for (name, a) in file.inputs.iter().zip(&file.actuators) {
        all.extend(
            [("alpha", &a.alpha), ("beta", &a.beta), ("gamma", &a.gamma)].map(|(p, q)| (name.clone(), p, q)),
        );
    }
    for (output, row) in file.outputs.iter().zip(&file.paths) {
        for (input, p) in file.inputs.iter().zip(row) {
            let path = format!("{input} to {output}");
            let numbers = [
                ("gain", &p.gain),
                ("natural_frequency", &p.natural_frequency),
                ("damping", &p.damping),
                ("delay", &p.delay),
            ];
            all.extend(numbers.map(|(name, q)| (path.clone(), name, q)));
        }
    }
    all
}

fn object(found: &CoupledIdentification, scored: &[Score], out: &Path, file: &CoupledFile) -> Value {
    json!({
        "model": out.display().to_string(),
        "structure": "hammerstein",
        "records": scored,
        "parameters": parameters(file).into_iter()
            .map(|(of, name, q)| json!({"of": of, "name": name, "value": q.value, "unit": q.unit, "std_error": q.std_error}))
            .collect::<Vec<_>>(),
        "findings": found.findings,
    })
}

fn text(found: &CoupledIdentification, scored: &[Score], file: &CoupledFile) -> String {
    let mut rows = console::table(&["of", "parameter", "value", "std. error", "unit"]);
    for (of, name, q) in parameters(file) {
        let (value, error) = with_std_error(q.value, q.std_error);
        let unit = if q.unit == "1" { String::new() } else { q.unit.replace("um", "µm") };
        rows.add_row(vec![of, name.to_owned(), value, error, unit]);
    }
    let mut text = format!("{rows}\n\n{}\n\n", table(scored));
    for finding in &found.findings {
        text += &format!("{finding}\n");
    }
    text
}

/// The library's error with what to do about it.
fn explain(error: &CoupledFitError) -> Failure {
    let failure = Failure::new("no branches were identified").because(error);
    match error {
        CoupledFitError::ModelClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); several modes a path need --structure modes; --least-fit 0 hands \
             the model out all the same",
        ),
        CoupledFitError::NoStart => failure.hint("drive all inputs in the same record, each with a signal of its own"),
        _ => failure,
    }
}
