//! `hysteron registry show`: the calibrations of a device.

use std::path::PathBuf;

use clap::Args;
use hysteron_registry::{Calibration, Parameter};
use hysteron_report::number::{significant, with_std_error};
use serde::Serialize;

use super::{explain, open};
use crate::console;
use crate::failure::Failure;

/// Show a device: its calibrations over time, and the parameters of each
#[derive(Args)]
pub struct Show {
    /// The registry
    #[arg(value_name = "FILE")]
    registry: PathBuf,

    /// Name of the device
    #[arg(value_name = "DEVICE")]
    device: String,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Shown<'a> {
    device: &'a str,
    calibrations: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    #[serde(flatten)]
    calibration: Calibration,
    parameters: Vec<Parameter>,
}

impl Show {
    pub fn run(&self) -> Result<(), Failure> {
        let registry = open(&self.registry)?;
        let entry = |calibration: Calibration| {
            let parameters = registry.parameters(&calibration)?;
            Ok(Entry { calibration, parameters })
        };
        let history = registry.history(&self.device).and_then(|h| h.into_iter().map(entry).collect());
        let calibrations: Vec<Entry> = history.map_err(|e| explain(&self.registry, &e))?;
        if self.json {
            return console::json(&Shown { device: &self.device, calibrations });
        }
        console::result(&text(&self.device, &calibrations))
    }
}

fn text(device: &str, calibrations: &[Entry]) -> String {
    let mut table = console::table(&["date", "status", "fit [%]", "RMSE", "operator", "notes", "reason"]);
    for Entry { calibration: c, .. } in calibrations {
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 4));
        let rmse = format!("{} {}", number(c.rmse), c.unit).trim().to_owned();
        table.add_row([&c.date, &c.status, &number(c.fit_percent), &rmse, &c.operator, &c.notes, &c.reason]);
    }
    let mut text = format!("{device}\n{table}\n");
    let Some(latest) = calibrations.iter().rev().find(|entry| !entry.parameters.is_empty()) else {
        return text;
    };
    let mut table = console::table(&["parameter", "value", "std. error", "unit"]);
    for p in &latest.parameters {
        let (value, error) = p.value.map(|value| with_std_error(value, p.std_error)).unwrap_or_default();
        let error = match p.std_error {
            Some(_) => error,
            None if p.held => "held".to_owned(),
            None => "not determined".to_owned(),
        };
        table.add_row([&p.name, &value, &error, &p.unit]);
    }
    text += &format!("parameters of {}\n{table}\n", latest.calibration.date);
    text
}
