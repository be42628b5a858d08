//! Results as tables of text and sentences, the same in a terminal and on a page.

pub mod adaptation;
pub mod axes_tracking;
pub mod decoupling;
pub mod design;
pub mod modes;
pub mod preparation;
pub mod realisation;
pub mod recalibration;
pub mod response;

use crate::page::{Column, Table};

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

    /// The table of a page, its first columns `words` and the others numbers.
    pub fn for_page(self, words: usize) -> Table {
        let columns = self.columns.into_iter().enumerate();
        let columns =
            columns.map(|(k, name)| if k < words { Column::text(name) } else { Column::number(name, "") });
        self.rows.into_iter().fold(Table::new(columns), Table::row)
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
