//! What came of the correction, for people and for programs.

use std::path::Path;

use clap::ValueEnum;
use hysteron_identify::online::{Alarm, Term};
use hysteron_numeric::display::short;
use hysteron_report::number::{significant, with_std_error};
use hysteron_rt::Misfit;
use serde_json::{Value, json};

use super::follow::Followed;
use super::{Method, Task};
use crate::console;

/// Alarms that are printed one by one.
const SHOWN: usize = 5;

/// A term as on the command line.
pub fn name(term: Term) -> String {
    match term {
        Term::Offset => "offset".to_owned(),
        Term::Gain => "gain".to_owned(),
        Term::Power(n) => format!("power={n}"),
        Term::Creep { lag_s } => format!("creep={}", short(lag_s)),
    }
}

fn misfit(misfit: Misfit) -> (&'static str, &'static str) {
    match misfit {
        Misfit::Above => ("above", "the output lies above what the model says"),
        Misfit::Below => ("below", "the output lies below what the model says"),
        Misfit::Spread => ("spread", "the residuals scatter more than they should"),
    }
}

fn time_s(task: &Task, alarm: &Alarm) -> f64 {
    let first = task.data.time.time_s(0).unwrap_or(0.0);
    task.data.time.time_s(alarm.sample).unwrap_or(first)
}

fn method(task: &Task) -> String {
    task.method.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned())
}

/// The tables and what they say.
pub fn text(task: &Task, found: &Followed) -> String {
    let mut moved = console::table(&["coefficient", "before", "after", "±", "least", "greatest"]);
    for path in &found.paths {
        let (end, error) = with_std_error(path.end, path.std_error);
        moved.add_row([
            name(path.term),
            significant(path.start, 6),
            end,
            if path.std_error.is_some() { error } else { "-".to_owned() },
            significant(path.least, 5),
            significant(path.greatest, 5),
        ]);
    }
    let unit = task.data.y_unit.to_string();
    let rmse = console::in_unit("RMSE", &unit);
    let largest = console::in_unit("max error", &unit);
    let mut errors = console::table(&["output", &rmse, &largest]);
    for (what, scores) in [
        ("model as it was", &found.before),
        ("… with its offset estimated", &found.before_offset_estimated),
        ("corrected, each sample predicted by those before", &found.predicted),
        ("corrected, all samples with the last coefficients", &found.last),
    ] {
        errors.add_row([what.to_owned(), significant(scores.rmse, 4), significant(scores.max_abs_error, 4)]);
    }
    let noise = format!("{} {unit}", short(task.noise));
    let how = match task.method {
        Method::Rls => format!("recursive least squares, memory {} s", short(task.memory_s)),
        Method::Nlms => format!("normalised least mean squares, step {}", short(task.step)),
    };
    let from =
        if found.every == 1 { "every sample".to_owned() } else { format!("one of {} samples", found.every) };
    format!(
        "{moved}\n\n{errors}\n\nmethod: {how}, from {from}; noise {}.\n{}",
        noise.trim_end(),
        verdict(task, found)
    )
}

/// Whether and when the model stopped fitting.
fn verdict(task: &Task, found: &Followed) -> String {
    let Some(first) = found.alarms.first() else {
        return "verdict: the corrected model fits: no alarm over the record.\n".to_owned();
    };
    let says = if task.reopen {
        "alarms, after each of which the coefficients were free again"
    } else {
        "the corrected model no longer fits"
    };
    let mut lines = format!(
        "verdict: {says}: first at {} s ({}); {} in all.\n",
        short(time_s(task, first)),
        misfit(first.misfit).1,
        found.alarms.len()
    );
    for alarm in found.alarms.iter().take(SHOWN) {
        lines += &format!("alarm: {} s: {}.\n", short(time_s(task, alarm)), misfit(alarm.misfit).1);
    }
    lines
}

/// The object of `--json`.
pub fn outcome(task: &Task, found: &Followed, model: Option<&Path>) -> Value {
    let coefficients: Vec<Value> = found
        .paths
        .iter()
        .map(|p| {
            json!({
                "term": name(p.term),
                "before": p.start,
                "after": p.end,
                "std_error": p.std_error,
                "least": p.least,
                "greatest": p.greatest,
            })
        })
        .collect();
    let alarms: Vec<Value> = found
        .alarms
        .iter()
        .map(|a| json!({ "time_s": time_s(task, a), "sample": a.sample, "misfit": misfit(a.misfit).0 }))
        .collect();
    json!({
        "model": model.map(|m| m.display().to_string()),
        "record": task.data.source.as_ref().map_or(&task.data.name, |s| &s.path),
        "unit": task.data.y_unit.symbol(),
        "method": method(task),
        "memory_s": (task.method == Method::Rls).then_some(task.memory_s),
        "every": found.every,
        "noise": task.noise,
        "coefficients": coefficients,
        "rmse_before": found.before.rmse,
        "rmse_before_offset_estimated": found.before_offset_estimated.rmse,
        "rmse_predicted": found.predicted.rmse,
        "rmse_last_coefficients": found.last.rmse,
        "fits": found.alarms.is_empty(),
        "alarms": alarms,
    })
}
