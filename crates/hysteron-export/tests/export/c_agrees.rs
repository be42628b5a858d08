//! The C source and `hysteron-rt` side by side along random calls, with every kind of bad number among them.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use hysteron_export::{Golden, Precision, Subject, c_files, write_folder};
use hysteron_model::realise::RuntimeParts;
use hysteron_rt::{ModelError, Real};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::models::{self, PRECISIONS};
use crate::tools::{STRICT, c_compilers, choices, pairs, run};

#[derive(Clone, Copy, Debug)]
enum Call {
    Step(f64),
    RestAt(f64),
    StartAt(f64, f64),
}

/// Status as in the source, and what was put out.
pub type Answer = (f64, f64);

/// Slow and fast moves, holds and jumps within the range; where `wild`, far beyond it and with bad numbers
/// too.
fn calls(seed: u64, count: usize, wild: Option<Precision>) -> Vec<Call> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut u = 0.0_f64;
    let mut out = Vec::with_capacity(count);
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    while out.len() < count {
        let length = random.random_range(1..60_usize);
        let slope: f64 = random.random_range(-3.0..3.0);
        match random.random_range(0..if wild.is_some() { 12 } else { 6 }) {
            0 => out.extend(std::iter::repeat_n(Call::Step(u), length)),
            1..3 => out.extend((0..length).map(|_| {
                u = (u + slope).clamp(0.0, 100.0);
                Call::Step(u)
            })),
            3 => out.extend((0..length).map(|_| {
                u = (u + 1e-6 * slope).clamp(0.0, 100.0);
                Call::Step(u)
            })),
            4 | 5 => {
                u = random.random_range(0.0..100.0);
                out.push(Call::Step(u));
            }
            6 => out.push(Call::Step(bad[random.random_range(0..3_usize)])),
            7 => out.push(Call::RestAt(bad[random.random_range(0..3_usize)])),
            8 => out.push(Call::StartAt(u, bad[random.random_range(0..3_usize)])),
            9 => {
                // Any power of ten that the number type has, either sign.
                let size = 10_f64.powf(
                    random.random_range(-30.0..if wild == Some(Precision::F32) { 38.0 } else { 308.0 }),
                );
                out.push(Call::Step(if random.random_bool(0.5) { size } else { -size }));
                out.push(Call::RestAt(u));
            }
            10 => out.push(Call::RestAt(u)),
            _ => out.push(Call::StartAt(u, random.random_range(-50.0..50.0))),
        }
    }
    out
}

fn of_runtime<T: Real + Into<f64>>(subject: &Subject, calls: &[Call]) -> Vec<Answer> {
    let mut parts = RuntimeParts::<T>::new(&subject.realisation).unwrap();
    let mut model = parts.model().unwrap();
    let mut y = 0.0;
    let mut first = true;
    let answer = |call: &Call| {
        let of = |x: f64| T::of(x);
        let result = match *call {
            Call::Step(u) => model.step(of(u)),
            Call::RestAt(u) => model.rest_at(of(u)),
            // Puts nothing out; what is held afterwards is the displacement it starts at.
            Call::StartAt(u, displacement) => model.start_at(of(u), of(displacement)).map(|()| of(f64::NAN)),
        };
        let status = match result {
            Ok(_) => 0.0,
            Err(ModelError::NotFinite | ModelError::Start { .. }) => -1.0,
            Err(_) => -2.0,
        };
        if let Ok(result) = result
            && result.is_finite()
        {
            y = result.into();
            first = false;
        }
        (status, if first { f64::NAN } else { y })
    };
    calls.iter().map(answer).collect()
}

fn of_source(program: &Path, calls: &[Call]) -> Vec<Answer> {
    let sent = calls.iter().map(|call| match *call {
        Call::Step(u) => [0.0, u, 0.0],
        Call::RestAt(u) => [1.0, u, 0.0],
        Call::StartAt(u, displacement) => [2.0, u, displacement],
    });
    exchange(program, sent)
}

/// Three numbers a call to a driver, two back.
pub fn exchange(program: &Path, calls: impl Iterator<Item = [f64; 3]>) -> Vec<Answer> {
    let bytes: Vec<u8> = calls.flatten().flat_map(f64::to_ne_bytes).collect();
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the driver starts");
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success(), "{}", output.status);
    let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().unwrap());
    output.stdout.chunks_exact(16).map(|pair| (number(&pair[..8]), number(&pair[8..]))).collect()
}

