//! `hysteron rig --axes`: the bench of several axes.

use hysteron_io::{NamedFile, write_csv_to};
use hysteron_rig::axes::{AxesPlan, AxesRole, AxesRun, AxesTruth, run_axes_campaign};

use super::{Rig, read_or_default, read_settings, settings};
use crate::console;
use crate::failure::Failure;

impl Rig {
    pub(super) fn several_axes(&self, axes: usize) -> Result<(), Failure> {
        let failure = |e| Failure::new("cannot simulate the bench").because(e);
        let truth: AxesTruth = match &self.truth {
            Some(path) => read_settings(path, "truth")?,
            None => AxesTruth::with_axes(axes).map_err(failure)?,
        };
        if truth.axes() != axes {
            return Err(Failure::usage(format!("--axes is {axes}, the truth has {} axes", truth.axes())));
        }
        let plan: AxesPlan = read_or_default(self.plan.as_deref(), "plan")?;
        let runs = run_axes_campaign(&truth, &plan, self.seed).map_err(failure)?;
        let mut files = vec![settings("truth.json", &truth)?, settings("plan.json", &plan)?];
        for run in &runs {
            files.push(file(run)?);
        }
        self.write(&files)?;
        for run in &runs {
            let path = self.record_of(&run.record.name);
            let use_of = match run.role {
                AxesRole::Identification => "to identify",
                AxesRole::Validation => "held out",
            };
            console::message(&format!("wrote {} ({} samples, {use_of})", path.display(), run.record.len()));
            if run.clipped_samples > 0 {
                console::note(&format!(
                    "{}: {} readings saturate the converter",
                    path.display(),
                    run.clipped_samples
                ));
            }
        }
        Ok(())
    }
}

/// The file of a record, with what it is in comments.
fn file(run: &AxesRun) -> Result<NamedFile, Failure> {
    let mut text: Vec<u8> =
        run.comments.iter().flat_map(|comment| format!("# {comment}\n").into_bytes()).collect();
    write_csv_to(&mut text, &run.record)
        .map_err(|e| Failure::new(format!("cannot write the record {}", run.record.name)).because(e))?;
    Ok(NamedFile::new(format!("{}.csv", run.record.name), text))
}
