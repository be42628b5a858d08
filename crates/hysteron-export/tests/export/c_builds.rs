//! The C source compiles without a word and passes its own test, under both compilers and under sanitizers.

use std::ops::Range;
use std::path::Path;
use std::process::Command;

use hysteron_export::{ExportError, Golden, NamedFile, Precision, c_files, write_folder};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};

use crate::models::{self, PRECISIONS};
use crate::tools::{STRICT, c_compilers, choices, pairs, run};

#[test]
fn every_kind_of_model_compiles_strictly_and_passes_its_selftest() {
    let place = tempfile::tempdir().unwrap();
    let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let all = pairs(&pairs(&PRECISIONS, &c_compilers()), &[&["-O2"][..], &sanitized[..]]);
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        for ((precision, compiler), flags) in choices(&all, k) {
            let folder = place.path().join(format!("{name}_{}", precision.name()));
            write_folder(&folder, &c_files(&models::subject(name, &model, precision)).unwrap()).unwrap();
            let (source, test) = (format!("{name}.c"), format!("{name}_selftest.c"));
            let mut arguments = [&STRICT[..], flags, &[&source, &test, "-o", "selftest"]].concat();
            arguments.push("-lm");
            run(&folder, compiler, &arguments);
            let said = run(&folder, "./selftest", &[]);
            println!("{} {compiler} {}: {}", precision.name(), flags[0], said.lines().next().unwrap());
            assert!(said.contains(&format!("PASSED: {name}")), "{said}");
        }
    }
}

#[test]
fn what_takes_the_compensation_away_does_not_compile() {
    let place = tempfile::tempdir().unwrap();
    let subject = models::subject("stage", &models::stage(), Precision::F32);
    write_folder(&place.path().join("out"), &c_files(&subject).unwrap()).unwrap();
    for compiler in c_compilers() {
        let arguments = ["-std=c99", "-O2", "-ffast-math", "-c", "stage.c"];
        let output = Command::new(compiler).args(arguments).current_dir(place.path().join("out")).output();
        let output = output.unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains("compile without -ffast-math"), "{said}");
    }
}

/// What the self-test of `name` says of `files`, and whether it passed.
fn judged(folder: &Path, compiler: &str, name: &str, files: &[NamedFile]) -> (bool, String) {
    write_folder(folder, files).unwrap();
    let (source, test) = (format!("{name}.c"), format!("{name}_selftest.c"));
    run(folder, compiler, &[&source, &test, "-o", "selftest", "-lm"]);
    let output = Command::new(folder.join("selftest")).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.success(), said.contains(&format!("PASSED: {name}")), "{said}");
    (output.status.success(), said)
}

/// The files with another text of `name`.c.
fn with_source(files: &[NamedFile], name: &str, change: impl Fn(&str) -> String) -> Vec<NamedFile> {
    let mut files = files.to_vec();
    let source = files.iter_mut().find(|f| f.name == format!("{name}.c")).unwrap();
    let text = String::from_utf8(source.bytes.clone()).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed);
    source.bytes = changed.into_bytes();
    files
}

#[test]
fn the_selftest_can_fail() {
    let place = tempfile::tempdir().unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let files = c_files(&models::subject("stage", &models::stage(), precision)).unwrap();
        // One digit of one coefficient.
        let wrong = with_source(&files, "stage", |text| text.replacen("{0.08", "{0.08001", 1));
        let Some(compiler) = c_compilers().first().copied() else { return };
        let (passed, said) = judged(&place.path().join(precision.name()), compiler, "stage", &wrong);
        assert!(!passed && said.contains("FAILED: golden vectors"), "{said}");
    }
}

/// Numbers of a table of C source with its place.
fn table(text: &str, name: &str) -> Option<(Range<usize>, Vec<String>)> {
    let from = text.find(&format!("real {name}["))?;
    let from = from + text[from..].find("= {")? + 3;
    let to = from + text[from..].find("};")?;
    Some((from..to, text[from..to].split(',').map(|x| x.trim().to_owned()).collect()))
}

/// A delay longer than the table, and a rate at which the poles are slow: the drive is held until it has come
/// out.
#[test]
fn the_selftest_sees_every_pole_behind_a_long_delay() {
    let place = tempfile::tempdir().unwrap();
    let Some(compiler) = c_compilers().first().copied() else { return };
    let late = Model { delay_s: 0.15, ..models::stage() };
    for (model, precision, rate_hz) in [
        (&late, Precision::F32, models::RATE_HZ),
        (&late, Precision::F64, models::RATE_HZ),
        (&models::stage(), Precision::F64, 1e7),
    ] {
        let subject = models::subject_at("stage", model, precision, rate_hz).unwrap();
        assert!(subject.realisation.dynamics.delay_samples > 1400);
        let golden = Golden::new(&subject).unwrap();
        assert!(golden.span > 1.0 && golden.tolerance > 0.0, "{golden:?}");
        let files = c_files(&subject).unwrap();
        let folder = place.path().join(format!("{}_{rate_hz}", precision.name()));
        let (passed, said) = judged(&folder, compiler, "stage", &files);
        println!("{} {rate_hz} Hz: {}", precision.name(), said.lines().next().unwrap());
        assert!(passed, "{said}");
        let test = files.iter().find(|f| f.name == "stage_selftest.c").unwrap();
        assert!(test.bytes.len() < 50_000, "{}", test.bytes.len());
        let source = files.iter().find(|f| f.name == "stage.c").unwrap();
        let source = String::from_utf8(source.bytes.clone()).unwrap();
        let (_, gains) = table(&source, "REAL_GAIN").unwrap();
        for pole in 0..gains.len() {
            let wrong = with_source(&files, "stage", |text| {
                let (place, mut gains) = table(text, "REAL_GAIN").unwrap();
                gains[pole] = format!("17 * {}", gains[pole]);
                format!("{}{}{}", &text[..place.start], gains.join(", "), &text[place.end..])
            });
            let (passed, said) = judged(&folder, compiler, "stage", &wrong);
            assert!(!passed, "{} pole {pole} of {gains:?}: {said}", precision.name());
        }
    }
}

#[test]
fn what_stands_still_has_no_selftest() {
    let operator = BoucWen::of(&models::stage().hysteresis).unwrap();
    let dead = BoucWen { polynomial: vec![0.0], alpha: 0.0, ..operator };
    let model = Model { hysteresis: Hysteresis::from(dead), ..models::stage() };
    for precision in [Precision::F32, Precision::F64] {
        let refused = models::subject_at("stage", &model, precision, models::RATE_HZ);
        let refused = refused.and_then(|subject| c_files(&subject)).unwrap_err();
        assert!(matches!(refused, ExportError::Still { .. }), "{refused}");
    }
}
