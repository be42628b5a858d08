//! Devices and calibrations of a registry. Texts come from other programs and are data: nothing of them is part
//! of a query.

use hysteron_model::Model;
use rusqlite::Row;
use serde::Serialize;
use serde_json::Value;

use crate::error::RegistryError;
use crate::open::Registry;

/// Names that the message about an unknown device proposes, at most.
const PROPOSED: usize = 5;

/// A device with its latest calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceEntry {
    /// Name.
    pub device: String,
    /// Serial number; may be empty.
    pub serial: String,
    /// Number of calibrations.
    pub calibrations: usize,
    /// The latest one, by date.
    #[serde(flatten)]
    pub latest: Calibration,
}

/// A calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// SHA-256 of record, options and program.
    pub key: String,
    /// SHA-256 of the record; `None` for one that could not be read.
    pub record_sha256: Option<String>,
    /// Files of the record.
    pub paths: Value,
    /// Date of the record, ISO 8601.
    pub date: String,
    /// Operator.
    pub operator: String,
    /// The operator's notes.
    pub notes: String,
    /// Program and version.
    pub program: String,
    /// Estimator and its options.
    pub options: Value,
    /// `ok` or `failed`.
    pub status: String,
    /// Why it failed; may be empty.
    pub reason: String,
    /// Kind of model.
    pub kind: Option<String>,
    /// Root mean square of the residual, in `unit`.
    pub rmse: Option<f64>,
    /// Fit \[%\].
    pub fit_percent: Option<f64>,
    /// Unit of the output.
    pub unit: String,
    /// Time of the fit \[s\].
    pub seconds: Option<f64>,
    /// When it was finished, ISO 8601.
    pub finished: String,
    /// Path of its report; may be empty.
    pub report: String,
    /// Scores of each record.
    pub scores: Value,
    /// Verdicts, advice and warnings.
    pub findings: Value,
    #[serde(skip)]
    id: i64,
}

/// A parameter of a calibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Block of the model.
    pub block: String,
    /// Name.
    pub name: String,
    /// Value.
    pub value: Option<f64>,
    /// Standard error, if known.
    pub std_error: Option<f64>,
    /// Unit.
    pub unit: String,
    /// Held at its value, not fitted.
    pub held: bool,
}

const COLUMNS: &str = "c.id, c.key, c.record_sha256, c.paths, c.date, c.operator, c.notes, c.program, c.options, \
    c.status, c.reason, c.kind, c.rmse, c.fit_percent, c.unit, c.seconds, c.finished, c.report, c.scores, \
    c.findings, d.name";

