//! Files of an export, written together: a folder that is complete, or as it was.

use std::path::Path;

use crate::error::ExportError;

/// A file of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportedFile {
    /// Name in the folder, with / between folders.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl ExportedFile {
    pub(crate) fn new(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }
}

/// What every file that an export wrote holds.
const MARK: &[u8] = b"hysteron export";

/// Writes all `files` into `folder`, made where it does not exist. Files of other names stay as they are; one of the same name is
/// replaced where an export wrote it. Everything is written beside the folder first and then renamed.
///
/// # Errors
/// [`ExportError::Foreign`] for a file of the same name that no export wrote; [`ExportError::Write`]. Nothing has changed then, but for a
/// rename that fails between two others.
pub fn write_folder(folder: &Path, files: &[ExportedFile]) -> Result<(), ExportError> {
    let failed = |action, path: &Path| {
        let path = path.to_owned();
        move |source| ExportError::Write { action, path, source }
    };
    for file in files {
        let path = folder.join(&file.name);
        if let Ok(old) = std::fs::read(&path)
            && !old.windows(MARK.len()).any(|part| part == MARK)
        {
            return Err(ExportError::Foreign { path });
        }
    }
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(parent).map_err(failed("making the folder", parent))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hysteron-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o755));
    }
    let beside = builder.tempdir_in(parent).map_err(failed("making a folder in", parent))?;
    for file in files {
        let path = beside.path().join(&file.name);
        let own = path.parent().unwrap_or(parent);
        let write = || {
            std::fs::create_dir_all(own)?;
            std::fs::write(&path, &file.bytes)?;
            std::fs::File::open(&path)?.sync_all()
        };
        write().map_err(failed("writing", &folder.join(&file.name)))?;
    }
    if !folder.exists() {
        let made = beside.keep();
        return std::fs::rename(&made, folder).map_err(|source| {
            let _ = std::fs::remove_dir_all(&made);
            ExportError::Write { action: "renaming the finished folder to", path: folder.to_owned(), source }
        });
    }
    for file in files {
        let path = folder.join(&file.name);
        let own = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(own)
            .and_then(|()| std::fs::rename(beside.path().join(&file.name), &path))
            .map_err(failed("replacing", &path))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> ExportedFile {
        ExportedFile::new(name, format!("/* hysteron export */ {text}"))
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
        assert!(matches!(&refused, ExportError::Foreign { path } if path.ends_with("mine.c")), "{refused}");
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
}
