//! The comparison as a page.

use std::collections::BTreeSet;

use crate::figure::{Axis, Colour, Dash, Figure, Marker, Panel, Series, Style};
use crate::number::significant;
use crate::page::{Block, Cell, Column, Highlight, Page, Section, Table};
use crate::titles;
use hysteron_identify::structure::{Comparison, Entry, Fold};
use hysteron_identify::{Compared, baselines::CrossValidated};
use hysteron_model::model_file::Maker;

/// Number of candidates shown fold by fold.
const SHOWN_BY_FOLD: usize = 5;
/// Height of one line of a figure \[px\].
const LINE_PX: f64 = 26.0;
/// Height of the picture of error over cost \[px\].
const COST_PX: f64 = 420.0;

/// The page of a comparison; `maker`: who made it, and by which command.
pub fn page(found: &Compared, maker: &Maker) -> Page {
    let comparison = &found.comparison;
    let mut result = Section::new("Which structure");
    if let Some(ranking) = &comparison.ranking {
        let preferred = &comparison.entries[ranking.preferred];
        let error = found.standing(ranking.preferred).map_or(f64::NAN, |s| s.mean);
        result = result.block(Block::Highlights(vec![
            Highlight::new("preferred structure", preferred.candidate.to_string(), ""),
            Highlight::new("held-out error", significant(error, 3), found.unit.as_str()),
            Highlight::new("noise floor", significant(comparison.noise_floor, 3), found.unit.as_str()),
            Highlight::new("parameters", preferred.parameters.to_string(), ""),
        ]));
    }
    let result = result
        .block(Block::list(found.verdict()))
        .block(errors(found))
        .block(table(found))
        .block(cost_picture(found))
        .block(Block::info(found.about()));
    let records = found.records.iter().map(String::as_str);
    let what = format!("{} structures compared", comparison.entries.len());
    let mut page = Page::new(titles::title(None, records, &what))
        .subtitled(found.records.join(", "))
        .section(result)
        .section(Section::new("Held-out folds").block(by_fold(found)).block(fold_table(found)));
    if let Some(section) = baselines_section(found) {
        page = page.section(section);
    }
    if let Some(command) = &maker.command {
        page = page.section(Section::new("Provenance").block(Block::code(command)));
    }
    page.footer_line(&maker.program)
}

fn axis(found: &Compared) -> Axis {
    Axis::log("held-out error", found.unit.as_str())
}

/// Positions of `count` lines, the first on top.
fn lines(count: usize) -> Vec<f64> {
    (0..count).rev().map(|i| i as f64).collect()
}

fn points(colour: Colour) -> Style {
    Style::line(colour).with_dash(Dash::None).with_marker(Marker::Circle)
}

/// Error of every candidate with its standard error, its training error, and the noise floor.
fn errors(found: &Compared) -> Figure {
    let comparison = &found.comparison;
    let order = found.order();
    let at = lines(order.len());
    let names: Vec<String> =
        order.iter().rev().map(|&i| comparison.entries[i].candidate.to_string()).collect();
    let standings: Vec<_> = order.iter().map(|&i| found.standing(i)).collect();
    let means = standings.iter().map(|s| s.map_or(f64::NAN, |s| s.mean)).collect();
    let training = order.iter().map(|&i| comparison.entries[i].training_rmse.unwrap_or(f64::NAN)).collect();
    let (mut bar_x, mut bar_y) = (Vec::new(), Vec::new());
    for (standing, &y) in standings.iter().zip(&at) {
        if let Some(s) = standing {
            // An error bar that would reach zero ends at a tenth of the mean: the axis is logarithmic.
            bar_x.extend([(s.mean - s.std_error).max(0.1 * s.mean), s.mean + s.std_error, f64::NAN]);
            bar_y.extend([y, y, f64::NAN]);
        }
    }
    let panel = Panel::new(axis(found), Axis::categories("", names))
        .series(noise_floor(comparison, order.len()))
        .series(Series::line("standard error over the folds", bar_x, bar_y, Style::line(Colour::Blue)))
        .series(marks("training RMSE", training, &at, points(Colour::Orange)))
        .series(marks("held-out RMSE", means, &at, points(Colour::Blue)));
    Figure::new("Held-out error of the simulation")
        .panel(panel)
        .panel_height(LINE_PX * order.len().max(3) as f64)
        .captioned(
            "Mean over the folds of the held-out RMSE, with its standard error, and the training RMSE. Folds \
             are harder or easier for all candidates alike, so that bars may overlap although the paired \
             differences in the table are significant.",
        )
}

