//! A model of several axes and its inverse in C, Rust and FMUs: without a warning, and the library's numbers.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hysteron_export::{
    AxesSubject, Means, NamedFile, Precision, axes_files, axes_fmu_files, axes_inverse_files,
    axes_rust_files, write_folder,
};
use hysteron_model::axes::{FeedbackStrain, HeldSimulation, LevelLaw, ScheduledModes, StrainLaw};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingLaw, LawOptions};
use hysteron_model::model_file::{Interval, ValidRange};
use hysteron_numeric::Listener;

use crate::fmu::python;
use crate::platforms::token;
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
        reach: f64::INFINITY,
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

fn limits() -> Vec<Limits> {
    vec![Limits::range(-1.0, 1.0).slew(2000.0), Limits::range(-0.5, 1.5)]
}

/// With and without hysteresis, at the model's rate and others, in double and in single precision, by name.
pub fn subjects() -> Vec<(&'static str, AxesSubject)> {
    let (double, single) = (Precision::F64, Precision::F32);
    [
        ("held", true, 2000.0, double),
        ("refitted", true, 20_000.0, double),
        ("far_above", true, 120_000.0, double),
        ("linear", false, 4000.0, double),
        ("single", true, 2000.0, single),
        ("single_linear", false, 4000.0, single),
    ]
    .into_iter()
    .map(|(name, hysteresis, rate, precision)| (name, subject(name, hysteresis, rate, precision)))
    .collect()
}

