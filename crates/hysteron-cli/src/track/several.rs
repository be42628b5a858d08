//! `hysteron track` of a model of several axes, on the simulated bench.

use hysteron_model::axes::AxesRecord;
use hysteron_model::control::slew_of_current;
use hysteron_model::decoupling::{AxesTrackOptions, AxesTracking, track_axes};
use hysteron_model::model::{AxesTrackingSummary, Capability, DecouplingRequest};
use hysteron_model::record::Unit;
use hysteron_report::results::axes_tracking::{ABOUT_ERRORS, errors, sentences};
use hysteron_report::tracking::{AxesTracked, axes_page};
use hysteron_rig::axes::{AxesRigStage, AxesTruth};

use super::{PlantArg, Track};
use crate::console;
use crate::failure::Failure;
use crate::maker::maker;
use crate::model::Loaded;
use crate::outputs::Outputs;
use crate::rig::read_settings;

impl Track {
    pub(super) fn several_axes(&self, loaded: &Loaded) -> Result<(), Failure> {
        for (given, flag) in [
            (self.plant == PlantArg::Model, "--plant model"),
            (!self.controllers.is_empty(), "--controller"),
            (self.predict_to.is_some(), "--predict-to"),
            (self.virgin_voltage.is_some(), "--virgin-voltage"),
            (self.lowest_frequency.is_some(), "--lowest-frequency"),
            (self.sines.is_some(), "--sines"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with a model of several axes yet")));
            }
        }
        let model = loaded.model();
        let modes = loaded.scheduled_modes(Capability::Tracking)?;
        let references =
            loaded.read_references(&self.reference_file, self.columns.time(), &self.axes.of_record())?;
        let truth: AxesTruth = match &self.truth {
            Some(path) => read_settings(path, "truth")?,
            None => AxesTruth::with_axes(modes.outputs)
                .map_err(|e| Failure::new("cannot simulate the bench").because(e))?,
        };
        let of_current =
            self.current.zip(self.capacitance).map(|(ma, uf)| slew_of_current(1e-3 * ma, 1e-6 * uf));
        let asked = DecouplingRequest {
            ranges: self.range.clone(),
            slews_per_s: self.slew.or(of_current).into_iter().collect(),
            ..DecouplingRequest::default()
        };
        let failed = |e| loaded.cannot_follow(&self.reference_file, e);
        let options = AxesTrackOptions {
            limits: asked.limits(loaded.model()).map_err(|e| failed(e.into()))?,
            bandwidth_hz: self.bandwidth,
            preview: self.preview,
            skip_s: self.skip,
        };
        let stage = AxesRigStage { truth: &truth, seed: self.seed };
        let found = track_axes(modes, &references.u, references.sample_rate_hz, &options, &stage)
            .map_err(|e| failed(e.into()))?;
        let mut outputs = Outputs::default();
        self.add_several(&mut outputs, loaded, &references, &found)?;
        let summary = AxesTrackingSummary::new(model, &found);
        let (actuators, _) = model.channels().unwrap_or_default();
        let tracked = AxesTracked {
            name: &self.reference_file.display().to_string(),
            stage: &truth.describe(),
            found: &found,
            summary: &summary,
            actuators,
            input_unit: &Unit::new(&model.units().input),
            references: &references.u,
        };
        self.result.add(&mut outputs, || axes_page(&tracked, &maker()))?;
        outputs.finish()?;
        if self.result.json {
            return console::json(&summary);
        }
        console::result(&text(&truth, &summary))
    }

    /// Refuses flags that only a model of several axes takes.
    pub(super) fn refuse_flags_of_axes(&self) -> Result<(), Failure> {
        if self.range.len() > 1 || self.axes.are_given() {
            let words = "several ranges and --outputs go with models of several axes";
            return Err(Failure::usage(words));
        }
        Ok(())
    }

    fn add_several(
        &self,
        files: &mut Outputs,
        loaded: &Loaded,
        references: &AxesRecord,
        found: &AxesTracking,
    ) -> Result<(), Failure> {
        let Some(out) = &self.out else { return Ok(()) };
        let failure = || Failure::new(format!("cannot write the samples to {}", out.display()));
        let record = loaded
            .model()
            .tracked_record(&out.display().to_string(), found, references)
            .map_err(|e| failure().because(e))?;
        files.add_record("the samples", out, &record)?;
        files.tell(format!("wrote {} simulated samples to {}", record.len(), out.display()));
        Ok(())
    }
}

fn text(truth: &AxesTruth, s: &AxesTrackingSummary) -> String {
    format!(
        "Simulated on the bench of several axes ({}).\n\n{}\n\n{ABOUT_ERRORS}\n\n{}\n",
        truth.describe(),
        console::listed(&errors(s)),
        sentences(s).join("\n\n")
    )
}
