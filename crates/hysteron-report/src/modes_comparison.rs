//! The comparison of structures of several axes as a page.

use hysteron_identify::modes::ModesComparison;
use hysteron_model::model_file::Maker;

use crate::figure::{Axis, Colour, Dash, Figure, Marker, Panel, Series, Style};
use crate::number::significant;
use crate::page::{Block, Column, Highlight, Page, Section, Table};
use crate::results::in_unit;
use crate::titles;

/// Height of one line of the figure \[px\].
const LINE_PX: f64 = 28.0;

/// Headings of the table.
pub fn header(unit: &str) -> [String; 6] {
    [
        "structure".to_owned(),
        "modes".to_owned(),
        "parameters".to_owned(),
        in_unit("held-out error", unit),
        in_unit("above the best", unit),
        in_unit("training error", unit),
    ]
}

/// Cells of a candidate, by its index.
pub fn cells(found: &ModesComparison, index: usize) -> [String; 6] {
    let (entry, standing) = (&found.entries[index], found.standing(index));
    let with_error =
        |value: f64, error: f64| format!("{} ± {}", significant(value, 3), significant(error, 2));
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| significant(x, 3));
    let is_best = found.ranking.as_ref().is_some_and(|ranking| ranking.best == index);
    [
        entry.candidate.to_string(),
        entry.modes.to_string(),
        entry.parameters.to_string(),
        standing.map_or_else(|| "-".to_owned(), |s| with_error(s.mean, s.std_error)),
        match standing {
            Some(_) if is_best => "best".to_owned(),
            Some(s) => with_error(s.difference, s.difference_std_error),
            None => "-".to_owned(),
        },
        number(entry.training),
    ]
}

/// The page; `maker`: who made it, and by which command.
pub fn page(found: &ModesComparison, maker: &Maker) -> Page {
    let mut result = Section::new("Which structure");
    if let Some(ranking) = &found.ranking {
        let preferred = &found.entries[ranking.preferred];
        let error = found.standing(ranking.preferred).map_or(f64::NAN, |s| s.mean);
        result = result.block(Block::Highlights(vec![
            Highlight::new("preferred structure", preferred.candidate.to_string(), ""),
            Highlight::new("held-out error", significant(error, 3), found.unit.as_str()),
            Highlight::new("parameters", preferred.parameters.to_string(), ""),
        ]));
    }
    let result = result
        .block(Block::list(found.verdict()))
        .block(errors(found))
        .block(table(found))
        .block(Block::info(found.about()));
    let what = format!("{} structures compared", found.entries.len());
    let mut page = Page::new(titles::title(None, found.records.iter().map(String::as_str), &what))
        .subtitled(found.records.join(", "))
        .section(result)
        .section(Section::new("Held-out folds").block(folds(found)));
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

fn table(found: &ModesComparison) -> Table {
    let columns = header(&found.unit);
    let columns = columns.into_iter().enumerate();
    let columns = columns.map(|(k, name)| if k == 0 { Column::text(name) } else { Column::number(name, "") });
    let preferred = found.ranking.as_ref().map(|ranking| ranking.preferred);
    found.order().into_iter().fold(Table::new(columns), |table, index| {
        let cells = cells(found, index);
        if Some(index) == preferred { table.highlighted_row(cells) } else { table.row(cells) }
    })
}

/// Held-out and training error of every candidate.
fn errors(found: &ModesComparison) -> Figure {
    let order = found.order();
    let at: Vec<f64> = (0..order.len()).rev().map(|i| i as f64).collect();
    let names: Vec<String> = order.iter().rev().map(|&i| found.entries[i].candidate.to_string()).collect();
    let points = |colour| Style::line(colour).with_dash(Dash::None).with_marker(Marker::Circle);
    let training = order.iter().map(|&i| found.entries[i].training.unwrap_or(f64::NAN)).collect();
    let held_out = order.iter().map(|&i| found.standing(i).map_or(f64::NAN, |s| s.mean)).collect();
    let (mut bar_x, mut bar_y) = (Vec::new(), Vec::new());
    for (&i, &y) in order.iter().zip(&at) {
        if let Some(s) = found.standing(i) {
            // An error bar that would reach zero ends at a tenth of the mean: the axis is logarithmic.
            bar_x.extend([(s.mean - s.std_error).max(0.1 * s.mean), s.mean + s.std_error, f64::NAN]);
            bar_y.extend([y, y, f64::NAN]);
        }
    }
    let panel = Panel::new(Axis::log("error", found.unit.as_str()), Axis::categories("", names))
        .series(Series::line("standard error over the folds", bar_x, bar_y, Style::line(Colour::Blue)))
        .series(Series::line("training error", training, at.clone(), points(Colour::Orange)))
        .series(Series::line("held-out error", held_out, at, points(Colour::Blue)));
    Figure::new("Held-out error of the simulation")
        .panel(panel)
        .panel_height(LINE_PX * order.len().max(3) as f64)
        .captioned(
            "Mean over the folds of the held-out error with its standard error, and the training error.",
        )
}

/// A row per fold: records held out, and the error of every candidate on them.
fn folds(found: &ModesComparison) -> Table {
    let order = found.order();
    let mut columns = vec![Column::text("held out")];
    columns.extend(
        order.iter().map(|&i| Column::number(found.entries[i].candidate.to_string(), found.unit.as_str())),
    );
    let rows = found.folds.iter().enumerate().map(|(f, held_out)| {
        let error = |&i: &usize| found.entries[i].folds.get(f).copied().flatten();
        let errors = order.iter().map(error);
        let cells = errors.map(|e| e.map_or_else(|| "-".to_owned(), |e| significant(e, 3)));
        std::iter::once(held_out.join(", ")).chain(cells).collect::<Vec<_>>()
    });
    rows.fold(Table::new(columns), Table::row)
}
