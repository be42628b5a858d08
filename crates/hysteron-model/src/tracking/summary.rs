//! Result as an object with units in its keys.

use hysteron_numeric::number::significant;
use serde::{Serialize, Serializer};

use crate::control::{Edge, FeedbackKind, Loop, Reach, SineAnswer, Sines};
use crate::record::{Keyed, key_in, range_of};

use super::run::{Adaptation, differ};
use super::{ControllerRun, Tracking};

impl Serialize for Tracking {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        summary(self).serialize(serializer)
    }
}

fn summary(found: &Tracking) -> Keyed {
    let (input, output) = (found.input.symbol(), found.output.symbol());
    let slew = found.settings.slew_v_per_s;
    Keyed::default()
        .with("simulated", true)
        .with("plant", found.plant.name)
        .with("samples", found.reference.len())
        .with("sample_rate_hz", found.sample_rate_hz)
        .with("scored_from_s", found.scored.start as f64 / found.sample_rate_hz)
        .with("scored_to_s", found.scored.end as f64 / found.sample_rate_hz)
        .in_unit("range", input, found.settings.range_v)
        .with(key_in("slew", input) + "_per_s", slew.is_finite().then_some(slew))
        .with("sines", found.sines.as_ref().map(|sines| played(sines, output)))
        .with("controllers", found.runs.iter().map(|run| row(run, input, output)).collect::<Vec<_>>())
        .with("reach", found.reach.iter().map(|r| reach(r, input, output)).collect::<Vec<_>>())
}

/// The sines by which bandwidths were measured.
fn played(sines: &Sines, output: &str) -> Keyed {
    Keyed::default()
        .in_unit("level", output, sines.level)
        .in_unit("amplitude", output, sines.amplitude)
        .with("lowest_hz", sines.range_hz[0])
        .with("highest_hz", sines.range_hz[1])
}

fn row(run: &ControllerRun, input: &str, output: &str) -> Keyed {
    let (drive_low, drive_high) = range_of(&run.played.drive);
    let (margins, both) = (run.made.margins(), run.bandwidths());
    // Null where it lies beyond the sines.
    let found = |i: usize| both.and_then(|both| Edge::found(both[i].1));
    let answers = run.followed.iter().flat_map(|followed| &followed.answers);
    Keyed::default()
        .with("controller", run.controller.name())
        .in_unit("rms", output, run.score.rms)
        .in_unit("max", output, run.score.max)
        .in_unit("mean", output, run.score.mean)
        .with("rms_percent_of_stroke", run.score.rms_percent)
        .with("max_percent_of_stroke", run.score.max_percent)
        .with("runs_away", run.runs_away())
        .in_unit("drive_low", input, drive_low)
        .in_unit("drive_high", input, drive_high)
        .with("samples_at_range", run.played.at_range)
        .with("samples_at_slew", run.played.at_slew)
        .with("minus_3_db_formula_hz", run.made.bandwidth.minus_3_db_hz)
        .with("minus_3_db_played_hz", found(0))
        .with("one_percent_error_formula_hz", run.made.bandwidth.one_percent_hz)
        .with("one_percent_error_played_hz", found(1))
        .with(
            "bandwidths_differ",
            both.map(|both| both.iter().any(|(formula, edge)| differ(*formula, *edge))),
        )
        .with("sines", answers.map(sine).collect::<Vec<_>>())
        .with("law", margins.map(|_| law(&run.made)))
        .with("gain_margin", margins.map(|m| m.gain))
        .with("phase_margin_deg", margins.map(|m| m.phase_deg))
        .with("modulus_margin", margins.map(|m| m.modulus))
        .with("crossover_hz", margins.map(|m| m.crossover_hz))
        .with("adaptation", run.adaptation.as_ref().map(adaptation))
}

fn sine(answer: &SineAnswer) -> Keyed {
    Keyed::default()
        .with("frequency_hz", answer.frequency_hz)
        .with("error_percent_of_stroke", answer.error_percent)
        .with("gain", answer.followed.norm())
        .with("phase_deg", answer.followed.arg().to_degrees())
        .with("samples_held_back", answer.held_back)
}

fn adaptation(own: &Adaptation) -> Keyed {
    let filter = &own.filter;
    Keyed::default()
        .with("weights", filter.adaptive.weights)
        .with("stride_samples", filter.stride)
        .with("step", filter.rate)
        .with("step_limit", filter.limit)
        .with("step_limit_at_hz", filter.limit_at_hz)
        .with("step_margin", filter.limit / filter.rate)
        .with("phase_error_deg", own.phase_error.map(|(degrees, _)| degrees))
        .with("phase_error_at_hz", own.phase_error.map(|(_, at_hz)| at_hz))
        .with("phase_margin_deg", own.phase_error.map(|(degrees, _)| 90.0 - degrees))
        .with("best_weights_rms_percent_of_stroke", own.best_percent)
}

fn reach(reach: &Reach, input: &str, output: &str) -> Keyed {
    Keyed::default()
        .in_unit("amplitude", output, reach.amplitude)
        .in_unit("drive_amplitude", input, reach.amplitude_v)
        .with("highest_hz", reach.highest_hz)
}

/// The law as a formula, s in rad/s.
pub fn law(made: &Loop) -> String {
    if let Some((gain, _)) = made.observer {
        return format!("observer, gain {}", significant(gain, 3));
    }
    let Some(tuned) = &made.feedback else { return "–".to_owned() };
    let (k, i) = (significant(tuned.law.proportional, 3), significant(tuned.law.integral_per_s, 3));
    match tuned.law.kind {
        FeedbackKind::Integral => format!("{i}/s"),
        FeedbackKind::Pi { corner_hz } => format!("{k} (1 + 2π {}/s)", significant(corner_hz, 3)),
        FeedbackKind::FractionalPi { corner_hz, order } => {
            format!("{k} (1 + (2π {}/s)^{order})", significant(corner_hz, 3))
        }
        FeedbackKind::NotchIntegral { notch } => format!(
            "{i}/s, notch at {} Hz, damping {} over {}",
            significant(notch.frequency_hz, 4),
            significant(notch.zeros, 2),
            significant(notch.poles, 2)
        ),
    }
}
