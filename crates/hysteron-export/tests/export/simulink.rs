//! The S-function, compiled against headers that stand in for Simulink's, under a master that calls it as
//! Simulink does.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use hysteron_export::{
    Golden, GoldenInverse, NamedFile, Precision, simulink_files, simulink_inverse_files, write_folder,
};
use hysteron_model::compensator::Prediction;

use crate::models;
use crate::tools::{STRICT, c_compilers, run};

/// Outputs along a drive from rest, and the master's exit.
fn along(program: &Path, rest: f64, drive: &[f64]) -> (Vec<f64>, bool) {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let bytes: Vec<u8> = std::iter::once(&rest).chain(drive).flat_map(|x| x.to_ne_bytes()).collect();
    let mut input = child.stdin.take().unwrap();
    // A master that has failed reads no further.
    let writer = std::thread::spawn(move || input.write_all(&bytes));
    let output = child.wait_with_output().unwrap();
    let _ = writer.join().unwrap();
    let numbers = output.stdout.chunks_exact(8).map(|b| f64::from_ne_bytes(b.try_into().unwrap()));
    (numbers.collect(), output.status.success())
}

/// Compiles the block, and compares it with the entries of golden vectors, each at the end of its samples.
fn check(
    name: &str,
    files: &[NamedFile],
    rest: f64,
    vectors: &[(f64, usize, f64)],
    tolerance: f64,
) -> String {
    let mut said = Vec::new();
    for compiler in c_compilers() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path();
        write_folder(folder, files).unwrap();
        std::fs::write(folder.join("simstruc.h"), include_str!("simulink/simstruc.h")).unwrap();
        std::fs::write(folder.join("simulink.c"), include_str!("simulink/simulink.c")).unwrap();
        let (block, source) = (format!("{name}_sfun.c"), format!("{name}.c"));
        let flags = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-DMATLAB_MEX_FILE"];
        let rest_of = [&block, &source, "-o", "block", "-lm"];
        run(folder, compiler, &[&STRICT[..], &flags[..], &rest_of[..]].concat());
        let drive: Vec<f64> =
            vectors.iter().flat_map(|&(u, lasts, _)| std::iter::repeat_n(u, lasts)).collect();
        let (out, well) = along(&folder.join("block"), rest, &drive);
        assert!(well && out.len() == drive.len(), "{name}: {} of {}", out.len(), drive.len());
        let (mut worst, mut at) = (0.0_f64, 0);
        for &(_, lasts, wanted) in vectors {
            at += lasts;
            worst = worst.max((out[at - 1] - wanted).abs());
        }
        said.push(format!(
            "{name} {compiler}: {} samples, {worst:.1e}, allowed {tolerance:.1e}\n",
            drive.len()
        ));
        assert!(worst <= tolerance, "{name}: {worst:e}");
        // A number that is none ends the simulation.
        let (out, well) = along(&folder.join("block"), rest, &[drive[0], f64::NAN, drive[0]]);
        assert!(!well && out.len() == 2, "{name}: {out:?}");
        let (out, well) = along(&folder.join("block"), f64::NAN, &drive[..1]);
        assert!(!well && out.is_empty(), "{name}: {out:?}");
    }
    said.concat()
}

#[test]
fn blocks_of_models_put_out_the_golden_vectors() {
    let one_of_each = ["stage", "means_quadratic", "preisach", "rate_dependent_plays", "jiles_atherton"];
    for (name, model) in models::all().into_iter().filter(|(name, _)| one_of_each.contains(name)) {
        for precision in [Precision::F64, Precision::F32] {
            let subject = models::subject(name, &model, precision);
            let golden = Golden::new(&subject).unwrap();
            let entries = golden.voltages.iter().zip(&golden.displacements).enumerate();
            let vectors: Vec<_> = entries.map(|(k, (&u, &y))| (u, golden.lasts(k), y)).collect();
            let files = simulink_files(&subject).unwrap();
            let said = check(name, &files, golden.voltages[0], &vectors, golden.tolerance);
            println!("{said}");
        }
    }
}

#[test]
fn blocks_of_inverses_put_out_the_golden_vectors() {
    for (name, model) in
        models::invertible().into_iter().filter(|(name, _)| ["stage", "plays"].contains(name))
    {
        for precision in [Precision::F64, Precision::F32] {
            let inverse = models::inverse(name, &model, precision, Prediction::Stays);
            let golden = GoldenInverse::new(&inverse).unwrap();
            let entries = golden.references.iter().zip(&golden.voltages).enumerate();
            let vectors: Vec<_> = entries.map(|(k, (&r, &u))| (r, golden.lasts(k), u)).collect();
            let files = simulink_inverse_files(&inverse).unwrap();
            let name = format!("{name}_inverse");
            println!("{}", check(&name, &files, golden.rest_v, &vectors, golden.tolerance));
        }
    }
}
