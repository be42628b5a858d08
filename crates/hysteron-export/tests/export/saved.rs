//! A run that is interrupted, saved, and restored in a fresh process gives the bits of the uninterrupted one;
//! a state of another export, or a damaged one, is refused.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use hysteron_export::{
    Golden, GoldenInverse, NamedFile, Precision, axes_files, axes_inverse_files, c_files, inverse_files,
    write_folder,
};
use hysteron_model::compensator::Prediction;

use crate::axes;
use crate::models::{self, PRECISIONS};
use crate::tools::{STRICT, c_compilers, choices, run};

/// Exit code of the driver where the state was refused.
const REFUSED: Option<i32> = Some(3);

fn played(folder: &Path, arguments: &[&str], samples: &[f64]) -> Output {
    let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_ne_bytes()).collect();
    let mut child = Command::new("./driver")
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

/// Plays samples whole and in two processes; `foreign` is a saved state of another export.
fn judge(folder: &Path, name: &str, files: &[NamedFile], samples: &[f64], own: &[&str]) -> Vec<u8> {
    write_folder(folder, files).unwrap();
    let [stage, screaming] = [name.to_owned(), name.to_ascii_uppercase()];
    let driver = include_str!("saved_driver.c")
        .replace("MODEL.h", &format!("{stage}.h"))
        .replace("MODEL_SAVED_BYTES", &format!("{screaming}_SAVED_BYTES"))
        .replace("MODEL_OK", &format!("{screaming}_OK"))
        .replace("MODEL_", &format!("{stage}_"));
    std::fs::write(folder.join("driver.c"), driver).unwrap();
    let source = format!("{name}.c");
    let compiler = c_compilers().first().copied().unwrap_or("cc");
    run(
        folder,
        compiler,
        &[&STRICT[..5], own, &["-O1", &source, "driver.c", "-o", "driver", "-lm"]].concat(),
    );
    let whole = played(folder, &["whole"], samples);
    assert!(whole.status.success() && !whole.stdout.is_empty(), "{name}: {}", whole.status);
    let first = played(folder, &["first", "state"], samples);
    let second = played(folder, &["second", "state"], samples);
    assert!(first.status.success() && second.status.success(), "{name}: {} {}", first.status, second.status);
    assert!([first.stdout, second.stdout].concat() == whole.stdout, "{name}: other bits after a reset");
    let saved = std::fs::read(folder.join("state")).unwrap();
    for (k, bit) in [(0, 1), (5, 0x80), (saved.len() / 2, 4), (saved.len() - 1, 1)] {
        let mut damaged = saved.clone();
        damaged[k] ^= bit;
        std::fs::write(folder.join("damaged"), damaged).unwrap();
        assert_eq!(played(folder, &["second", "damaged"], samples).status.code(), REFUSED, "{name}: {k}");
    }
    // Written half, the rest being what was there before.
    let torn = [&saved[..saved.len() / 2], &vec![0xff; saved.len() - saved.len() / 2]].concat();
    std::fs::write(folder.join("torn"), torn).unwrap();
    assert_eq!(played(folder, &["second", "torn"], samples).status.code(), REFUSED, "{name}");
    saved
}

/// That the driver of the last export refuses a state of another one.
fn refuses(folder: &Path, foreign: &[u8], samples: &[f64]) {
    std::fs::write(folder.join("foreign"), foreign).unwrap();
    assert_eq!(played(folder, &["second", "foreign"], samples).status.code(), REFUSED, "{folder:?}");
}

#[test]
fn a_model_restored_in_a_fresh_process_goes_on_with_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let mut foreign: Option<Vec<u8>> = None;
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        for precision in choices(&PRECISIONS, k) {
            let subject = models::subject(name, &model, precision);
            let golden = Golden::new(&subject).unwrap();
            let folder = place.path().join(format!("{name}_{}", precision.name()));
            let saved = judge(&folder, name, &c_files(&subject).unwrap(), &golden.voltages, &[]);
            if let Some(foreign) = foreign.replace(saved) {
                refuses(&folder, &foreign, &golden.voltages);
            }
        }
    }
}

#[test]
fn an_inverse_restored_in_a_fresh_process_goes_on_with_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let mut foreign: Option<Vec<u8>> = None;
    for (k, (name, model)) in models::invertible().into_iter().enumerate() {
        for precision in choices(&PRECISIONS, k) {
            let inverse = models::inverse(name, &model, precision, Prediction::Stays);
            let golden = GoldenInverse::new(&inverse).unwrap();
            let folder = place.path().join(format!("{name}_{}", precision.name()));
            let (name, files) = (format!("{name}_inverse"), inverse_files(&inverse).unwrap());
            let saved = judge(&folder, &name, &files, &golden.references, &[]);
            if let Some(foreign) = foreign.replace(saved) {
                refuses(&folder, &foreign, &golden.references);
            }
        }
    }
}

#[test]
fn several_axes_restored_in_a_fresh_process_go_on_with_the_same_bits() {
    let place = tempfile::tempdir().unwrap();
    let own = ["-DAXES", "-DAXES_GIVEN=2", "-DAXES_FOUND=2"];
    let samples: Vec<f64> = (0..1200).map(|k| 0.4 * (0.05 * f64::from(k)).sin()).collect();
    for (name, subject) in axes::subjects() {
        for (name, files) in [
            (name.to_owned(), axes_files(&subject).unwrap()),
            (format!("{name}_inverse"), axes_inverse_files(&subject).unwrap()),
        ] {
            judge(&place.path().join(&name), &name, &files, &samples, &own);
        }
    }
}

/// The same model with another number, at another rate and of another file: its states are refused.
#[test]
fn a_state_of_another_version_of_the_model_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let subject = models::subject("stage", &models::stage(), Precision::F64);
    let golden = Golden::new(&subject).unwrap();
    let original = place.path().join("original");
    let saved = judge(&original, "stage", &c_files(&subject).unwrap(), &golden.voltages, &[]);
    let mut renewed = subject.clone();
    renewed.origin.date = Some("2030-01-01".into());
    let mut other_file = subject.clone();
    other_file.origin.model_sha256 = "0".repeat(64);
    let mut other_offset = subject.clone();
    other_offset.realisation.model.offset += 1e-9;
    for (name, subject, is_own) in
        [("renewed", &renewed, true), ("file", &other_file, false), ("offset", &other_offset, false)]
    {
        let folder = place.path().join(name);
        judge(&folder, "stage", &c_files(subject).unwrap(), &golden.voltages, &[]);
        if is_own {
            std::fs::write(folder.join("foreign"), &saved).unwrap();
            assert!(played(&folder, &["second", "foreign"], &golden.voltages).status.success());
        } else {
            refuses(&folder, &saved, &golden.voltages);
        }
    }
}
