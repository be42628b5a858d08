//! `hysteron compare`: which structure do these records support?

mod text;

use std::path::PathBuf;

use clap::Args;
use hysteron_identify::baselines::cross_validate_all;
use hysteron_identify::structure::{Candidate, Comparison, UnknownCandidate, compare};
use hysteron_identify::{CampaignRecord, Compared, IdentifyError, Options, Watch};
use hysteron_report::comparison;

use crate::columns::ColumnFlags;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::maker::maker;
use crate::output::{self, OutFile};
use crate::progress;
use crate::result_flags::ResultFlags;

/// Compare structures by held-out simulation error (cross-validation), and say which of them the records
/// support.
#[derive(Args)]
#[command(after_help = "Cross-validation: each record (or part of one, where there are fewer than three of \
    different content) is held out in turn, every candidate is fitted to the rest and simulated on the \
    held-out record. Records that repeat one experiment are refused, with what to measure instead.\n\n\
    Without --candidates the structure is searched for: first the usual dynamic blocks (none, integer1 to \
    integer4, arx, fractional ones), then variations of the best so far in creep, hysteresis family (those \
    quick to fit), polynomial degree and free n, until none is better. This takes six minutes of processor \
    time for four records of 45 000 samples together. A candidate is \
    BLOCK[+CREEP][+degreeN][+n-free][+FAMILY], BLOCK one of none, integer1 to integer12, modes4 to modes12 \
    (resonances in parallel), arx, oe, bj, srivc, fractional, fractional-free-lowest, two-fractional, CREEP \
    one of creep (fractional), log-creep, kelvin-voigt (two elements); the defaults are a cubic polynomial, \
    n = 1 and the family bouc-wen. The families are those of identify --hysteresis, with their usual number \
    of elements.\n\n\
    The table also gives the cost in a controller: nanoseconds per sample of the realisation to 1e-5 \
    (hysteron realise), timed with the same drive for all candidates, on this machine; ratios are more \
    reliable than times. Its last column says if the hysteresis is invertible: always, on records (the \
    output rose with the drive everywhere along them) or no.\n\n\
    Ctrl-C prints the candidates finished so far.\n\n\
    Example: hysteron compare loop_1hz.csv sweep.csv sine_*.csv --report compare.html\n\
    Example: hysteron compare loop.csv sweep.csv --candidates none,integer2,fractional,fractional+degree2 -o \
    model.json\n\
    Example: hysteron compare loop_1hz.csv sweep.csv sine_*.csv --candidates fractional+creep --baselines\n\
    Example: hysteron compare cycle_*.csv --continued --candidates \
    integer1,integer1+kelvin-voigt+preisach-density\n\
    Example: hysteron compare loops.csv sweep.csv --candidates \
    fractional+creep,fractional+creep+prandtl-ishlinskii,fractional+creep+dahl")]
pub struct Compare {
    /// The records
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Structures to compare, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = candidate)]
    candidates: Vec<Candidate>,

    /// The records are consecutive parts of one run on one clock: each part is left out in turn; hysteresis
    /// memory and creep carry over
    #[arg(long, conflicts_with = "baselines")]
    continued: bool,

    /// Train black-box NARX models (polynomial, kernel, neural) on the same folds as baselines
    #[arg(long)]
    baselines: bool,

    /// Model file of the preferred structure to write, identified from all samples of all records
    #[arg(short, long = "output-model", value_name = "MODEL.json")]
    out: Option<OutFile>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    columns: ColumnFlags,
}

fn candidate(text: &str) -> Result<Candidate, UnknownCandidate> {
    text.parse()
}

impl Compare {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(path) = &self.out {
            output::check_file("the model", path)?;
        }
        self.result.check()?;
        let records = self.columns.read_all(&self.records)?.into_iter();
        let campaign: Vec<_> = records.map(|data| CampaignRecord { data, role: None }).collect();
        let stop = Interrupt::listen("what is finished is printed")?;
        let watch = progress::watch(&stop);
        let candidates = (!self.candidates.is_empty()).then_some(self.candidates.as_slice());
        let options = Options { continued: self.continued, ..Options::default() };
        let comparison = compare(&campaign, candidates, &options, &watch);
        drop(watch);
        let comparison = comparison.map_err(|e| explain(&e))?;
        let baselines = match &comparison.ranking {
            Some(_) if self.baselines => {
                let data: Vec<_> = campaign.iter().map(|r| r.data.clone()).collect();
                cross_validate_all(&data, &comparison.folds, &progress::watch(&stop), &console::clock())
            }
            _ => Vec::new(),
        };
        let maker = maker();
        let found = Compared::new(comparison, &campaign, baselines, &console::clock());
        self.result.write(|| comparison::page(&found, &maker))?;
        if self.result.json {
            console::json(&found)?;
        } else {
            console::result(&text::text(&found))?;
        }
        if found.comparison.ranking.is_none() {
            return Err(stop.told(nothing(&found.comparison)));
        }
        if found.comparison.interrupted {
            return Err(Failure::new("the comparison was interrupted")
                .because("the finished candidates are printed, and no model is written")
                .hint("run it again, or name fewer structures with --candidates")
                .exiting_with(stop.exit_code()));
        }
        let Some(path) = &self.out else { return Ok(()) };
        let watch = Watch::silent().stopped_by(stop.stop());
        let Some((candidate, fit)) = found.identify_preferred(&campaign, &watch, &maker) else {
            return Ok(());
        };
        let failure = || Failure::new(format!("cannot identify {candidate} from all records"));
        crate::model::save(path, &fit.map_err(|e| failure().because(e))?.model)?;
        console::message(&format!("model of {candidate} written to {}", path.display()));
        Ok(())
    }
}

/// Failure for a comparison without a finished candidate.
fn nothing(comparison: &Comparison) -> Failure {
    let failure = Failure::new("no structure could be compared");
    match comparison.entries.iter().find_map(|e| Some((e.candidate, e.failures.first()?))) {
        Some((candidate, why)) => failure.because(format!("{candidate}: {why}")),
        None => failure.because("it was stopped before the first candidate was finished"),
    }
}

fn explain(error: &IdentifyError) -> Failure {
    match error {
        IdentifyError::CannotRank { because, measure } => {
            Failure::new("structures cannot be ranked on these records")
                .because(because)
                .hint(format!("measure {measure}."))
        }
        error => Failure::new("structures cannot be compared on these records").because(error),
    }
}
