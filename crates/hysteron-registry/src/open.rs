//! Opening a registry: read-only, of a schema that is known.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags, OptionalExtension};

use crate::error::RegistryError;

/// Revisions of `python/hysteron_models/fleet/migrations` whose columns are read here; the newest last.
const SCHEMAS: &[&str] = &["0001", "0002"];
/// Time to wait for the writer to finish a row.
const BUSY: Duration = Duration::from_secs(10);

/// An open registry.
#[derive(Debug)]
pub struct Registry {
    pub(crate) connection: Connection,
    path: PathBuf,
}

impl Registry {
    /// Opens the SQLite file at `path`, which is not changed.
    ///
    /// # Errors
    /// [`RegistryError`] for no file, another program's file, or a schema of a newer version.
    pub fn open(path: &Path) -> Result<Self, RegistryError> {
        let unreadable = |source| RegistryError::Unreadable { path: path.to_path_buf(), source };
        std::fs::File::open(path).map_err(unreadable)?;
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)
            .map_err(|source| RegistryError::Database { path: path.to_path_buf(), source })?;
        let registry = Self { connection, path: path.to_path_buf() };
        registry.connection.busy_timeout(BUSY).map_err(|e| registry.failed(e))?;
        registry.check_schema()?;
        Ok(registry)
    }

    fn check_schema(&self) -> Result<(), RegistryError> {
        let not_a_registry =
            |problem: String| RegistryError::NotARegistry { path: self.path.clone(), problem };
        let tables = "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND \
                      name IN ('alembic_version', 'devices', 'calibrations', 'parameters')";
        let count = self.connection.query_row(tables, [], |row| row.get::<_, i64>(0));
        match count.map_err(|e| not_a_registry(e.to_string()))? {
            4 => {}
            _ => return Err(not_a_registry("it has no tables of devices and calibrations".to_owned())),
        }
        let version = "SELECT version_num FROM alembic_version";
        let found = self.connection.query_row(version, [], |row| row.get::<_, String>(0)).optional();
        let found = found.map_err(|e| self.failed(e))?.unwrap_or_default();
        if SCHEMAS.contains(&found.as_str()) {
            return Ok(());
        }
        Err(RegistryError::Schema { path: self.path.clone(), found, known: SCHEMAS })
    }

    pub(crate) fn failed(&self, source: rusqlite::Error) -> RegistryError {
        RegistryError::Database { path: self.path.clone(), source }
    }
}
