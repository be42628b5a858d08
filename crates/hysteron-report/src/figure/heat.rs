//! Cells of a panel with two categorical axes: numbers from −1 to 1 as colour and as text.

use super::layout::{PlacedPanel, SMALL};
use super::style::Colour;
use super::text::{number, width};
use hysteron_numeric::number::fixed;

/// Opacity of a full cell: dark text on it can still be read.
const FULL: f64 = 0.7;
/// Part of a cell's width that its number may fill.
const FILLED: f64 = 0.9;

/// Formats of the numbers, the longer first; all cells use the same one.
const FORMATS: [fn(f64) -> String; 3] =
    [|x| fixed(x, 2), |x| without_zero(fixed(x, 2)), |x| without_zero(fixed(x, 1))];

/// `−.97` for `−0.97`.
fn without_zero(text: String) -> String {
    match text.strip_prefix('−').map_or(text.strip_prefix("0."), |rest| rest.strip_prefix("0.")) {
        Some(digits) => format!("{}.{digits}", if text.starts_with('−') { "−" } else { "" }),
        None => text,
    }
}

/// Whether every number of `cells` fits its cell, of rows that share the width `all`.
fn fits(format: &fn(f64) -> String, cells: &[Vec<f64>], all: f64) -> bool {
    cells.iter().all(|row| {
        let room = FILLED * all / row.len().max(1) as f64;
        row.iter().filter(|v| v.is_finite()).all(|&v| width(&format(v), SMALL) <= room)
    })
}

/// Draws `cells`, row by row from the top; positive values in one colour, negative ones in the other, the
/// paler the smaller.
pub(super) fn draw(out: &mut String, cells: &[Vec<f64>], placed: &PlacedPanel) {
    let f = placed.frame;
    let h = f.h / cells.len().max(1) as f64;
    let longest = FORMATS.iter().find(|format| fits(format, cells, f.w));
    for (i, row) in cells.iter().enumerate() {
        let w = f.w / row.len().max(1) as f64;
        for (j, &value) in row.iter().enumerate().filter(|(_, v)| v.is_finite()) {
            let colour = if value < 0.0 { Colour::Vermillion } else { Colour::Blue };
            let (x, y) = (f.x + j as f64 * w, f.y + i as f64 * h);
            put!(
                out,
                "<g class=\"{}\" color=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" \
                 fill=\"currentColor\" fill-opacity=\"{}\"/></g>",
                colour.class(),
                colour.hex(),
                number(x),
                number(y),
                number(w),
                number(h),
                number(FULL * value.abs().min(1.0))
            );
            if let Some(format) = longest {
                let text = format(value);
                put!(
                    out,
                    "<text class=\"t\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{text}</text>",
                    number(x + 0.5 * w),
                    number(y + 0.5 * h + 4.2)
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_lose_their_zero_before_they_lose_a_digit() {
        let cells = vec![vec![1.0, -0.97], vec![-0.97, 1.0]];
        let chosen = |cell: f64| FORMATS.iter().find(|f| fits(f, &cells, 2.0 * cell)).map(|f| f(-0.97));
        assert_eq!(chosen(60.0).as_deref(), Some("−0.97"));
        assert_eq!(chosen(34.0).as_deref(), Some("−.97"));
        assert_eq!(chosen(2.0), None);
        assert_eq!(FORMATS[1](1.0), "1.00");
        assert_eq!(FORMATS[2](0.0), ".0");
    }
}
