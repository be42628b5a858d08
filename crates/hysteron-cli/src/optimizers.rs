//! `hysteron optimizers`: the optimisers compared.

use clap::Args;
use hysteron_article::ArticleError;
use hysteron_article::optimizer_study::{
    Competitor, ProblemResult, Study, StudyOptions, StudyProblem, run_study,
};
use hysteron_article::page::optimizer_study::{ROW_HEADINGS, page, row_cells, target};
use serde::de::DeserializeOwned;

use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::numbers::whole;
use crate::progress;
use crate::result_flags::ResultFlags;

/// Compare the optimisers on the article's two identification problems, over many seeds with equal budgets.
#[derive(Args)]
#[command(
    after_help = "Success is an RMSE within 1 % of the one that a least-squares fit from the true parameters \
    reaches. The result does not depend on the number of threads.\n\n\
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
    #[arg(
        long, value_name = "N", default_value_t = StudyOptions::default().seeds,
        value_parser = whole::<usize>, allow_hyphen_values = true,
    )]
    seeds: usize,

    /// Seed of the first run
    #[arg(
        long, value_name = "N", default_value_t = StudyOptions::default().first_seed,
        value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// Cost evaluations of a run
    #[arg(
        long, value_name = "N", default_value_t = StudyOptions::default().budget,
        value_parser = whole::<usize>, allow_hyphen_values = true,
    )]
    budget: usize,

    /// Threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true)]
    threads: Option<usize>,

    #[command(flatten)]
    result: ResultFlags,
}

impl Optimizers {
    pub fn run(&self) -> Result<(), Failure> {
        self.result.check()?;
        let study = self.study()?;
        self.result.write(|| page(&study).footer_line(concat!("hysteron ", env!("CARGO_PKG_VERSION"))))?;
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
            ArticleError::StudyOption { .. } => Failure::usage("cannot compare the optimisers").because(e),
            ArticleError::StudyStopped { .. } => {
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

/// One table per problem.
fn text(study: &Study) -> String {
    study.problems.iter().map(problem_text).collect::<Vec<_>>().join("\n")
}

fn problem_text(problem: &ProblemResult) -> String {
    let mut table = console::table(&ROW_HEADINGS);
    for row in &problem.rows {
        table.add_row(row_cells(row));
    }
    format!("{}\n{}\n{}\n{table}\n", problem.title, problem.description, target(problem))
}
