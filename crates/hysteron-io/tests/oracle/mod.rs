//! Files that other programs write, and the numbers that those programs read from them.
//!
//! A script of this folder writes the files into a temporary one. It runs under the interpreter
//! `HYSTERON_PYTHON`, else `python3`; where that lacks a package, the test says so and is skipped.
#![allow(clippy::unwrap_used, clippy::print_stderr, dead_code)]

use std::path::{Path, PathBuf};
use std::process::Command;

use hysteron_io::{Content, IoError, ReadOptions, contents, read_record};
use hysteron_model::record::{TimeBase, Unit};
use serde::Deserialize;
use tempfile::TempDir;

/// Exit code of a script whose packages are missing.
const SKIPPED: i32 = 77;

/// A file and the columns expected in it.
#[derive(Deserialize)]
pub struct Case {
    pub file: PathBuf,
    pub columns: Vec<ExpectedColumn>,
    /// Paths of columns that hold something else than numbers.
    #[serde(default)]
    pub refused: Vec<String>,
}

#[derive(Deserialize)]
pub struct ExpectedColumn {
    pub path: String,
    pub unit: Option<String>,
    pub sample_rate_hz: Option<f64>,
    /// Bits of its doubles.
    pub bits: Vec<u64>,
}

/// Runs a script; the folder lives as long as the value.
pub fn written_by(script: &str) -> Option<(TempDir, Vec<Case>)> {
    let folder = tempfile::tempdir().unwrap();
    let python = std::env::var("HYSTERON_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle").join(script);
    let run = Command::new(&python).arg("-B").arg(&script).arg(folder.path()).output();
    let output = match run {
        Ok(output) if output.status.code() != Some(SKIPPED) => output,
        other => {
            let why =
                other.map_or_else(|e| e.to_string(), |o| String::from_utf8_lossy(&o.stderr).into_owned());
            eprintln!("skipped: {} under `{python}`: {why}", script.display());
            return None;
        }
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let expected = std::fs::read(folder.path().join("expected.json")).unwrap();
    let mut cases: Vec<Case> = serde_json::from_slice(&expected).unwrap();
    cases.iter_mut().for_each(|case| case.file = folder.path().join(&case.file));
    Some((folder, cases))
}

/// Reads each column of each file, as input of a record, and compares its bits, its unit and its rate.
/// Returns how many columns there were.
pub fn compare(cases: &[Case]) -> usize {
    for case in cases {
        let file = case.file.display();
        let held = contents(&case.file, &ReadOptions::default()).unwrap();
        for expected in &case.columns {
            let path = &expected.path;
            assert!(held.iter().any(|content| content.path == *path), "{file}: no {path} in {held:?}");
            let options = ReadOptions { input: Some(path.clone()), ..ReadOptions::default() };
            let record = read_record(&case.file, &options).unwrap();
            let expected_values: Vec<f64> = expected.bits.iter().map(|&bits| f64::from_bits(bits)).collect();
            let is_there = record.channels.iter().any(|channel| {
                channel.samples.len() == expected_values.len()
                    && channel.samples.iter().zip(&expected.bits).all(|(own, bits)| own.to_bits() == *bits)
                    && expected.unit.as_deref().is_none_or(|unit| channel.unit == Unit::new(unit))
            });
            let first = |values: &[f64]| (values.len(), values.first().copied(), values.last().copied());
            let read = || record.channels.iter().map(|c| (c.header(), first(&c.samples))).collect::<Vec<_>>();
            assert!(is_there, "{file}, {path}: {:?} not in {:?}", first(&expected_values), read());
            if let (Some(hz), TimeBase::Uniform { sample_rate_hz, .. }) =
                (expected.sample_rate_hz, &record.time)
            {
                assert_eq!(hz, *sample_rate_hz, "{file}, {path}");
            }
        }
    }
    cases.iter().for_each(|case| refused(case, &contents(&case.file, &ReadOptions::default()).unwrap()));
    cases.iter().map(|case| case.columns.len()).sum()
}

/// The columns that hold no numbers are listed as something else, and are refused where they are chosen.
fn refused(case: &Case, held: &[Content]) {
    for path in &case.refused {
        let listed = held.iter().find(|content| content.path == *path).map(|content| content.kind.as_str());
        assert!(listed.is_some_and(|kind| kind != "numbers"), "{}: {path} in {held:?}", case.file.display());
        let options = ReadOptions { input: Some(path.clone()), ..ReadOptions::default() };
        let refusal = read_record(&case.file, &options).unwrap_err();
        assert!(matches!(refusal, IoError::ArrayType { .. }), "{refusal}");
    }
}
