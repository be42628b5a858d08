//! Parameters that the records determine together.

use hysteron_identify::structure::Prospects;
use hysteron_model::record::InputOutput;

use crate::console;
use crate::design::{self, DesignFrom};

/// For people.
pub fn text(prospects: &Prospects, records: &[InputOutput], from: DesignFrom<'_>) -> String {
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
    let command = design::command(from, records, prospects.next_for);
    text + &design::measure_next(prospects, &command)
}
