//! `hysteron compare`: which structure do these records support?

mod several;
mod text;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use hysteron_identify::baselines::cross_validate_all;
use hysteron_identify::modes::ModesCandidate;
use hysteron_identify::structure::{
    Candidate, Comparison, Selection, UnknownCandidate, compare_from, prospects,
};
use hysteron_identify::{CampaignRecord, Compared, Fit, IdentifyError, Options, Watch};
use hysteron_model::Model;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::record::InputOutput;
use hysteron_report::comparison;

use crate::axes::AxesFlags;
use crate::columns::ColumnFlags;
use crate::console;
use crate::design::{self, DesignFrom};
use crate::failure::Failure;
use crate::interrupt::{Interrupt, partial};
use crate::kept::{self, Kept};
use crate::maker::maker;
use crate::numbers::positive;
use crate::output::{self, OutFile};
use crate::outputs::Outputs;
use crate::progress;
use crate::result_flags::ResultFlags;

/// Compare structures by held-out simulation error (cross-validation), and say which of them the records
/// support.
#[derive(Args)]
#[command(after_help = format!("\
    Cross-validation: each record (or part of one, where there are fewer than three of different content) is \
    held out in turn, every candidate is fitted to the rest and simulated on the \
    held-out record. Records that repeat one experiment are refused, with what to measure instead.\n\n\
    Without --candidates the structure is searched for: from fractional dynamics with creep, variations of \
    the preferred candidate so far in hysteresis family (those quick to fit), dynamic block (none, integer1 \
    to integer4, fractional ones, arx), creep, polynomial degree and free n, until it stays. A candidate \
    that, with all records in its fit, still has more than 1.2 times the smallest held-out error is not \
    cross-validated, and what was more than 1.5 times as far off is not tried again. --quick goes once through the commonest of each; --time-limit ends after so many \
    seconds with what is finished by then. A candidate is \
    BLOCK[+CREEP][+degreeN][+n-free][+FAMILY], BLOCK one of none, integer1 to integer12, modes4 to modes12 \
    (resonances in parallel), arx, oe, bj, srivc, fractional, fractional-free-lowest, two-fractional, CREEP \
    one of creep (fractional), log-creep, kelvin-voigt (two elements); the defaults are a cubic polynomial, \
    n = 1 and the family {}. The families are those of identify --hysteresis, with their usual number \
    of elements.\n\n\
    The table also gives the cost in a controller: nanoseconds per sample of the realisation to 1e-5 \
    (hysteron realise), timed with the same drive for all candidates, on this machine; ratios are more \
    reliable than times. Its last column says if the hysteresis is invertible: always, on records (the \
    output rose with the drive everywhere along them) or no.\n\n\
    Ctrl-C prints the candidates finished so far and writes the model of the one preferred among them to \
    MODEL.partial.json. With -o the finished candidates are kept in MODEL.searches.json as they come, also of a \
    command that is killed: the same command with --resume MODEL.searches.json fits only the others and ends \
    with the same result.\n\n\
    Several axes (--inputs, --outputs) compare structures of modes, [modesN+] and one of linear, polynomial, \
    playsN, by default linear, polynomial, plays3, plays6; each fold holds out one record of every level.\n\n\
    Example: hysteron compare loop_1hz.csv sweep.csv sine_*.csv --report compare.html\n\
    Example: hysteron compare small*.csv large*.csv --inputs u1_V,u2_V --outputs y1_nm,y2_nm\n\
    Example: hysteron compare loop_1hz.csv sweep.csv sine_*.csv --quick --time-limit 30 -o model.json\n\
    Example: hysteron compare loop.csv sweep.csv --candidates none,integer2,fractional,fractional+degree2 -o \
    model.json\n\
    Example: hysteron compare loop_1hz.csv sweep.csv sine_*.csv --candidates fractional+creep --baselines\n\
    Example: hysteron compare cycle_*.csv --continued --candidates integer1,integer1+kelvin-voigt\n\
    Example: hysteron compare loops.csv sweep.csv --candidates fractional+creep,fractional+creep+{}",
    HysteresisForm::default().name(),
    HysteresisForm::plays(1).name()))]
pub struct Compare {
    /// The records
    #[arg(value_name = "RECORD", required = true)]
    records: Vec<PathBuf>,

