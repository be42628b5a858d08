//! Contents of a file, before anything of it is chosen.

use std::io::Read;
use std::path::Path;

use serde::Serialize;

use crate::columns::{ColumnForm, Headings, Kind};
use crate::read::{open, read_columns};
use crate::{IoError, ReadOptions};

/// A column or an array of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Content {
    /// Its name, or the path where it stands: `u_V`, `rec.u`, `signals.values(:,2)`.
    pub path: String,
    /// Shape of the array; empty for a single value and for the columns of a text.
    pub shape: Vec<usize>,
    /// Unit, where there is one.
    pub unit: Option<String>,
    /// `numbers`, or what it is instead: `text`, `complex numbers`, `function`.
    pub kind: String,
}

/// Lists what a file holds: the columns of a text, the arrays of a file of named arrays.
///
/// # Errors
/// Any [`IoError`] that says why the file's contents cannot be listed.
pub fn contents(path: &Path, options: &ReadOptions) -> Result<Vec<Content>, IoError> {
    list(&path.display().to_string(), open(path)?, options)
}

/// [`contents`] of a file in memory; `name` stands for the file in messages, and its extension may choose the
/// format.
///
/// # Errors
/// Those of [`contents`].
pub fn contents_of_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Vec<Content>, IoError> {
    list(name, bytes, options)
}

fn list(file: &str, source: impl Read, options: &ReadOptions) -> Result<Vec<Content>, IoError> {
    let mut contents = Vec::new();
    let wanted = |headings: &Headings| {
        contents =
            headings.columns.iter().filter(|column| !column.header.is_empty()).map(Content::of).collect();
        Ok(vec![ColumnForm::Nothing; headings.columns.len()])
    };
    read_columns(file, source, options, wanted)?;
    Ok(contents)
}

impl Content {
    fn of(column: &crate::columns::Heading) -> Self {
        let (shape, kind) = match &column.array {
            None => (Vec::new(), "numbers".to_owned()),
            Some(array) => match &array.kind {
                Kind::Numbers => (array.shape.clone(), "numbers".to_owned()),
                Kind::Other(kind) => (array.shape.clone(), kind.clone()),
            },
        };
        let unit = Some(column.unit.symbol()).filter(|symbol| !symbol.is_empty()).map(str::to_owned);
        Content { path: column.header.clone(), shape, unit, kind }
    }
}
