//! A registry as Python writes it, in the columns that are read here.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use std::path::Path;

use hysteron_registry::{Registry, RegistryError};
use rusqlite::{Connection, params};

const TABLES: &str = "
    CREATE TABLE alembic_version (version_num VARCHAR(32) NOT NULL);
    CREATE TABLE devices (id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE, serial TEXT NOT NULL DEFAULT '');
    CREATE TABLE calibrations (
        id INTEGER PRIMARY KEY, device_id INTEGER NOT NULL, key VARCHAR(64) NOT NULL, record_sha256 VARCHAR(64),
        paths TEXT NOT NULL, date VARCHAR(32) NOT NULL, operator TEXT NOT NULL DEFAULT '',
        notes TEXT NOT NULL DEFAULT '', program TEXT NOT NULL, options TEXT NOT NULL, status VARCHAR(8) NOT NULL,
        reason TEXT NOT NULL DEFAULT '', kind TEXT, model TEXT, scores TEXT NOT NULL DEFAULT '[]',
        findings TEXT NOT NULL DEFAULT '[]', rmse DOUBLE, fit_percent DOUBLE, input_unit TEXT NOT NULL DEFAULT '',
        unit TEXT NOT NULL DEFAULT '', seconds DOUBLE, finished VARCHAR(32) NOT NULL, report TEXT NOT NULL DEFAULT ''
    );
    CREATE TABLE parameters (
        calibration_id INTEGER NOT NULL, position INTEGER NOT NULL, block TEXT NOT NULL, name TEXT NOT NULL,
        value DOUBLE, std_error DOUBLE, unit TEXT NOT NULL, held BOOLEAN NOT NULL
    );
    INSERT INTO devices (id, name) VALUES (1, 'A'), (2, 'B');
";

/// Two devices: A failed after a calibration that succeeded, B failed.
fn registry(folder: &Path, schema: &str) -> std::path::PathBuf {
    let path = folder.join("fleet.sqlite");
    let connection = Connection::open(&path).unwrap();
    connection.execute_batch(TABLES).unwrap();
    connection.execute("INSERT INTO alembic_version VALUES (?1)", [schema]).unwrap();
    let insert = "INSERT INTO calibrations (device_id, key, paths, date, program, options, status, model, rmse, \
                  finished) VALUES (?1, ?2, '[\"a.csv\"]', ?3, 'p', '{}', ?4, ?5, ?6, '')";
    for (device, key, date, status, model, rmse) in [
        (1, "k2", "2026-02-01", "failed", None, None),
        (1, "k1", "2026-01-01", "ok", Some("no model file"), Some(0.25)),
        (2, "k3", "2026-01-01", "failed", None, None),
    ] {
        connection.execute(insert, params![device, key, date, status, model, rmse]).unwrap();
    }
    let insert = "INSERT INTO parameters VALUES (2, ?1, 'hysteresis', ?2, ?3, NULL, 'um/V', 0)";
    connection.execute(insert, params![1, "second", 2.0]).unwrap();
    connection.execute(insert, params![0, "first", None::<f64>]).unwrap();
    path
}

#[test]
fn every_device_is_listed_once_with_its_latest_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let registry = Registry::open(&registry(folder.path(), "0001")).unwrap();
    let devices = registry.devices().unwrap();
    let seen: Vec<_> =
        devices.iter().map(|d| (d.device.as_str(), d.calibrations, d.latest.key.as_str())).collect();
    assert_eq!(seen, [("A", 2, "k2"), ("B", 1, "k3")]);
    let history = registry.history("A").unwrap();
    assert_eq!(history.iter().map(|c| c.rmse).collect::<Vec<_>>(), [Some(0.25), None]);
    assert_eq!(history[0].paths, serde_json::json!(["a.csv"]));
    let parameters = registry.parameters(&history[0]).unwrap();
    let seen: Vec<_> = parameters.iter().map(|p| (p.name.as_str(), p.value)).collect();
    assert_eq!(seen, [("first", None), ("second", Some(2.0))]);
}

#[test]
fn models_are_those_of_calibrations_that_succeeded() {
    let folder = tempfile::tempdir().unwrap();
    let registry = Registry::open(&registry(folder.path(), "0002")).unwrap();
    assert_eq!(registry.devices_with_model().unwrap(), ["A"]);
    assert_eq!(registry.model_text("A", 0).unwrap(), "no model file");
    assert!(matches!(registry.model("A", 0), Err(RegistryError::Model { .. })));
    assert!(matches!(registry.model_text("A", 1), Err(RegistryError::NoModel { found: 1, asked: 2, .. })));
    assert!(matches!(registry.model_text("B", 0), Err(RegistryError::NoModel { found: 0, asked: 1, .. })));
    let missing = registry.history("a'; DROP TABLE devices; --").unwrap_err();
    assert!(matches!(missing, RegistryError::NoDevice { .. }), "{missing}");
    assert_eq!(registry.devices().unwrap().len(), 2);
}

#[test]
fn a_schema_of_a_newer_version_is_refused_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let refused = Registry::open(&registry(folder.path(), "0099")).unwrap_err().to_string();
    assert!(refused.contains("has schema 0099: this version reads schemas 0001, 0002"), "{refused}");
}

#[test]
fn every_schema_of_the_python_package_is_known() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let versions = here.join("../../python/hysteron_models/fleet/migrations/versions");
    let mut seen = 0;
    for entry in std::fs::read_dir(versions).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "py") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let revision = text.split("\nrevision = \"").nth(1).unwrap().split('"').next().unwrap();
        let folder = tempfile::tempdir().unwrap();
        Registry::open(&registry(folder.path(), revision)).unwrap();
        seen += 1;
    }
    assert_eq!(seen, 2);
}
