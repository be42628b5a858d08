//! `hysteron compare` of several axes.

use std::path::Path;

use hysteron_identify::modes::{ModesCandidate, ModesComparison, Options, compare_modes};
use hysteron_identify::{FitRecords, IdentifyError, Task, Watch, fit};
use hysteron_model::Model;
use hysteron_report::modes_comparison::{cells, header, page};

use super::{Compare, Structure, write_preferred};
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::kept::{self, Kept};
use crate::maker::maker;
use crate::outputs::Outputs;

impl Compare {
    pub(super) fn several_axes(&self) -> Result<(), Failure> {
        for (given, flag) in [
            (self.quick, "--quick"),
            (self.continued, "--continued"),
            (self.baselines, "--baselines"),
            (self.time_limit.is_some(), "--time-limit"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with several axes yet")));
            }
        }
        if self.axes.inputs.is_empty() || self.axes.outputs.is_empty() {
            return Err(Failure::usage("several axes need their inputs and outputs")
                .hint("name them in order, e.g. --inputs u1_V,u2_V --outputs y1_nm,y2_nm"));
        }
        let candidates = self.candidates.iter().map(|structure| match structure {
            Structure::Several(candidate) => Ok(*candidate),
            Structure::One(candidate) => {
                Err(Failure::usage(format!("{candidate} is a structure of one input and one output"))
                    .hint("structures of several axes are e.g. linear, polynomial, plays6, modes8+plays6"))
            }
        });
        let candidates = candidates.collect::<Result<Vec<ModesCandidate>, Failure>>()?;
        let records = self.axes.read_all(&self.records, self.columns.of_drive())?;
        let resume = self.resume.as_deref().map(kept::read).transpose()?;
        let stop = Interrupt::listen("what is finished is printed")?;
        let kept = Kept::beside(self.out.as_deref());
        let watch = kept.watch_searches(&stop);
        let options = Options::default();
        let found = compare_modes(&records, &candidates, &options, &watch, resume);
        drop(watch);
        let found = found.map_err(|e| explain(&e))?;
        let maker = maker();
        let write = |model: Option<(&Path, &Model)>| {
            let mut outputs = Outputs::default();
            if let Some((path, model)) = model {
                outputs.add_model(path, model)?;
            }
            self.result.add(&mut outputs, || page(&found, &maker))?;
            outputs.finish().map_err(|e| kept.told(e))
        };
        if self.result.json {
            console::json(&found)?;
        } else {
            console::result(&text(&found))?;
        }
        if found.interrupted {
            write(None).map_err(|e| stop.told(e))?;
            return Err(stop.told(interrupted(&kept)));
        }
        if found.ranking.is_none() {
            write(None)?;
            let failure = Failure::new("no structure could be compared");
            let why = found.entries.iter().find_map(|entry| entry.failures.first());
            return Err(
                why.map_or(Failure::new("no structure could be compared"), |why| failure.because(why))
            );
        }
        let Some(path) = &self.out else { return write(None) };
        let watch = Watch::silent().stopped_by(stop.stop());
        let Some((candidate, options)) = found.preferred(&options) else { return write(None) };
        let fit = fit(&FitRecords::Several(records), &Task::Modes(options), &watch, None, &maker);
        if stop.stop().is_requested() {
            write(None).map_err(|e| stop.told(e))?;
            return Err(stop.told(interrupted(&kept)));
        }
        write_preferred(&candidate, fit, path, write)?;
        kept.forget();
        Ok(())
    }
}

/// Failure of a comparison that was stopped, with what goes on with it.
fn interrupted(kept: &Kept) -> Failure {
    let failure = Failure::new("the comparison was interrupted")
        .because("the finished candidates are printed, and no model is written");
    match kept.file() {
        Some(file) => failure.hint(format!("go on with the same command and --resume {}", file.display())),
        None => failure.hint("run it again, or name fewer structures with --candidates"),
    }
}

fn text(found: &ModesComparison) -> String {
    let header = header(&found.unit);
    let mut table = console::table(&header.each_ref().map(String::as_str));
    for index in found.order() {
        table.add_row(cells(found, index));
    }
    let verdict: String = found.verdict().into_iter().map(|line| line + "\n").collect();
    format!("{table}\n\n{verdict}\n{}\n", found.about())
}

fn explain(error: &IdentifyError) -> Failure {
    match error {
        IdentifyError::CannotRank { because, measure } => {
            Failure::new("structures cannot be ranked on these records")
                .because(because)
                .hint(format!("measure {measure}"))
        }
        IdentifyError::Resume => Failure::new("the comparison cannot be resumed")
            .because(error)
            .hint("resume with the records of the interrupted one; or leave out --resume to start again"),
        error => Failure::new("structures cannot be compared on these records").because(error),
    }
}
