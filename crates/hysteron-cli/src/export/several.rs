//! `hysteron export` of a model of several axes.

use hysteron_export::{
    AxesExportRequest, AxesExported, ExportError, FileSummary, Means, export_axes, write_folder,
};
use hysteron_identify::Listener;
use hysteron_model::model::DecouplingRequest;
use serde::Serialize;

use super::Export;
use crate::advice;
use crate::console;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::model::Loaded;
use crate::progress;

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
        for (given, flag) in [
            (self.predict_to.is_some(), "--predict-to"),
            (self.lowest_frequency.is_some(), "--lowest-frequency"),
            (self.accuracy.is_some(), "--accuracy"),
        ] {
            if given {
                return Err(Failure::usage(format!("{flag} does not go with a model of several axes yet")));
            }
        }
        let request = AxesExportRequest {
            form: self.to,
            float: self.float.precision(),
            name: self.name(),
            sample_rate_hz: self.sample_rate,
            inverse: self.inverse,
            decoupling: DecouplingRequest {
                ranges: self.range.clone(),
                slews_per_s: self.slew.clone(),
                bandwidth_hz: self.bandwidth,
                level: self.level,
                preview: self.preview,
                ..DecouplingRequest::default()
            },
            controller: self.controller,
            model_sha256: Some(loaded.source().sha256.clone()),
            date: self.date(),
        };
        let interrupt = Interrupt::listen("no file is written")?;
        let watch = progress::watch(&interrupt);
        let teller = watch.teller();
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".into());
        let means = Means { compiler: &compiler, listener: Listener::new(&teller) };
        let exported = export_axes(loaded.model(), &request, means);
        drop(teller);
        drop(watch);
        let AxesExported { subject, files, findings } = exported.map_err(|e| match e {
            ExportError::Stopped => interrupt.told(Failure::new("the export was interrupted")),
            e => self.cannot(&e),
        })?;
        for finding in &findings {
            console::note(&advice::text(finding));
        }
        write_folder(&self.out_dir, &files).map_err(|e| self.cannot(&e))?;
        if let Some(range) = loaded.model().valid_range() {
            console::note(&range.in_words());
        }
        let (law, modes) = (subject.law(), &subject.law().held.model);
        let summary = Summary {
            name: request.name,
            sample_rate_hz: modes.sample_rate_hz,
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
