//! The exported crate builds without std from what was written alone and passes its own test.

use std::path::PathBuf;

use hysteron_export::{NamedFile, Precision, RUNTIME, rust_files, write_folder};
use hysteron_model::compensator::Prediction;

use crate::models::{self, PRECISIONS};
use crate::tools::{choices, run, workspace_of};

#[test]
fn every_kind_of_model_builds_and_passes_its_selftest() {
    let place = tempfile::tempdir().unwrap();
    // One workspace and one runtime, so that it is compiled once.
    let runtime = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../hysteron-rt").canonicalize().unwrap();
    let shared = format!("path = {runtime:?}");
    let (mut members, mut inverses) = (Vec::new(), 0);
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        for precision in choices(&PRECISIONS, k) {
            let has_inverse = models::invertible().iter().any(|(other, _)| *other == name);
            let name = format!("{name}_{}", precision.name());
            let inverse = has_inverse.then(|| models::inverse(&name, &model, precision, Prediction::Stays));
            inverses += usize::from(has_inverse);
            let subject = models::subject(&name, &model, precision);
            let mut files = own_files(rust_files(&subject, inverse.as_ref()).unwrap());
            let manifest = files.iter_mut().find(|f| f.name == "Cargo.toml").unwrap();
            let text = String::from_utf8(manifest.bytes.clone()).unwrap();
            let dependencies: Vec<&str> =
                text.lines().skip_while(|l| *l != "[dependencies]").take_while(|l| !l.is_empty()).collect();
            assert_eq!(dependencies.len(), 3, "{text}");
            let inside = text.replace("[workspace]", "").replace("path = \"runtime\"", &shared);
            assert_ne!(text, inside);
            manifest.bytes = inside.into_bytes();
            write_folder(&place.path().join(&name), &files).unwrap();
            members.push(format!("\"{name}\""));
        }
    }
    std::fs::write(place.path().join("Cargo.toml"), workspace_of(&members)).unwrap();
    let lock = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    std::fs::copy(lock, place.path().join("Cargo.lock")).unwrap();
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exported-crates");
    let target = target.to_str().unwrap();
    // The self-tests, and the examples of one: every crate's are the same, and take longer than its
    // self-tests.
    let tests = ["test", "--offline", "--workspace", "--test", "*", "--target-dir", target];
    let said = run(place.path(), env!("CARGO"), &tests);
    assert_eq!(said.matches("test golden_vectors ... ok").count(), members.len() + inverses, "{said}");
    let examples = ["test", "--offline", "--doc", "--package", "stage_f32", "--target-dir", target];
    let said = run(place.path(), env!("CARGO"), &examples);
    assert!(said.contains("test result: ok. 2 passed"), "{said}");
    // Without a warning, with those for documentation.
    let check = [
        "clippy",
        "--offline",
        "--workspace",
        "--target-dir",
        target,
        "--",
        "-D",
        "warnings",
        "-W",
        "missing-docs",
    ];
    run(place.path(), env!("CARGO"), &check);
}

/// Without the runtime.
fn own_files(mut files: Vec<NamedFile>) -> Vec<NamedFile> {
    files.retain(|file| !file.name.starts_with(RUNTIME));
    files
}

/// As it is written, in an empty folder, without a network.
#[test]
fn a_crate_builds_from_what_was_written_alone() {
    let place = tempfile::tempdir().unwrap();
    let (name, model) = models::invertible().swap_remove(0);
    let subject = models::subject(name, &model, Precision::F64);
    let inverse = models::inverse(name, &model, Precision::F64, Prediction::Stays);
    write_folder(place.path(), &rust_files(&subject, Some(&inverse)).unwrap()).unwrap();
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exported-crate");
    let tests = ["test", "--offline", "--target-dir", target.to_str().unwrap()];
    let said = run(place.path(), env!("CARGO"), &tests);
    assert_eq!(said.matches("test golden_vectors ... ok").count(), 2, "{said}");
}
