//! FMPy finds nothing wrong with the FMUs and simulates what the library does; the source compiles against
//! the standard's headers.

use std::fmt::Write;
use std::path::PathBuf;
use std::process::Command;

use hysteron_export::{Golden, GoldenInverse, Precision, fmu_files, inverse_fmu_files, write_folder};
use hysteron_model::compensator::Prediction;
use hysteron_model::realise::RuntimeParts;

use crate::models::{self, PRECISIONS, RATE_HZ};
use crate::tools::{c_compilers, choices, run, skipped, thinned};

/// The Python that FMPy is installed for: `target/fmpy-venv`, made by `make test`.
pub fn python() -> Option<String> {
    let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../target/fmpy-venv/bin/python");
    let python = if own.exists() { own.display().to_string() } else { "python3".into() };
    let there = Command::new(&python).args(["-c", "import fmpy"]).output().is_ok_and(|o| o.status.success());
    if !there {
        skipped("FMPy", "the exported FMUs were not judged");
    }
    there.then_some(python)
}

#[test]
fn every_kind_of_unit_is_compiled() {
    let Some(compiler) = c_compilers().first().copied() else { return };
    // The code around a model is the same for all; the model's own is compiled by other tests too.
    for (name, model) in thinned(models::all()) {
        let subject = models::subject(name, &model, Precision::F32);
        assert_eq!(fmu_files(&subject, compiler).unwrap().len(), 2, "{name}");
    }
}

#[test]
fn fmpy_judges_both_versions() {
    let Some(python) = python() else { return };
    let Some(compiler) = c_compilers().first().copied() else { return };
    let headers = run(
        &std::env::temp_dir(),
        &python,
        &["-c", "import fmpy, os; print(os.path.join(os.path.dirname(fmpy.__file__), 'c-code'))"],
    );
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        if ![
            "stage",
            "quadratic",
            "plays",
            "parallel",
            "rate_dependent_plays",
            "preisach_density",
            "song_der_kiureghian",
        ]
        .contains(&name)
        {
            continue;
        }
        for precision in choices(&PRECISIONS, k) {
            let place = tempfile::tempdir().unwrap();
            let subject = models::subject(name, &model, precision);
            let folder = place.path().join("out");
            write_folder(&folder, &fmu_files(&subject, compiler).unwrap()).unwrap();
            std::fs::write(folder.join("fmu.py"), include_str!("fmu.py")).unwrap();
            let golden = Golden::new(&subject).unwrap();
            let mut parts = RuntimeParts::<f64>::new(&subject.realisation).unwrap();
            let mut library = parts.model().unwrap();
            // Row k + 1 holds the displacement after sample k.
            let mut rows =
                format!("0,{:?},{:?}\n", golden.voltages[0], library.rest_at(golden.voltages[0]).unwrap());
            for (k, pair) in golden.voltages.windows(2).enumerate() {
                let y = library.step(pair[0]).unwrap();
                writeln!(rows, "{:?},{:?},{y:?}", (k + 1) as f64 / RATE_HZ, pair[1]).unwrap();
            }
            std::fs::write(folder.join("record.csv"), rows).unwrap();
            for version in [2, 3] {
                let unit = format!("{name}_fmi{version}.fmu");
                let (rate, tolerance) = (format!("{RATE_HZ}"), format!("{:e}", golden.tolerance));
                let said = run(&folder, &python, &["fmu.py", &unit, "record.csv", &rate, &tolerance]);
                println!("{name} {}: {}", precision.name(), said.lines().last().unwrap_or_default());
                assert!(said.contains(": valid;"), "{said}");
                // Every function is declared as in the standard's own headers.
                let unpacked = folder.join(format!("fmi{version}"));
                run(&folder, &python, &["-m", "zipfile", "-e", &unit, unpacked.to_str().unwrap()]);
                let include = format!("-I{}", headers.trim());
                let main = format!("fmi{version}.c");
                let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-DFMI_STANDARD_HEADERS", &include];
                run(
                    &unpacked.join("sources"),
                    compiler,
                    &[&flags[..], &["-c", &main, "-o", "check.o"]].concat(),
                );
                let own = [
                    "-std=c99",
                    "-pedantic-errors",
                    "-Wall",
                    "-Wextra",
                    "-Werror",
                    "-c",
                    &main,
                    "-o",
                    "check.o",
                ];
                run(&unpacked.join("sources"), compiler, &own);
            }
        }
    }
}

#[test]
fn fmpy_judges_the_inverse() {
    let Some(python) = python() else { return };
    let Some(compiler) = c_compilers().first().copied() else { return };
    for (k, (name, model)) in thinned(models::invertible()).enumerate() {
        for precision in choices(&PRECISIONS, k) {
            let inverse = models::inverse(name, &model, precision, Prediction::Stays);
            let place = tempfile::tempdir().unwrap();
            let folder = place.path().join("out");
            write_folder(&folder, &inverse_fmu_files(&inverse, compiler).unwrap()).unwrap();
            std::fs::write(folder.join("fmu.py"), include_str!("fmu_inverse.py")).unwrap();
            let golden = GoldenInverse::new(&inverse).unwrap();
            let mut rows = String::new();
            for (k, (r, u)) in golden.references.iter().zip(&golden.voltages).enumerate() {
                // The voltage at the end of each reference is known.
                (1..golden.lasts(k)).for_each(|_| writeln!(rows, "{r:?},nan").unwrap());
                writeln!(rows, "{r:?},{u:?}").unwrap();
            }
            std::fs::write(folder.join("record.csv"), rows).unwrap();
            let [low, high] = inverse.range_v;
            let step = inverse.slew_v_per_s / RATE_HZ;
            let numbers =
                [RATE_HZ, golden.tolerance, golden.rest_v, low, high, step].map(|x| format!("{x:e}"));
            for version in [2, 3] {
                let unit = format!("{name}_inverse_fmi{version}.fmu");
                let mut arguments = vec!["fmu.py", &unit, "record.csv"];
                arguments.extend(numbers.iter().map(String::as_str));
                let said = run(&folder, &python, &arguments);
                println!("{name} {}: {}", precision.name(), said.lines().last().unwrap_or_default());
                assert!(said.contains(": valid;"), "{said}");
            }
        }
    }
}
