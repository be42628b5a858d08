//! `hysteron registry list`: every device with its latest calibration.

use std::path::PathBuf;

use clap::Args;
use hysteron_report::number::significant;

use super::{explain, open};
use crate::console;
use crate::failure::Failure;

/// List every device with its latest calibration
#[derive(Args)]
pub struct List {
    /// The registry
    #[arg(value_name = "FILE")]
    registry: PathBuf,

    /// Only devices without a model
    #[arg(long)]
    failed: bool,

    /// Print one JSON list, one entry a device
    #[arg(long)]
    json: bool,
}

impl List {
    pub fn run(&self) -> Result<(), Failure> {
        let mut devices = open(&self.registry)?.devices().map_err(|e| explain(&self.registry, &e))?;
        if self.failed {
            devices.retain(|device| device.latest.status != "ok");
        }
        if self.json {
            return console::json(&devices);
        }
        let header = ["device", "serial", "date", "calibrations", "status", "fit [%]", "RMSE", "reason"];
        let mut table = console::table(&header);
        for device in &devices {
            let latest = &device.latest;
            let number = |value: Option<f64>| value.map_or_else(String::new, |value| significant(value, 4));
            table.add_row([
                device.device.clone(),
                device.serial.clone(),
                latest.date.chars().take(10).collect(),
                device.calibrations.to_string(),
                latest.status.clone(),
                number(latest.fit_percent),
                format!("{} {}", number(latest.rmse), latest.unit).trim().to_owned(),
                latest.reason.clone(),
            ]);
        }
        console::result(&format!("{table}\n"))
    }
}
