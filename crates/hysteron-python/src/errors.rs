//! Errors of the library as exceptions of the package, and results as JSON.

use std::fmt::{Debug, Display};

use hysteron_identify::IdentifyError;
use hysteron_io::{FilePart, Place};
use hysteron_model::Advice;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Class of the package's exceptions.
#[derive(Clone, Copy)]
pub enum Class {
    /// A file cannot be read or written.
    File,
    /// A record or a model cannot be used as asked.
    Model,
    /// No model was identified.
    Identify,
    /// A model cannot be exported.
    Export,
    /// An option is invalid.
    Option,
}

impl Class {
    fn name(self) -> &'static str {
        match self {
            Self::File => "FileError",
            Self::Model => "ModelError",
            Self::Identify => "IdentifyError",
            Self::Export => "ExportError",
            Self::Option => "OptionError",
        }
    }
}

/// The exception for an error of the facade.
pub fn raised(error: impl Into<hysteron::Error>) -> PyErr {
    use hysteron::Error;
    match error.into() {
        Error::File(e) => exception(Class::File, &e, e.place(), e.advice()),
        Error::Model(hysteron_model::Error::Name(e)) => option(e),
        Error::Model(e) => exception(Class::Model, &e, None, e.advice()),
        Error::Identify(e) => {
            let measure = match &e {
                IdentifyError::CannotRank { measure, .. } => Some(format!("measure {measure}")),
                _ => None,
            };
            described(Class::Identify, &e, None, e.advice(), measure)
        }
        Error::Export(e) => exception(Class::Export, &e, None, None),
        e => exception(Class::Option, &e, None, None),
    }
}

/// The exception for an option.
pub fn option(error: impl Display + Debug) -> PyErr {
    exception(Class::Option, &error, None, None)
}

/// The exception for an error of another layer.
pub fn failed(class: Class, error: impl Display + Debug) -> PyErr {
    exception(class, &error, None, None)
}

fn exception(
    class: Class,
    error: &(impl Display + Debug),
    place: Option<Place>,
    advice: Option<Advice>,
) -> PyErr {
    described(class, error, place, advice, None)
}

/// [`exception`] with a remedy that concerns no argument.
fn described(
    class: Class,
    error: &(impl Display + Debug),
    place: Option<Place>,
    advice: Option<Advice>,
    hint: Option<String>,
) -> PyErr {
    Python::attach(|py| {
        let made = || -> PyResult<PyErr> {
            let details = PyDict::new(py);
            details.set_item("code", code(&format!("{error:?}")))?;
            if let Some(place) = &place {
                details.set_item("file", place.file.as_ref())?;
                match &place.part {
                    FilePart::Line(line) => details.set_item("line", line)?,
                    FilePart::Cell { line, column, .. } => {
                        details.set_item("line", line)?;
                        details.set_item("column", column)?;
                    }
                    _ => {}
                }
            }
            if let Some(advice) = &advice {
                details.set_item("advice", to_json(advice)?)?;
            }
            if let Some(hint) = &hint {
                details.set_item("hint", hint)?;
            }
            let of_package = py.import("hysteron_models._errors")?.getattr(class.name())?;
            Ok(PyErr::from_value(of_package.call((error.to_string(),), Some(&details))?))
        };
        made().unwrap_or_else(|e| e)
    })
}

/// `not-a-number`, `model.unknown-version`: names of the variants of an error, from the outside in.
fn code(debug: &str) -> String {
    let mut names = Vec::new();
    let mut rest = debug;
    loop {
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let (name, behind) = rest.split_at(end);
        if !name.starts_with(|c: char| c.is_ascii_uppercase()) {
            break;
        }
        let mut kebab = String::new();
        for (k, c) in name.chars().enumerate() {
            if k > 0 && c.is_ascii_uppercase() {
                kebab.push('-');
            }
            kebab.push(c.to_ascii_lowercase());
        }
        names.push(kebab);
        match behind.strip_prefix('(') {
            Some(inner) => rest = inner,
            None => break,
        }
    }
    names.join(".")
}

/// A message; its code is `option`.
struct Said(String);

impl Display for Said {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl Debug for Said {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Option")
    }
}

/// A result as JSON.
pub fn to_json(value: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(option)
}

/// Options from JSON.
pub fn from_json<T: DeserializeOwned>(json: &str) -> PyResult<T> {
    // The place in the JSON means nothing to a user who gave arguments.
    let told = |e: serde_json::Error| e.to_string().split(" at line ").next().unwrap_or_default().to_owned();
    serde_json::from_str(json).map_err(|e| exception(Class::Option, &Said(told(e)), None, None))
}
