//! The files of a controller.

use super::ClosedLoop;
use super::GoldenLoop;
use crate::c::{Numbers, core_files, description_comment, filling as c_filling, rows};
use crate::error::ExportError;
use crate::escape::{c_comment, c_string};
use crate::inverse::{inverse_core, inverse_files, inverse_filling};
use crate::number::Precision;
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
    let subject = &closed.inverse.subject;
    let mut filling = controller_filling(closed);
    let mut files = inverse_files(&closed.inverse)?;
    files.extend(own_files(closed, &filling)?);
    golden_keys(&mut filling, closed, &GoldenLoop::new(closed)?, &|x| subject.precision.c_literal(x));
    files.push(NamedFile::new(format!("{}_selftest.c", closed.name), filling.fill(SELFTEST)?));
    Ok(files)
}

/// The sources of the controller with all that it runs, and what its own were filled with.
pub(crate) fn controller_core(closed: &ClosedLoop) -> Result<(Vec<NamedFile>, Filling), ExportError> {
    let filling = controller_filling(closed);
    let inverse = inverse_filling(&closed.inverse, Numbers::Constant)?;
    let mut files = inverse_core(&closed.inverse, &inverse)?;
    files.extend(own_files(closed, &filling)?);
    Ok((files, filling))
}

/// Header and source of the controller, of the poles of its law and of the model of its observer.
fn own_files(closed: &ClosedLoop, filling: &Filling) -> Result<Vec<NamedFile>, ExportError> {
    let mut files = Vec::new();
    for (block, what) in [
        (&closed.law, "the poles of a feedback law of"),
        (&closed.observed, "the model that the observer compares the stage with, of"),
    ] {
        if let Some(block) = block {
            let mut filling = c_filling(block, Numbers::Constant)?;
            filling.key("DESCRIPTION", description_comment(&closed.block_description(block, what)));
            files.extend(core_files(block, &filling)?);
        }
    }
    let Subject { precision, origin, .. } = &closed.inverse.subject;
    let own = (HEADER, SOURCE);
    files.extend(saved::header_and_source(&mut filling.clone(), *precision, own, &origin.model_sha256)?);
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

/// Sets what a self-test is filled with, in literals of its language.
pub(super) fn golden_keys(
    filling: &mut Filling,
    closed: &ClosedLoop,
    golden: &GoldenLoop,
    literal: &dyn Fn(f64) -> String,
) {
    let all = |numbers: &[f64]| rows(numbers.iter().map(|&x| literal(x)));
    filling
        .key("SAMPLES", golden.references.len())
        .key("REST", literal(golden.rest_v))
        .key("MEASURED", literal(golden.measured))
        .key("REFERENCES", all(&golden.references))
        .key("VOLTAGES", all(&golden.voltages))
        .key("READINGS", all(&golden.readings))
        .key("TOLERANCE", literal(golden.tolerance))
        .key("TOLERANCE_IN_WORDS", closed.dry_run.tolerance_in_words(closed.inverse.subject.precision));
}

impl ClosedLoop {
    /// Description of a block of the controller.
    pub(super) fn block_description(&self, block: &Subject, what: &str) -> Vec<String> {
        let linear = &block.realisation.dynamics;
        let mut lines = vec![format!(
            "{}: {what} {}, {} taps and {} states at {} Hz; run by it.",
            block.name,
            self.name,
            linear.taps.len(),
            linear.states(),
            significant(block.realisation.sample_rate_hz)
        )];
        lines.extend(block.origin.lines());
        lines
    }

    /// Description for the head of the source: text that is not escaped yet.
    pub(crate) fn description(&self) -> Vec<String> {
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
        if subject.precision == Precision::F32 {
            lines.push(self.rounding.in_words("voltage", &subject.input_unit));
            lines.extend(self.dry_run.in_words(&self.compared()).iter().map(|line| format!("NOTE: {line}")));
        }
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
