//! Files that are either complete or not there: written beside the target, flushed to the disk, renamed over
//! it. Symbolic links are followed; devices, pipes and open descriptors are written directly.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Failure of an atomic write: the step and the file.
#[derive(Debug, thiserror::Error)]
#[error("cannot write `{}`: {action} failed: {source}", path.display())]
#[non_exhaustive]
pub struct AtomicWriteError {
    /// The file that was to be written; what it held before is untouched.
    pub path: PathBuf,
    /// The step that failed.
    pub action: &'static str,
    /// Error of the operating system.
    pub source: io::Error,
}

/// Writes `bytes` to `path`: a reader finds the old content or all of the new, at any moment.
///
/// # Errors
/// Any step the operating system refuses; the old file is then untouched and no temporary file is left.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), AtomicWriteError> {
    write_atomically_with(path, |out| out.write_all(bytes))
}

/// Checks whether `path` can be written, before the work whose result it is to hold; leaves nothing behind.
///
/// # Errors
/// Those of [`write_atomically`]: no such folder, a folder that may not be written to, a folder of this name,
/// a loop of symbolic links.
pub fn check_writable(path: &Path) -> Result<(), AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    match Target::of(path).map_err(failed(OPENING))? {
        Target::File { folder, .. } => temporary_in(&folder).map(drop).map_err(failed(CREATING)),
        // A pipe or a terminal: its other end would notice that it was opened.
        Target::Stream(_) | Target::Descriptor(_) => Ok(()),
    }
}

pub(crate) const OPENING: &str = "opening";
const CREATING: &str = "creating a file in its folder";

/// Most symbolic links in a chain, as in Linux.
const MOST_LINKS: usize = 40;

/// Where the bytes for a path go, its symbolic links followed.
#[derive(Debug)]
pub(crate) enum Target {
    /// A regular file, or one to be made: `path` in `folder`.
    File { folder: PathBuf, path: PathBuf },
    /// A device, pipe or socket, written directly: a rename would destroy it.
    Stream(PathBuf),
    /// An open descriptor (`/dev/stdout`, `/proc/self/fd/1`), written directly even where it is redirected to
    /// a regular file: that file is open elsewhere, and may already hold output.
    Descriptor(PathBuf),
}

impl Target {
    pub(crate) fn of(path: &Path) -> io::Result<Self> {
        let mut path = path.to_path_buf();
        for _ in 0..=MOST_LINKS {
            let is_folder = path.as_os_str().as_encoded_bytes().ends_with(b"/");
            let Some(name) = path.file_name().filter(|_| !is_folder) else {
                return Err(io::ErrorKind::IsADirectory.into());
            };
            let folder = folder_of(&path).canonicalize()?;
            let place = folder.join(name);
            let found = match std::fs::symlink_metadata(&place) {
                Err(e) if e.kind() == io::ErrorKind::NotFound => {
                    return Ok(Self::File { folder, path: place });
                }
                found => found?,
            };
            if holds_descriptors(&folder) {
                if std::fs::metadata(&place)?.is_dir() {
                    return Err(io::ErrorKind::IsADirectory.into());
                }
                return Ok(Self::Descriptor(place));
            }
            if found.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            if found.is_file() {
                return Ok(Self::File { folder, path: place });
            }
            if !found.is_symlink() {
                return Ok(Self::Stream(place));
            }
            path = folder.join(std::fs::read_link(&place)?);
        }
        Err(io::Error::other(format!("its symbolic links form a loop or a chain of more than {MOST_LINKS}")))
    }
}

/// Whether a canonical `folder` is that of the open descriptors of a process: `/proc/PID/fd`, `/dev/fd`.
fn holds_descriptors(folder: &Path) -> bool {
    folder == Path::new("/dev/fd") || folder.starts_with("/proc") && folder.ends_with("fd")
}

