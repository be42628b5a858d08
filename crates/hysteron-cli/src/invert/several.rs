//! `hysteron invert` of a model of several axes.

use hysteron_io::write_record;
use hysteron_model::axes::AxesRecord;
use hysteron_model::decoupling::AxesDrive;
use hysteron_model::model::{DecoupledSummary, DecouplingRequest};
use hysteron_report::results::decoupling;

use super::Invert;
use crate::console;
use crate::failure::Failure;
use crate::model::Loaded;

impl Invert {
    /// The drives of all actuators.
    pub(super) fn several_axes(&self, loaded: &Loaded) -> Result<(), Failure> {
        for (given, flag) in [
            (self.rest_voltage.is_some(), "--rest-voltage"),
            (self.virgin_voltage.is_some(), "--virgin-voltage"),
            (self.learn_from.is_some(), "--learn-from"),
            (self.predict_to.is_some(), "--predict-to"),
            (self.correct, "--correct"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with a model of several axes yet")));
            }
        }
        let model = loaded.model();
        let references =
            loaded.read_references(&self.reference_file, self.columns.time(), &self.axes.of_record())?;
        let request = DecouplingRequest {
            ranges: self.range.clone(),
            slews_per_s: self.slew.clone(),
            bandwidth_hz: self.bandwidth,
            level: self.level,
            periodic: self.periodic,
            preview: self.preview,
        };
        let found = model.decouple_for(&references, &request);
        let (found, summary) = found.map_err(|e| loaded.cannot_follow(&self.reference_file, e))?;
        self.write_several(loaded, references, found)?;
        if self.json { console::json(&summary) } else { console::result(&text(&summary)) }
    }

    /// Refuses flags that only a model of several axes takes.
    pub(super) fn refuse_flags_of_axes(&self) -> Result<(), Failure> {
        let several = self.range.len() > 1 || self.slew.len() > 1;
        if several || self.level.is_some() || self.axes.are_given() {
            return Err(Failure::usage(
                "several limits, --level and --outputs go with models of several axes",
            ));
        }
        Ok(())
    }

    fn write_several(
        &self,
        loaded: &Loaded,
        references: AxesRecord,
        found: AxesDrive,
    ) -> Result<(), Failure> {
        let failure = || Failure::new(format!("cannot write the drives to {}", self.out.display()));
        let record = loaded.model().decoupled_record(&self.out.display().to_string(), references, found);
        let record = record.map_err(|e| failure().because(e))?;
        write_record(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}

fn text(summary: &DecoupledSummary) -> String {
    let tables = [decoupling::actuators(summary), decoupling::axes(summary)];
    let tables = tables.iter().map(|table| console::listed(table).to_string());
    tables.chain(decoupling::sentences(summary)).collect::<Vec<_>>().join("\n\n") + "\n"
}
