//! Files that are either complete or not there: written beside the target, flushed to the disk, renamed over it.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// What an atomic write could not do, to which file.
#[derive(Debug, thiserror::Error)]
#[error("cannot write `{}`: {action} failed: {source}", path.display())]
#[non_exhaustive]
pub struct AtomicWriteError {
    /// The file that was to be written; what it held before is untouched.
    pub path: PathBuf,
    /// The step that failed.
    pub action: &'static str,
    /// What the operating system says.
    pub source: io::Error,
}

/// Writes `bytes` to `path`: whoever opens `path`, at any moment, finds the old content or all of the new.
///
/// # Errors
/// Any step the operating system refuses; the old file is then untouched and no temporary file is left.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), AtomicWriteError> {
    write_atomically_with(path, |out| out.write_all(bytes))
}

/// Finds out, before the work whose result it is to hold, whether `path` can be written; leaves nothing behind.
///
/// # Errors
/// What [`write_atomically`] would meet now: no such folder, a folder that may not be written to, a folder of this name.
pub fn check_writable(path: &Path) -> Result<(), AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(failed("opening")(io::Error::from(io::ErrorKind::IsADirectory))),
        // A pipe or a terminal: opening it only to see would be noticed at its other end.
        Ok(found) if !found.is_file() => Ok(()),
        _ => temporary_in(folder_of(path)).map(drop).map_err(failed(CREATING)),
    }
}

const CREATING: &str = "creating a file in its folder";

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file with the permissions of an ordinary one. The error does not name it: the user knows nothing of it.
fn temporary_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hysteron-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|e| io::Error::from(e.kind()))
}

/// Like [`write_atomically`], for content that is produced piece by piece.
///
/// A `path` that exists and is not a regular file (a pipe, a terminal) is written directly: there is nothing to rename over.
///
/// # Errors
/// As [`write_atomically`]; also whatever `produce` returns.
pub fn write_atomically_with(
    path: &Path,
    produce: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    if let Ok(found) = std::fs::metadata(path)
        && !found.is_file()
    {
        if found.is_dir() {
            return Err(failed("opening")(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        let mut out = BufWriter::new(File::create(path).map_err(failed("opening"))?);
        produce(&mut out).map_err(failed("writing"))?;
        return out.flush().map_err(failed("writing"));
    }
    let folder = folder_of(path);
    let mut temporary = temporary_in(folder).map_err(failed(CREATING))?;
    {
        let mut out = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
        produce(&mut out).map_err(failed("writing"))?;
        out.flush().map_err(failed("writing"))?;
    }
    temporary.as_file().sync_all().map_err(failed("flushing to the disk"))?;
    temporary.persist(path).map_err(|e| failed("renaming the finished file")(e.error))?;
    // The rename itself is durable once the folder is flushed; file systems that cannot do this lose nothing but time.
    if let Ok(handle) = File::open(folder) {
        let _ = handle.sync_all();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_the_whole_content_and_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"a long first version").unwrap();
        write_atomically(&path, b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn keeps_the_old_content_when_producing_the_new_one_fails() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, b"old").unwrap();
        let err = write_atomically_with(&path, |out| {
            out.write_all(b"half")?;
            Err(io::Error::other("gave up"))
        })
        .unwrap_err();
        assert!(err.to_string().contains("a.txt"), "{err}");
        assert!(err.to_string().contains("gave up"), "{err}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_target_are_errors_that_name_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/such/folder/a.txt");
        let err = write_atomically(&missing, b"x").unwrap_err();
        assert!(err.to_string().contains("no/such/folder"), "{err}");
        let err = write_atomically(folder.path(), b"x").unwrap_err();
        assert_eq!(err.action, "opening");
    }

    #[test]
    fn what_could_not_be_written_is_found_beforehand_without_a_trace() {
        // A folder whose own name is not that of a temporary file.
        let folder = tempfile::Builder::new().prefix("folder").tempdir().unwrap();
        let path = folder.path().join("a.txt");
        check_writable(&path).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        std::fs::write(&path, "old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        for (bad, kind) in [
            (folder.path().to_path_buf(), io::ErrorKind::IsADirectory),
            (folder.path().join("no/a.txt"), io::ErrorKind::NotFound),
            (path.join("b.txt"), io::ErrorKind::NotADirectory),
        ] {
            let err = check_writable(&bad).unwrap_err();
            assert_eq!(err.source.kind(), kind, "{err}");
            assert!(!err.to_string().contains(".tmp"), "{err}");
            assert_eq!(err.to_string(), write_atomically(&bad, b"x").unwrap_err().to_string());
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_file_gets_ordinary_permissions_not_those_of_a_temporary_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let plain = folder.path().join("b.txt");
        write_atomically(&path, b"x").unwrap();
        std::fs::write(&plain, b"x").unwrap();
        let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain));
    }
}
