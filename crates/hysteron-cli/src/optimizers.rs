//! `hysteron optimizers`: the optimisers compared.

use clap::Args;
use hysteron_article::optimizer_study::{
    Competitor, ProblemResult, Row, Study, StudyError, StudyOptions, StudyProblem, run_study,
};
use hysteron_report::figure::{Axis, Figure, Panel, Series, Style};
use hysteron_report::number::significant;
use hysteron_report::page::{Block, Column, Page, Section, Table};
use serde::de::DeserializeOwned;

use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::numbers::whole;
use crate::progress;
use crate::result_flags::ResultFlags;

/// Compare the optimisers on the article's two identification problems, over many seeds with one budget.
#[derive(Args)]
#[command(
    after_help = "Success is an RMSE within 1 % of the best that a least-squares fit polished from the truth reaches. \
    The result does not depend on the number of threads.\n\n\
    Example: hysteron optimizers --report optimizers.html"
)]
pub struct Optimizers {
    /// Problem to compare on: static-block or fractional-block; may be repeated [default: both]
    #[arg(long = "problem", value_name = "NAME", value_parser = by_name::<StudyProblem>)]
    problems: Vec<StudyProblem>,

    /// Competitor, e.g. de-abc, de, pso, abc, cma-es, least-squares; may be repeated [default: all]
    #[arg(long = "optimizer", value_name = "NAME", value_parser = by_name::<Competitor>)]
    competitors: Vec<Competitor>,

    /// Runs of each competitor
    #[arg(long, value_name = "N", default_value_t = StudyOptions::default().seeds, value_parser = whole::<usize>, allow_hyphen_values = true)]
    seeds: usize,

    /// Seed of the first run
    #[arg(long, value_name = "N", default_value_t = StudyOptions::default().first_seed, value_parser = whole::<u64>, allow_hyphen_values = true)]
    seed: u64,

    /// Cost evaluations of a run
    #[arg(long, value_name = "N", default_value_t = StudyOptions::default().budget, value_parser = whole::<usize>, allow_hyphen_values = true)]
    budget: usize,

    /// Threads [default: one a core]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true)]
    threads: Option<usize>,

    #[command(flatten)]
    result: ResultFlags,
}

impl Optimizers {
    pub fn run(&self) -> Result<(), Failure> {
        self.result.check()?;
        let study = self.study()?;
        self.result.write(|| page(&study))?;
        if self.result.json { console::json(&study) } else { console::result(&text(&study)) }
    }

    fn study(&self) -> Result<Study, Failure> {
        let or_all = StudyOptions::default();
        let options = StudyOptions {
            problems: if self.problems.is_empty() { or_all.problems } else { self.problems.clone() },
            competitors: if self.competitors.is_empty() {
                or_all.competitors
            } else {
                self.competitors.clone()
            },
            seeds: self.seeds,
            first_seed: self.seed,
            budget: self.budget,
            threads: self.threads,
            ..StudyOptions::default()
        };
        let stop = Interrupt::listen("no comparison is printed")?;
        run_study(&options, &progress::watch(&stop)).map_err(|e| match e {
            StudyError::Option { .. } => Failure::usage("cannot compare the optimisers").because(e),
            StudyError::Cancelled { .. } => {
                Failure::new("cannot compare the optimisers").because(e).exiting_with(stop.exit_code())
            }
            _ => Failure::new("cannot compare the optimisers").because(e),
        })
    }
}

/// Parses one of the library's names.
fn by_name<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    serde_json::from_value(text.into()).map_err(|e| e.to_string())
}

/// A table a problem.
fn text(study: &Study) -> String {
    study.problems.iter().map(problem_text).collect::<Vec<_>>().join("\n")
}

fn problem_text(problem: &ProblemResult) -> String {
    let mut table = console::table(&HEADER);
    for row in &problem.rows {
        table.add_row(cells(row));
    }
    format!("{}\n{}\n{}\n{table}\n", problem.title, problem.description, target(problem))
}

const HEADER: [&str; 6] = [
    "optimizer",
    "median best RMSE [um]",
    "success [%]",
    "evaluations to 1 % [median]",
    "quartiles",
    "scouts fired",
];

fn cells(row: &Row) -> [String; 6] {
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

fn target(problem: &ProblemResult) -> String {
    format!(
        "Best RMSE that can be reached {} um; success is within 1 %: {} um.",
        significant(problem.reachable_rmse, 5),
        significant(problem.target_rmse, 5)
    )
}

fn page(study: &Study) -> Page {
    let options = &study.options;
    let mut page = Page::new("Optimisers compared").subtitled(format!(
        "{} seeds from {}, {} evaluations a run, simulated records",
        options.seeds, options.first_seed, options.budget
    ));
    for problem in &study.problems {
        page = page.section(section(problem));
    }
    page.footer_line(concat!("hysteron ", env!("CARGO_PKG_VERSION")))
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
    let table = problem.rows.iter().fold(Table::new(columns), |table, row| table.row(cells(row)));
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
