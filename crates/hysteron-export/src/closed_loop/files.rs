//! The files of a controller.

use super::ClosedLoop;
use super::golden::{GoldenLoop, SAMPLES};
use crate::c::{Numbers, core_files, description_comment, filling, rows};
use crate::error::ExportError;
use crate::escape::{c_comment, c_string};
use crate::inverse::inverse_files;
use crate::saved;
use crate::subject::{Subject, significant};
use crate::template::Filling;
use hysteron_io::NamedFile;

const HEADER: &str = include_str!("../../templates/c/controller.h");
const SOURCE: &str =
    concat!(include_str!("../../templates/c/controller.c"), include_str!("../../templates/c/saved.c"));
const SELFTEST: &str = include_str!("../../templates/c/controller_selftest.c");

/// The controller as C99: the files of its inverse, `NAME_law` and `NAME_observed` where there are such, and
/// `NAME_controller.h`, `NAME_controller.c` and `NAME_controller_selftest.c` with golden vectors.
///
/// # Errors
/// Those of [`inverse_files`]; [`ExportError::Control`] where the library has no result along the vectors.
pub fn controller_files(closed: &ClosedLoop) -> Result<Vec<NamedFile>, ExportError> {
    let mut files = inverse_files(&closed.inverse)?;
    for (block, what) in [
        (&closed.law, "the poles of a feedback law of"),
        (&closed.observed, "the model that the observer compares the stage with, of"),
    ] {
        if let Some(block) = block {
            let mut filling = filling(block, Numbers::Constant)?;
            filling.key("DESCRIPTION", description_comment(&block_description(closed, block, what)));
            files.extend(core_files(block, &filling)?);
        }
    }
    let mut filling = controller_filling(closed);
    let subject = &closed.inverse.subject;
    saved::fill(&mut filling, subject.precision, (HEADER, SOURCE), &[&subject.origin.model_sha256])?;
    let name = &closed.name;
    files.push(NamedFile::new(format!("{name}.h"), filling.fill(HEADER)?));
    files.push(NamedFile::new(format!("{name}.c"), filling.fill(SOURCE)?));
    golden_keys(&mut filling, closed)?;
    files.push(NamedFile::new(format!("{name}_selftest.c"), filling.fill(SELFTEST)?));
    Ok(files)
}

fn controller_filling(closed: &ClosedLoop) -> Filling {
    let subject = &closed.inverse.subject;
    let literal = |x: f64| subject.precision.c_literal(x);
    let mut filling = Filling::new(subject.precision);
    let mut named = |key: &str, name: &str| {
        filling.key(key, name).key(&key.to_ascii_uppercase(), name.to_ascii_uppercase());
    };
    named("name", &closed.name);
    named("inverse", &subject.name);
    for (key, block) in [("law", &closed.law), ("observed", &closed.observed)] {
        if let Some(block) = block {
            named(key, &block.name);
        }
    }
    filling
        .key("DESCRIPTION", description_comment(&closed.description()))
        .key("INPUT_UNIT", c_comment(&subject.input_unit))
        .key("OUTPUT_UNIT", c_comment(&subject.output_unit))
        .key("INPUT_UNIT_STRING", c_string(&subject.input_unit))
        .flag("saves", true)
        .flag("law", closed.law.is_some())
        .flag("observer", closed.observed.is_some())
        .flag("feedback", closed.made.feedback.is_some());
    if let Some(tuned) = &closed.made.feedback {
        filling
            .key("PROPORTIONAL", literal(tuned.law.proportional))
            .key("INTEGRAL", literal(tuned.law.integral_per_s / tuned.law.sample_rate_hz))
            .key("LAW_IN_WORDS", if closed.law.is_some() { " and the poles of the law" } else { "" });
    }
    if let Some((gain, _)) = closed.made.observer {
        filling.key("OBSERVER_GAIN", literal(gain));
    }
    filling
}

fn golden_keys(filling: &mut Filling, closed: &ClosedLoop) -> Result<(), ExportError> {
    let golden = GoldenLoop::new(closed)?;
    let literal = |x: f64| closed.inverse.subject.precision.c_literal(x);
    let all = |numbers: &[f64]| rows(numbers.iter().map(|&x| literal(x)));
    filling
        .key("SAMPLES", SAMPLES)
        .key("REST", literal(golden.rest_v))
        .key("MEASURED", literal(golden.measured))
        .key("REFERENCES", all(&golden.references))
        .key("VOLTAGES", all(&golden.voltages))
        .key("READINGS", all(&golden.readings))
        .key("TOLERANCE", literal(golden.tolerance));
    Ok(())
}

/// Description of a block of the controller.
fn block_description(closed: &ClosedLoop, block: &Subject, what: &str) -> Vec<String> {
    let linear = &block.realisation.dynamics;
    let mut lines = vec![format!(
        "{}: {what} {}, {} taps and {} states at {} Hz; run by it.",
        block.name,
        closed.name,
        linear.taps.len(),
        linear.states(),
        significant(block.realisation.sample_rate_hz)
    )];
    lines.extend(block.origin.lines());
    lines
}

impl ClosedLoop {
    /// Description for the head of the source: text that is not escaped yet.
    pub(super) fn description(&self) -> Vec<String> {
        let subject = &self.inverse.subject;
        let mut lines = vec![format!(
            "{}: controller `{}` ({}), around {}: reference and reading in {}, voltage out in {}.",
            self.name,
            self.controller.name(),
            self.controller.words(),
            subject.name,
            subject.output_unit,
            subject.input_unit
        )];
        lines.extend(subject.origin.lines());
        if let Some(margins) = self.made.margins() {
            lines.push(format!(
                "Designed from the model, one period of computation included: gain margin {}, phase margin \
                 {} degrees, least |1 + L| {}.",
                significant(margins.gain),
                significant(margins.phase_deg),
                significant(margins.modulus)
            ));
        }
        if let Some((gain, _)) = self.made.observer {
            lines.push(format!("Gain of the observer: {}.", significant(gain)));
        }
        lines
    }
}
