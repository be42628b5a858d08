//! Files written together: a folder that is complete, or as it was.

use std::io::{self, ErrorKind};
use std::path::Path;

use crate::IoError;
use crate::atomic_file::write_atomically;

/// A file to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    /// Name in the folder, with / between folders.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl NamedFile {
    /// A file with this content.
    pub fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }
}

/// A temporary folder, removed when dropped.
///
/// # Errors
/// Where the operating system refuses.
pub fn temporary_folder() -> io::Result<tempfile::TempDir> {
    tempfile::tempdir()
}

/// Writes all `files` into `folder`, made where it does not exist. Files of other names stay as they are; one
/// of the same name is replaced where it holds `mark`, as all files written this way do; without a mark,
/// whatever it holds. Everything is
/// written beside its place first, and then renamed; what was replaced is put back where a later rename
/// fails. A symbolic link to a file stays, and that file is replaced or made.
///
/// # Errors
/// [`IoError::Foreign`] for a file of the same name without the mark; [`IoError::Folder`]. Nothing has
/// changed then.
pub fn write_folder(folder: &Path, files: &[NamedFile], mark: Option<&[u8]>) -> Result<(), IoError> {
    for file in files {
        check(&folder.join(&file.name), mark)?;
    }
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // In the folder itself where it exists: it must be writable, and may be on another disk than its parent.
    let is_new = !folder.exists();
    let place = if is_new { parent } else { folder };
    std::fs::create_dir_all(place).map_err(failed("making the folder", place))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hysteron-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o755));
    }
    let beside = builder.tempdir_in(place).map_err(failed("making a folder in", place))?;
    let (new, old) = (beside.path().join("new"), beside.path().join("old"));
    let prepared = if is_new { beside.path() } else { &new };
    for file in files {
        let path = prepared.join(&file.name);
        let own = path.parent().unwrap_or(parent);
        let write = || {
            std::fs::create_dir_all(own)?;
            std::fs::write(&path, &file.bytes)?;
            std::fs::File::open(&path)?.sync_all()
        };
        write().map_err(failed("writing", &folder.join(&file.name)))?;
    }
    if is_new {
        let made = beside.keep();
        return std::fs::rename(&made, folder).map_err(|source| {
            let _ = std::fs::remove_dir_all(&made);
            IoError::Folder { action: "renaming the finished folder to", path: folder.to_owned(), source }
        });
    }
    for (done, file) in files.iter().enumerate() {
        if let Err(source) = replace(folder, &new, &old, &file.name) {
            for file in files[..done].iter().rev() {
                put_back(folder, &old, &file.name);
            }
            remove_empty(folder, &folder.join(&file.name));
            return Err(failed("replacing", &folder.join(&file.name))(source));
        }
    }
    Ok(())
}

fn failed(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> IoError {
    let path = path.to_owned();
    move |source| IoError::Folder { action, path, source }
}

/// Whether a file can be replaced, or made.
fn check(path: &Path, mark: Option<&[u8]>) -> Result<(), IoError> {
    let refused = |kind: ErrorKind| failed("writing", path)(kind.into());
    match std::fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(refused(ErrorKind::IsADirectory)),
        // A device or a pipe bears no mark, and reading it might block.
        Ok(found) if !found.is_file() => Err(IoError::Foreign { path: path.to_owned() }),
        Ok(_) => {
            let Some(mark) = mark else { return Ok(()) };
            let old = std::fs::read(path).map_err(failed("reading", path))?;
            let ours = old.windows(mark.len()).any(|part| part == mark);
            if ours { Ok(()) } else { Err(IoError::Foreign { path: path.to_owned() }) }
        }
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
        Err(e) => Err(failed("writing", path)(e)),
    }
}

/// Moves the file `name` from `new` to its place in `folder`, and what was there to `old`.
fn replace(folder: &Path, new: &Path, old: &Path, name: &str) -> io::Result<()> {
    let (path, kept) = (folder.join(name), old.join(name));
    for file in [&path, &kept] {
        std::fs::create_dir_all(file.parent().unwrap_or(folder))?;
    }
    // A copy, so that its place is never empty.
    if path.exists() {
        std::fs::copy(&path, &kept)?;
    }
    put(&new.join(name), &path)
}

/// Moves the file `from` to `path`, or its content to where a link there leads.
fn put(from: &Path, path: &Path) -> io::Result<()> {
    if path.is_symlink() {
        return write_atomically(path, &std::fs::read(from)?).map_err(|e| e.source);
    }
    std::fs::rename(from, path)
}

/// Undoes [`replace`] as far as possible.
fn put_back(folder: &Path, old: &Path, name: &str) {
    let (path, kept) = (folder.join(name), old.join(name));
    if kept.exists() {
        let _ = put(&kept, &path);
        return;
    }
    // A link that led to no file is left as it was.
    let _ = path.canonicalize().and_then(std::fs::remove_file);
    remove_empty(folder, &path);
}

