//! `hysteron registry export`: models as files.

use std::collections::HashSet;
use std::path::PathBuf;

use clap::Args;
use hysteron_model::Model;
use hysteron_registry::Registry;
use serde::Serialize;

use super::{explain, open};
use crate::console;
use crate::failure::Failure;
use crate::output;
use crate::outputs::Outputs;

/// Write the latest model of each device as a model file
#[derive(Args)]
pub struct Export {
    /// The registry
    #[arg(value_name = "FILE")]
    registry: PathBuf,

    /// Names of devices; all that have a model, if none is given
    #[arg(value_name = "DEVICE")]
    devices: Vec<String>,

    /// Folder to write to, one file a device
    #[arg(long, value_name = "DIR", default_value = ".")]
    out_dir: PathBuf,

    /// Print one JSON list, one entry a file
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Written {
    device: String,
    path: String,
}

impl Export {
    pub fn run(&self) -> Result<(), Failure> {
        let registry = open(&self.registry)?;
        output::check_folder("the models", &self.out_dir)?;
        let devices = if self.devices.is_empty() { self.all(&registry)? } else { self.devices.clone() };
        let folder = self.out_dir.display();
        std::fs::create_dir_all(&self.out_dir)
            .map_err(|e| Failure::new(format!("cannot make the folder {folder}")).because(e))?;
        let mut names = HashSet::new();
        let mut outputs = Outputs::default();
        let mut written = Vec::new();
        for device in devices {
            let text = registry.model_text(&device, 0).map_err(|e| explain(&self.registry, &e))?;
            Model::from_json(text.as_bytes())
                .map_err(|e| Failure::new(format!("the model of {device} is no model file")).because(e))?;
            let mut name = file_name(&device);
            while !names.insert(name.to_lowercase()) {
                name.push('_');
            }
            let path = self.out_dir.join(name + ".json");
            outputs.add("the model", &path, text.as_bytes())?;
            written.push(Written { device, path: path.display().to_string() });
        }
        if !self.json {
            outputs.tell(format!("{} models written to {folder}", written.len()));
        }
        outputs.finish()?;
        if self.json { console::json(&written) } else { Ok(()) }
    }

    /// Devices that have a model, now or before a calibration that failed.
    fn all(&self, registry: &Registry) -> Result<Vec<String>, Failure> {
        let with_model = registry.devices_with_model().map_err(|e| explain(&self.registry, &e))?;
        if with_model.is_empty() {
            return Err(Failure::new(format!("{} has no model", self.registry.display())));
        }
        Ok(with_model)
    }
}

/// Name of a file for a device: letters, digits, `-`, `_` and `.`, no hidden file.
fn file_name(device: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' };
    let name: String = device.chars().map(plain).take(80).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "device".to_owned() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn a_device_names_a_file_in_the_folder_and_nowhere_else() {
        assert_eq!(file_name("../../etc/passwd"), "_.._etc_passwd");
        assert_eq!((file_name("A 17/µ").as_str(), file_name("...").as_str()), ("A_17_µ", "device"));
    }
}
