//! Remarks of the library on a simulation, in words, with the flag that says otherwise.

use std::path::Path;

use hysteron_model::model::{Remark, SignalRole};
use hysteron_model::{Model, Start};
use hysteron_numeric::display::short;

use crate::console;

/// Prints the remarks on the record at `path`.
pub fn tell(path: &Path, model: &Model, remarks: &[Remark]) {
    for remark in remarks {
        if let Some(text) = text(model, remark) {
            console::note(&format!("{}: {text}", path.display()));
        }
    }
}

fn text(model: &Model, remark: &Remark) -> Option<String> {
    let units = model.units();
    Some(match remark {
        Remark::UnitAssumed { signal, unit } => {
            format!("the {} has no unit; taken to be in {unit}, the model's", signal.name())
        }
        Remark::Extrapolates { input, identified, unit } => format!(
            "the input runs from {} to {} {unit}, the model was identified from {} to {} {unit}: it extrapolates",
            short(input.0),
            short(input.1),
            short(identified.0),
            short(identified.1),
        ),
        Remark::LevelExtrapolates { level, identified, unit } => format!(
            "the inputs have {} {unit} rms, the model was identified from {} to {} {unit}: it extrapolates, with the modes of \
             the nearest level",
            short(*level),
            short(identified.0),
            short(identified.1),
        ),
        Remark::DoesNotRepeat if model.channels().is_some() => {
            "this drive does not repeat and is taken to start at rest, its inputs held before (--settled says otherwise)".into()
        }
        Remark::DoesNotRepeat if !model.rests_at_a_voltage() => {
            "the model was identified on settled periodic records; this drive does not repeat and is taken to start at rest \
             (--settled says otherwise)"
                .into()
        }
        Remark::DoesNotRepeat => {
            "the model was identified on settled periodic records; this drive does not repeat and is taken to start at rest at \
             its first sample (--rest-voltage says otherwise)"
                .into()
        }
        Remark::StartChosen { chosen, expected } if model.rests_at_a_voltage() => format!(
            "simulated {}, which explains it better than {} (--rest-voltage or --settled say otherwise)",
            chosen.in_words(&units.input, &units.output),
            expected.in_words(&units.input, &units.output)
        ),
        Remark::StartChosen { chosen, expected } => format!(
            "simulated {}, which explains it better than {} (--settled says otherwise)",
            from_rest_or_settled(chosen),
            from_rest_or_settled(expected)
        ),
        Remark::LeftOut { samples } => format!(
            "the drive starts with a jump, which a model without dynamics cannot follow: its first {samples} samples are not \
             scored (--skip 0 scores them)"
        ),
        Remark::Fast { signal, fastest_hz, identified_hz } => format!(
            "the {} swings at up to {} Hz, the model was identified up to {} Hz: beyond that it extrapolates{}",
            signal.name(),
            short(*fastest_hz),
            short(*identified_hz),
            if *signal == SignalRole::Reference { ", and the predicted error says nothing of that" } else { "" }
        ),
        _ => return None,
    })
}

/// A start of a model that knows no rest voltage.
fn from_rest_or_settled(start: &Start) -> String {
    match start {
        settled @ Start::Settled { .. } => settled.in_words("", ""),
        _ => "from rest".to_owned(),
    }
}