fn subject(name: &str, hysteresis: bool, rate: f64, precision: Precision) -> AxesSubject {
    let law = DecouplingLaw::new(&device(hysteresis), rate, &LawOptions::default()).unwrap();
    let subject = AxesSubject::new(name, Some("two */ axes"), ("V", "um"), law, limits()).unwrap();
    subject.in_precision(precision)
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

/// Drives a thousand times too large, then none; references as large. What it says of itself by its exit code.
const RUNS_AWAY: &str = r#"
#include "held.h"
#include "held_inverse.h"

int main(void)
{
    static held_state model;
    static held_inverse_state inverse;
    int k, m, overflows = 0;
    held_init(&model);
    held_inverse_init(&inverse);
    for (k = 0; k < 20000; k++) {
        const double size = k >= 4000 ? 0.0 : k / 10 % 2 ? 500.0 : -500.0;
        const double voltages[HELD_INPUTS] = {size, size}, references[HELD_OUTPUTS] = {1e6 * size, -1e6 * size};
        double outputs[HELD_OUTPUTS], found[HELD_INPUTS];
        overflows += held_step(&model, voltages, outputs) == HELD_OVERFLOW;
        (void)held_inverse_step(&inverse, references, found);
        for (m = 0; m < 2; m++) {
            if (!(outputs[m] - outputs[m] == 0.0) || !(found[m] >= -1.0 && found[m] <= 1.5)) {
                return 1;
            }
        }
        if (k == 19999 && !(outputs[0] * outputs[0] < 1.0)) {
            return 2;
        }
    }
    return overflows > 0 ? 0 : 3;
}
"#;

#[test]
fn a_motion_that_runs_away_is_told_and_comes_back() {
    let place = tempfile::tempdir().unwrap();
    let subject = subject("held", true, 2000.0, Precision::F64);
    let mut files = [axes_files(&subject).unwrap(), axes_inverse_files(&subject).unwrap()].concat();
    files.push(NamedFile::new("runs_away.c", RUNS_AWAY));
    write_folder(place.path(), &files).unwrap();
    let sources = ["held.c", "held_inverse.c", "runs_away.c", "-o", "runs_away"];
    run(place.path(), "cc", &[&["-std=c99", "-O1"], &sources[..], &["-lm"]].concat());
    run(place.path(), "./runs_away", &[]);
}

/// Exit code 0: a hundredth beyond the range is not told, more is, and a bad number is told first.
const EXTRAPOLATES: &str = r#"
#include "held.h"

int main(void)
{
    static held_state model;
    const double zero = 0.0, far[HELD_INPUTS] = {0.2, 1.1}, bad[HELD_INPUTS] = {zero / zero, 1.1};
    const double within[HELD_INPUTS] = {HELD_VOLTAGE_LOW, HELD_VOLTAGE_HIGH + 0.01};
    double outputs[HELD_OUTPUTS];
    held_init(&model);
    if (held_step(&model, within, outputs) != HELD_OK || held_rest_at(&model, within) != HELD_OK) {
        return 1;
    }
    if (held_step(&model, far, outputs) != HELD_EXTRAPOLATED || held_rest_at(&model, far) != HELD_EXTRAPOLATED) {
        return 2;
    }
    return held_step(&model, bad, outputs) == HELD_NOT_FINITE ? 0 : 3;
}
"#;

#[test]
fn voltages_beyond_the_records_are_told() {
    let place = tempfile::tempdir().unwrap();
    let subject = subject("held", true, 2000.0, Precision::F64);
    let range = Interval { low: -1.0, high: 1.0, unit: "V".into() };
    let subject = subject.identified_in(Some(ValidRange { input: range, rate: None, frequency: None }));
    let mut files = axes_files(&subject).unwrap();
    files.push(NamedFile::new("extrapolates.c", EXTRAPOLATES));
    write_folder(place.path(), &files).unwrap();
    let sources = ["held.c", "extrapolates.c", "-o", "extrapolates"];
    run(place.path(), "cc", &[&STRICT[..], &sources].concat());
    run(place.path(), "./extrapolates", &[]);
    let rust = axes_rust_files(&subject, false).unwrap();
    let source = rust.iter().find(|file| file.name == "src/lib.rs").unwrap();
    let text = String::from_utf8(source.bytes.clone()).unwrap();
    assert!(text.contains("pub const VOLTAGE_RANGE: (f64, f64) = (-1.0, 1.0);"), "{text}");
}

#[test]
fn the_loop_of_several_axes_starts_anywhere_within_its_limits() {
    let place = tempfile::tempdir().unwrap();
    let subject = subject("held", true, 2000.0, Precision::F64);
    let mut files = [axes_files(&subject).unwrap(), axes_inverse_files(&subject).unwrap()].concat();
    files.push(NamedFile::new("driver.c", include_str!("axes_loop_driver.c")));
    write_folder(place.path(), &files).unwrap();
    let sources = ["held.c", "held_inverse.c", "held_inverse_loop.c", "driver.c", "-o", "loop"];
    let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    run(place.path(), "cc", &[&STRICT[..], &sanitized, &sources].concat());
    // The slew rate is 2000 V/s, the sample rate 2000 Hz: steps of at most 1 V. Beyond 1 V is beyond the limits
    // of the first actuator. What the hysteresis remembers is not known but at 0 V: up to twice its largest, 0.022
    // of strain, at a gain of 2 um.
    for (at, known, tolerance) in
        [("0", "1", 1e-3), ("0.4", "1", 0.09), ("0.4", "0", 0.09), ("1.4", "1", 0.09)]
    {
        let said = run(place.path(), "./loop", &[at, known, "20000"]);
        let numbers: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
        println!("at {at} V, known {known}: {said}");
        let [step, largest, missed, alarms] = numbers[..] else { unreachable!() };
        assert!(step <= 1.0 + 1e-12 && largest <= 1.5 && alarms == 0.0, "{at} {known}: {said}");
        assert!(missed <= tolerance, "{at} {known}: {said}");
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

/// What the binary of a unit for this machine puts out for these inputs, two a sample.
fn of_binary(
    folder: &Path,
    unit: &NamedFile,
    version: usize,
    rate: f64,
    inputs: &[[f64; 2]],
) -> Vec<[f64; 2]> {
    zip::ZipArchive::new(std::io::Cursor::new(&unit.bytes)).unwrap().extract(folder).unwrap();
    let description = std::fs::read_to_string(folder.join("modelDescription.xml")).unwrap();
    let libraries = folder.join(["binaries/linux64", "binaries/x86_64-linux"][version - 2]);
    let library = std::fs::read_dir(libraries).unwrap().next().unwrap().unwrap().path();
    std::fs::write(folder.join("master.c"), include_str!("master.c")).unwrap();
    let (fmi, rate) = (format!("-DFMI={version}"), format!("-DRATE_HZ={rate:e}"));
    let flags = ["-std=c99", "-D_GNU_SOURCE", "-DGIVEN=2", "-DFOUND=2", &fmi, &rate];
    run(folder, "cc", &[&flags[..], &["master.c", "-o", "master", "-ldl"]].concat());
    let mut child = Command::new(folder.join("master"))
        .args([library.to_str().unwrap(), &token(&description)])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let bytes: Vec<u8> = inputs.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", output.status);
    let numbers: Vec<f64> =
        output.stdout.chunks_exact(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect();
    numbers.as_chunks::<2>().0.to_vec()
}

#[test]
fn units_of_several_axes_put_out_what_the_library_does() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return crate::tools::skipped("64-bit Linux on x86-64", "units of several axes were not run");
    }
    let place = tempfile::tempdir().unwrap();
    let wave = |k: usize, i: usize| (0.05 + 0.02 * i as f64) * k as f64;
    for (name, subject) in subjects() {
        let (law, rate) = (subject.law(), subject.law().held.model.sample_rate_hz);
        let means = Means { compiler: "cc", listener: Listener::silent() };
        let units = axes_fmu_files(&subject, true, means).unwrap();
        let names: Vec<&str> = units.iter().map(|unit| unit.name.as_str()).collect();
        let own = |tail: &str| format!("{name}{tail}.fmu");
        assert_eq!(names, ["_fmi2", "_fmi3", "_inverse_fmi2", "_inverse_fmi3"].map(own));
        let tolerance = if name.starts_with("single") { 1e-3 } else { 1e-9 };
        let mut simulation = HeldSimulation::new(law.held.model.clone(), law.state);
        let drives: Vec<[f64; 2]> = (0..600).map(|k| [0, 1].map(|i| 0.6 * wave(k, i).sin())).collect();
        let mut wanted = Vec::new();
        for u in &drives {
            simulation.advance();
            wanted.push(simulation.apply(u).to_vec());
        }
        let mut controller = law.controller(&limits()).unwrap();
        let rest = controller.output().to_vec();
        let references: Vec<[f64; 2]> =
            (0..600).map(|k| [0, 1].map(|i| rest[i] + 0.2 * wave(k, i).sin())).collect();
        let voltages: Vec<Vec<f64>> = references.iter().map(|r| controller.step(r).to_vec()).collect();
        judge(name, &units, [&drives, &references], [&wanted, &voltages], (rate, tolerance));
        for (k, unit) in units.iter().enumerate() {
            let (inputs, wanted) = if k < 2 { (&drives, &wanted) } else { (&references, &voltages) };
            let found = of_binary(&place.path().join(&unit.name), unit, 2 + k % 2, rate, inputs);
            assert_eq!(found.len(), wanted.len());
            let apart = |(found, wanted): (&[f64; 2], &Vec<f64>)| {
                found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            };
            let worst = found.iter().zip(wanted).map(apart).fold(0.0, f64::max);
            println!("{}: largest difference {worst:.1e}", unit.name);
            assert!(worst <= tolerance, "{}: {worst:e}", unit.name);
        }
    }
}

/// FMPy's judgement of model and inverse in both versions.
fn judge(
    name: &str,
    units: &[NamedFile],
    inputs: [&[[f64; 2]]; 2],
    wanted: [&[Vec<f64>]; 2],
    (rate, tolerance): (f64, f64),
) {
    let Some(python) = python() else { return };
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    write_folder(&folder, units).unwrap();
    std::fs::write(folder.join("fmu.py"), include_str!("fmu_axes.py")).unwrap();
    let numbers = [rate, tolerance].map(|x| format!("{x:e}"));
    for (what, (inputs, wanted)) in
        [name.to_owned(), format!("{name}_inverse")].iter().zip(inputs.iter().zip(wanted))
    {
        let row = |(x, y): (&[f64; 2], &Vec<f64>)| format!("{:?},{:?},{:?},{:?}\n", x[0], x[1], y[0], y[1]);
        let rows: String = inputs.iter().zip(wanted).map(row).collect();
        std::fs::write(folder.join("record.csv"), rows).unwrap();
        for version in [2, 3] {
            let unit = format!("{what}_fmi{version}.fmu");
            let said = run(&folder, &python, &["fmu.py", &unit, "record.csv", &numbers[0], &numbers[1]]);
            assert!(said.contains(": valid;"), "{said}");
        }
    }
}

#[test]
fn limits_that_do_not_fit_and_odd_names_are_refused() {
    let law = DecouplingLaw::new(&device(false), 2000.0, &LawOptions::default()).unwrap();
    let limits = |count| vec![Limits::range(-1.0, 1.0); count];
    assert!(AxesSubject::new("stage", None, ("V", "um"), law.clone(), limits(1)).is_err());
    assert!(AxesSubject::new("Stage 1", None, ("V", "um"), law, limits(2)).is_err());
}
