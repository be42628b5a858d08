//! `hysteron compare` of several axes.

use hysteron_identify::modes::{ModesCandidate, ModesComparison, Options, compare_modes};
use hysteron_identify::{FitRecords, IdentifyError, Task, Watch, fit};
use hysteron_report::modes_comparison::{cells, header, page};

use super::{Compare, Structure};
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::maker::maker;
use crate::progress;

impl Compare {
    pub(super) fn several_axes(&self) -> Result<(), Failure> {
        for (given, flag) in [
            (self.quick, "--quick"),
            (self.continued, "--continued"),
            (self.baselines, "--baselines"),
            (self.resume.is_some(), "--resume"),
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
        let stop = Interrupt::listen("what is finished is printed")?;
        let watch = progress::watch(&stop);
        let options = Options::default();
        let found = compare_modes(&records, &candidates, &options, &watch);
        drop(watch);
        let found = found.map_err(|e| explain(&e))?;
        let maker = maker();
        self.result.write(|| page(&found, &maker))?;
        if self.result.json {
            console::json(&found)?;
        } else {
            console::result(&text(&found))?;
        }
        if found.interrupted {
            return Err(stop.told(
                Failure::new("the comparison was interrupted")
                    .because("the finished candidates are printed, and no model is written"),
            ));
        }
        if found.ranking.is_none() {
            let failure = Failure::new("no structure could be compared");
            let why = found.entries.iter().find_map(|entry| entry.failures.first());
            return Err(
                why.map_or(Failure::new("no structure could be compared"), |why| failure.because(why))
            );
        }
        let Some(path) = &self.out else { return Ok(()) };
        let watch = Watch::silent().stopped_by(stop.stop());
        let Some((candidate, options)) = found.preferred(&options) else { return Ok(()) };
        let fit = fit(&FitRecords::Several(records), &Task::Modes(options), &watch, None, &maker);
        if stop.stop().is_requested() {
            return Err(stop.told(
                Failure::new("the comparison was interrupted")
                    .because("the candidates are printed, and no model is written"),
            ));
        }
        let fit = fit
            .map_err(|e| Failure::new(format!("cannot identify {candidate} from all records")).because(e))?;
        crate::model::save(path, &fit.model)?;
        console::message(&format!("model of {candidate} written to {}", path.display()));
        Ok(())
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
        error => Failure::new("structures cannot be compared on these records").because(error),
    }
}
