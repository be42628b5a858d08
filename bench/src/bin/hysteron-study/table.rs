//! Tables for people and for the docs.

use std::io::{Write, stdout};

use crate::Outcome;

/// Prints a table in Markdown, columns aligned.
pub fn print(header: &[&str], rows: &[Vec<String>]) -> Outcome<()> {
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &[String]| -> String {
        cells.iter().zip(&widths).map(|(cell, &width)| format!("| {cell:<width$} ")).collect::<String>() + "|"
    };
    let mut out = stdout().lock();
    writeln!(out, "{}", line(&header.iter().map(|&cell| cell.to_owned()).collect::<Vec<_>>()))?;
    writeln!(out, "{}", line(&widths.iter().map(|&width| "-".repeat(width)).collect::<Vec<_>>()))?;
    for row in rows {
        writeln!(out, "{}", line(row))?;
    }
    Ok(writeln!(out)?)
}

/// The middle one of the values, the mean of the two middle ones of an even number; NaN of none.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    match (sorted.get(sorted.len() / 2), sorted.get(sorted.len().saturating_sub(1) / 2)) {
        (Some(a), Some(b)) => 0.5 * (a + b),
        _ => f64::NAN,
    }
}

/// Square root of the mean square; NaN of none.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), x| (count + 1.0, sum + x * x));
    (sum / count).sqrt()
}
