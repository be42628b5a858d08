//! A workspace: a plain folder of records, models and reports, with a history beside them.

mod examples;
mod history;
mod models;
mod names;
mod read;
mod records;
mod remembered;
mod scan;
mod trash;
mod upload;

use std::path::{Path, PathBuf};
use std::sync::Mutex;

pub(crate) use examples::open_example;
pub(crate) use history::History;
pub(crate) use names::{HISTORY, device_of, path_of, shown, stem_of};
pub(crate) use read::ReadRecord;
pub(crate) use scan::{Found, Kind, Listing};
pub(crate) use upload::too_large;

use crate::error::AppError;
use crate::notice::{Change, Notices};
use crate::refused::{Answer, Refused};
use read::Cache;
use remembered::Remembered;
pub(crate) use remembered::Simulated;

/// An open workspace.
pub(crate) struct Workspace {
    folder: PathBuf,
    pub(crate) history: History,
    pub(crate) notices: Notices,
    cache: Mutex<Cache>,
    /// Models on records, with what was scored.
    pub(crate) scored: Remembered<Simulated>,
    listing: Mutex<Listing>,
    pub(crate) max_upload_bytes: u64,
}

impl Workspace {
    /// Opens the folder, which is made where it is missing.
    ///
    /// # Errors
    /// If folder or history cannot be made or read.
    pub(crate) fn open(folder: &Path, max_upload_bytes: u64, memory: u64) -> Result<Self, AppError> {
        let cannot = |source| AppError::Folder { folder: folder.to_path_buf(), source };
        std::fs::create_dir_all(folder).map_err(cannot)?;
        let folder = folder.canonicalize().map_err(cannot)?;
        let history = History::open(&folder.join(HISTORY))?;
        // Uploads that ended with the program; no other one runs here now.
        for entry in std::fs::read_dir(&folder).map_err(cannot)?.flatten() {
            if entry.file_name().to_string_lossy().starts_with(upload::UPLOAD) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
        Ok(Self {
            history,
            notices: Notices::default(),
            cache: Mutex::new(Cache::new(memory)),
            scored: Remembered::default(),
            listing: Mutex::new(Listing::default()),
            folder,
            max_upload_bytes,
        })
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The path of an identifier.
    ///
    /// # Errors
    /// For one that is none.
    pub(crate) fn path(&self, id: &str) -> Answer<PathBuf> {
        path_of(&self.folder, id)
    }

    /// The path of a file that is to be written, in a folder that is there; a file of this name goes to the
    /// trash folder.
    ///
    /// # Errors
    /// For an identifier that is none, or has another ending than files of this kind.
    pub(crate) fn to_write(&self, id: &str, kind: Kind) -> Answer<PathBuf> {
        let path = self.path(id)?;
        let endings: &[&str] = match kind {
            Kind::Record => &[".csv", ".npz", ".mat"],
            Kind::Model => &[".json"],
            Kind::Report => &[".html"],
        };
        let is_kept = id.ends_with(".partial.json") || id.ends_with(".searches.json");
        if is_kept || !endings.iter().any(|ending| id.ends_with(ending)) {
            return Err(Refused::bad(format!(
                "the name of a {} ends in {}",
                kind.name(),
                endings.join(", ")
            )));
        }
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(Refused::failed)?;
        }
        if path.exists() {
            self.keep_replaced(id, kind)?;
        }
        Ok(path)
    }

    /// The path of a file that is there.
    ///
    /// # Errors
    /// For one that is not.
    pub(crate) fn existing(&self, id: &str) -> Answer<PathBuf> {
        let path = self.path(id)?;
        if !path.is_file() {
            return Err(Refused::missing(format!("there is no `{}` in the workspace", shown(id))));
        }
        Ok(path)
    }

    /// Looks at the folder again and tells the pages what has changed.
    pub(crate) fn look(&self) -> Listing {
        let found = scan::scan(&self.folder);
        let mut last = self.listing.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for (kind, change) in
            [(Kind::Record, Change::Records), (Kind::Model, Change::Models), (Kind::Report, Change::Reports)]
        {
            if found.of(kind).ne(last.of(kind)) {
                self.notices.changed(change);
            }
        }
        last.clone_from(&found);
        found
    }
}
