//! Failures of reading a registry.

use std::path::PathBuf;

use hysteron_model::model_file::ModelFileError;

/// Why a registry was not read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// No such file: SQLite would make an empty one.
    #[error("`{}` cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A database of another program, or no database.
    #[error("`{}` is no registry: {problem}", path.display())]
    NotARegistry {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A schema that this version does not know.
    #[error("`{}` has schema {found}: this version reads schemas {}", path.display(), known.join(", "))]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its schema.
        found: String,
        /// Schemas that can be read.
        known: &'static [&'static str],
    },
    /// No device of this name.
    #[error("the registry has no device `{device}`{}", similar(names))]
    NoDevice {
        /// The name asked for.
        device: String,
        /// Names that contain it, or begin alike.
        names: Vec<String>,
    },
    /// No calibration of the device with a model.
    #[error("`{device}` has {found} calibrations with a model: {asked} are needed")]
    NoModel {
        /// The device.
        device: String,
        /// Calibrations with a model.
        found: usize,
        /// Calibrations needed.
        asked: usize,
    },
    /// A model of the registry that is no model file.
    #[error("model of `{device}`: {source}")]
    Model {
        /// The device.
        device: String,
        /// What is wrong.
        source: ModelFileError,
    },
    /// The database.
    #[error("`{}`: {source}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// Error of SQLite.
        source: rusqlite::Error,
    },
}

fn similar(names: &[String]) -> String {
    if names.is_empty() { String::new() } else { format!(": it has {}", names.join(", ")) }
}
