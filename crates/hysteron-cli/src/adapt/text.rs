//! Results of a correction, as text and as JSON.

use hysteron_identify::online::{Alarm, FollowMethod, Followed};
use hysteron_numeric::display::short;
use hysteron_report::number::{significant, with_std_error};
use hysteron_rt::Misfit;

use super::Task;
use crate::console;

/// Alarms that are printed one by one.
const SHOWN: usize = 5;

fn misfit(misfit: Misfit) -> (&'static str, &'static str) {
    match misfit {
        Misfit::Above => ("above", "the output lies above the model's prediction"),
        Misfit::Below => ("below", "the output lies below the model's prediction"),
        Misfit::Spread => ("spread", "the variance of the residual is too large"),
    }
}

fn time_s(task: &Task, alarm: &Alarm) -> f64 {
    let first = task.data.time.time_s(0).unwrap_or(0.0);
    task.data.time.time_s(alarm.sample).unwrap_or(first)
}

/// Tables of coefficients and errors, and the verdict.
pub fn text(task: &Task, found: &Followed) -> String {
    let mut moved = console::table(&["coefficient", "before", "after", "±", "least", "greatest"]);
    for path in &found.paths {
        let (end, error) = with_std_error(path.end, path.std_error);
        moved.add_row([
            path.term.to_string(),
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
        ("corrected, each sample predicted from the previous ones", &found.predicted),
        ("corrected, all samples with the last coefficients", &found.last),
    ] {
        errors.add_row([what.to_owned(), significant(scores.rmse, 4), significant(scores.max_abs_error, 4)]);
    }
    let noise = format!("{} {unit}", short(task.options.noise));
    let how = match task.options.method {
        FollowMethod::LeastSquares { .. } => {
            format!("recursive least squares, memory {} s", short(found.memory_s.unwrap_or_default()))
        }
        FollowMethod::Gradient { step } => {
            format!("normalised least mean squares, step {}", short(step))
        }
    };
    let from =
        if found.every == 1 { "every sample".to_owned() } else { format!("one of {} samples", found.every) };
    format!(
        "{moved}\n\n{errors}\n\nmethod: {how}, from {from}; noise {}.\n{}",
        noise.trim_end(),
        verdict(task, found)
    )
}

/// Alarms of the monitor, in words.
fn verdict(task: &Task, found: &Followed) -> String {
    let Some(first) = found.alarms.first() else {
        return "verdict: the corrected model fits: no alarm over the record.\n".to_owned();
    };
    let says = if task.options.reopen {
        "alarms, after each of which the estimation was reset"
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
