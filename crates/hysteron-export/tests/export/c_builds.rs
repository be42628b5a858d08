//! The C source compiles without a word and passes its own test, under both compilers and under sanitizers.

use hysteron_export::{Precision, c_files, write_folder};

use crate::models;
use crate::tools::{STRICT, c_compilers, run};

#[test]
fn every_kind_of_model_compiles_strictly_and_passes_its_selftest() {
    let place = tempfile::tempdir().unwrap();
    let compilers = c_compilers();
    for (name, model) in models::all() {
        for precision in [Precision::F32, Precision::F64] {
            let folder = place.path().join(format!("{name}_{}", precision.name()));
            write_folder(&folder, &c_files(&models::subject(name, &model, precision)).unwrap()).unwrap();
            let (source, test) = (format!("{name}.c"), format!("{name}_selftest.c"));
            for compiler in &compilers {
                let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                for flags in [&["-O2"][..], &sanitized[..]] {
                    let mut arguments = [&STRICT[..], flags, &[&source, &test, "-o", "selftest"]].concat();
                    arguments.push("-lm");
                    run(&folder, compiler, &arguments);
                    let said = run(&folder, "./selftest", &[]);
                    println!(
                        "{} {compiler} {}: {}",
                        precision.name(),
                        flags[0],
                        said.lines().next().unwrap()
                    );
                    assert!(said.contains(&format!("PASSED: {name}")), "{said}");
                }
            }
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
        let output = std::process::Command::new(compiler)
            .args(arguments)
            .current_dir(place.path().join("out"))
            .output();
        let output = output.unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains("compile without -ffast-math"), "{said}");
    }
}

#[test]
fn the_selftest_can_fail() {
    let place = tempfile::tempdir().unwrap();
    for precision in [Precision::F32, Precision::F64] {
        let mut files = c_files(&models::subject("stage", &models::stage(), precision)).unwrap();
        // One digit of one coefficient.
        let source = files.iter_mut().find(|f| f.name == "stage.c").unwrap();
        let text = String::from_utf8(source.bytes.clone()).unwrap();
        let wrong = text.replacen("{0.08", "{0.08001", 1);
        assert_ne!(text, wrong);
        source.bytes = wrong.into_bytes();
        let folder = place.path().join(precision.name());
        write_folder(&folder, &files).unwrap();
        let Some(compiler) = c_compilers().first().copied() else { return };
        run(&folder, compiler, &["stage.c", "stage_selftest.c", "-o", "selftest", "-lm"]);
        let output = std::process::Command::new(folder.join("selftest")).output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.code() == Some(1) && said.contains("FAILED: golden vectors"), "{said}");
    }
}
