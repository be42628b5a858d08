//! Simulink S-functions around the exported C.

use hysteron_io::NamedFile;

use crate::c::{Numbers, c_files, description_comment, filling};
use crate::error::ExportError;
use crate::inverse::{Inverse, inverse_files, inverse_filling};
use crate::subject::Subject;
use crate::template::Filling;

const SOURCE: &str = include_str!("../templates/simulink/sfun.c");

/// The files of [`c_files`], and `NAME_sfun.c`, a level-2 S-function in C around them.
///
/// # Errors
/// Those of [`c_files`].
pub fn simulink_files(subject: &Subject) -> Result<Vec<NamedFile>, ExportError> {
    let filling = filling(subject, Numbers::Constant)?;
    with_source(subject, filling, &subject.description(), c_files(subject)?)
}

/// The inverse in the same form, as `NAME_inverse`.
///
/// # Errors
/// Those of [`inverse_files`].
pub fn simulink_inverse_files(inverse: &Inverse) -> Result<Vec<NamedFile>, ExportError> {
    let mut filling = inverse_filling(inverse, Numbers::Constant)?;
    filling.flag("inverse", true);
    with_source(&inverse.subject, filling, &inverse.description(), inverse_files(inverse)?)
}

fn with_source(
    subject: &Subject,
    mut filling: Filling,
    description: &[String],
    mut files: Vec<NamedFile>,
) -> Result<Vec<NamedFile>, ExportError> {
    filling.key("DESCRIPTION", description_comment(description));
    files.push(NamedFile::new(format!("{}_sfun.c", subject.name), filling.fill(SOURCE)?));
    Ok(files)
}
