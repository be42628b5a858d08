//! The modules of a controller in an exported crate.

use hysteron_io::NamedFile;
use hysteron_model::control::ControllerParts;
use hysteron_rt::Real;

use super::files::golden_keys;
use super::{ClosedLoop, GoldenLoop};
use crate::error::ExportError;
use crate::escape::rust_comment;
use crate::number::Precision;
use crate::rust_crate::{head, module};
use crate::saved;
use crate::template::Filling;

const SOURCE: &str = include_str!("../../templates/rust/controller.rs");
const SELFTEST: &str = include_str!("../../templates/rust/controller_selftest.rs");

/// `src/controller.rs`, `src/controller/law.rs` and `src/controller/observed.rs` where there are such, and
/// `tests/controller_selftest.rs`, for the crate of this name.
///
/// # Errors
/// Those of [`GoldenLoop::new`].
pub(crate) fn controller_modules(closed: &ClosedLoop, name: &str) -> Result<Vec<NamedFile>, ExportError> {
    let subject = &closed.inverse.subject;
    let literal = |x: f64| subject.precision.rust_literal(x);
    let mut files = Vec::new();
    if let Some((law, tuned)) = closed.law_block()?.zip(closed.made.feedback.as_ref()) {
        let description = closed.block_description(&law, "a feedback law of");
        let text = module(&law, "law", description, |filling: &mut Filling| {
            filling
                .key("PROPORTIONAL", literal(tuned.law.proportional))
                .key("INTEGRAL", literal(tuned.law.integral_per_s / tuned.law.sample_rate_hz));
        })?;
        files.push(NamedFile::new("src/controller/law.rs", text));
    }
    if let Some(observed) = &closed.observed {
        let what = "the model that the observer compares the stage with, of";
        let text = module(observed, "observed", closed.block_description(observed, what), |_| ())?;
        files.push(NamedFile::new("src/controller/observed.rs", text));
    }
    let mut filling = Filling::new(subject.precision);
    let bytes = match subject.precision {
        Precision::F32 => saved_bytes::<f32>(closed)?,
        Precision::F64 => saved_bytes::<f64>(closed)?,
    };
    filling
        .key("crate", name)
        .key("INPUT_UNIT", rust_comment(&subject.input_unit))
        .key("OUTPUT_UNIT", rust_comment(&subject.output_unit))
        .key("OFFSET", literal(subject.realisation.model.offset))
        .key("SAVED_BYTES", bytes)
        .key("DESCRIPTION", "")
        .key("MARK", "0")
        .flag("feedback", closed.made.feedback.is_some())
        .flag("observer", closed.observed.is_some());
    if let Some((gain, _)) = closed.made.observer {
        filling.key("OBSERVER_GAIN", literal(gain));
    }
    golden_keys(&mut filling, closed, &GoldenLoop::new(closed)?, &literal);
    // Told apart by all that it runs.
    let own = [filling.fill(SOURCE)?, filling.fill(SELFTEST)?];
    let identity = [env!("CARGO_PKG_VERSION"), &subject.origin.model_sha256];
    let mark = saved::mark(own.iter().map(String::as_str).chain(identity));
    filling.key("MARK", format!("0x{mark:016x}")).key("DESCRIPTION", head(&closed.description()));
    files.push(NamedFile::new("src/controller.rs", filling.fill(SOURCE)?));
    files.push(NamedFile::new("tests/controller_selftest.rs", filling.fill(SELFTEST)?));
    Ok(files)
}

/// Bytes of a saved state.
fn saved_bytes<T: Real>(closed: &ClosedLoop) -> Result<usize, ExportError> {
    let name = closed.controller.name();
    let parts = ControllerParts::<T>::new(&closed.made)?;
    let mut parts = parts.ok_or(ExportError::Controller { controller: name })?;
    Ok(parts.controller()?.saved_bytes())
}
