//! The comparison as text.

use hysteron_identify::frequency_response::Explained;
use hysteron_report::results::response::{ABOUT_AIC, parameters, structures};

use crate::{advice, console};

pub fn text(found: &Explained) -> String {
    let explanations: String =
        found.candidates.iter().map(|c| format!("{}: {}\n", c.name, c.explanation)).collect();
    let findings: String =
        found.findings().iter().map(|f| format!("warning: {}\n", advice::text(f))).collect();
    let records = found.empirical.as_ref().map_or_else(String::new, |e| e.in_words() + "\n");
    format!(
        "{}\n{findings}{records}\n{}\n\n{explanations}\n{}\n\n{ABOUT_AIC}\n",
        found.what(),
        console::listed(&structures(found)),
        console::listed(&parameters(found))
    )
}
