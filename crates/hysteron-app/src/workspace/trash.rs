//! Deleting to the trash folder, and its undo.

use std::path::Path;

use super::names::TRASH;
use super::scan::{Kind, kind_of};
use super::{Workspace, shown};
use crate::api::Trashed;
use crate::clock::now;
use crate::refused::{Answer, Refused};

impl Workspace {
    /// Moves a file of a kind into the trash folder.
    ///
    /// # Errors
    /// If it is not there, of another kind, or cannot be moved.
    pub(crate) fn discard(&self, id: &str, kind: Kind) -> Answer<Trashed> {
        let trashed = self.put_into_trash(id, kind, |from, to| std::fs::rename(from, to))?;
        self.look();
        Ok(trashed)
    }

    /// Keeps a file that is about to be replaced in the trash folder; it is there until then.
    ///
    /// # Errors
    /// If it is not there, of another kind, or cannot be kept.
    pub(crate) fn keep_replaced(&self, id: &str, kind: Kind) -> Answer<Trashed> {
        let keep = |from: &Path, to: &Path| {
            std::fs::hard_link(from, to).or_else(|_| std::fs::copy(from, to).map(drop))
        };
        self.put_into_trash(id, kind, keep)
    }

    fn put_into_trash(
        &self,
        id: &str,
        kind: Kind,
        put: impl Fn(&Path, &Path) -> std::io::Result<()>,
    ) -> Answer<Trashed> {
        let path = self.existing(id)?;
        if kind_of(&path.file_name().unwrap_or_default().to_string_lossy()) != Some(kind) {
            return Err(Refused::missing(format!("`{}` is no {}", shown(id), kind.name())));
        }
        let failed = |e: std::io::Error| {
            Refused::failed(format!("`{}` cannot be moved to the trash folder: {e}", shown(id)))
        };
        let folder = self.folder().join(TRASH);
        std::fs::create_dir_all(&folder).map_err(failed)?;
        // A folder of its own keeps the name, whatever was deleted before.
        let own = tempfile::Builder::new().prefix("").rand_bytes(12).tempdir_in(&folder).map_err(failed)?;
        let token = own.path().file_name().map(|name| name.to_string_lossy().into_owned());
        let token = token.ok_or_else(|| Refused::failed("the trash folder cannot be used"))?;
        let name = path.file_name().map(Path::new).unwrap_or(&path);
        let trashed = Trashed { token, id: id.to_owned(), deleted: now() };
        // Written before the move: a file in the trash that nobody knows of could not be restored.
        self.history.add_trash(&trashed)?;
        if let Err(e) = put(&path, &own.path().join(name)) {
            self.history.forget_trash(&trashed.token)?;
            return Err(failed(e));
        }
        let _ = own.keep();
        Ok(trashed)
    }

    /// Undoes a deletion.
    ///
    /// # Errors
    /// If nothing was deleted under this token, or another file has the name now.
    pub(crate) fn restore(&self, token: &str) -> Answer<Trashed> {
        let trashed = self.trash()?.into_iter().find(|trashed| trashed.token == token);
        let unknown = || Refused::missing("nothing in the trash folder has this token");
        let trashed = trashed.ok_or_else(unknown)?;
        let path = self.path(&trashed.id)?;
        let name = path.file_name().map(Path::new).unwrap_or(&path);
        let own = self.folder().join(TRASH).join(&trashed.token);
        let failed =
            |e: std::io::Error| Refused::failed(format!("`{}` cannot be restored: {e}", shown(&trashed.id)));
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        // A hard link does not replace a file that has the name by now, unlike renaming; not every file system
        // has them.
        let renamed = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotFound => Err(e),
            _ if path.exists() => Err(std::io::ErrorKind::AlreadyExists.into()),
            _ => std::fs::rename(own.join(name), &path),
        };
        std::fs::hard_link(own.join(name), &path).or_else(renamed).map_err(|e| match e.kind() {
            std::io::ErrorKind::AlreadyExists => {
                Refused::conflict(format!("another file is called `{}` now", shown(&trashed.id)))
                    .hint("Rename or delete it first.")
            }
            std::io::ErrorKind::NotFound => unknown(),
            _ => failed(e),
        })?;
        let _ = std::fs::remove_dir_all(&own);
        self.history.forget_trash(token)?;
        self.look();
        Ok(trashed)
    }

    /// What is in the trash folder, newest first.
    ///
    /// # Errors
    /// If the history cannot be read.
    pub(crate) fn trash(&self) -> Answer<Vec<Trashed>> {
        let folder = self.folder().join(TRASH);
        let mut trash = self.history.trash()?;
        trash.retain(|trashed| folder.join(&trashed.token).is_dir());
        Ok(trash)
    }
}
