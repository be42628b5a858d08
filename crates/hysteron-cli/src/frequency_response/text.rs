//! The comparison as text.

use hysteron_identify::frequency_response::Explained;
use hysteron_report::frequency_response::{ABOUT_AIC, cells};
use hysteron_report::number::with_std_error;

use crate::{advice, console};

const HEADER: [&str; 6] =
    ["structure", "formula", "parameters", "rms error [%]", "largest error [%]", "AIC above the best"];

pub fn text(found: &Explained) -> String {
    let best = found.lowest_aic();
    let mut table = console::table(&HEADER);
    for candidate in &found.candidates {
        table.add_row(cells(candidate, best));
    }
    let explanations: String =
        found.candidates.iter().map(|c| format!("{}: {}\n", c.name, c.explanation)).collect();
    let mut parameters = console::table(&["structure", "parameter", "value", "std. error", "unit"]);
    for candidate in &found.candidates {
        for p in &candidate.fit.parameters {
            let (value, error) = with_std_error(p.value, p.std_error);
            let error = match (p.on_edge, error.is_empty()) {
                (true, _) => "on the edge".to_owned(),
                (false, true) => "-".to_owned(),
                (false, false) => error,
            };
            parameters.add_row([candidate.name.clone(), p.name.clone(), value, error, p.unit.clone()]);
        }
    }
    let findings: String =
        found.findings().iter().map(|f| format!("warning: {}\n", advice::text(f))).collect();
    let records = found.empirical.as_ref().map_or_else(String::new, |e| e.in_words() + "\n");
    format!("{}\n{findings}{records}\n{table}\n\n{explanations}\n{parameters}\n\n{ABOUT_AIC}\n", found.what())
}