/// Error over cost on logarithmic axes, each candidate by its name, the Pareto front as a line.
fn cost_picture(found: &Compared) -> Figure {
    let comparison = &found.comparison;
    let mut points: Vec<(f64, f64, String)> = found
        .order()
        .into_iter()
        .filter_map(|i| {
            let cost = found.costs.get(i)?.cost?;
            let error = found.standing(i)?.mean;
            Some((cost.nanoseconds, error, comparison.entries[i].candidate.to_string()))
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut least = f64::INFINITY;
    let front: Vec<&(f64, f64, String)> = points
        .iter()
        .filter(|p| {
            p.1 < least && {
                least = p.1;
                true
            }
        })
        .collect();
    let (front_x, front_y) = front.iter().map(|p| (p.0, p.1)).unzip();
    let on_front = |p: &(f64, f64, String)| front.iter().any(|q| q.2 == p.2);
    let of = |wanted: bool| -> (Vec<f64>, Vec<f64>) {
        points.iter().filter(|p| on_front(p) == wanted).map(|p| (p.0, p.1)).unzip()
    };
    let ((best_x, best_y), (other_x, other_y)) = (of(true), of(false));
    let far = points.iter().map(|p| p.0).fold(0.0, f64::max);
    let near = points.iter().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let floor = comparison.noise_floor;
    let grey = Style::line(Colour::Grey).with_dash(Dash::Dashed);
    let mut panel = Panel::new(Axis::log("time per sample, this machine", "ns"), axis(found))
        .series(Series::line("noise floor", vec![near, far], vec![floor, floor], grey))
        .series(Series::line("", front_x, front_y, Style::line(Colour::Blue).with_width(1.0)))
        .series(marks_over("Pareto front", best_x, best_y, points_of(Colour::Blue, Marker::Circle)))
        .series(marks_over("others", other_x, other_y, points_of(Colour::Orange, Marker::Diamond)));
    for (x, y, name) in points {
        panel = panel.name(x, y, name);
    }
    Figure::new("Error against cost").panel(panel).panel_height(COST_PX).captioned(
        "Held-out error (mean over the folds) against the time of one sample of the realised model: \
         hysteresis, dynamics to 1e-5 of the range and delay, double precision. Minimum of several runs of \
         each candidate along the same drive on this machine, reproducible to about ten per cent.",
    )
}

fn points_of(colour: Colour, marker: Marker) -> Style {
    Style::line(colour).with_dash(Dash::None).with_marker(marker)
}

/// Marks that no line joins, over both axes.
fn marks_over(label: &str, x: Vec<f64>, y: Vec<f64>, style: Style) -> Series {
    let apart = |values: Vec<f64>| values.into_iter().flat_map(|v| [v, f64::NAN]).collect();
    Series::line(label, apart(x), apart(y), style)
}

/// Marks that no line joins: a break between any two keeps them all, even in a row.
fn marks(label: &str, x: Vec<f64>, y: &[f64], style: Style) -> Series {
    let x = x.into_iter().flat_map(|x| [x, f64::NAN]).collect();
    let y = y.iter().flat_map(|&y| [y, f64::NAN]).collect();
    Series::line(label, x, y, style)
}

fn noise_floor(comparison: &Comparison, lines: usize) -> Series {
    let floor = comparison.noise_floor;
    let style = Style::line(Colour::Grey).with_dash(Dash::Dashed);
    Series::line("noise floor", vec![floor, floor], vec![-0.5, lines as f64 - 0.5], style)
}

/// Error of the first few candidates on every fold.
fn by_fold(found: &Compared) -> Figure {
    let comparison = &found.comparison;
    let at = lines(comparison.folds.len());
    // Short names, where they distinguish the folds.
    let contents: BTreeSet<&str> = comparison.folds.iter().map(|f| f.content.as_str()).collect();
    let short = contents.len() == comparison.folds.len();
    let names = comparison.folds.iter().rev().map(|f| if short { &f.content } else { &f.label });
    let mut panel = Panel::new(axis(found), Axis::categories("", names))
        .series(noise_floor(comparison, comparison.folds.len()));
    for (place, index) in found.order().into_iter().take(SHOWN_BY_FOLD).enumerate() {
        let entry = &comparison.entries[index];
        let errors = entry.fold_rmse.iter().map(|e| e.unwrap_or(f64::NAN)).collect();
        let style = Style::nth(place).marked(place).with_dash(Dash::None);
        panel = panel.series(marks(&entry.candidate.to_string(), errors, &at, style));
    }
    Figure::new("Held-out error by fold")
        .panel(panel)
        .panel_height(LINE_PX * comparison.folds.len().max(4) as f64)
        .captioned("RMSE of the leading candidates on each held-out fold.")
}

fn table(found: &Compared) -> Table {
    let comparison = &found.comparison;
    let unit = found.unit.as_str();
    let columns = [
        Column::text("structure"),
        Column::number("parameters", ""),
        Column::number("held-out error", unit),
        Column::number("above the best", unit),
        Column::number("training RMSE", unit),
        Column::number("AIC", ""),
        Column::number("BIC", ""),
        Column::number("time per sample", "ns"),
        Column::text("inverse"),
    ];
    let preferred = comparison.ranking.as_ref().map(|r| r.preferred);
    found.order().into_iter().fold(Table::new(columns), |table, index| {
        let cells = cells(found, index);
        if preferred == Some(index) { table.highlighted_row(cells) } else { table.row(cells) }
    })
}

fn fold_table(found: &Compared) -> Table {
    let comparison = &found.comparison;
    let shown: Vec<usize> = found.order().into_iter().take(SHOWN_BY_FOLD).collect();
    let mut columns = vec![Column::text("held-out fold"), Column::text("content")];
    columns.extend(
        shown
            .iter()
            .map(|&i| Column::number(comparison.entries[i].candidate.to_string(), found.unit.as_str())),
    );
    comparison.folds.iter().enumerate().fold(Table::new(columns), |table, (f, fold)| {
        let mut cells: Vec<Cell> = vec![fold.label.as_str().into(), fold.content.as_str().into()];
        for &i in &shown {
            let error = comparison.entries[i].fold_rmse[f];
            cells.push(error.map_or_else(|| "-".to_owned(), |e| significant(e, 3)).into());
        }
        table.row(cells)
    })
}

/// One row: candidate, parameters, held-out error ± its standard error, difference to the best ± its standard
/// error, training error, AIC and BIC above their lowest, time of a sample, whether its hysteresis has an
/// inverse.
pub fn cells(found: &Compared, index: usize) -> [String; 9] {
    let comparison = &found.comparison;
    let costs = found.costs.get(index);
    let entry = &comparison.entries[index];
    let missing = || "-".to_owned();
    let standing = found.standing(index);
    [
        entry.candidate.to_string(),
        entry.parameters.to_string(),
        standing.map_or_else(missing, |s| with_error(s.mean, s.std_error)),
        standing.map_or_else(missing, |s| match s.difference {
            0.0 => "best".to_owned(),
            difference => with_error(difference, s.difference_std_error),
        }),
        entry.training_rmse.map_or_else(missing, |x| significant(x, 3)),
        above(comparison, entry, |e| e.aic),
        above(comparison, entry, |e| e.bic),
        costs.and_then(|c| c.cost).map_or_else(missing, |c| significant(c.nanoseconds, 2)),
        costs.and_then(|c| c.inverse).map_or_else(missing, |inverse| inverse.word().to_owned()),
    ]
}

/// A mean and its standard error.
pub fn with_error(value: f64, error: f64) -> String {
    format!("{} ± {}", significant(value, 3), significant(error, 2))
}

fn above(comparison: &Comparison, entry: &Entry, of: impl Fn(&Entry) -> Option<f64>) -> String {
    let lowest = comparison.entries.iter().filter_map(&of).fold(f64::INFINITY, f64::min);
    of(entry).map_or_else(|| "-".to_owned(), |x| format!("{:.0}", x - lowest))
}

/// One row: baseline, parameters, lags, held-out error ± its standard error, training error, time.
pub fn baseline_cells(entry: &CrossValidated) -> [String; 7] {
    let missing = || "-".to_owned();
    let model = entry.model.as_ref();
    [
        entry.kind.name().to_owned(),
        model.map_or_else(missing, |m| m.parameters().to_string()),
        model.map_or_else(missing, |m| significant(1e3 * m.units.interval_s, 3)),
        model.map_or_else(missing, |m| format!("{}, {}", m.regressors.lags.output, m.regressors.lags.input)),
        entry.error().map_or_else(missing, |(mean, error)| with_error(mean, error)),
        entry.training_rmse.map_or_else(missing, |x| significant(x, 3)),
        entry.seconds.map_or_else(missing, |s| significant(s, 2)),
    ]
}

/// Header and rows: the held-out data, the error of the best structure and of each baseline.
pub fn baselines_by_fold(found: &Compared) -> (Vec<String>, Vec<Vec<String>>) {
    let best = found.comparison.ranking.as_ref().map(|r| &found.comparison.entries[r.best]);
    let mut names = vec!["held-out fold".to_owned()];
    names.extend(best.map(|entry| entry.candidate.to_string()));
    names.extend(found.baselines.iter().map(|b| b.kind.name().to_owned()));
    let row = |(index, fold): (usize, &Fold)| {
        let of_best = best.map(|entry| &entry.fold_rmse);
        let errors = of_best.into_iter().chain(found.baselines.iter().map(|b| &b.fold_rmse));
        let errors = errors.map(|e| e[index].map_or_else(|| "-".to_owned(), |e| significant(e, 3)));
        std::iter::once(fold.label.clone()).chain(errors).collect()
    };
    (names, found.comparison.folds.iter().enumerate().map(row).collect())
}

/// The section of the page, `None` where there are none.
fn baselines_section(found: &Compared) -> Option<Section> {
    if found.baselines.is_empty() {
        return None;
    }
    let unit = found.unit.as_str();
    let columns = [
        Column::text("baseline"),
        Column::number("parameters", ""),
        Column::number("lag interval", "ms"),
        Column::text("lags of y, u"),
        Column::number("held-out error", unit),
        Column::number("training RMSE", unit),
        Column::number("time", "s"),
    ];
    let table =
        found.baselines.iter().fold(Table::new(columns), |table, entry| table.row(baseline_cells(entry)));
    let (names, rows) = baselines_by_fold(found);
    let columns = names.into_iter().enumerate();
    let columns = columns.map(|(i, n)| if i == 0 { Column::text(n) } else { Column::number(n, unit) });
    let folds = rows.into_iter().fold(Table::new(columns), Table::row);
    Some(
        Section::new("Black-box baselines")
            .block(table)
            .block(Block::list(found.verdict_of_baselines()))
            .block(folds),
    )
}