    /// Structures to compare, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = candidate)]
    candidates: Vec<Structure>,

    /// Search through the commonest structures only, in one pass
    #[arg(long, conflicts_with = "candidates")]
    quick: bool,

    /// End the search after this time, in seconds, with what is finished by then; timing the candidates and
    /// identifying the preferred one for --output-model come after it
    #[arg(
        long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true,
        conflicts_with = "baselines",
    )]
    time_limit: Option<f64>,

    /// The records are consecutive parts of one run on one clock: each part is left out in turn; hysteresis
    /// memory and creep carry over
    #[arg(long, conflicts_with = "baselines")]
    continued: bool,

    /// Train black-box NARX models (polynomial, kernel, neural) on the same folds as baselines
    #[arg(long)]
    baselines: bool,

    /// Go on with an interrupted comparison of the same records and candidates: those that it finished are
    /// not fitted again
    #[arg(long, value_name = "MODEL.searches.json", conflicts_with = "baselines")]
    resume: Option<PathBuf>,

    /// Model file of the preferred structure to write, identified from all samples of all records
    #[arg(short, long = "output-model", value_name = "MODEL.json")]
    out: Option<OutFile>,

    #[command(flatten)]
    result: ResultFlags,

    #[command(flatten)]
    columns: ColumnFlags,

    #[command(flatten)]
    axes: AxesFlags,
}

/// A structure by its name.
#[derive(Clone, Copy, Debug)]
enum Structure {
    /// Of one input and one output.
    One(Candidate),
    /// Of several axes.
    Several(ModesCandidate),
}

fn candidate(text: &str) -> Result<Structure, UnknownCandidate> {
    match text.parse() {
        Ok(candidate) => Ok(Structure::One(candidate)),
        Err(unknown) => text.parse().map(Structure::Several).map_err(|_| unknown),
    }
}

