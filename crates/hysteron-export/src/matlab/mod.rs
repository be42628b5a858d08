//! MATLAB functions, which GNU Octave runs too: the exported C, translated statement by statement.
//!
//! The C of an operator, written once beside its Rust, is the source of these functions too, so that a new
//! family has them from the start. What is translated is the part of C that the templates are written in:
//! pointers are arguments of a call, its results, or short names of parts of a table.

mod expression;
mod files;
mod parse;
mod syntax;
mod tokens;
mod value;
mod write;

pub use files::{matlab_files, matlab_inverse_files};

/// Something that the translation does not know: an error of the templates, not of a model.
#[derive(Clone, Debug, PartialEq)]
struct Untranslated {
    wanted: &'static str,
    found: String,
}

impl Untranslated {
    fn new(wanted: &'static str, found: &str) -> Self {
        Self { wanted, found: found.chars().take(200).collect() }
    }
}

impl From<Untranslated> for crate::ExportError {
    fn from(error: Untranslated) -> Self {
        Self::Template { place: format!("expected {} at {}", error.wanted, error.found) }
    }
}
