//! Parameters that the records determine together.

use hysteron_identify::structure::Prospects;
use hysteron_model::record::InputOutput;

use crate::console;

/// For people.
pub fn text(prospects: &Prospects, records: &[InputOutput]) -> String {
    let what = match records.len() {
        1 => "This record determines",
        _ => "These records together determine",
    };
    let mut table = console::table(&[what, "", "because"]);
    for p in &prospects.statements {
        let answer = match p.determined {
            Some(true) => "yes",
            Some(false) => "no",
            None => "in part",
        };
        table.add_row([p.topic.as_ref(), answer, p.text.as_str()]);
    }
    let mut text = format!("{table}\n");
    if records.len() > 1 {
        for (record, content) in records.iter().zip(&prospects.records) {
            text += &format!("- {}: {content}\n", record.name);
        }
    }
    match &prospects.next {
        Some(next) => text + &format!("Measure next: {next}.\n"),
        None => text + "Measure next: a record for validation, of another amplitude and other frequencies.\n",
    }
}
