//! Result in words.

use hysteron_model::tracking::{Tracking, differ};
use hysteron_numeric::display::short;

use crate::number::significant;

/// Plant, reference, rate, limits and samples that are scored.
pub fn introduction(found: &Tracking) -> String {
    let [from, to] = [found.scored.start, found.scored.end].map(|k| k as f64 / found.sample_rate_hz);
    let to = if found.scored.end < found.reference.len() {
        format!(" to {} s, behind which not all is there that is to be known ahead,", significant(to, 4))
    } else {
        String::from(" on,")
    };
    let slew = if found.settings.slew_v_per_s.is_finite() {
        format!(", at most {} {}/s", significant(found.settings.slew_v_per_s, 3), found.input)
    } else {
        String::new()
    };
    let [low, high] = found.settings.range_v;
    format!(
        "Simulated: {} follows {} at {} Hz, driven from {} to {} {}{slew}. Errors are those of the \
         displacement from {} s{to} their mean taken off.",
        found.plant.words,
        found.name,
        short(found.sample_rate_hz),
        significant(low, 4),
        significant(high, 4),
        found.input,
        significant(from, 3)
    )
}

/// Controllers that do not hold the stage.
pub fn of_runaways(found: &Tracking) -> Option<String> {
    let names: Vec<&str> =
        found.runs.iter().filter(|run| run.runs_away()).map(|run| run.controller.words()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "Do not use: {}. The error exceeds the whole stroke: the stage is not held. Where there is \
             feedback its loop oscillates, because the stage is not the model that the margins are of: \
             identify the model up to higher frequencies, or ask for more margin.",
            names.join("; ")
        )
    })
}

/// Definition of the bandwidths, and whether formula and played sines agree.
pub fn of_bandwidths(found: &Tracking) -> String {
    let Some(sines) = &found.sines else { return String::new() };
    let apart = found.runs.iter().filter_map(|run| run.bandwidths());
    let apart = apart.filter(|both| both.iter().any(|(formula, played)| differ(*formula, *played))).count();
    let verdict = if apart == 0 {
        "Formula and sines agree within a tenth.".to_owned()
    } else {
        format!(
            "For {apart} of {} controllers they are more than a tenth apart (last column): trust what was \
             played.",
            found.runs.len()
        )
    };
    let limited = found.runs.iter().filter(|run| {
        let mut answers = run.followed.iter().flat_map(|followed| &followed.answers);
        answers.any(|answer| answer.held_back > 0)
    });
    let limited = match limited.count() {
        0 => String::new(),
        count => format!(" Range or rate of the drive held back sines of {count} controllers."),
    };
    format!(
        "Bandwidths: up to where 1/√2 of a sine is left (−3 dB), and up to where its error stays below 1 % \
         of its stroke, rms. By formula of the model, taken for linear and true; and of sines from {} to {} \
         Hz that were played, {} {} about {} {}, hysteresis, limits and noise included. {verdict}{limited}",
        significant(sines.range_hz[0], 3),
        significant(sines.range_hz[1], 3),
        significant(sines.amplitude, 3),
        found.output,
        significant(sines.level, 3),
        found.output
    )
}

/// Introduction of the table of adaptations.
pub const OF_ADAPTATIONS: &str = "Weights that adapt: the step, and the largest at which a level or a sine \
    up to the highest frequency, alone, leaves them stable if the model is true; by how much the stage \
    differs from the model in phase (the inverse alone, sines), which must stay below 90° for any step; what \
    is left of the reference, and what the best constant weights would have left.";
