//! What a drive is designed for where the model does not have it, and what is said about that.

use super::limits::{Limits, SAMPLES_A_PERIOD};
use super::prior::Assumed;
use super::quantities::{creeps, rises_within};
use super::{DesignOptions, Purpose};
use hysteron_model::hammerstein::Model;
use hysteron_model::{Finding, FindingKind};
use hysteron_numeric::display::short_to;

/// Highest frequency over the resonance.
pub(super) const ABOVE_RESONANCE: f64 = 1.5;

/// Dynamics to assume, where the model lacks those that the drive is for.
pub(super) fn assumed(
    options: &DesignOptions,
    model: &Model,
    own_resonance: Option<f64>,
    limits: &Limits,
    findings: &mut Vec<Finding>,
) -> Assumed {
    let mut warn =
        |topic: &'static str, text: String| findings.push(Finding::new(FindingKind::Warning, topic, text));
    if options.purpose != Purpose::Resonance && options.resonance_hz.is_some() {
        warn("resonance", "The drive is not for the resonance: the one given is not used.".to_owned());
    }
    if options.purpose == Purpose::Creep && own_resonance.is_some_and(|f| rises_within(f, options.time_s)) {
        let text = "Up to ten times the inverse of the time of the drive the gain rises towards the resonance: the \
                    creep per decade is less by that rise; a longer drive tells them apart.";
        warn("creep", text.to_owned());
    }
    match options.purpose {
        Purpose::Resonance => {
            let assumed_hz = options.resonance_hz.unwrap_or(0.5 * limits.highest_hz);
            match own_resonance {
                None => warn(
                    "resonance",
                    format!(
                        "The model has no resonance: one near {} Hz is assumed, known to a third.",
                        short_to(assumed_hz, 3)
                    ),
                ),
                Some(own_hz) if options.resonance_hz.is_some() => warn(
                    "resonance",
                    format!(
                        "The model has a resonance, at {} Hz: the one given is not used.",
                        short_to(own_hz, 3)
                    ),
                ),
                Some(_) => {}
            }
            let frequency_hz = own_resonance.unwrap_or(assumed_hz);
            if frequency_hz > limits.highest_hz {
                warn("resonance", above_highest(frequency_hz, limits));
            }
            own_resonance.map_or(Assumed::Resonance { frequency_hz }, |_| Assumed::Nothing)
        }
        Purpose::Creep if !creeps(model, options.time_s) => {
            let text = "The model has no creep: creep of one percent after a second is assumed, known to its \
                        own size.";
            warn("creep", text.to_owned());
            Assumed::Creep
        }
        _ => Assumed::Nothing,
    }
}

/// That a resonance is above the highest frequency of the drive, and what to do.
fn above_highest(frequency_hz: f64, limits: &Limits) -> String {
    let needed_hz = ABOVE_RESONANCE * SAMPLES_A_PERIOD * frequency_hz;
    let remedy = if needed_hz > limits.rate_hz {
        format!("choose a sample rate of {} Hz or more", short_to(needed_hz, 2))
    } else {
        format!("raise that to {} Hz", short_to(ABOVE_RESONANCE * frequency_hz, 2))
    };
    format!(
        "The resonance at {} Hz is above the highest frequency of the drive, {} Hz, which its steps alone exceed: \
         {remedy}.",
        short_to(frequency_hz, 3),
        short_to(limits.highest_hz, 3)
    )
}
