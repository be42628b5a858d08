//! A model corrected over a record: coefficients, errors, alarms of the monitor.

use hysteron_identify::online::{Alarm, FollowMethod, FollowOptions, Followed};
use hysteron_model::record::InputOutput;
use hysteron_numeric::display::short;
use hysteron_rt::Misfit;

use super::{Listing, in_unit};
use crate::number::{significant, with_std_error};

/// Alarms that are told one by one.
const SHOWN: usize = 5;

/// Each coefficient before and after.
pub fn coefficients(found: &Followed) -> Listing {
    let mut moved = Listing::new(["coefficient", "before", "after", "±", "least", "greatest"]);
    for path in &found.paths {
        let (end, error) = with_std_error(path.end, path.std_error);
        moved.push([
            path.term.to_string(),
            significant(path.start, 6),
            end,
            if path.std_error.is_some() { error } else { "-".to_owned() },
            significant(path.least, 5),
            significant(path.greatest, 5),
        ]);
    }
    moved
}

/// Errors of the model as it was and corrected, in the output's unit.
pub fn errors(found: &Followed, unit: &str) -> Listing {
    let mut errors = Listing::new(["output".to_owned(), in_unit("RMSE", unit), in_unit("max error", unit)]);
    for (what, scores) in [
        ("model as it was", &found.before),
        ("… with its offset estimated", &found.before_offset_estimated),
        ("corrected, each sample predicted from the previous ones", &found.predicted),
        ("corrected, all samples with the last coefficients", &found.last),
    ] {
        errors.push([what.to_owned(), significant(scores.rmse, 4), significant(scores.max_abs_error, 4)]);
    }
    errors
}

/// The method in a sentence.
pub fn method(found: &Followed, options: &FollowOptions, unit: &str) -> String {
    let how = match options.method {
        FollowMethod::LeastSquares { .. } => {
            format!("recursive least squares, memory {} s", short(found.memory_s.unwrap_or_default()))
        }
        FollowMethod::Gradient { step } => format!("normalised least mean squares, step {}", short(step)),
    };
    let from =
        if found.every == 1 { "every sample".to_owned() } else { format!("one of {} samples", found.every) };
    let noise = format!("{} {unit}", short(options.noise));
    format!("method: {how}, from {from}; noise {}.", noise.trim_end())
}

/// What the monitor says: the verdict, then the first alarms.
pub fn verdict(found: &Followed, data: &InputOutput, options: &FollowOptions) -> Vec<String> {
    let Some(first) = found.alarms.first() else {
        return vec!["verdict: the corrected model fits: no alarm over the record.".to_owned()];
    };
    let says = if options.reopen {
        "alarms, after each of which the estimation was reset"
    } else {
        "the corrected model no longer fits"
    };
    let at = |alarm: &Alarm| format!("{} s", short(time_s(data, alarm)));
    let mut lines = vec![format!(
        "verdict: {says}: first at {} ({}); {} in all.",
        at(first),
        misfit(first.misfit),
        found.alarms.len()
    )];
    let told = found.alarms.iter().take(SHOWN);
    lines.extend(told.map(|alarm| format!("alarm: {}: {}.", at(alarm), misfit(alarm.misfit))));
    lines
}

fn misfit(misfit: Misfit) -> &'static str {
    match misfit {
        Misfit::Above => "the output lies above the model's prediction",
        Misfit::Below => "the output lies below the model's prediction",
        Misfit::Spread => "the variance of the residual is too large",
    }
}

fn time_s(data: &InputOutput, alarm: &Alarm) -> f64 {
    let first = data.time.time_s(0).unwrap_or(0.0);
    data.time.time_s(alarm.sample).unwrap_or(first)
}