/// Opens a descriptor for writing after its present content.
fn open_descriptor(path: &Path) -> io::Result<File> {
    #[cfg(unix)]
    {
        use std::os::fd::AsFd;
        let process = Path::new("/proc").join(std::process::id().to_string());
        let is_own = path.starts_with("/dev/fd") || path.starts_with(process);
        // A duplicate shares the position in a redirected file, and serves a socket, which cannot be opened.
        match path.file_name().and_then(|name| name.to_str()) {
            Some("1") if is_own => {
                io::stdout().flush()?;
                return io::stdout().as_fd().try_clone_to_owned().map(File::from);
            }
            Some("2") if is_own => return io::stderr().as_fd().try_clone_to_owned().map(File::from),
            _ => {}
        }
    }
    OpenOptions::new().append(true).open(path)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// A temporary file with the permissions of an ordinary one, which the error does not name to the user.
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
/// Symbolic links are followed, and stay; the file behind a dangling link is made. A device, a pipe or an
/// open descriptor (`/dev/stdout`) is written directly, and never renamed over.
///
/// # Errors
/// Those of [`write_atomically`], and those of `produce`.
pub fn write_atomically_with(
    path: &Path,
    produce: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    match Target::of(path).map_err(failed(OPENING))? {
        Target::File { folder, path: place } => {
            let temporary = staged(path, &folder, produce)?;
            named(path, &folder, place, temporary)
        }
        Target::Stream(place) => direct(path, OpenOptions::new().write(true).open(place), produce),
        Target::Descriptor(place) => direct(path, open_descriptor(&place), produce),
    }
}

/// Writes the content of `path` beside its place, and flushes it to the disk.
pub(crate) fn staged(
    path: &Path,
    folder: &Path,
    produce: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<tempfile::NamedTempFile, AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    let mut temporary = temporary_in(folder).map_err(failed(CREATING))?;
    {
        let mut out = BufWriter::with_capacity(1 << 16, temporary.as_file_mut());
        produce(&mut out).map_err(failed("writing"))?;
        out.flush().map_err(failed("writing"))?;
    }
    temporary.as_file().sync_all().map_err(failed("flushing to the disk"))?;
    Ok(temporary)
}

/// Gives a finished file its name.
pub(crate) fn named(
    path: &Path,
    folder: &Path,
    place: PathBuf,
    temporary: tempfile::NamedTempFile,
) -> Result<(), AtomicWriteError> {
    temporary.persist(place).map_err(|e| AtomicWriteError {
        path: path.to_path_buf(),
        action: "renaming the finished file",
        source: e.error,
    })?;
    // The rename is durable once the folder is flushed, which some file systems cannot do.
    if let Ok(handle) = File::open(folder) {
        let _ = handle.sync_all();
    }
    Ok(())
}

/// Writes to what is open elsewhere or is no file.
fn direct(
    path: &Path,
    opened: io::Result<File>,
    produce: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), AtomicWriteError> {
    let failed = |action| move |source| AtomicWriteError { path: path.to_path_buf(), action, source };
    let mut out = BufWriter::new(opened.map_err(failed(OPENING))?);
    produce(&mut out).map_err(failed("writing"))?;
    out.flush().map_err(failed("writing"))
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

    #[cfg(unix)]
    mod links {
        use super::*;
        use std::os::fd::AsRawFd;
        use std::os::unix::fs::{FileTypeExt, symlink};

        #[test]
        fn a_link_to_a_file_stays_and_the_file_gets_the_content() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            std::fs::create_dir_all(at("data/deep")).unwrap();
            std::fs::write(at("data/file"), "old").unwrap();
            // A chain through folders, relative and absolute, and a folder that is a link itself.
            symlink("../file", at("data/deep/first")).unwrap();
            symlink(at("data/deep/first"), at("second")).unwrap();
            symlink("data/deep", at("folder")).unwrap();
            for (link, content) in [("second", "1"), ("folder/first", "2"), ("data/deep/first", "3")] {
                check_writable(&at(link)).unwrap();
                write_atomically(&at(link), content.as_bytes()).unwrap();
                assert!(at(link).is_symlink(), "{link}");
                assert!(!at("data/file").is_symlink(), "{link}");
                assert_eq!(std::fs::read_to_string(at("data/file")).unwrap(), content, "{link}");
            }
            assert_eq!(std::fs::read_dir(at("data")).unwrap().count(), 2);
        }

        #[test]
        fn the_file_behind_a_dangling_link_is_made() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            symlink("made", at("first")).unwrap();
            symlink("first", at("second")).unwrap();
            check_writable(&at("second")).unwrap();
            assert!(!at("made").exists());
            write_atomically(&at("second"), b"new").unwrap();
            assert!(at("second").is_symlink() && at("first").is_symlink());
            assert_eq!(std::fs::read(at("made")).unwrap(), b"new");
            symlink("no/such/folder/file", at("lost")).unwrap();
            let err = write_atomically(&at("lost"), b"x").unwrap_err();
            assert_eq!(err.source.kind(), io::ErrorKind::NotFound);
            assert_eq!(err.to_string(), check_writable(&at("lost")).unwrap_err().to_string());
        }

        #[test]
        fn a_loop_of_links_and_a_link_to_a_folder_are_errors_that_say_so() {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            symlink("b", at("a")).unwrap();
            symlink("a", at("b")).unwrap();
            symlink(".", at("c")).unwrap();
            for (link, wanted) in [("a", "loop"), ("c", "directory")] {
                let err = write_atomically(&at(link), b"x").unwrap_err().to_string();
                assert!(err.contains(wanted), "{err}");
                assert_eq!(err, check_writable(&at(link)).unwrap_err().to_string());
                assert!(at(link).is_symlink());
            }
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
        }

        #[test]
        fn a_pipe_and_a_device_are_written_directly_and_stay() {
            let folder = tempfile::tempdir().unwrap();
            let pipe = folder.path().join("pipe");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
            assert!(made.success());
            let (to_pipe, to_null) = (folder.path().join("to_pipe"), folder.path().join("to_null"));
            symlink("pipe", &to_pipe).unwrap();
            symlink("/dev/null", &to_null).unwrap();
            for path in [&pipe, &to_pipe] {
                check_writable(path).unwrap();
                let reader = std::thread::spawn({
                    let pipe = pipe.clone();
                    move || std::fs::read(pipe)
                });
                write_atomically(path, b"through the pipe").unwrap();
                assert_eq!(reader.join().unwrap().unwrap(), b"through the pipe");
                assert!(std::fs::metadata(path).unwrap().file_type().is_fifo());
            }
            check_writable(&to_null).unwrap();
            write_atomically(&to_null, b"nothing").unwrap();
            assert!(std::fs::metadata(&to_null).unwrap().file_type().is_char_device());
            assert!(to_null.is_symlink() && to_pipe.is_symlink());
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn an_open_descriptor_of_a_file_is_written_after_its_content() {
            let folder = tempfile::tempdir().unwrap();
            let (path, link) = (folder.path().join("file"), folder.path().join("link"));
            let mut file = File::create(&path).unwrap();
            file.write_all(b"before ").unwrap();
            let descriptor = format!("/proc/self/fd/{}", file.as_raw_fd());
            symlink(&descriptor, &link).unwrap();
            for path in [Path::new(&descriptor), &link] {
                check_writable(path).unwrap();
                write_atomically(path, b"after ").unwrap();
            }
            assert_eq!(std::fs::read(&path).unwrap(), b"before after after ");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
            assert!(link.is_symlink());
        }
    }
}
