//! Every public data file reads as what its description says, or is refused for the right reason.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use hysteron_io::{ReadOptions, read_input_output, read_record};
use hysteron_model::record::{InputOutput, TimeBase};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Folder of the public data, if it is on this machine.
fn data() -> Option<PathBuf> {
    let folder =
        std::env::var_os("HYSTERON_DATA").map_or_else(|| repository().join("../shared/data"), PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    println!("skipped: no folder {}; set HYSTERON_DATA to the public data", folder.display());
    None
}

#[test]
fn the_shipped_record_reads_as_described() {
    let path = repository().join("examples/piezo-p885-200hz/identification_1hz.csv");
    let outcome = read_input_output(&path, &ReadOptions::default()).unwrap();
    let InputOutput { u, y, time, .. } = &outcome.data;
    assert_eq!(u.len(), 8027);
    assert!(
        matches!(time, TimeBase::Uniform { start_s: 0.0, sample_rate_hz: 200.0, jitter_samples }
            if *jitter_samples < 1e-9),
        "{time:?}"
    );
    assert_eq!((u[0], y[0], y[1]), (1.8, -123.059139, -120.154262));
    assert!(outcome.notes.is_empty(), "{:?}", outcome.notes);
}

/// What a file of the public data is expected to be.
enum Expected {
    /// Rows, sample rate \[Hz\], input and output.
    Uniform(Option<usize>, f64, &'static str, &'static str),
    /// Time stamps that are no grid.
    NonUniform(&'static str, &'static str),
    /// No time column.
    Untimed(usize, &'static str, &'static str),
    /// Readable, but the choice of channels is refused with this text.
    NoPair(&'static str),
    /// Refused with this text.
    Refused(&'static str),
}
use Expected::*;

/// Longest prefix of the path decides.
const EXPECTATIONS: &[(&str, Expected)] = &[
    ("boucwen-benchmark/train", Uniform(Some(40960), 750.0, "u", "y")),
    ("boucwen-benchmark/test_multisine", Uniform(Some(8192), 750.0, "u", "y")),
    ("boucwen-benchmark/test_sinesweep", Uniform(Some(153_000), 750.0, "u", "y")),
    ("fractional-proc/", Uniform(Some(1001), 20.0, "u", "y")),
    ("hasel-multifreq/", Uniform(None, 200.0, "u_cmd", "y")),
    ("piezo-fsm-multisine/train", NoPair("`u1` (V), `u2` (V), `u3` (V)")),
    ("piezo-fsm-multisine/frf", Refused("frequency response")),
    ("piezo-npxy100a-frf/", Refused("frequency response")),
    ("piezo-michelson-quasistatic/loop", NonUniform("u", "y")),
    ("piezo-michelson-quasistatic/points", NonUniform("u", "dy")),
    ("piezo-michelson-quasistatic/raw_fringe", NoPair("only one channel besides time, `photodiode` (V)")),
    ("piezo-michelson-quasistatic/raw_voltage", NoPair("only one channel besides time, `u` (V)")),
    ("piezo-p885-200hz/", Uniform(Some(8027), 200.0, "u", "y")),
    ("piezo-sine-1hz/", Uniform(Some(50001), 5000.0, "u", "y")),
    ("secondary-loops/butterfly", Untimed(401, "u", "y")),
    ("secondary-loops/steel_bh", Untimed(1000, "H", "B")),
];

#[test]
fn every_public_file_reads_or_is_refused_for_the_right_reason() {
    let Some(data) = data() else { return };
    let mut seen = 0;
    for folder in std::fs::read_dir(&data).unwrap().map(|f| f.unwrap().path()).filter(|f| f.is_dir()) {
        for file in std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().path()) {
            if file.extension().is_none_or(|e| e != "csv") {
                continue;
            }
            let name = file.strip_prefix(&data).unwrap().display().to_string();
            let expected = EXPECTATIONS
                .iter()
                .filter(|(prefix, _)| name.starts_with(prefix))
                .max_by_key(|(prefix, _)| prefix.len());
            let Some((_, expected)) = expected else {
                println!("skipped: nothing is said about {name}");
                continue;
            };
            let outcome = read_input_output(&file, &ReadOptions::default());
            seen += 1;
            match expected {
                Uniform(rows, rate, input, output) => {
                    let d = outcome.unwrap_or_else(|e| panic!("{name}: {e}")).data;
                    assert!(rows.is_none_or(|n| n == d.u.len()), "{name}: {} rows", d.u.len());
                    let hz = d.sample_rate_hz().unwrap_or_else(|| panic!("{name}: not uniform"));
                    assert!((hz / rate - 1.0).abs() < 1e-6, "{name}: {hz} Hz");
                    assert_eq!((d.input.as_str(), d.output.as_str()), (*input, *output), "{name}");
                }
                NonUniform(input, output) => {
                    let d = outcome.unwrap_or_else(|e| panic!("{name}: {e}")).data;
                    assert!(matches!(d.time, TimeBase::NonUniform { .. }), "{name}: {:?}", d.time);
                    assert_eq!((d.input.as_str(), d.output.as_str()), (*input, *output), "{name}");
                }
                Untimed(rows, input, output) => {
                    let d = outcome.unwrap_or_else(|e| panic!("{name}: {e}")).data;
                    assert_eq!((d.u.len(), &d.time), (*rows, &TimeBase::Unknown), "{name}");
                    assert_eq!((d.input.as_str(), d.output.as_str()), (*input, *output), "{name}");
                }
                NoPair(text) => {
                    assert!(read_record(&file, &ReadOptions::default()).is_ok(), "{name}");
                    let message = outcome.unwrap_err().to_string();
                    assert!(message.contains(text), "{name}: {message}");
                }
                Refused(text) => {
                    let message = outcome.unwrap_err().to_string();
                    assert!(message.contains(text) && message.contains("line 1"), "{name}: {message}");
                }
            }
        }
    }
    assert!(seen > 0, "no CSV file below {}", data.display());
}
