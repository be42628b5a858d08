//! `--baselines`: black-box models beside the structures, on the same folds.

use hysteron_identify::Stop;
use hysteron_identify::baselines::{Baseline, CrossValidated, Trained, cross_validate};
use hysteron_identify::structure::{Comparison, Fold};
use hysteron_model::record::InputOutput;
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Column, Section, Table};
use serde::Serialize;

use super::{Found, text};
use crate::console;

/// Every baseline on the folds of the comparison; those that were not stopped.
pub fn scored(comparison: &Comparison, records: &[InputOutput], stop: &Stop) -> Vec<CrossValidated> {
    let score = |kind| {
        console::message(&format!("training {}", Baseline::name(kind)));
        cross_validate(kind, records, &comparison.folds, stop)
    };
    Baseline::ALL.into_iter().map_while(score).collect()
}

/// One row: baseline, parameters, lags, error on left-out data ± its standard error, training error, time.
fn cells(entry: &CrossValidated) -> [String; 7] {
    let missing = || "-".to_owned();
    let model = entry.model.as_ref();
    [
        entry.kind.name().to_owned(),
        model.map_or_else(missing, |m| m.parameters().to_string()),
        model.map_or_else(missing, |m| significant(1e3 * m.units.interval_s, 3)),
        model.map_or_else(missing, |m| format!("{}, {}", m.regressors.lags.output, m.regressors.lags.input)),
        entry.error().map_or_else(missing, |(mean, error)| text::with_error(mean, error)),
        entry.training_rmse.map_or_else(missing, |x| significant(x, 3)),
        significant(entry.seconds, 2),
    ]
}

/// The table for people, empty where there are none.
pub fn table(found: &Found) -> String {
    if found.baselines.is_empty() {
        return String::new();
    }
    let error = |what: &str| console::in_unit(what, &found.unit);
    let mut table = console::table(&[
        "baseline",
        "parameters",
        "lag interval [ms]",
        "lags of y, u",
        &error("error on unseen data"),
        &error("training RMSE"),
        "time [s]",
    ]);
    for entry in &found.baselines {
        table.add_row(cells(entry));
    }
    let (names, rows) = by_fold(found);
    let mut folds = console::table(&names.iter().map(String::as_str).collect::<Vec<_>>());
    for row in rows {
        folds.add_row(row);
    }
    let lines: String = lines(found).into_iter().map(|line| line + "\n").collect();
    format!("\n{table}\n\n{lines}\n{folds}\n")
}

/// Header and rows: what was left out, the error of the best structure and of each baseline.
fn by_fold(found: &Found) -> (Vec<String>, Vec<Vec<String>>) {
    let best = found.comparison.ranking.as_ref().map(|r| &found.comparison.entries[r.best]);
    let mut names = vec!["left out".to_owned()];
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

/// What the table says, and how it came about.
fn lines(found: &Found) -> Vec<String> {
    let comparison = &found.comparison;
    let best = comparison.ranking.as_ref().and_then(|r| text::standing(comparison, r.best)).map(|s| s.mean);
    let errors = found.baselines.iter().filter_map(|b| Some((b.error()?.0, b.kind.name())));
    let least = errors.min_by(|a, b| a.0.total_cmp(&b.0));
    let mut lines = Vec::new();
    if let (Some(best), Some((error, name))) = (best, least) {
        let ratio = significant(error / best, 3);
        lines.push(if error < best {
            format!(
                "{name} has {ratio} times the error of the best structure: the structures compared lack something that these records hold."
            )
        } else {
            format!("The best baseline, {name}, has {ratio} times the error of the best structure.")
        });
    }
    for entry in &found.baselines {
        lines.extend(entry.failures.iter().map(|why| format!("{}: {why}.", entry.kind.name())));
    }
    lines.push(
        "Baselines are black-box NARX models trained on the same records, all choices made on what they are trained on, simulated (not one step \
         ahead) on the same left-out data. They hold for their lag interval and have no inverse and no intervals."
            .to_owned(),
    );
    lines
}

/// The section of the page, `None` where there are none.
pub fn section(found: &Found) -> Option<Section> {
    if found.baselines.is_empty() {
        return None;
    }
    let unit = found.unit.as_str();
    let columns = [
        Column::text("baseline"),
        Column::number("parameters", ""),
        Column::number("lag interval", "ms"),
        Column::text("lags of y, u"),
        Column::number("error on unseen data", unit),
        Column::number("training RMSE", unit),
        Column::number("time", "s"),
    ];
    let table = found.baselines.iter().fold(Table::new(columns), |table, entry| table.row(cells(entry)));
    let (names, rows) = by_fold(found);
    let columns = names.into_iter().enumerate();
    let columns = columns.map(|(i, n)| if i == 0 { Column::text(n) } else { Column::number(n, unit) });
    let folds = rows.into_iter().fold(Table::new(columns), Table::row);
    Some(Section::new("Black-box baselines").block(table).block(Block::list(lines(found))).block(folds))
}

#[derive(Serialize)]
pub struct BaselineEntry<'a> {
    name: &'static str,
    parameters: Option<usize>,
    lag_interval_s: Option<f64>,
    output_lags: Option<usize>,
    input_lags: Option<usize>,
    error: Option<f64>,
    error_std_error: Option<f64>,
    training_rmse: Option<f64>,
    fold_errors: &'a [Option<f64>],
    failures: &'a [String],
    seconds: f64,
}

impl<'a> BaselineEntry<'a> {
    pub fn new(entry: &'a CrossValidated) -> Self {
        let model = entry.model.as_ref();
        let lags = model.map(|m| m.regressors.lags);
        BaselineEntry {
            name: entry.kind.name(),
            parameters: model.map(Trained::parameters),
            lag_interval_s: model.map(|m| m.units.interval_s),
            output_lags: lags.map(|l| l.output),
            input_lags: lags.map(|l| l.input),
            error: entry.error().map(|e| e.0),
            error_std_error: entry.error().map(|e| e.1),
            training_rmse: entry.training_rmse,
            fold_errors: &entry.fold_rmse,
            failures: &entry.failures,
            seconds: entry.seconds,
        }
    }
}
