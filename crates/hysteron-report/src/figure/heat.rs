//! Cells of a panel with two categorical axes: numbers from −1 to 1 as colour and as text.

use super::layout::{PlacedPanel, SMALL};
use super::style::Colour;
use super::text::{number, width};
use super::ticks::fixed;

/// Opacity of a full cell: dark text on it can still be read.
const FULL: f64 = 0.7;
/// Part of a cell's width that its number may fill.
const FILLED: f64 = 0.9;

/// Draws `cells`, row by row from the top; positive values in one colour, negative ones in the other, the paler the smaller.
pub(super) fn draw(out: &mut String, cells: &[Vec<f64>], placed: &PlacedPanel) {
    let f = placed.frame;
    let h = f.h / cells.len().max(1) as f64;
    for (i, row) in cells.iter().enumerate() {
        let w = f.w / row.len().max(1) as f64;
        for (j, &value) in row.iter().enumerate().filter(|(_, v)| v.is_finite()) {
            let colour = if value < 0.0 { Colour::Vermillion } else { Colour::Blue };
            let (x, y) = (f.x + j as f64 * w, f.y + i as f64 * h);
            put!(
                out,
                "<g class=\"{}\" color=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"currentColor\" \
                 fill-opacity=\"{}\"/></g>",
                colour.class(),
                colour.hex(),
                number(x),
                number(y),
                number(w),
                number(h),
                number(FULL * value.abs().min(1.0))
            );
            let text = fixed(value, 2);
            if width(&text, SMALL) <= FILLED * w {
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
