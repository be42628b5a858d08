//! Figure 1: loops against frequency.

use crate::Reproduction;

use super::SIMULATED;
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Column, Section, Table};

pub(super) fn section(found: &Reproduction) -> Section {
    let loops = &found.loops.loops;
    let axes = || (Axis::linear("voltage", "V"), Axis::linear("displacement", "µm"));
    let panel = |title: &str, from: f64, to: f64| {
        let (x, y) = axes();
        let shown = loops.iter().filter(|l| (from..=to).contains(&l.frequency_hz));
        shown.enumerate().fold(Panel::new(x, y).titled(title), |panel, (i, l)| {
            let label = format!("{} Hz", l.frequency_hz);
            panel.series(Series::line(label, closed(&l.u_v), closed(&l.y_um), Style::nth(i).with_width(1.4)))
        })
    };
    let figure = Figure::new("Figure 1. Loops against frequency")
        .subtitled(SIMULATED)
        .panel(panel("1 to 5 Hz", 0.0, 5.0))
        .panel(panel("5 to 100 Hz", 5.0, 1e9))
        .in_columns(2)
        .panel_height(290.0)
        .captioned(
            "Figure 1. Last period of every sine, 0–10 V. Left: where the article calls the loop unchanged. \
             Right: where it opens.",
        );
    let mut table = Table::new([
        Column::number("frequency", "Hz"),
        Column::number("stroke", "µm"),
        Column::number("opening", "% of stroke"),
        Column::number("largest distance", "% of stroke"),
        Column::number("rms distance", "% of stroke"),
    ])
    .captioned("Loops against frequency: how far each is from the 1 Hz loop.")
    .note(
        "Opening: down branch minus up branch at mid-range drive; positive is counter-clockwise. Distance: \
         from the 1 Hz loop at the same phase of the drive, each loop about its own mean, in % of the 1 Hz \
         stroke.",
    );
    let distance = |d: f64| if d == 0.0 { "—".to_owned() } else { significant(d, 2) };
    for l in loops {
        table = table.row([
            l.frequency_hz.to_string(),
            significant(l.stroke_um, 4),
            significant(l.opening_percent, 3),
            distance(l.largest_distance_percent),
            distance(l.rms_distance_percent),
        ]);
    }
    Section::new("Figure 1: the loop and its frequency").block(figure).block(table).block(Block::paragraph(
        "The claim that the loop hardly changes below 5 Hz is what allows the article to take the 1 Hz loop \
             as static. The distance at 5 Hz is the price: it is in every error of the static block from the \
             start.",
    ))
}

/// A period with its first sample appended, so that the loop is drawn closed.
fn closed(period: &[f64]) -> Vec<f64> {
    period.iter().chain(period.first()).copied().collect()
}
