//! Treatment of the records before the fit, in words.

use super::RecordFacts;
use super::joint::UNKNOWN_PAST;
use super::options::{Initial, Options, RecordRole};
use super::result::Identification;
use hysteron_model::Start;
use hysteron_numeric::display::short;

/// One sentence per record: role, samples, start, offset, and omitted samples.
pub(super) fn treatment(facts: &[RecordFacts], options: &Options, result: &Identification) -> Vec<String> {
    let mut list = Vec::new();
    if let Some(reduction) = result.reduction {
        list.push(reduction.describe());
    }
    let mut quasi_static = 0;
    for (facts, fit) in facts.iter().zip(&result.records) {
        let name = &fit.data.name;
        let unit = &fit.data.y_unit;
        let start = match fit.start {
            Start::AsIdentified => "simulated from rest at its first sample".to_owned(),
            Start::Rest { voltage_v } => {
                format!("simulated from rest at {} {}", short(voltage_v), fit.data.u_unit)
                    .trim_end()
                    .to_owned()
            }
            Start::Remembering { voltage_v, memory } => format!(
                "simulated from rest at {voltage_v} {} {} that it fits",
                fit.data.u_unit,
                memory.in_words(&short(memory.value()), &fit.data.u_unit.to_string(), &unit.to_string())
            ),
            settled @ Start::Settled { .. } => settled.in_words("", ""),
        };
        let role = match fit.role {
            RecordRole::QuasiStatic => "quasi-static",
            RecordRole::Dynamic => "dynamic",
        };
        let masked = facts.data.y.len() - facts.scored(0).len();
        let masked =
            if masked > 0 { format!(", {masked} samples masked as not valid") } else { String::new() };
        let offset = match options.demands.fixed(super::static_step::OFFSET) {
            Some(value) => format!("held at {value} {unit}"),
            None => "estimated".to_owned(),
        };
        list.push(format!(
            "{name}: {role}, {} samples{masked}, {start}; its offset was {offset}.",
            facts.data.y.len()
        ));
        if options.initial != Initial::Periodic
            && let Some(cycle) = facts.first_of_several_cycles()
        {
            list.push(format!(
                "{name}: the first of several cycles ({cycle} samples) has {UNKNOWN_PAST} of the weight of \
                 the others in the fit, because the history before it is unknown; the scores count it as any \
                 other."
            ));
        }
        if fit.data.valid != facts.data.valid {
            list.push(format!(
                "{name}: the fit was interrupted; its scores are of its first {} samples.",
                fit.scores.samples
            ));
        }
        if fit.role == RecordRole::QuasiStatic {
            let creep = result.structure.creeps.get(quasi_static).copied().unwrap_or(0.0);
            let left_out = result.structure.left_out.get(quasi_static).copied().unwrap_or(0);
            if creep != 0.0 {
                list.push(format!(
                    "{name}: a slow creep of {creep:.3} {unit} per e-fold of time was allowed for in the \
                     fit; it is not part of the model and counts in the scores."
                ));
            }
            if left_out > 0 {
                list.push(format!(
                    "{name}: its first {left_out} samples (rest, or a start that a model without lag cannot \
                     follow) were left out of the fit and its scores."
                ));
            }
            quasi_static += 1;
        }
    }
    list
}
