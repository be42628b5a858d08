//! `hysteron export` of a model of several axes.

use hysteron_export::{
    AxesSubject, ExportError, FileSummary, Form, axes_files, axes_inverse_files, axes_rust_files,
    write_folder,
};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingLaw, LawOptions};
use hysteron_model::model::Capability;
use serde::Serialize;

use super::{Export, Float};
use crate::console;
use crate::failure::Failure;
use crate::invert::limits_of_actuators;
use crate::model::Loaded;

/// Summary of an export of several axes.
#[derive(Serialize)]
struct Summary {
    name: String,
    sample_rate_hz: f64,
    inputs: usize,
    outputs: usize,
    states: usize,
    rate_error: f64,
    level: f64,
    preview_samples: Option<usize>,
    bandwidth_hz: Option<f64>,
    files: Vec<FileSummary>,
}

impl Export {
    pub(super) fn several_axes(&self, loaded: &Loaded) -> Result<(), Failure> {
        let refused = |form: String| self.cannot(&ExportError::OneAxis { form });
        if !matches!(self.to, Form::C | Form::Rust) {
            return Err(refused(self.to.name().to_owned()));
        }
        if matches!(self.float, Float::F32) {
            return Err(refused("f32".to_owned()));
        }
        for (given, flag) in [
            (self.predict_to.is_some(), "--predict-to"),
            (self.lowest_frequency.is_some(), "--lowest-frequency"),
            (self.date.is_some(), "--date"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with a model of several axes yet")));
            }
        }
        let modes = loaded.scheduled_modes(Capability::Export)?;
        let rate = self.sample_rate.unwrap_or(modes.sample_rate_hz);
        let options = LawOptions { bandwidth_hz: self.bandwidth, preview: self.preview, level: self.level };
        let failed = |e: ExportError| self.cannot(&e);
        let law = DecouplingLaw::new(modes, rate, &options).map_err(|e| failed(e.into()))?;
        let limits = match limits_of_actuators(loaded, &self.range, &self.slew) {
            Err(_) if !self.inverse => vec![Limits::range(-1.0, 1.0); modes.inputs],
            limits => limits?,
        };
        let name = self.name();
        let units = loaded.model().units();
        let subject =
            AxesSubject::new(&name, loaded.model().name(), (&units.input, &units.output), law, limits)
                .map_err(failed)?;
        let files = if self.to == Form::Rust {
            axes_rust_files(&subject, self.inverse).map_err(failed)?
        } else {
            let mut files = axes_files(&subject).map_err(failed)?;
            if self.inverse {
                files.extend(axes_inverse_files(&subject).map_err(failed)?);
            }
            files
        };
        write_folder(&self.out_dir, &files).map_err(|e| self.cannot(&e))?;
        if let Some(range) = loaded.model().valid_range() {
            console::note(&range.in_words());
        }
        let law = subject.law();
        let summary = Summary {
            name,
            sample_rate_hz: rate,
            inputs: modes.inputs,
            outputs: modes.outputs,
            states: law.held.model.states(),
            rate_error: law.held.error,
            level: law.level,
            preview_samples: self.inverse.then_some(law.preview),
            bandwidth_hz: self.inverse.then_some(law.bandwidth_hz),
            files: files
                .iter()
                .map(|f| FileSummary {
                    path: self.out_dir.join(&f.name).display().to_string(),
                    bytes: f.bytes.len(),
                })
                .collect(),
        };
        if self.json {
            return console::json(&summary);
        }
        let lines: Vec<String> =
            summary.files.iter().map(|f| format!("wrote {} ({} bytes)\n", f.path, f.bytes)).collect();
        console::result(&lines.concat())
    }
}
