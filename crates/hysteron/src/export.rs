//! A model as source code independent of Hysteron.

use serde::{Deserialize, Serialize};
use std::path::Path;

use hysteron_export::{ExportRequest, Form, Means, NamedFile, Precision, export, write_folder};
use hysteron_identify::Listener;
use hysteron_model::model::Capability;

use crate::{Error, Model};

/// Form of an export.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Target {
    /// C99: a header, a source without `malloc`, a self-test with golden vectors.
    C {
        /// Number type.
        float: Precision,
    },
    /// A `no_std` crate on top of `hysteron-rt`, with the same golden vectors.
    Rust {
        /// Number type.
        float: Precision,
    },
    /// FMI 2.0 and 3.0 for co-simulation: source, a binary made by the C compiler `cc`, and binaries for
    /// other platforms whose cross compilers are installed.
    Fmu,
    /// Functions of MATLAB and GNU Octave, their numbers, a self-test with golden vectors.
    Matlab,
    /// The files of [`Self::C`] with a Simulink S-function around them.
    Simulink {
        /// Number type.
        float: Precision,
    },
}

impl Target {
    fn form(self) -> (Form, Precision) {
        match self {
            Self::C { float } => (Form::C, float),
            Self::Rust { float } => (Form::Rust, float),
            Self::Fmu => (Form::Fmu, Precision::F64),
            Self::Matlab => (Form::Matlab, Precision::F64),
            Self::Simulink { float } => (Form::Simulink, float),
        }
    }
}

/// Files of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    files: Vec<NamedFile>,
}

impl Export {
    /// The files, by name and content.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.files.iter().map(|file| (file.name.as_str(), file.bytes.as_slice()))
    }

    /// Writes all files or none into a folder, which is created if missing.
    ///
    /// # Errors
    /// [`Error::Export`].
    pub fn write(&self, folder: impl AsRef<Path>) -> Result<(), Error> {
        Ok(write_folder(folder.as_ref(), &self.files)?)
    }
}

impl Model {
    /// The model as source for a controller's rate \[Hz\]; names in it begin with `model`.
    ///
    /// # Errors
    /// [`Error::Model`], [`Error::Export`].
    pub fn export(&self, sample_rate_hz: f64, target: Target) -> Result<Export, Error> {
        let body = self.core().hammerstein(Capability::Export)?;
        let (form, float) = target.form();
        let sample_rate_hz = Some(sample_rate_hz);
        let request = ExportRequest { float, sample_rate_hz, ..ExportRequest::new(form, "model") };
        let means = Means { compiler: "cc", listener: Listener::silent() };
        let files = export(body, &request, means)?.files;
        Ok(Export { files })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_has_a_target() {
        for form in Form::ALL {
            let mut written = serde_json::json!(form.name());
            if !matches!(form, Form::Fmu | Form::Matlab) {
                written = serde_json::json!({form.name(): {"float": "f32"}});
            }
            let target: Target = serde_json::from_value(written).unwrap();
            assert_eq!(target.form().0, form);
        }
    }
}
