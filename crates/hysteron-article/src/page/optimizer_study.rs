//! The comparison of the optimisers over many seeds, as tables and a page.

use crate::optimizer_study::{ProblemResult, Row, Study};
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Column, Page, Section, Table};

/// Headings of a table of the optimisers, for people.
pub const ROW_HEADINGS: [&str; 6] = [
    "optimizer",
    "median best RMSE [um]",
    "success [%]",
    "evaluations to 1 % [median]",
    "quartiles",
    "scouts fired",
];

/// A line of it.
pub fn row_cells(row: &Row) -> [String; 6] {
    let whole = |x: f64| format!("{x:.0}");
    let quartiles = row.evaluations_to_target.as_ref();
    [
        row.name.clone(),
        significant(row.median_best_rmse, 4),
        whole(row.success_percent),
        quartiles.map_or("-".into(), |q| whole(q.median)),
        quartiles.map_or("-".into(), |q| format!("{:.0} to {:.0}", q.lower, q.upper)),
        row.scouts_fired.to_string(),
    ]
}

/// The success criterion of a problem as a sentence: the cost to fall below.
pub fn target(problem: &ProblemResult) -> String {
    format!(
        "Best RMSE that can be reached {} um; success is within 1 %: {} um.",
        significant(problem.reachable_rmse, 5),
        significant(problem.target_rmse, 5)
    )
}

/// The page of a comparison of the optimisers.
pub fn page(study: &Study) -> Page {
    let options = &study.options;
    let mut page = Page::new("Optimisers compared").subtitled(format!(
        "{} seeds from {}, {} evaluations a run, simulated records",
        options.seeds, options.first_seed, options.budget
    ));
    for problem in &study.problems {
        page = page.section(section(problem));
    }
    page
}

fn section(problem: &ProblemResult) -> Section {
    let columns = [
        Column::text("optimiser"),
        Column::number("median best RMSE", "µm"),
        Column::number("success", "%"),
        Column::number("evaluations to 1 %, median", ""),
        Column::text("quartiles"),
        Column::number("scouts fired", ""),
    ];
    let table = problem.rows.iter().fold(Table::new(columns), |table, row| table.row(row_cells(row)));
    let mut panel = Panel::new(Axis::linear("evaluations", ""), Axis::log("best RMSE so far", "µm"));
    for (i, row) in problem.rows.iter().enumerate() {
        let curve = &row.curve;
        let x: Vec<f64> = curve.evaluations.iter().map(|&n| n as f64).collect();
        let line = Series::line(row.name.as_str(), x, curve.median.clone(), Style::nth(i));
        panel = panel.series(line.with_band(curve.lower.clone(), curve.upper.clone()));
    }
    let figure = Figure::new(format!("{}: convergence", problem.title))
        .captioned("Median and quartiles over the seeds of the best RMSE so far.")
        .panel(panel)
        .panel_height(320.0);
    Section::new(problem.title.as_str())
        .block(Block::paragraph(problem.description.as_str()))
        .block(Block::paragraph(target(problem)))
        .block(table)
        .block(figure)
}
