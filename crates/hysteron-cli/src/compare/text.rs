//! The comparison for people.

use hysteron_identify::Compared;
use hysteron_report::comparison::{baseline_cells, baselines_by_fold, cells};
use hysteron_report::number::significant;

use crate::console;

fn header(unit: &str) -> [String; 9] {
    let error = |what: &str| console::in_unit(what, unit);
    [
        "structure".into(),
        "parameters".into(),
        error("held-out error"),
        error("above the best"),
        error("training RMSE"),
        "AIC".into(),
        "BIC".into(),
        "ns per sample".into(),
        "inverse".into(),
    ]
}

pub fn text(found: &Compared) -> String {
    let comparison = &found.comparison;
    let header = header(&found.unit);
    let mut table = console::table(&header.each_ref().map(String::as_str));
    for index in found.order() {
        table.add_row(cells(found, index));
    }
    let mut by_fold = console::table(&["held-out fold", "content", "smallest error", "of"]);
    for (f, fold) in comparison.folds.iter().enumerate() {
        let errors = comparison.entries.iter().filter_map(|e| Some((e.fold_rmse[f]?, e.candidate)));
        let (error, best) = errors.min_by(|a, b| a.0.total_cmp(&b.0)).map_or_else(
            || ("-".to_owned(), "-".to_owned()),
            |(error, candidate)| (significant(error, 3), candidate.to_string()),
        );
        by_fold.add_row([fold.label.clone(), fold.content.clone(), error, best]);
    }
    let verdict: String = found.verdict().into_iter().map(|line| line + "\n").collect();
    format!("{table}\n\n{verdict}\n{by_fold}\n\n{}\n{}", found.about(), baselines(found))
}

/// Tables of the baselines; empty without any.
fn baselines(found: &Compared) -> String {
    if found.baselines.is_empty() {
        return String::new();
    }
    let error = |what: &str| console::in_unit(what, &found.unit);
    let mut table = console::table(&[
        "baseline",
        "parameters",
        "lag interval [ms]",
        "lags of y, u",
        &error("held-out error"),
        &error("training RMSE"),
        "time [s]",
    ]);
    for entry in &found.baselines {
        table.add_row(baseline_cells(entry));
    }
    let (names, rows) = baselines_by_fold(found);
    let mut folds = console::table(&names.iter().map(String::as_str).collect::<Vec<_>>());
    for row in rows {
        folds.add_row(row);
    }
    let lines: String = found.verdict_of_baselines().into_iter().map(|line| line + "\n").collect();
    format!("\n{table}\n\n{lines}\n{folds}\n")
}
