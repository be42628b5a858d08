//! `hysteron invert` of a model of several axes.

use hysteron_io::write_record;
use hysteron_model::axes::AxesRecord;
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{AxesDrive, DecouplingOptions, LawOptions};
use hysteron_model::model::DecoupledSummary;
use hysteron_model::record::{Channel, Record, Unit};
use hysteron_report::number::significant;

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
            (self.preview.is_some() && self.periodic, "--periodic with --preview"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with a model of several axes yet")));
            }
        }
        let model = loaded.model();
        let references =
            loaded.read_references(&self.reference_file, self.columns.time(), &self.axes.of_record())?;
        let limits = limits_of_actuators(loaded, &self.range, &self.slew)?;
        let failed = |e| loaded.cannot_follow(&self.reference_file, e);
        let (found, preview) = match self.preview {
            Some(_) => {
                let options =
                    LawOptions { bandwidth_hz: self.bandwidth, preview: self.preview, level: self.level };
                let (found, law) =
                    model.decouple_by_sample(&references, &options, &limits).map_err(failed)?;
                console::message(&format!(
                    "sample by sample: preview of {} samples, of {} that affect the drives",
                    law.preview, law.useful_preview
                ));
                (found, Some(law.preview))
            }
            None => {
                let options = DecouplingOptions {
                    bandwidth_hz: self.bandwidth,
                    periodic: self.periodic,
                    level: self.level,
                    ..DecouplingOptions::within(limits)
                };
                (model.decouple(&references, &options).map_err(failed)?, None)
            }
        };
        let summary = DecoupledSummary::new(model, &references, &found, preview);
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
        let units = loaded.model().units();
        let (inputs, outputs) = loaded.model().channels().unwrap_or((&[], &[]));
        let mut channels = Vec::new();
        let mut add = |names: &[String], prefix: &str, unit: &str, lists: Vec<Vec<f64>>| {
            let named = names.iter().zip(lists);
            channels.extend(named.map(|(name, list)| Channel::new(&format!("{prefix}{name}"), unit, list)));
        };
        add(inputs, "", &units.input, found.drive);
        add(outputs, "", &units.output, found.predicted);
        add(outputs, "reference_", &units.output, references.u);
        let record = Record::new(&self.out.display().to_string(), references.time, channels)
            .map_err(|e| failure().because(e))?;
        write_record(&self.out, &record).map_err(|e| failure().because(e))?;
        console::message(&format!("wrote {} samples to {}", record.len(), self.out.display()));
        Ok(())
    }
}

/// Limits of every actuator: those given, one for all or one each, else the range of the records.
pub fn limits_of_actuators(
    loaded: &Loaded,
    ranges: &[[f64; 2]],
    slews: &[f64],
) -> Result<Vec<Limits>, Failure> {
    let model = loaded.model();
    let count = model.channels().map_or(1, |(inputs, _)| inputs.len());
    let counted = |flag: &str, given: usize| match given {
        n if n <= 1 || n == count => Ok(()),
        n => Err(Failure::usage(format!("{flag} has {n} entries, the model has {count} inputs"))
            .hint("give one for all actuators, or one per actuator, separated by commas")),
    };
    counted("--range", ranges.len())?;
    counted("--slew", slews.len())?;
    let of = |k: usize| ranges.get(k).or(ranges.first());
    let mut limits = match (ranges.is_empty(), model.limits_of_records()) {
        (false, _) => (0..count).filter_map(of).map(|[low, high]| Limits::range(*low, *high)).collect(),
        (true, Some(limits)) => limits,
        (true, None) => {
            return Err(Failure::new("the drives have no limits")
                .because("the model file does not say which voltages it was identified with")
                .hint("give the range of the drives, e.g. --range=-1:1"));
        }
    };
    for (k, limit) in limits.iter_mut().enumerate() {
        if let Some(slew) = slews.get(k).or(slews.first()) {
            *limit = limit.slew(*slew);
        }
    }
    Ok(limits)
}

fn text(s: &DecoupledSummary) -> String {
    let (input, output) = (Unit::new(&s.input_unit), Unit::new(&s.output_unit));
    let mut actuators = console::table(&[
        "actuator",
        &console::in_unit("at rest", &input.to_string()),
        &console::in_unit("from", &input.to_string()),
        &console::in_unit("to", &input.to_string()),
        "samples limited by --range",
        "by --slew",
    ]);
    for one in &s.actuators {
        actuators.add_row(vec![
            one.name.clone(),
            one.rest.map_or_else(|| "–".to_owned(), |rest| significant(rest, 4)),
            significant(one.low, 4),
            significant(one.high, 4),
            one.samples_at_range.to_string(),
            one.samples_at_slew.to_string(),
        ]);
    }
    let mut axes = console::table(&[
        "axis",
        &console::in_unit("stroke", &output.to_string()),
        &console::in_unit("predicted error, rms", &output.to_string()),
        &console::in_unit("largest", &output.to_string()),
    ]);
    for one in &s.axes {
        axes.add_row(vec![
            one.name.clone(),
            significant(one.stroke, 4),
            significant(one.rms, 3),
            significant(one.max, 3),
        ]);
    }
    let mut lines = vec![
        actuators.to_string(),
        axes.to_string(),
        format!(
            "Errors assume an exact model. Bandwidth {} Hz; each voltage is held for {} s.",
            significant(s.bandwidth_hz, 3),
            significant(1.0 / s.sample_rate_hz, 4)
        ),
    ];
    if s.level > 0.0 {
        lines.push(format!("Modes as at a drive of {} {input} rms.", significant(s.level, 3)));
    }
    if s.rate_error > 0.0 {
        lines.push(format!(
            "At this rate the model's linear response is matched to {} % rms.",
            significant(100.0 * s.rate_error, 2)
        ));
    }
    let worst = s.axes.iter().fold(0.0_f64, |most, one| most.max(one.rms));
    lines.push(format!("Worst axis: {} {output} rms.", significant(worst, 3)));
    lines.join("\n\n") + "\n"
}