/// Removes the folders between `folder` and `path` that are empty.
fn remove_empty(folder: &Path, path: &Path) {
    for between in path.ancestors().skip(1).take_while(|a| *a != folder) {
        let _ = std::fs::remove_dir(between);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    const MARK: &[u8] = b"hysteron export";

    fn write_folder(folder: &Path, files: &[NamedFile]) -> Result<(), IoError> {
        super::write_folder(folder, files, Some(MARK))
    }

    fn file(name: &str, text: &str) -> NamedFile {
        NamedFile::new(name, format!("/* hysteron export */ {text}"))
    }

    #[test]
    fn a_folder_is_made_replaced_and_foreign_files_are_left_alone() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/out");
        write_folder(&folder, &[file("a.c", "1"), file("src/b.c", "1")]).unwrap();
        std::fs::write(folder.join("mine.c"), "mine").unwrap();
        write_folder(&folder, &[file("a.c", "2"), file("src/b.c", "2")]).unwrap();
        let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
        assert!(read("a.c").ends_with('2') && read("src/b.c").ends_with('2'));
        assert_eq!(read("mine.c"), "mine");
        let refused = write_folder(&folder, &[file("a.c", "3"), file("mine.c", "3")]).unwrap_err();
        assert!(matches!(&refused, IoError::Foreign { path } if path.ends_with("mine.c")), "{refused}");
        assert!(read("a.c").ends_with('2') && read("mine.c") == "mine");
        // No temporary folder is left.
        assert_eq!(std::fs::read_dir(place.path().join("deep")).unwrap().count(), 1);
    }

    #[test]
    fn a_file_in_the_place_of_the_folder_is_an_error() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("out");
        std::fs::write(&path, "x").unwrap();
        assert!(write_folder(&path, &[file("a.c", "1")]).is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "x");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_files_are_followed_and_pipes_are_left_alone() {
        use std::os::unix::fs::symlink;
        let place = tempfile::tempdir().unwrap();
        let (folder, there) = (place.path().join("out"), place.path().join("there"));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::create_dir_all(&there).unwrap();
        std::fs::write(there.join("a.c"), "/* hysteron export */ 1").unwrap();
        symlink("../there/a.c", folder.join("a.c")).unwrap();
        symlink("../there/made.c", folder.join("b.c")).unwrap();
        write_folder(&folder, &[file("a.c", "2"), file("b.c", "2")]).unwrap();
        assert!(folder.join("a.c").is_symlink() && folder.join("b.c").is_symlink());
        for name in ["a.c", "made.c"] {
            assert!(std::fs::read_to_string(there.join(name)).unwrap().ends_with('2'), "{name}");
        }
        // Put back through the links, too.
        let (new, old) = (place.path().join("new"), place.path().join("old"));
        std::fs::remove_file(there.join("made.c")).unwrap();
        write_folder(&new, &[file("a.c", "3"), file("b.c", "3")]).unwrap();
        for name in ["a.c", "b.c"] {
            replace(&folder, &new, &old, name).unwrap();
            assert!(std::fs::read_to_string(folder.join(name)).unwrap().ends_with('3'), "{name}");
            put_back(&folder, &old, name);
        }
        assert!(std::fs::read_to_string(there.join("a.c")).unwrap().ends_with('2'));
        assert!(folder.join("b.c").is_symlink() && !there.join("made.c").exists());
        let pipe = folder.join("pipe.c");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        symlink("/dev/null", folder.join("null.c")).unwrap();
        for name in ["pipe.c", "null.c"] {
            let refused = write_folder(&folder, &[file(name, "2")]).unwrap_err();
            assert!(matches!(refused, IoError::Foreign { .. }), "{refused}");
        }
    }

    /// Everything in a folder, folders without content included.
    fn tree(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
        let mut all = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                all.push((path.clone(), Vec::new()));
                all.extend(tree(&path));
            } else {
                all.push((path.clone(), std::fs::read(&path).unwrap()));
            }
        }
        all.sort();
        all
    }

    #[test]
    fn where_one_file_cannot_be_written_none_is() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        let files = [file("a.c", "2"), file("new/b.c", "2"), file("c.c", "2")];
        // A folder of the name of a file, and a file of the name of a folder.
        for (at, is_folder) in [("c.c", true), ("a.c", true), ("new", false)] {
            std::fs::create_dir_all(&folder).unwrap();
            if is_folder {
                std::fs::create_dir(folder.join(at)).unwrap();
            } else {
                std::fs::write(folder.join(at), "/* hysteron export */").unwrap();
            }
            let before = tree(&folder);
            let refused = write_folder(&folder, &files).unwrap_err();
            assert!(matches!(refused, IoError::Folder { .. }), "{at}: {refused}");
            assert_eq!(tree(place.path()).len(), 1 + before.len(), "{at}");
            assert_eq!(tree(&folder), before, "{at}");
            std::fs::remove_dir_all(&folder).unwrap();
        }
    }

    /// A rename that fails after others have succeeded, which no check beforehand can foresee.
    #[test]
    fn what_was_replaced_before_a_failure_is_put_back() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        write_folder(&folder, &[file("a.c", "1")]).unwrap();
        let before = tree(&folder);
        let (new, old) = (place.path().join("new"), place.path().join("old"));
        write_folder(&new, &[file("a.c", "2"), file("src/b.c", "2")]).unwrap();
        for name in ["a.c", "src/b.c"] {
            replace(&folder, &new, &old, name).unwrap();
        }
        assert_ne!(tree(&folder), before);
        assert!(replace(&folder, &new, &old, "c.c").is_err());
        for name in ["src/b.c", "a.c"] {
            put_back(&folder, &old, name);
        }
        assert_eq!(tree(&folder), before);
    }
}