/// Largest difference along the calls, held outputs included; statuses must be the same.
fn difference(calls: &[Call], rust: &[Answer], c: &[Answer], relative: bool) -> f64 {
    assert_eq!((rust.len(), c.len()), (calls.len(), calls.len()));
    let mut worst = 0.0_f64;
    let mut held = false;
    for (k, ((call, rust), c)) in calls.iter().zip(rust).zip(c).enumerate() {
        // The source tells extrapolation apart.
        let status = if c.0 > 0.0 { 0.0 } else { c.0 };
        assert_eq!(status, rust.0, "{k}: {call:?} {rust:?} {c:?}");
        // After a start what is held is the displacement it starts at, which the driver does not see.
        held = match call {
            Call::StartAt(..) => rust.0 == 0.0 || held,
            _ => held && rust.0 < 0.0,
        };
        if !held && rust.1.is_finite() && !matches!(call, Call::StartAt(..)) {
            let scale = if relative { 1.0_f64.max(rust.1.abs()) } else { 1.0 };
            worst = worst.max((rust.1 - c.1).abs() / scale);
            assert!(c.1.is_finite(), "{k}: {call:?} {rust:?} {c:?}");
        }
    }
    worst
}

fn build(folder: &Path, compiler: &str, name: &str, flags: &[&str]) {
    std::fs::write(folder.join("driver.c"), include_str!("driver.c").replace("MODEL", name)).unwrap();
    let source = format!("{name}.c");
    let mut arguments = [&STRICT[..], flags, &[&source, "driver.c", "-o", "driver"]].concat();
    arguments.push("-lm");
    run(folder, compiler, &arguments);
}

fn runtime(subject: &Subject, calls: &[Call]) -> Vec<Answer> {
    match subject.precision {
        Precision::F32 => of_runtime::<f32>(subject, calls),
        Precision::F64 => of_runtime::<f64>(subject, calls),
    }
}

#[test]
fn source_and_runtime_agree_along_random_moves() {
    let place = tempfile::tempdir().unwrap();
    let all = pairs(&PRECISIONS, &c_compilers());
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        for (precision, compiler) in choices(&all, k) {
            let subject = models::subject(name, &model, precision);
            let tolerance = Golden::new(&subject).unwrap().tolerance;
            let folder = place.path().join(format!("{name}_{}_{compiler}", precision.name()));
            write_folder(&folder, &c_files(&subject).unwrap()).unwrap();
            build(&folder, compiler, name, &["-O2"]);
            let calls = [vec![Call::RestAt(0.0)], calls(1, 100_000, None)].concat();
            let (rust, c) = (runtime(&subject, &calls), of_source(&folder.join("driver"), &calls));
            let worst = difference(&calls, &rust, &c, false);
            println!("{name} {} {compiler}: {worst:.1e} um, allowed {tolerance:.1e}", precision.name());
            assert!(worst <= tolerance, "{name} {} {compiler}: {worst:e}", precision.name());
        }
    }
}

#[test]
fn source_and_runtime_agree_about_bad_numbers_under_sanitizers() {
    let place = tempfile::tempdir().unwrap();
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        for precision in choices(&PRECISIONS, k) {
            let subject = models::subject(name, &model, precision);
            // One is enough here: building with sanitizers takes its time.
            for compiler in c_compilers().into_iter().take(1) {
                let folder = place.path().join(format!("{name}_{}_{compiler}", precision.name()));
                write_folder(&folder, &c_files(&subject).unwrap()).unwrap();
                let flags = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                build(&folder, compiler, name, &flags);
                let calls = [vec![Call::RestAt(0.0)], calls(2, 30_000, Some(precision))].concat();
                let (rust, c) = (runtime(&subject, &calls), of_source(&folder.join("driver"), &calls));
                let refused = rust.iter().filter(|answer| answer.0 < 0.0).count();
                assert!(refused > 500, "{name}: {refused}");
                let worst = difference(&calls, &rust, &c, true);
                println!(
                    "{name} {} {compiler}: {worst:.1e} of the output, {refused} calls refused",
                    precision.name()
                );
                assert!(
                    worst <= 64.0 * precision.epsilon(),
                    "{name} {} {compiler}: {worst:e}",
                    precision.name()
                );
            }
        }
    }
}
