//! The workspace's history: one SQLite file with settings, jobs, what fits found, commands and the trash.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rusqlite::{Connection, OptionalExtension, params};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::api::{Command, Job, RecordSettings, Role, Trashed};
use crate::error::AppError;
use crate::refused::Answer;

/// Version of the tables below.
const VERSION: i64 = 1;
/// Time to wait for another program that writes the file.
const BUSY: Duration = Duration::from_secs(2);

/// Rows are JSON of the API's own types: what is shown is what is kept.
const TABLES: &str = "
    CREATE TABLE IF NOT EXISTS settings (record TEXT PRIMARY KEY, settings TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS seen (record TEXT PRIMARY KEY, stamp TEXT NOT NULL, entry TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, job TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS fits (model TEXT PRIMARY KEY, sha256 TEXT NOT NULL, found TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS actions (id INTEGER PRIMARY KEY AUTOINCREMENT, command TEXT NOT NULL);
    CREATE TABLE IF NOT EXISTS trash (
        token TEXT PRIMARY KEY, id TEXT NOT NULL, deleted TEXT NOT NULL, settings TEXT
    );
";

const SETTINGS: &str = "SELECT settings FROM settings WHERE record = ?1";
const KEEP_SETTINGS: &str = "INSERT INTO settings VALUES (?1, ?2) ON CONFLICT DO UPDATE SET settings = ?2";

/// The open history.
pub(crate) struct History(Mutex<Connection>);

impl History {
    /// Opens the file, which is made where it is missing, for this program alone.
    ///
    /// # Errors
    /// If it is no such file, cannot be written, a newer program wrote it, or another program has it open.
    pub(crate) fn open(path: &Path) -> Result<Self, AppError> {
        let connection = Connection::open(path)?;
        connection.busy_timeout(BUSY)?;
        // One server a folder: another would take its running jobs for interrupted ones.
        connection.pragma_update(None, "locking_mode", "EXCLUSIVE")?;
        let version: i64 = connection.pragma_query_value(None, "user_version", |row| row.get(0))?;
        if version > VERSION {
            return Err(AppError::NewerHistory { version, known: VERSION });
        }
        connection.execute_batch(TABLES)?;
        connection.pragma_update(None, "user_version", VERSION)?;
        Ok(Self(Mutex::new(connection)))
    }

    fn connection(&self) -> MutexGuard<'_, Connection> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn one<T: DeserializeOwned>(
        &self,
        query: &str,
        keys: impl rusqlite::Params,
    ) -> rusqlite::Result<Option<T>> {
        one(&self.connection(), query, keys)
    }

    fn all<T: DeserializeOwned>(&self, query: &str) -> rusqlite::Result<Vec<T>> {
        let connection = self.connection();
        let mut statement = connection.prepare(query)?;
        let rows = statement.query_map([], |row| row.get::<_, String>(0))?;
        let rows = rows.collect::<rusqlite::Result<Vec<_>>>()?;
        Ok(rows.iter().filter_map(|text| serde_json::from_str(text).ok()).collect())
    }

    /// Settings of a record; the default ones where none were made.
    pub(crate) fn settings(&self, record: &str) -> rusqlite::Result<RecordSettings> {
        Ok(self.one(SETTINGS, [record])?.unwrap_or_default())
    }

    /// Forgets the settings of a record.
    pub(crate) fn forget_settings(&self, record: &str) -> rusqlite::Result<()> {
        self.connection().execute("DELETE FROM settings WHERE record = ?1", [record])?;
        Ok(())
    }

    /// Changes the settings of a record in one step, so that no change of another page is lost.
    pub(crate) fn change_settings(
        &self,
        record: &str,
        change: impl FnOnce(RecordSettings) -> Answer<RecordSettings>,
    ) -> Answer<()> {
        let mut connection = self.connection();
        let both = connection.transaction()?;
        let before = one(&both, SETTINGS, [record])?.unwrap_or_default();
        both.execute(KEEP_SETTINGS, params![record, json(&change(before)?)?])?;
        Ok(both.commit()?)
    }

    /// Keeps the settings of a record.
    pub(crate) fn keep_settings(&self, record: &str, settings: &RecordSettings) -> rusqlite::Result<()> {
        self.connection().execute(KEEP_SETTINGS, params![record, json(settings)?])?;
        Ok(())
    }

    /// Says the role of a record that was written, and nothing else of it.
    pub(crate) fn say_role(&self, record: &str, role: Role) -> rusqlite::Result<()> {
        self.keep_settings(record, &RecordSettings { role, ..RecordSettings::default() })
    }

    /// What was found in a record when its file and its settings had this stamp.
    pub(crate) fn seen<T: DeserializeOwned>(&self, record: &str, stamp: &str) -> rusqlite::Result<Option<T>> {
        self.one("SELECT entry FROM seen WHERE record = ?1 AND stamp = ?2", [record, stamp])
    }

    /// Keeps what was found in a record.
    pub(crate) fn keep_seen(
        &self,
        record: &str,
        stamp: &str,
        entry: &impl Serialize,
    ) -> rusqlite::Result<()> {
        let query = "INSERT INTO seen VALUES (?1, ?2, ?3) ON CONFLICT DO UPDATE SET stamp = ?2, entry = ?3";
        self.connection().execute(query, params![record, stamp, json(entry)?])?;
        Ok(())
    }

    /// All jobs, oldest first.
    pub(crate) fn jobs(&self) -> rusqlite::Result<Vec<Job>> {
        self.all("SELECT job FROM jobs ORDER BY id")
    }

    /// Adds a job and returns its number.
    pub(crate) fn add_job(&self, job: &Job) -> rusqlite::Result<i64> {
        let mut connection = self.connection();
        let both = connection.transaction()?;
        both.execute("INSERT INTO jobs (job) VALUES (?1)", params![json(job)?])?;
        let id = both.last_insert_rowid();
        let numbered = Job { id, ..job.clone() };
        both.execute("UPDATE jobs SET job = ?2 WHERE id = ?1", params![id, json(&numbered)?])?;
        both.commit()?;
        Ok(id)
    }

    /// Keeps the state of a job.
    pub(crate) fn keep_job(&self, job: &Job) -> rusqlite::Result<()> {
        self.connection().execute("UPDATE jobs SET job = ?2 WHERE id = ?1", params![job.id, json(job)?])?;
        Ok(())
    }

    /// Deletes a job.
    pub(crate) fn delete_job(&self, id: i64) -> rusqlite::Result<()> {
        self.connection().execute("DELETE FROM jobs WHERE id = ?1", [id])?;
        Ok(())
    }

    /// What the fit of a model found, if the file is still that of the fit.
    pub(crate) fn fit<T: DeserializeOwned>(&self, model: &str, sha256: &str) -> rusqlite::Result<Option<T>> {
        self.one("SELECT found FROM fits WHERE model = ?1 AND sha256 = ?2", [model, sha256])
    }

    /// Keeps what the fit of a model found.
    pub(crate) fn keep_fit(&self, model: &str, sha256: &str, found: &impl Serialize) -> rusqlite::Result<()> {
        let query = "INSERT INTO fits VALUES (?1, ?2, ?3) ON CONFLICT DO UPDATE SET sha256 = ?2, found = ?3";
        self.connection().execute(query, params![model, sha256, json(found)?])?;
        Ok(())
    }

    /// A file has another name: its settings and findings go with it.
    pub(crate) fn renamed(&self, old: &str, new: &str) -> rusqlite::Result<()> {
        let mut connection = self.connection();
        let both = connection.transaction()?;
        both.execute("UPDATE OR REPLACE fits SET model = ?2 WHERE model = ?1", [old, new])?;
        both.execute("UPDATE OR REPLACE settings SET record = ?2 WHERE record = ?1", [old, new])?;
        both.commit()
    }

    /// Adds a command to what was done; one that was just done is not added again.
    pub(crate) fn add_action(&self, command: &Command) -> rusqlite::Result<()> {
        let text = json(command)?;
        let connection = self.connection();
        let query = "SELECT command FROM actions ORDER BY id DESC LIMIT 1";
        let last: Option<String> = connection.query_row(query, [], |row| row.get(0)).optional()?;
        if last.as_ref() != Some(&text) {
            connection.execute("INSERT INTO actions (command) VALUES (?1)", [text])?;
        }
        Ok(())
    }

    /// What was done, oldest first.
    pub(crate) fn actions(&self) -> rusqlite::Result<Vec<Command>> {
        self.all("SELECT command FROM actions ORDER BY id")
    }

    /// Adds a deleted file. Its settings go with it: another file of its name begins with none.
    pub(crate) fn add_trash(&self, trashed: &Trashed) -> rusqlite::Result<()> {
        let Trashed { token, id, deleted } = trashed;
        let mut connection = self.connection();
        let both = connection.transaction()?;
        let query = "INSERT INTO trash SELECT ?1, ?2, ?3, \
                     (SELECT settings FROM settings WHERE record = ?2)";
        both.execute(query, [token, id, deleted])?;
        both.execute("DELETE FROM settings WHERE record = ?1", [id])?;
        both.commit()
    }

    /// Deleted files, newest first.
    pub(crate) fn trash(&self) -> rusqlite::Result<Vec<Trashed>> {
        let connection = self.connection();
        let query = "SELECT token, id, deleted FROM trash ORDER BY rowid DESC";
        let mut statement = connection.prepare(query)?;
        let row = |row: &rusqlite::Row<'_>| {
            Ok(Trashed { token: row.get(0)?, id: row.get(1)?, deleted: row.get(2)? })
        };
        statement.query_map([], row)?.collect()
    }

    /// Forgets a deleted file that is restored; its settings hold again.
    pub(crate) fn forget_trash(&self, token: &str) -> rusqlite::Result<()> {
        let mut connection = self.connection();
        let both = connection.transaction()?;
        let query = "INSERT OR REPLACE INTO settings \
                     SELECT id, settings FROM trash WHERE token = ?1 AND settings IS NOT NULL";
        both.execute(query, [token])?;
        both.execute("DELETE FROM trash WHERE token = ?1", [token])?;
        both.commit()
    }
}

/// What the first row holds as JSON; a row that an older program wrote differently counts as missing.
fn one<T: DeserializeOwned>(
    connection: &Connection,
    query: &str,
    keys: impl rusqlite::Params,
) -> rusqlite::Result<Option<T>> {
    let found: Option<String> = connection.query_row(query, keys, |row| row.get(0)).optional()?;
    Ok(found.and_then(|text| serde_json::from_str(&text).ok()))
}

fn json(value: &impl Serialize) -> rusqlite::Result<String> {
    serde_json::to_string(value).map_err(|e| rusqlite::Error::ToSqlConversionFailure(Box::new(e)))
}
