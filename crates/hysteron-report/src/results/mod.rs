//! Results as tables of text and sentences, the same in a terminal and on a page.

pub mod adaptation;
pub mod decoupling;
pub mod design;
pub mod preparation;
pub mod realisation;
pub mod recalibration;
pub mod response;

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// Headings, with units in square brackets.
    pub columns: Vec<String>,
    /// Rows, each as long as the headings.
    pub rows: Vec<Vec<String>>,
}

impl Listing {
    /// A table without rows.
    pub fn new<T: Into<String>>(columns: impl IntoIterator<Item = T>) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push<T: Into<String>>(&mut self, row: impl IntoIterator<Item = T>) {
        self.rows.push(row.into_iter().map(Into::into).collect());
    }
}

/// A heading with its unit, where it has one.
pub fn in_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}
