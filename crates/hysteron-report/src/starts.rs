//! Table of every start of a search.

use crate::number::significant;
use crate::page::{Block, Column, Table};

/// The starts of one search.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SearchStarts {
    /// Search, e.g. `joint fit`.
    pub step: String,
    /// Unit of the objective.
    pub unit: String,
    /// The starts, in their order.
    pub rows: Vec<StartRow>,
}

/// One start.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StartRow {
    /// Objective at the start; infinite where the model could not be simulated.
    pub initial: f64,
    /// Objective where it ended.
    pub end: f64,
    /// Iterations.
    pub iterations: usize,
    /// Termination reason, in words.
    pub how: String,
    /// It ended in the best optimum found.
    pub best: bool,
}

impl SearchStarts {
    /// A sentence and the table, the starts that ended in the best optimum shaded.
    pub fn blocks(&self) -> Vec<Block> {
        let best = self.rows.iter().filter(|row| row.best).count();
        let sentence = match (best, self.rows.len()) {
            (_, 0) => return Vec::new(),
            (1, 1) => format!("{}: one start was made.", self.step),
            (1, total) => format!(
                "{}: 1 of {total} starts reached the best optimum found; no other confirms it.",
                self.step
            ),
            (same, total) => {
                format!("{}: {same} of {total} starts reached the same best optimum.", self.step)
            }
        };
        let mut table = Table::new([
            Column::number("start", ""),
            Column::number("RMSE at the start", &self.unit),
            Column::number("RMSE at the end", &self.unit),
            Column::number("iterations", ""),
            Column::text("how it ended"),
            Column::text("same optimum"),
        ]);
        for (index, row) in self.rows.iter().enumerate() {
            let cells = [
                (index + 1).to_string(),
                significant(row.initial, 4),
                significant(row.end, 6),
                row.iterations.to_string(),
                row.how.clone(),
                if row.best { "yes".to_owned() } else { "no".to_owned() },
            ];
            table = if row.best { table.highlighted_row(cells) } else { table.row(cells) };
        }
        vec![Block::paragraph(sentence), table.into()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::{Page, Section};

    fn page(best: &[bool]) -> String {
        let row = |best: &bool| StartRow {
            initial: 2.0,
            end: 0.1,
            iterations: 7,
            how: "converged".into(),
            best: *best,
        };
        let starts = SearchStarts {
            step: "joint fit".into(),
            unit: "µm".into(),
            rows: best.iter().map(row).collect(),
        };
        Page::new("x").section(Section::new("s").blocks(starts.blocks())).to_html()
    }

    #[test]
    fn the_sentence_counts_the_starts_that_agree() {
        assert!(
            page(&[true, false, true]).contains("joint fit: 2 of 3 starts reached the same best optimum.")
        );
        assert!(page(&[false, true]).contains("1 of 2 starts reached the best optimum found; no other"));
        assert!(page(&[true]).contains("one start was made"));
        assert!(!page(&[]).contains("joint fit"));
    }
}
