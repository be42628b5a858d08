//! Files to be written, looked at before the work whose result they are to hold: a fit of minutes must not end in a folder that
//! does not exist.

use std::io::ErrorKind;
use std::path::Path;

use hysteron::atomic_file::{AtomicWriteError, check_writable};

use crate::failure::Failure;

/// Checks that the file `path` can be written; `what` it is to hold, e.g. `the model`.
///
/// # Errors
/// If it cannot, with what to do about it. Nothing is left behind.
pub fn check_file(what: &str, path: &Path) -> Result<(), Failure> {
    check_writable(path).map_err(|e| cannot_write(what, path, e))
}

/// Checks that files can be written into the folder `path`, which need not exist.
///
/// # Errors
/// As [`check_file`].
pub fn check_folder(what: &str, path: &Path) -> Result<(), Failure> {
    let existing = path.ancestors().find(|a| a.as_os_str().is_empty() || a.exists()).unwrap_or(path);
    check_writable(&existing.join(".hysteron-check")).map_err(|e| match e.source.kind() {
        ErrorKind::NotADirectory => Failure::new(format!("cannot write {what} to {}", path.display()))
            .because(format!("{} is a file, not a folder", existing.display()))
            .hint("name another folder"),
        _ => cannot_write(what, path, e),
    })
}

/// The failure to write `path`, with what to do about it.
pub fn cannot_write(what: &str, path: &Path, error: AtomicWriteError) -> Failure {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.display().to_string(),
        _ => ".".to_owned(),
    };
    let failure = Failure::new(format!("cannot write {what} to {}", path.display()));
    match error.source.kind() {
        ErrorKind::NotFound => failure
            .because(format!("there is no folder {folder}"))
            .hint(format!("make it first (mkdir -p {folder}), or name another place")),
        ErrorKind::IsADirectory => failure
            .because("it is a folder, not a file")
            .hint(format!("give the name of a file, e.g. {}", path.join("NAME").display())),
        ErrorKind::NotADirectory => {
            failure.because(format!("{folder} is a file, not a folder")).hint("name another folder")
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            failure.because(error.source).hint("choose a folder that you may write to")
        }
        _ => failure.because(error).hint("choose another folder, or make room on the disk"),
    }
}