/// Writes the model of the preferred candidate, fitted to all records, with the report; without it where the fit
/// failed.
fn write_preferred(
    candidate: &impl Display,
    fit: Result<Fit, IdentifyError>,
    path: &Path,
    write: impl Fn(Option<(&Path, &Model)>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let fit = match fit {
        Ok(fit) => fit,
        Err(e) => {
            write(None)?;
            let failure = Failure::new(format!("cannot identify {candidate} from all records"));
            return Err(failure.because(e));
        }
    };
    write(Some((path, &fit.model)))?;
    console::message(&format!("model of {candidate} written to {}", path.display()));
    Ok(())
}

impl Compare {
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(path) = &self.out {
            output::check_file("the model", path)?;
        }
        self.result.check()?;
        if self.axes.are_given() {
            return self.several_axes();
        }
        let candidates = self.candidates.iter().map(|structure| match structure {
            Structure::One(candidate) => Ok(*candidate),
            Structure::Several(candidate) => {
                Err(Failure::usage(format!("{candidate} is a structure of several axes"))
                    .hint("name their columns with --inputs and --outputs"))
            }
        });
        let candidates = candidates.collect::<Result<Vec<_>, Failure>>()?;
        let records = self.columns.read_all(&self.records)?.into_iter();
        let campaign: Vec<_> = records.map(|data| CampaignRecord { data, role: None }).collect();
        let resume = self.resume.as_deref().map(kept::read).transpose()?;
        let stop = Interrupt::listen("what is finished is printed")?;
        let kept = Kept::beside(self.out.as_deref());
        let watch = kept.watch_candidates(&stop);
        let selection = Selection::of(&candidates, self.quick);
        let options = Options { continued: self.continued, ..Options::default() };
        let comparison = match self.time_limit {
            None => compare_from(&campaign, selection, &options, &watch, resume),
            Some(seconds) => {
                let limit = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
                compare_from(&campaign, selection, &options, &watch.within(limit, console::clock()), resume)
            }
        };
        drop(watch);
        let comparison = comparison.map_err(|e| explain(&e, &self.next_drive(&campaign, None)))?;
        let baselines = match &comparison.ranking {
            Some(_) if self.baselines => {
                let data: Vec<_> = campaign.iter().map(|r| r.data.clone()).collect();
                cross_validate_all(&data, &comparison.folds, &progress::watch(&stop), &console::clock())
            }
            _ => Vec::new(),
        };
        let maker = maker();
        let found = Compared::new(comparison, &campaign, baselines, &console::clock());
        if self.result.json {
            console::json(&found)?;
        } else {
            console::result(&text::text(&found))?;
        }
        let write = |model: Option<(&Path, &Model)>| self.write(&found, model).map_err(|e| kept.told(e));
        if found.comparison.ranking.is_none() {
            write(None)?;
            return Err(stop.told(nothing(&found.comparison)));
        }
        let interrupted = || self.interrupted(&found, &campaign, kept.file()).map_err(|e| stop.told(e));
        if stop.stop().is_requested() {
            return Err(stop.told(interrupted()?));
        }
        let Some(path) = &self.out else { return write(None) };
        let watch = Watch::silent().stopped_by(stop.stop());
        let Some((candidate, fit)) = found.identify_preferred(&campaign, &watch, &maker) else {
            return write(None);
        };
        if stop.stop().is_requested() {
            return Err(stop.told(interrupted()?));
        }
        write_preferred(&candidate, fit, path, write)?;
        console::message(&format!("the next drive: {}", self.next_drive(&campaign, Some(path))));
        kept.forget();
        Ok(())
    }

    /// Writes the report, and the model where there is one: both or none.
    fn write(&self, found: &Compared, model: Option<(&Path, &Model)>) -> Result<(), Failure> {
        let mut outputs = Outputs::default();
        if let Some((path, model)) = model {
            outputs.add_model(path, model)?;
        }
        self.result.add(&mut outputs, || comparison::page(found, &maker()))?;
        outputs.finish()
    }

    /// The command that makes the next drive, from the model where there is one.
    fn next_drive(&self, campaign: &[CampaignRecord], model: Option<&Path>) -> String {
        let records: Vec<InputOutput> = campaign.iter().map(|record| record.data.clone()).collect();
        let purpose = prospects(&records).next_for;
        let from = model.map_or(DesignFrom::Records(&self.records, &self.columns), DesignFrom::Model);
        design::command(from, &records, purpose)
    }

    /// Writes the preferred model so far beside where the model was to be, and says so.
    fn interrupted(
        &self,
        found: &Compared,
        campaign: &[CampaignRecord],
        kept: Option<&Path>,
    ) -> Result<Failure, Failure> {
        let failure = Failure::new("the comparison was interrupted").hint(match kept {
            Some(file) => format!("go on with the same command and --resume {}", file.display()),
            None => "run it again, with --time-limit, or name fewer structures with --candidates".to_owned(),
        });
        let (Some(path), Some((candidate, model))) = (&self.out, found.preferred_so_far(campaign)) else {
            self.write(found, None)?;
            return Ok(failure.because("the finished candidates are printed, and no model is written"));
        };
        let path = partial(path);
        let cannot = || Failure::new(format!("cannot write the model of {candidate}"));
        self.write(found, Some((&path, &model.map_err(|e| cannot().because(e))?)))?;
        let kept = format!("the preferred model so far, {candidate}, is in {}", path.display());
        Ok(failure.because(format!("the finished candidates are printed; {kept}")))
    }
}

/// Failure for a comparison without a finished candidate.
fn nothing(comparison: &Comparison) -> Failure {
    let failure = Failure::new("no structure could be compared");
    match comparison.entries.iter().find_map(|e| Some((e.candidate, e.failures.first()?))) {
        Some((candidate, why)) => failure.because(format!("{candidate}: {why}")),
        None if comparison.out_of_time => failure
            .because("the time given was over before the first candidate was finished")
            .hint("give a longer --time-limit, or fewer samples with --from and --to"),
        None => failure.because("it was stopped before the first candidate was finished"),
    }
}

/// The failure, with the command that makes the `next` drive.
fn explain(error: &IdentifyError, next: &str) -> Failure {
    match error {
        IdentifyError::CannotRank { because, measure } => {
            Failure::new("structures cannot be ranked on these records")
                .because(because)
                .hint(format!("measure {measure}.\nThe drive for it: {next}"))
        }
        IdentifyError::Resume => Failure::new("the comparison cannot be resumed").because(error).hint(
            "resume with the records and candidates of the interrupted one; or leave out --resume to start again",
        ),
        error => Failure::new("structures cannot be compared on these records").because(error),
    }
}
