//! Comparison of a published table with its reproduction, side by side.

use hysteron_report::page::{Cell, Column, Row, Table};

/// A table as an article prints it and as it comes out here, cell by cell.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparisonTable {
    /// Text above the table, with the number of the article's table.
    pub caption: String,
    /// Heading of the first column.
    pub row_header: String,
    /// Quantities compared: name and unit.
    pub quantities: Vec<(String, String)>,
    /// Heading over the printed numbers; empty means `article (printed)`.
    pub printed_heading: String,
    /// Heading over our numbers; empty means `here (simulated bench)`.
    pub here_heading: String,
    /// Rows.
    pub rows: Vec<ComparisonRow>,
    /// Text under the table.
    pub notes: Vec<String>,
}

/// One row of a [`ComparisonTable`]; texts are formatted numbers, and a missing one shows `—`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ComparisonRow {
    /// Subject of the row.
    pub name: String,
    /// The article's numbers, one for each quantity.
    pub printed: Vec<String>,
    /// Our numbers, one for each quantity.
    pub here: Vec<String>,
    /// True for a shaded row.
    pub highlight: bool,
}

impl ComparisonTable {
    /// Lays the comparison out: all printed quantities on the left, all of ours on the right, under headings
    /// that say which is which.
    pub fn to_table(&self) -> Table {
        let or =
            |text: &str, default: &str| if text.is_empty() { default.to_owned() } else { text.to_owned() };
        let mut columns = vec![Column::text(&self.row_header)];
        for _ in 0..2 {
            columns.extend(self.quantities.iter().map(|(name, unit)| Column::number(name, unit)));
        }
        let width = self.quantities.len();
        let mut table = Table::new(columns)
            .captioned(&self.caption)
            .group("", 1)
            .group(or(&self.printed_heading, "article (printed)"), width)
            .group(or(&self.here_heading, "here (simulated bench)"), width);
        for row in &self.rows {
            let mut cells = vec![Cell::new(&row.name)];
            let missing = "—".to_owned();
            let padded = |values: &[String]| -> Vec<String> {
                (0..width)
                    .map(|k| values.get(k).filter(|v| !v.is_empty()).unwrap_or(&missing).clone())
                    .collect()
            };
            cells.extend(padded(&row.printed).into_iter().map(Cell::quiet));
            cells.extend(padded(&row.here).into_iter().map(Cell::new));
            table.rows.push(Row { cells, highlight: row.highlight });
        }
        table.notes = self.notes.clone();
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_and_own_numbers_stand_in_their_own_columns() {
        let comparison = ComparisonTable {
            row_header: "frequency".into(),
            quantities: vec![("max".into(), "µm".into()), ("RMSE".into(), "µm".into())],
            rows: vec![ComparisonRow {
                name: "10 Hz".into(),
                printed: vec!["0.5000".into(), "0.1127".into()],
                here: vec!["0.61".into()],
                highlight: false,
            }],
            ..ComparisonTable::default()
        };
        let table = comparison.to_table();
        let texts: Vec<&str> = table.rows[0].cells.iter().map(|c| c.text.as_str()).collect();
        assert_eq!(texts, ["10 Hz", "0.5000", "0.1127", "0.61", "—"]);
        assert_eq!(table.groups.iter().map(|g| g.1).sum::<usize>(), table.columns.len());
        assert!(table.rows[0].cells[1].quiet && !table.rows[0].cells[3].quiet);
    }
}
