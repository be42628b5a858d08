//! `hysteron article`: the source article, reproduced on the simulated bench.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use hysteron_article::page::{page, tables};
use hysteron_article::{ArticleError, Plan, Reproduction, Summary, reproduce};
use hysteron_io::Batch;
use hysteron_report::figure_files;
use serde::Serialize;

use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::numbers::whole;
use crate::output;
use crate::progress;

/// Reproduce the source article on a simulated bench: its tables and figures beside its printed numbers.
#[derive(Args)]
#[command(
    after_help = "Writes index.html (works offline), figures/*.svg, tables/*.csv and article.json into the \
    folder. The article's data are not public: every number is from the simulated bench of `hysteron rig`, \
    and the page states the interpretations chosen where the text is ambiguous, contradictions among the \
    printed numbers, and disagreements of the result with the claims.\n\n\
    Example: hysteron article --out-dir article --seed 1"
)]
pub struct Article {
    /// Output folder; made if it does not exist
    #[arg(long, value_name = "DIR")]
    out_dir: PathBuf,

    /// Seed of the bench's noise and of every search
    #[arg(
        long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>, allow_hyphen_values = true,
    )]
    seed: u64,

    /// Threads; the result does not depend on it [default: all cores]
    #[arg(
        long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
        allow_hyphen_values = true,
    )]
    threads: Option<u16>,

    /// Print the tables' numbers, the verdicts and the files written as one JSON object
    #[arg(long)]
    json: bool,

    /// Rehearse in seconds with few runs, few generations and a short sweep; the page marks its numbers as
    /// provisional
    #[arg(long)]
    quick: bool,
}

/// Output of `--json`: all results except the curves, which are in article.json.
#[derive(Serialize)]
struct Outcome {
    page: String,
    files: Vec<String>,
    #[serde(flatten)]
    found: Summary,
}

impl Article {
    pub fn run(&self) -> Result<(), Failure> {
        output::check_folder("the reproduction", &self.out_dir)?;
        let found = self.reproduce()?;
        let files = self.write(&found)?;
        if self.json {
            console::json(&Outcome {
                page: self.out_dir.join("index.html").display().to_string(),
                files: files.iter().map(|f| f.display().to_string()).collect(),
                found: found.summary(),
            })
        } else {
            console::result(&self.words(&found))
        }
    }

    fn reproduce(&self) -> Result<Reproduction, Failure> {
        let failure = || Failure::new("cannot reproduce the article");
        let plan = Plan { seed: self.seed, ..if self.quick { Plan::quick() } else { Plan::default() } };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .build()
            .map_err(|e| failure().because(e))?;
        let stop = Interrupt::listen("nothing is written")?;
        let watch = progress::watch(&stop);
        pool.install(|| reproduce(&plan, &watch)).map_err(|e| match e {
            ArticleError::Stopped => {
                failure().because(e).hint("nothing was written; run it again").exiting_with(stop.exit_code())
            }
            _ => failure().because(e),
        })
    }

    fn write(&self, found: &Reproduction) -> Result<Vec<PathBuf>, Failure> {
        let mut page = page(found);
        page.footer.push(format!("hysteron {}, seed {}.", env!("CARGO_PKG_VERSION"), self.seed));
        let failure = || Failure::new("cannot write the reproduction");
        let (figures, folder) = (self.out_dir.join("figures"), self.out_dir.join("tables"));
        make_folder(&figures)?;
        make_folder(&folder)?;
        let drawn = figure_files("article", &page).into_iter();
        let mut files: Vec<(PathBuf, String)> = drawn.map(|(name, svg)| (figures.join(name), svg)).collect();
        files.extend(tables(found).into_iter().map(|table| (folder.join(table.name), table.text)));
        let json = serde_json::to_string(found).map_err(|e| failure().because(e))?;
        files.push((self.out_dir.join("article.json"), json));
        files.push((self.out_dir.join("index.html"), page.to_html()));
        let mut batch = Batch::default();
        for (path, text) in &files {
            batch.add(path, text.as_bytes()).map_err(|e| failure().because(e))?;
        }
        batch.finish().map_err(|e| failure().because(e))?;
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }

    /// The verdicts, as a table.
    fn words(&self, found: &Reproduction) -> String {
        let mut table = console::table(&["claim of the article", "on the simulated bench"]);
        for claim in &found.claims {
            table.add_row([claim.claim.clone(), claim.verdict.word().to_owned()]);
        }
        let rehearsal = if self.quick { "A rehearsal (--quick): the numbers do not count.\n" } else { "" };
        format!("{table}\n\n{rehearsal}page  {}\n", self.out_dir.join("index.html").display())
    }
}

fn make_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path)
        .map_err(|e| Failure::new(format!("cannot make the folder {}", path.display())).because(e))
}
