//! Uploads: a file arrives whole and readable, or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};

use hysteron_io::{IoError, ReadOptions, contents};

use super::read::read_as_said;
use super::scan::Kind;
use super::{ReadRecord, Workspace, shown};
use crate::api::{Problem, RecordEntry, RecordSettings};
use crate::refused::{Answer, Refused};

/// What the names of arriving files begin with.
pub(super) const UPLOAD: &str = ".upload-";

/// A file that is arriving.
pub(crate) struct Upload {
    id: String,
    path: PathBuf,
    replace: bool,
    file: tempfile::NamedTempFile,
    bytes: u64,
    most: u64,
}

impl Upload {
    /// Adds bytes.
    ///
    /// # Errors
    /// Above the limit; if the disk is full.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Answer<()> {
        self.bytes += bytes.len() as u64;
        if self.bytes > self.most {
            return Err(too_large(self.most));
        }
        self.file.write_all(bytes).map_err(|e| cannot_write(&self.id, &e))
    }
}

/// The refusal of a file above the limit.
pub(crate) fn too_large(most: u64) -> Refused {
    let what = format!("the file is larger than {most} bytes, the largest upload");
    let remedy = "Copy it into the folder, or start hysteron app with a larger --max-upload.";
    let problem = Problem { what, remedy: Some(remedy.to_owned()), ..Problem::default() };
    Refused::new(axum::http::StatusCode::PAYLOAD_TOO_LARGE, problem)
}

fn cannot_write(id: &str, e: &std::io::Error) -> Refused {
    Refused::failed(format!("`{}` cannot be written: {e}", shown(id)))
}

impl Workspace {
    /// Begins an upload to an identifier.
    ///
    /// # Errors
    /// For a name that is no record's, or is taken and not to be replaced.
    pub(crate) fn begin_upload(&self, id: &str, replace: bool) -> Answer<Upload> {
        let path = self.path(id)?;
        let ending = id.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase());
        let known = |ending: &String| hysteron_io::record_extensions().any(|known| known == ending);
        if !ending.as_ref().is_some_and(known) {
            let all: Vec<&str> = hysteron_io::record_extensions().collect();
            return Err(Refused::bad(format!("`{}` has no ending of a record", shown(id)))
                .hint(format!("Known endings: {}.", all.join(", "))));
        }
        if path.exists() && !replace {
            return Err(taken(id));
        }
        let cannot = |e: std::io::Error| cannot_write(id, &e);
        // Of the same ending, as it may choose the format; in the workspace, to be renamed.
        let suffix = format!(".{}", ending.unwrap_or_default());
        let mut file = tempfile::Builder::new();
        let file = file.prefix(UPLOAD).suffix(&suffix).tempfile_in(self.folder()).map_err(cannot)?;
        let most = self.max_upload_bytes;
        Ok(Upload { id: id.to_owned(), path, replace, file, bytes: 0, most })
    }

    /// Ends an upload: the file is read, and has its name if it is a record.
    ///
    /// # Errors
    /// If it is none; the folder is then as it was.
    pub(crate) fn end_upload(&self, upload: Upload) -> Answer<RecordEntry> {
        let Upload { id, path, replace, mut file, .. } = upload;
        let cannot = |e: std::io::Error| cannot_write(&id, &e);
        file.flush().map_err(cannot)?;
        let read = check(file.path(), &id)?;
        file.as_file().sync_all().map_err(cannot)?;
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(cannot)?;
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let ordinary = std::fs::Permissions::from_mode(0o644);
            file.as_file().set_permissions(ordinary).map_err(cannot)?;
        }
        if replace && path.exists() {
            let kept = self.keep_replaced(&id, Kind::Record)?;
            if let Err(e) = file.persist(&path) {
                self.history.forget_trash(&kept.token)?;
                return Err(cannot(e.error));
            }
        } else {
            // A file of this name that another program has taken away had settings.
            self.history.forget_settings(&id)?;
            // Does not replace a file that has appeared meanwhile.
            file.persist_noclobber(&path).map_err(|e| match e.error.kind() {
                std::io::ErrorKind::AlreadyExists => taken(&id),
                _ => cannot(e.error),
            })?;
        }
        if let Some(read) = read {
            self.keep_read(&id, read)?;
        }
        self.look();
        self.first_look(&id)
    }
}

fn taken(id: &str) -> Refused {
    Refused::conflict(format!("`{}` is there already", shown(id)))
        .hint("Give it another name, or replace the old one.")
}

/// Refuses a file that is no record. One whose columns are still to be chosen is accepted.
fn check(path: &Path, id: &str) -> Answer<Option<ReadRecord>> {
    match read_as_said(path, id, &RecordSettings::default()) {
        Ok(read) => Ok(Some(read)),
        Err(problem) => {
            let listed = contents(path, &ReadOptions::default());
            let can_choose = match hysteron_io::read_record(path, &ReadOptions::default()) {
                Err(e) => is_choice(&e) && listed.is_ok_and(|listed| !listed.is_empty()),
                Ok(_) => true,
            };
            if can_choose { Ok(None) } else { Err(Refused::cannot(problem)) }
        }
    }
}

/// True if the person can make a record of the file by choosing columns or giving the rate.
fn is_choice(e: &IoError) -> bool {
    matches!(e, IoError::ChooseArrays { .. } | IoError::ChooseRate { .. } | IoError::AmbiguousColumn { .. })
}
