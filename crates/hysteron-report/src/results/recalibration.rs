//! Gain, delay and offset before and after a recalibration.

use hysteron_identify::recalibrate::{Change, Recalibration, SIGNIFICANT};

use super::{Listing, in_unit};
use crate::number::{significant, with_std_error};

/// Gain and delay: old, from the records alone, new.
pub fn numbers(found: &Recalibration) -> Listing {
    let mut numbers = Listing::new(["", "old", "± ", "from the records", "±", "new", "±", "unit"]);
    for (name, change, unit) in [("gain", &found.gain, ""), ("delay", &found.delay, "s")] {
        let mut row = vec![name.to_owned()];
        for (value, error) in [
            (change.old, change.old_std_error),
            (change.measured, change.measured_std_error),
            (change.value, change.std_error),
        ] {
            let (value, shown) = with_std_error(value, error);
            row.extend([value, if error.is_some() { shown } else { "-".to_owned() }]);
        }
        row.push(unit.to_owned());
        numbers.push(row);
    }
    numbers
}

/// Errors of each record before and after, in the output's unit.
pub fn scores(found: &Recalibration, unit: &str) -> Listing {
    let rmse = in_unit("RMSE", unit);
    let (before, after) = (format!("{rmse} before"), format!("{rmse} after"));
    let mut scores = Listing::new(["record", "samples", &before, &after, "fit [%]"]);
    for r in &found.records {
        scores.push([
            r.data.name.clone(),
            r.after.samples.to_string(),
            significant(r.before.rmse, 4),
            significant(r.after.rmse, 4),
            r.after.fit_percent.map_or("-".to_owned(), |fit| format!("{fit:.2}")),
        ]);
    }
    scores
}

/// The new offset in a sentence.
pub fn offset(found: &Recalibration, unit: &str) -> String {
    format!("offset: {} {unit} (of the first record)", significant(found.model.offset, 6))
}

/// Verdicts on gain and delay, a sentence each.
pub fn verdicts(found: &Recalibration) -> [String; 2] {
    [verdict("gain", &found.gain), verdict("delay", &found.delay)]
}

/// Verdict on the change of a parameter.
fn verdict(name: &str, change: &Change) -> String {
    let Some(times) = change.in_standard_errors() else {
        return if change.value.to_bits() == change.old.to_bits() {
            format!("{name}: the records do not determine it; it is held at its old value.")
        } else {
            format!(
                "{name}: the estimate is on the edge of its search range, {}; it is held there, without a \
                 standard error.",
                significant(change.value, 4)
            )
        };
    };
    let prior = match (change.old_std_error, change.measured_std_error) {
        (None, _) => {
            " (the model file gives no standard error of the old value: that of the records alone)".to_owned()
        }
        // An uncertain old value must not be taken as evidence of an unchanged device.
        (Some(old), Some(measured)) if old > SIGNIFICANT * measured => format!(
            " (standard error of the old value ± {}, of that from the records only ± {})",
            significant(old, 2),
            significant(measured, 2)
        ),
        _ => String::new(),
    };
    let times = significant(times, 2);
    if change.is_significant() {
        format!(
            "{name}: the device has changed: {times} combined standard errors from the old value, more than \
             {SIGNIFICANT}{prior}; the new value is that of the records alone."
        )
    } else {
        format!("{name}: no significant change: {times} combined standard errors from the old value{prior}.")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sentence_says_what_the_table_shows() {
        let old = Change {
            old: 1.0,
            old_std_error: Some(0.01),
            measured: 1.3,
            measured_std_error: None,
            value: 1.0,
            std_error: Some(0.01),
        };
        assert!(verdict("gain", &old).contains("held at its old value"));
        let edge =
            verdict("delay", &Change { old: 0.002, measured: 0.0, value: 0.0, std_error: None, ..old });
        assert!(edge.contains("edge") && !edge.contains("old value"), "{edge}");
        let changed = Change { measured_std_error: Some(0.01), value: 1.3, ..old };
        assert!(verdict("gain", &changed).contains("the device has changed"));
    }
}
