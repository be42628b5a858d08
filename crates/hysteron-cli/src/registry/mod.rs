//! `hysteron registry`: the results of a fleet's calibrations, from the file that the Python package keeps.

mod diff;
mod export;
mod list;
mod show;

use std::path::Path;

use clap::{Args, Subcommand};
use hysteron_registry::{Registry, RegistryError};

use crate::failure::Failure;

/// Read the registry of a fleet that hysteron_models.fleet calibrated: list, show, compare, export.
#[derive(Args)]
#[command(
    after_help = "The file is the SQLite file of hysteron_models.fleet.calibrate(registry=…); it is only read, \
    also while a fleet is calibrated.\n\n\
    Example: hysteron registry list fleet.sqlite\n\
    Example: hysteron registry show fleet.sqlite A-0017\n\
    Example: hysteron registry diff fleet.sqlite A-0017\n\
    Example: hysteron registry export fleet.sqlite --out-dir models"
)]
pub struct RegistryCommand {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    List(list::List),
    Show(show::Show),
    Diff(diff::Diff),
    Export(export::Export),
}

impl RegistryCommand {
    pub fn run(&self) -> Result<(), Failure> {
        match &self.action {
            Action::List(c) => c.run(),
            Action::Show(c) => c.run(),
            Action::Diff(c) => c.run(),
            Action::Export(c) => c.run(),
        }
    }
}

fn open(path: &Path) -> Result<Registry, Failure> {
    Registry::open(path).map_err(|e| explain(path, &e))
}

fn explain(path: &Path, error: &RegistryError) -> Failure {
    let failure = Failure::new(format!("cannot read the registry {}", path.display())).because(error);
    match error {
        RegistryError::Schema { .. } => failure.hint("update hysteron to the version that wrote it"),
        RegistryError::NotARegistry { .. } => {
            failure.hint("name the SQLite file that hysteron_models.fleet.calibrate(registry=…) wrote")
        }
        RegistryError::NoDevice { .. } => {
            failure.hint(format!("hysteron registry list {} lists the devices", path.display()))
        }
        RegistryError::NoModel { .. } => failure.hint("name two devices, or calibrate the device again"),
        _ => failure,
    }
}
