//! Result in words.

use hysteron_model::tracking::{Tracking, differ};
use hysteron_numeric::display::short;

use crate::number::significant;

/// Plant, reference, rate, limits and samples that are scored.
pub fn introduction(found: &Tracking) -> String {
    let [from, to] = [found.scored.start, found.scored.end].map(|k| k as f64 / found.sample_rate_hz);
    let to = if found.scored.end < found.reference.len() {
        format!(" to {} s, up to which the preview of the reference is complete,", significant(to, 4))
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
         displacement from {} s{to} their mean removed.",
        found.plant.words,
        found.name,
        short(found.sample_rate_hz),
        significant(low, 4),
        significant(high, 4),
        found.input,
        significant(from, 3)
    )
}

/// Controllers whose error exceeds the whole stroke.
pub fn of_runaways(found: &Tracking) -> Option<String> {
    let names: Vec<&str> =
        found.runs.iter().filter(|run| run.runs_away()).map(|run| run.controller.words()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "Do not use: {}. The error exceeds the whole stroke: the stage does not follow. Feedback loops \
             oscillate, because the stage differs from the model that the margins are computed from: \
             identify the model up to higher frequencies, or ask for more margin.",
            names.join("; ")
        )
    })
}

/// Definition of the bandwidths, and agreement of formula and simulated sines.
pub fn of_bandwidths(found: &Tracking) -> String {
    let Some(sines) = &found.sines else { return String::new() };
    let apart = found.runs.iter().filter_map(|run| run.bandwidths());
    let apart = apart.filter(|both| both.iter().any(|(formula, played)| differ(*formula, *played))).count();
    let verdict = if apart == 0 {
        "Formula and sines agree within a tenth.".to_owned()
    } else {
        format!(
            "For {apart} of {} controllers they differ by more than a tenth (last column): rely on the \
             simulated sines.",
            found.runs.len()
        )
    };
    let limited = found.runs.iter().filter(|run| {
        let mut answers = run.followed.iter().flat_map(|followed| &followed.answers);
        answers.any(|answer| answer.held_back > 0)
    });
    let limited = match limited.count() {
        0 => String::new(),
        count => format!(" Range or slew rate of the drive limited the sines of {count} controllers."),
    };
    format!(
        "Bandwidths: up to where a sine keeps 1/√2 of its amplitude (−3 dB), and up to where its rms error \
         stays below 1 % of its stroke. By formula of the model, assumed linear and exact; and by simulated \
         sines from {} to {} Hz, {} {} about {} {}, hysteresis, limits and noise included. \
         {verdict}{limited}",
        significant(sines.range_hz[0], 3),
        significant(sines.range_hz[1], 3),
        significant(sines.amplitude, 3),
        found.output,
        significant(sines.level, 3),
        found.output
    )
}

/// Introduction of the table of adaptations.
pub const OF_ADAPTATIONS: &str = "Adaptive weights: step size and stability limit for a constant or a single \
    sine up to the highest frequency, for an exact model; largest phase difference between stage and model \
    (the inverse alone, sines), which must stay below 90° for any step; error, and that of the best constant \
    weights.";
