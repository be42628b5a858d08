//! A model of several axes and its inverse in C and Rust: without a warning, and the library's numbers.

use std::path::PathBuf;

use hysteron_export::{AxesSubject, axes_files, axes_inverse_files, axes_rust_files, write_folder};
use hysteron_model::axes::{FeedbackStrain, LevelLaw, ScheduledModes, StrainLaw};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingLaw, LawOptions};

use crate::tools::{STRICT, c_compilers, run, workspace_of};

/// Two axes, two modes, two steps a sample of 2 kHz; hysteresis in feedback where `hysteresis`.
fn device(hysteresis: bool) -> ScheduledModes {
    let pole = |f: f64| {
        let angle = std::f64::consts::TAU * f / 4000.0;
        let size = (-0.03 * angle).exp();
        [size * angle.cos(), size * angle.sin()]
    };
    let law = |weight: f64| StrainLaw {
        coefficients: vec![0.01 * weight, -0.02 * weight, 0.1 * weight, 0.06 * weight],
        radii: vec![0.05, 0.2],
        slopes: vec![0.8, 0.5],
        variance: 0.1,
    };
    let mut input = vec![0.0; 12];
    (input[0], input[1], input[4], input[5]) = (0.2, 0.08, 0.15, -0.3);
    (input[8], input[11]) = (0.7, 0.7);
    let mut rows = vec![0.0; 16];
    (rows[4], rows[13]) = (1.0, 1.0);
    let mut stress = vec![0.0; 16];
    (stress[1], stress[11]) = (0.2, 0.3);
    let model = ScheduledModes {
        inputs: 2,
        outputs: 2,
        modes: 2,
        sample_rate_hz: 2000.0,
        steps: 2,
        level: LevelLaw { reference: 0.5, exponent: 1.0, lowest: 0.1, highest: 0.5, time_constant_s: 2.0 },
        transition: [&pole(130.0)[..], &pole(250.0), &[0.3, 0.4]].concat(),
        transition_slopes: vec![0.002, -0.003, 0.001, -0.004, 0.0, 0.0],
        strain_input: input.clone(),
        input,
        output: vec![0.0, 1.0, 0.0, 0.5, 1.5, 0.0, 0.0, 0.4, 0.0, -0.9, 0.0, 1.4],
        output_slopes: vec![0.0; 12],
        feedthrough: vec![0.01, 0.0, 0.0, 0.02],
        feedthrough_slopes: vec![0.0; 4],
        strain_feedthrough: vec![0.02, 0.0, 0.0, 0.01],
        feedback: hysteresis.then(|| FeedbackStrain {
            drive_rows: rows,
            stress_rows: stress,
            drive: law(1.0),
            stress: vec![law(0.3), law(-0.2)],
        }),
    };
    model.validate().unwrap();
    model
}

/// With and without hysteresis, at the model's rate and others, by name.
pub fn subjects() -> Vec<(&'static str, AxesSubject)> {
    [("held", true, 2000.0), ("refitted", true, 20_000.0), ("linear", false, 4000.0)]
        .into_iter()
        .map(|(name, hysteresis, rate)| {
            let law = DecouplingLaw::new(&device(hysteresis), rate, &LawOptions::default()).unwrap();
            let limits = vec![Limits::range(-1.0, 1.0).slew(2000.0), Limits::range(-0.5, 1.5)];
            (name, AxesSubject::new(name, Some("two */ axes"), ("V", "um"), law, limits).unwrap())
        })
        .collect()
}

#[test]
fn several_axes_in_c_are_the_library_s() {
    let place = tempfile::tempdir().unwrap();
    for (name, subject) in subjects() {
        for compiler in c_compilers() {
            let folder = place.path().join(format!("{name}_{compiler}"));
            let files = [axes_files(&subject).unwrap(), axes_inverse_files(&subject).unwrap()].concat();
            write_folder(&folder, &files).unwrap();
            for own in [name.to_owned(), format!("{name}_inverse")] {
                let (source, test) = (format!("{own}.c"), format!("{own}_selftest.c"));
                let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                for (flags, program) in [(&["-O2"][..], "plain"), (&sanitized[..], "sanitized")] {
                    run(&folder, compiler, &[&STRICT[..], flags, &[&source, &test, "-o", program]].concat());
                    let said = run(&folder, format!("./{program}"), &[]);
                    println!("{compiler}: {}", said.lines().next().unwrap());
                    assert!(said.contains(&format!("PASSED: {own}")), "{said}");
                }
            }
        }
    }
}

#[test]
fn several_axes_in_rust_are_the_library_s() {
    let place = tempfile::tempdir().unwrap();
    let mut members = Vec::new();
    for (name, subject) in subjects() {
        let mut files = axes_rust_files(&subject, true).unwrap();
        let manifest = files.iter_mut().find(|f| f.name == "Cargo.toml").unwrap();
        let text = String::from_utf8(manifest.bytes.clone()).unwrap();
        manifest.bytes = text.replace("[workspace]", "").into_bytes();
        write_folder(&place.path().join(name), &files).unwrap();
        members.push(format!("\"{name}\""));
    }
    std::fs::write(place.path().join("Cargo.toml"), workspace_of(&members)).unwrap();
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exported-axes");
    let target = target.to_str().unwrap();
    let said =
        run(place.path(), env!("CARGO"), &["test", "--offline", "--workspace", "--target-dir", target]);
    assert_eq!(said.matches("test golden_vectors ... ok").count(), 2 * members.len(), "{said}");
    let check = ["clippy", "--offline", "--workspace", "--target-dir", target, "--"];
    run(place.path(), env!("CARGO"), &[&check[..], &["-D", "warnings", "-W", "missing-docs"]].concat());
}

#[test]
fn limits_that_do_not_fit_and_odd_names_are_refused() {
    let law = DecouplingLaw::new(&device(false), 2000.0, &LawOptions::default()).unwrap();
    let limits = |count| vec![Limits::range(-1.0, 1.0); count];
    assert!(AxesSubject::new("stage", None, ("V", "um"), law.clone(), limits(1)).is_err());
    assert!(AxesSubject::new("Stage 1", None, ("V", "um"), law, limits(2)).is_err());
}
