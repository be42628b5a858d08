//! `hysteron registry diff`: two models, number by number, in their standard errors.

use std::path::PathBuf;

use clap::Args;
use hysteron_identify::difference::{Difference, difference};
use hysteron_identify::recalibrate::SIGNIFICANT;
use hysteron_report::number::significant;
use serde::Serialize;

use super::{explain, open};
use crate::console;
use crate::failure::Failure;

/// Compare the latest model of a device with the one before, or with that of another device
#[derive(Args)]
#[command(
    after_help = "Each number is compared in combined standard errors; all of them together by Wald's test with \
    their covariances. Both assume independent records and a model class that is true."
)]
pub struct Diff {
    /// The registry
    #[arg(value_name = "FILE")]
    registry: PathBuf,

    /// Name of the device
    #[arg(value_name = "DEVICE")]
    device: String,

    /// Name of another device; the device's own model before, if not given
    #[arg(value_name = "OTHER")]
    other: Option<String>,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Compared<'a> {
    first: &'a str,
    second: &'a str,
    significant: bool,
    #[serde(flatten)]
    difference: &'a Difference,
}

impl Diff {
    pub fn run(&self) -> Result<(), Failure> {
        let registry = open(&self.registry)?;
        let failed = |e| explain(&self.registry, &e);
        let (first, second) = match &self.other {
            Some(other) => (registry.model(&self.device, 0), registry.model(other, 0)),
            None => (registry.model(&self.device, 1), registry.model(&self.device, 0)),
        };
        let found = difference(&first.map_err(failed)?, &second.map_err(failed)?)
            .map_err(|e| Failure::new("the models cannot be compared").because(e))?;
        let (first, second) = match &self.other {
            Some(other) => (self.device.as_str(), other.as_str()),
            None => ("before", "latest"),
        };
        if self.json {
            let significant = found.is_significant();
            return console::json(&Compared { first, second, significant, difference: &found });
        }
        console::result(&text(first, second, &found))
    }
}

fn text(first: &str, second: &str, found: &Difference) -> String {
    let mut table = console::table(&["number", first, second, "unit", "standard errors", "p", ""]);
    for number in &found.numbers {
        let shown = |value: Option<f64>, digits| value.map_or_else(String::new, |v| significant(v, digits));
        table.add_row([
            number.name.clone(),
            significant(number.first, 6),
            significant(number.second, 6),
            number.unit.clone(),
            shown(number.in_standard_errors, 3),
            shown(number.p, 2),
            if number.significant { "changed".to_owned() } else { String::new() },
        ]);
    }
    let mut text = format!("{table}\n");
    for (names, which) in [(&found.only_first, first), (&found.only_second, second)] {
        if !names.is_empty() {
            text += &format!("only of {which}: {}\n", names.join(", "));
        }
    }
    text += &match &found.joint {
        Some(joint) => format!(
            "All together: chi-square {} with {} degrees of freedom, p = {}: the models {}.\n",
            significant(joint.chi_square, 4),
            joint.degrees,
            significant(joint.p, 2),
            if joint.significant { "differ" } else { "do not differ beyond their standard errors" }
        ),
        None => "No joint test: a model states no correlation of its numbers.\n".to_owned(),
    };
    text + &format!("changed: beyond {SIGNIFICANT} combined standard errors\n")
}
