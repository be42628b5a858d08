//! What a designed drive makes certain, before and after.

use hysteron_identify::design::{DesignSummary, Expected};
use hysteron_model::record::Unit;

use super::Listing;
use crate::number::significant;

/// Standard errors now, after the drive, after loop and sweep of the same length.
pub fn expected(design: &DesignSummary) -> Listing {
    let mut rows = Listing::new([
        "standard error of",
        "estimate",
        "now",
        "after this drive",
        "after loop + sweep",
        "unit",
    ]);
    for e in &design.expected {
        let error = |x: f64| significant(x, 3);
        rows.push([
            if e.aim { format!("{} (aim)", e.name) } else { e.name.clone() },
            e.value.map_or("-".to_owned(), |value| significant(value, 5)),
            error(e.now),
            error(e.designed),
            error(e.usual),
            if e.unit.is_empty() { String::new() } else { Unit::new(&e.unit).to_string() },
        ]);
    }
    rows
}

/// Fall of a standard error, as a share of it, below which a drive tells nothing new.
const NOTHING_NEW: f64 = 0.005;

/// The gain over loop and sweep in a sentence.
pub fn verdict(design: &DesignSummary) -> String {
    let aims: Vec<&Expected> = design.expected.iter().filter(|e| e.aim).collect();
    if aims.iter().all(|e| e.designed > (1.0 - NOTHING_NEW) * e.now) {
        let names: Vec<String> = aims.iter().map(|e| format!("of the {}", e.name)).collect();
        return format!(
            "the standard error {} does not fall: with this noise and length no drive tells more than is known; a \
             longer drive, a wider range or less noise does.",
            names.join(" and ")
        );
    }
    let changes: Vec<String> = aims
        .iter()
        .map(|e| {
            let unit = if e.unit.is_empty() { String::new() } else { Unit::new(&e.unit).spaced() };
            format!(
                "the standard error of the {} falls from {} to {}{unit}",
                e.name,
                significant(e.now, 3),
                significant(e.designed, 3)
            )
        })
        .collect();
    let against = match design.usual_repetitions {
        Some(times) if times > 1.005 => {
            format!(
                "a loop and a sweep of this length must be run {} times for the same",
                significant(times, 3)
            )
        }
        Some(_) => "this is the usual loop and sweep: no other drive tried is better".to_owned(),
        None => {
            "a loop and a sweep of this length do not reach the same however often they are run".to_owned()
        }
    };
    format!("{}; {against}.", changes.join(", and "))
}