impl Registry {
    /// All devices by name, each with its latest calibration.
    ///
    /// # Errors
    /// [`RegistryError`] of the database.
    pub fn devices(&self) -> Result<Vec<DeviceEntry>, RegistryError> {
        let query = format!(
            "SELECT {COLUMNS}, d.serial, n.count FROM devices d \
             JOIN (SELECT device_id, count(*) AS count FROM calibrations GROUP BY device_id) n \
               ON n.device_id = d.id \
             JOIN calibrations c ON c.id = (SELECT l.id FROM calibrations l WHERE l.device_id = d.id \
               ORDER BY l.date DESC, l.id DESC LIMIT 1) ORDER BY d.name"
        );
        let mut statement = self.connection.prepare(&query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map([], |row| {
            let count = row.get::<_, i64>(22)?;
            let calibrations = usize::try_from(count).unwrap_or_default();
            Ok(DeviceEntry {
                device: row.get(20)?,
                serial: row.get(21)?,
                calibrations,
                latest: calibration(row)?,
            })
        });
        rows.and_then(Iterator::collect).map_err(|e| self.failed(e))
    }

    /// Names of the devices that have a model.
    ///
    /// # Errors
    /// [`RegistryError`] of the database.
    pub fn devices_with_model(&self) -> Result<Vec<String>, RegistryError> {
        let query = "SELECT d.name FROM devices d WHERE EXISTS (SELECT 1 FROM calibrations c \
                     WHERE c.device_id = d.id AND c.status = 'ok' AND c.model IS NOT NULL) ORDER BY d.name";
        let mut statement = self.connection.prepare(query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map([], |row| row.get(0));
        rows.and_then(Iterator::collect).map_err(|e| self.failed(e))
    }

    /// Calibrations of a device by date, the latest last.
    ///
    /// # Errors
    /// [`RegistryError::NoDevice`] where there is none.
    pub fn history(&self, device: &str) -> Result<Vec<Calibration>, RegistryError> {
        let query = format!(
            "SELECT {COLUMNS} FROM calibrations c JOIN devices d ON d.id = c.device_id WHERE d.name = ?1 \
             ORDER BY c.date, c.id"
        );
        let mut statement = self.connection.prepare(&query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map([device], calibration);
        let found: Vec<_> = rows.and_then(Iterator::collect).map_err(|e| self.failed(e))?;
        if found.is_empty() {
            return Err(RegistryError::NoDevice {
                device: device.to_owned(),
                names: self.names_like(device)?,
            });
        }
        Ok(found)
    }

    /// Parameters of a calibration in the order of the model.
    ///
    /// # Errors
    /// [`RegistryError`] of the database.
    pub fn parameters(&self, of: &Calibration) -> Result<Vec<Parameter>, RegistryError> {
        let query = "SELECT block, name, value, std_error, unit, held FROM parameters \
                     WHERE calibration_id = ?1 ORDER BY position";
        let mut statement = self.connection.prepare(query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map([of.id], |row| {
            Ok(Parameter {
                block: row.get(0)?,
                name: row.get(1)?,
                value: row.get(2)?,
                std_error: row.get(3)?,
                unit: row.get(4)?,
                held: row.get(5)?,
            })
        });
        rows.and_then(Iterator::collect).map_err(|e| self.failed(e))
    }

    /// The `back`-th model of a device before its latest one.
    ///
    /// # Errors
    /// [`RegistryError::NoDevice`], [`RegistryError::NoModel`], or a model that is no model file.
    pub fn model(&self, device: &str, back: usize) -> Result<Model, RegistryError> {
        let text = self.model_text(device, back)?;
        let model = Model::from_json(text.as_bytes());
        model.map_err(|source| RegistryError::Model { device: device.to_owned(), source })
    }

    /// [`Registry::model`] as the text of its model file.
    ///
    /// # Errors
    /// [`RegistryError::NoDevice`], [`RegistryError::NoModel`].
    pub fn model_text(&self, device: &str, back: usize) -> Result<String, RegistryError> {
        let query = "SELECT c.model FROM calibrations c JOIN devices d ON d.id = c.device_id \
                     WHERE d.name = ?1 AND c.status = 'ok' AND c.model IS NOT NULL \
                     ORDER BY c.date DESC, c.id DESC";
        let mut statement = self.connection.prepare(query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map([device], |row| row.get::<_, String>(0));
        let mut found: Vec<String> = rows.and_then(Iterator::collect).map_err(|e| self.failed(e))?;
        if back < found.len() {
            return Ok(found.swap_remove(back));
        }
        self.history(device)?;
        Err(RegistryError::NoModel { device: device.to_owned(), found: found.len(), asked: back + 1 })
    }

    fn names_like(&self, name: &str) -> Result<Vec<String>, RegistryError> {
        let query = "SELECT name FROM devices WHERE instr(lower(name), lower(?1)) > 0 OR \
                     substr(lower(name), 1, 3) = substr(lower(?1), 1, 3) ORDER BY name LIMIT ?2";
        let mut statement = self.connection.prepare(query).map_err(|e| self.failed(e))?;
        let rows = statement.query_map(rusqlite::params![name, PROPOSED as i64], |row| row.get(0));
        rows.and_then(Iterator::collect).map_err(|e| self.failed(e))
    }
}

fn calibration(row: &Row<'_>) -> rusqlite::Result<Calibration> {
    let json = |column: usize| -> rusqlite::Result<Value> {
        let text: String = row.get(column)?;
        // A text that another program wrote differently is shown as it is.
        Ok(serde_json::from_str(&text).unwrap_or(Value::String(text)))
    };
    Ok(Calibration {
        id: row.get(0)?,
        key: row.get(1)?,
        record_sha256: row.get(2)?,
        paths: json(3)?,
        date: row.get(4)?,
        operator: row.get(5)?,
        notes: row.get(6)?,
        program: row.get(7)?,
        options: json(8)?,
        status: row.get(9)?,
        reason: row.get(10)?,
        kind: row.get(11)?,
        rmse: row.get(12)?,
        fit_percent: row.get(13)?,
        unit: row.get(14)?,
        seconds: row.get(15)?,
        finished: row.get(16)?,
        report: row.get(17)?,
        scores: json(18)?,
        findings: json(19)?,
    })
}
