//! The functions for MATLAB do in GNU Octave what the library does, for every family and kind.

use std::path::Path;

use hysteron_export::{
    ExportError, Golden, GoldenInverse, NamedFile, Precision, matlab_files, matlab_inverse_files,
    write_folder,
};
use hysteron_model::compensator::{CompensatorParts, Prediction};
use hysteron_model::hammerstein::Model;
use hysteron_model::realise::RuntimeParts;

use crate::models;
use crate::tools::{is_there, run};

/// A function to call along a drive, and what is to come out.
struct Case {
    name: String,
    files: Vec<NamedFile>,
    /// Where it rests first, and what is handed in.
    rest: f64,
    drive: Vec<f64>,
    wanted: Vec<f64>,
    tolerance: f64,
}

fn model_case(name: &str, model: &Model) -> Case {
    let subject = models::subject(name, model, Precision::F64);
    let golden = Golden::new(&subject).unwrap();
    let held = |(k, &u): (usize, &f64)| std::iter::repeat_n(u, golden.lasts(k));
    let drive: Vec<f64> = golden.voltages.iter().enumerate().flat_map(held).collect();
    let mut parts = RuntimeParts::<f64>::new(&subject.realisation).unwrap();
    let mut runtime = parts.model().unwrap();
    runtime.rest_at(drive[0]).unwrap();
    let wanted = drive.iter().map(|&u| runtime.step(u).unwrap()).collect();
    let files = matlab_files(&subject).unwrap();
    Case { name: name.into(), files, rest: drive[0], drive, wanted, tolerance: golden.tolerance }
}

fn inverse_case(name: &str, model: &Model, prediction: Prediction) -> Case {
    let inverse = models::inverse(name, model, Precision::F64, prediction);
    let golden = GoldenInverse::new(&inverse).unwrap();
    // Every second of the sine and of the steps, one sample each: Octave takes some milliseconds for one.
    let drive: Vec<f64> = golden.references.iter().copied().step_by(2).collect();
    let mut parts =
        CompensatorParts::<f64>::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s).unwrap();
    let mut runtime = parts.compensator().unwrap();
    runtime.rest_at(golden.rest_v).unwrap();
    let wanted = drive.iter().map(|&r| runtime.step(r).voltage).collect();
    let files = matlab_inverse_files(&inverse).unwrap();
    let name = inverse.subject.name.clone();
    Case { name, files, rest: golden.rest_v, drive, wanted, tolerance: golden.tolerance }
}

fn numbers(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// What each function puts out along its drive, in one run of Octave.
fn run_in_octave(folder: &Path, cases: &[Case]) -> Vec<Vec<f64>> {
    let mut script = String::from("1;\n");
    for case in cases {
        write_folder(folder, &case.files).unwrap();
        std::fs::write(folder.join(format!("{}.in", case.name)), numbers(&case.drive)).unwrap();
        script.push_str(&format!(
            "f = fopen('{0}.in'); u = fread(f, Inf, 'double', 0, 'ieee-le')'; fclose(f);\n\
             c = {0}(); s = c.rest_at(c.init(), {1:?});\n\
             [y, s, status] = {0}(u, s); assert(all(status >= 0));\n\
             f = fopen('{0}.out', 'w'); fwrite(f, y, 'double', 0, 'ieee-le'); fclose(f);\n",
            case.name, case.rest
        ));
    }
    std::fs::write(folder.join("all_of_them.m"), script).unwrap();
    run(folder, "octave-cli", &["--norc", "--quiet", "--no-history", "all_of_them.m"]);
    let out = |case: &Case| {
        let bytes = std::fs::read(folder.join(format!("{}.out", case.name))).unwrap();
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    };
    cases.iter().map(out).collect()
}

/// Checks the agreement of each function; a row of a table for each: name, samples, largest difference as a
/// share of the range.
fn agree(cases: &[Case]) -> String {
    let mut lines = Vec::new();
    let place = tempfile::tempdir().unwrap();
    let answers = run_in_octave(place.path(), cases);
    for (case, answer) in cases.iter().zip(answers) {
        assert_eq!(answer.len(), case.wanted.len(), "{}", case.name);
        let off = case.wanted.iter().zip(&answer).map(|(a, b)| (a - b).abs());
        let worst = off.fold(0.0_f64, |worst, x| if x <= worst { worst } else { x });
        let share = 1e-12 * worst / case.tolerance;
        lines.push(format!("| {} | {} | {share:.1e} |\n", case.name, case.drive.len()));
        assert!(worst <= case.tolerance, "{}: {worst:e}, allowed {:e}", case.name, case.tolerance);
    }
    lines.concat()
}

const WITHOUT: &str = "the exported MATLAB functions were not run";

#[test]
fn models_agree_with_the_library_in_octave() {
    if is_there("octave-cli", WITHOUT) {
        let cases: Vec<Case> = models::all().iter().map(|(name, model)| model_case(name, model)).collect();
        println!("{}", agree(&cases));
    }
}

#[test]
fn inverses_agree_with_the_library_in_octave() {
    if is_there("octave-cli", WITHOUT) {
        let cases = models::invertible();
        let cases = cases.iter().map(|(name, model)| inverse_case(name, model, Prediction::Stays));
        println!("{}", agree(&cases.collect::<Vec<_>>()));
    }
}

/// What the functions promise in their own help, in Octave.
const PROMISES: &str = include_str!("matlab/promises.m");

#[test]
fn the_functions_keep_what_their_help_says() {
    if !is_there("octave-cli", WITHOUT) {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    let model = models::stage();
    let subject = models::subject("stage", &model, Precision::F64);
    let inverse = models::inverse("stage", &model, Precision::F64, Prediction::Stays);
    write_folder(place.path(), &matlab_files(&subject).unwrap()).unwrap();
    write_folder(place.path(), &matlab_inverse_files(&inverse).unwrap()).unwrap();
    std::fs::write(place.path().join("promises.m"), PROMISES).unwrap();
    let said = run(place.path(), "octave-cli", &["--norc", "--quiet", "--no-history", "promises.m"]);
    for part in ["PASSED: stage\n", "PASSED: stage_inverse\n", "all promises kept\n"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn what_matlab_does_not_take_is_refused() {
    let single = models::subject("stage", &models::stage(), Precision::F32);
    assert!(matches!(matlab_files(&single), Err(ExportError::MatlabPrecision)));
    for name in ["end", &*"a".repeat(48)] {
        let subject = models::subject(name, &models::stage(), Precision::F64);
        assert!(matches!(matlab_files(&subject), Err(ExportError::MatlabName { .. })) == (name == "end"));
        let inverse = models::inverse(name, &models::stage(), Precision::F64, Prediction::Stays);
        let refused = matlab_inverse_files(&inverse);
        assert!(matches!(refused, Err(ExportError::MatlabName { .. })) == (name != "end"));
    }
}
