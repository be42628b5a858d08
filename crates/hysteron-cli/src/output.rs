//! Output files, checked before the computation: a fit of minutes must not fail on a missing folder, nor
//! overwrite the record it was made from.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::ops::Deref;
use std::path::{Path, PathBuf};

use clap::ArgMatches;
use hysteron_io::atomic_file::{AtomicWriteError, check_writable};

use crate::failure::Failure;

/// Output file on the command line. Input files are [`PathBuf`]: [`check_distinct`] distinguishes them by
/// type.
#[derive(Clone, Debug)]
pub struct OutFile(PathBuf);

impl From<OsString> for OutFile {
    fn from(path: OsString) -> Self {
        OutFile(path.into())
    }
}

impl Deref for OutFile {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

/// Checks, for every command, that no file is both read and written, and none written twice.
///
/// # Errors
/// If one is: wrong usage, which names it.
pub fn check_distinct(matches: &ArgMatches) -> Result<(), Failure> {
    let (mut read, mut written) = (Vec::new(), Vec::new());
    let mut level = Some(matches);
    while let Some(matches) = level {
        read.extend(given::<PathBuf>(matches).cloned());
        written.extend(given::<OutFile>(matches).map(|file| file.to_path_buf()));
        level = matches.subcommand().map(|(_, below)| below);
    }
    for (i, path) in written.iter().enumerate() {
        keep_input(path, &read)?;
        if written[..i].iter().any(|other| is_same(other, path)) {
            return Err(Failure::usage(format!("{} is named twice as the file to write", path.display()))
                .because("one result would replace the other")
                .hint("name another file for one of them"));
        }
    }
    Ok(())
}

/// Checks that `written` is none of the files that are read.
///
/// # Errors
/// If it is: wrong usage, which names it.
pub fn keep_input(written: &Path, read: &[PathBuf]) -> Result<(), Failure> {
    match read.iter().find(|path| is_same(path, written)) {
        None => Ok(()),
        Some(path) => {
            Err(Failure::usage(format!("{} would be written over {}", written.display(), path.display()))
                .because("it is a file that this command reads, and what it holds would be lost")
                .hint("name another file to write"))
        }
    }
}

/// The values of one type, of all flags.
fn given<T: Clone + Send + Sync + 'static>(matches: &ArgMatches) -> impl Iterator<Item = &T> {
    let of = |id: &clap::Id| matches.try_get_many::<T>(id.as_str()).ok().flatten();
    matches.ids().filter_map(of).flatten()
}

/// True if two paths lead to one regular file, through symbolic links or not. A second hard link counts as
/// another file: writing replaces the name, not the content.
fn is_same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| match path.canonicalize() {
        Ok(found) => found.is_file().then_some(found),
        Err(_) => {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
            Some(folder.join(path.file_name()?))
        }
    };
    resolved(a).is_some_and(|a| Some(a) == resolved(b))
}

/// Checks that the file `path` can be written; `what` names its content, e.g. `the model`.
///
/// # Errors
/// If it cannot, with a remedy. No temporary file remains.
pub fn check_file(what: &str, path: &Path) -> Result<(), Failure> {
    check_writable(path).map_err(|e| cannot_write(what, path, e))
}

/// Checks that files can be written into the folder `path`, which need not exist.
///
/// # Errors
/// Those of [`check_file`].
pub fn check_folder(what: &str, path: &Path) -> Result<(), Failure> {
    let existing = path.ancestors().find(|a| a.as_os_str().is_empty() || a.exists()).unwrap_or(path);
    check_writable(&existing.join(".hysteron-check")).map_err(|e| match e.source.kind() {
        ErrorKind::NotADirectory => Failure::new(format!("cannot write {what} to {}", path.display()))
            .because(format!("{} is a file, not a folder", existing.display()))
            .hint("name another folder"),
        _ => cannot_write(what, path, e),
    })
}

/// The failure to write `path`, with a remedy.
pub fn cannot_write(what: &str, path: &Path, error: AtomicWriteError) -> Failure {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.display().to_string(),
        _ => ".".to_owned(),
    };
    let failure = Failure::new(format!("cannot write {what} to {}", path.display()));
    match error.source.kind() {
        ErrorKind::NotFound if Path::new(&folder).exists() => {
            let said = format!("no file can be made in {folder}: {}", error.source);
            failure.because(said).hint("choose another folder")
        }
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

#[cfg(test)]
mod tests {
    use std::any::TypeId;

    use clap::{Command, CommandFactory};

    use super::OutFile;

    /// Long flags whose value is no file to write.
    fn flags_of_other_types(command: &Command, of: &str) -> Vec<String> {
        let own = command.get_arguments().filter(|argument| {
            let flag = argument.get_long().unwrap_or_default();
            let writes = ["out", "output-model", "report", "plot"].contains(&flag);
            writes && argument.get_value_parser().type_id() != TypeId::of::<OutFile>()
        });
        let own = own.map(|argument| format!("{of} {argument}"));
        let below = |c: &Command| flags_of_other_types(c, &format!("{of} {}", c.get_name()));
        own.chain(command.get_subcommands().flat_map(below)).collect()
    }

    #[test]
    fn every_flag_that_names_a_file_to_write_is_told_from_those_that_name_one_to_read() {
        assert_eq!(flags_of_other_types(&crate::Cli::command(), "hysteron"), Vec::<String>::new());
    }
}
