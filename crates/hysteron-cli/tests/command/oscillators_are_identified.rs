//! `identify --structure oscillator` turns a record of force and displacement into a file that `validate` and
//! `simulate` accept. The records are simulated.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::bench::Bench;
use hysteron_model::Start;
use hysteron_model::model_file::{self, Document, OscillatorFile};
use hysteron_model::oscillator::Oscillator;
use hysteron_model::record::InterSample;
use serde_json::Value;

const RATE: f64 = 500.0;
/// In N, µm and s: 31.8 Hz at small motion.
const DEVICE: Oscillator =
    Oscillator { mass: 2e-3, damping: 0.02, stiffness: 40.0, alpha: 40.0, beta: 0.6, gamma: 0.2, n: 1.0 };

/// A force of lines with quadratic phases up to 100 Hz that repeats.
fn force(samples: usize, size: f64) -> Vec<f64> {
    let lines = samples / 5;
    let phase = |l: usize| std::f64::consts::PI * (l * l) as f64 / lines as f64;
    let at = |k: usize| {
        let line = |l: usize| (TAU * ((l * k) % samples) as f64 / samples as f64 + phase(l)).cos();
        size * (1..=lines).map(line).sum::<f64>() / (0.5 * lines as f64).sqrt()
    };
    (0..samples).map(at).collect()
}

/// A record as a file; the noise is a fixed pattern of one part in two hundred.
fn csv(u: &[f64], start: Start) -> String {
    csv_of(&DEVICE, RATE, u, start)
}

fn csv_of(device: &Oscillator, rate: f64, u: &[f64], start: Start) -> String {
    let y = device.simulate_record(u, rate, InterSample::BandLimited, start).unwrap();
    let size = (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
    let mut text = "t_s,u_N,y_um\n".to_owned();
    let mut noise = 1u64;
    for (k, (u, y)) in u.iter().zip(&y).enumerate() {
        noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let unit = (noise >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        writeln!(text, "{},{u},{}", k as f64 / rate, y + 0.3 + 0.017 * size * unit).unwrap();
    }
    text
}

/// Three periods of a steady state, as a file.
pub fn settled_record() -> String {
    csv(&force(1024, 60.0).repeat(3), Start::settled(1024))
}

/// A folder with a periodic record to identify from and one from rest.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("train.csv", settled_record());
    let sweep: Vec<f64> =
        (0..2000).map(|k| 50.0 * (TAU * (15.0 + 5.0 * k as f64 / RATE) * k as f64 / RATE).sin()).collect();
    bench.write("sweep.csv", csv(&sweep, Start::Rest { voltage_v: 0.0 }));
    bench
}

fn read(bench: &Bench, name: &str) -> OscillatorFile {
    match model_file::read(&std::fs::read(bench.path(name)).unwrap()).unwrap() {
        Document::Oscillator(file) => *file,
        other => panic!("a model of the kind {}", other.kind()),
    }
}

/// A thin loop far below the resonance: the oscillator that the equation error gives for its shape cannot be
/// simulated.
#[test]
fn a_fit_starts_at_its_own_oscillator() {
    const PERIOD: usize = 1024;
    let thin =
        Oscillator { mass: 1e-3, damping: 0.02, stiffness: 25.0, alpha: 5.0, beta: 1.0, gamma: 0.5, n: 1.0 };
    let line = |k: usize, f: usize| (TAU * (f * k % PERIOD) as f64 / PERIOD as f64 + (f * f) as f64).sin();
    let drive: Vec<f64> = (0..PERIOD).map(|k| 10.0 * (5..40).map(|f| line(k, f)).sum::<f64>()).collect();
    let bench = Bench::new();
    bench.write("train.csv", csv_of(&thin, PERIOD as f64, &drive.repeat(3), Start::settled(PERIOD)));
    for command in [
        "identify train.csv --structure oscillator -o first.json",
        "identify train.csv --structure oscillator --start first.json -o again.json",
    ] {
        let run = bench.run(command);
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
    }
    let [first, again] = ["first.json", "again.json"].map(|name| read(&bench, name).parameters);
    for (first, again) in first.all().into_iter().zip(again.all()) {
        let apart = (first.value - again.value).abs();
        assert!(apart <= 1e-2 * first.std_error.unwrap_or(first.value.abs()), "{first:?}, {again:?}");
    }
}

#[test]
fn a_record_becomes_a_file_that_predicts_another_record() {
    let bench = bench();
    let run = bench.run("identify train.csv --structure oscillator -o oscillator.json --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(told["structure"], "oscillator");
    let file = read(&bench, "oscillator.json");
    assert_eq!(file.start(), Start::PERIODIC);
    assert!((file.offset.value - 0.3).abs() < 1e-3, "{:?}", file.offset);
    for ((name, found), truth) in Oscillator::NAMES.iter().zip(file.parameters.all()).zip(DEVICE.values()) {
        let Some(error) = found.std_error else { continue };
        assert!((found.value - truth).abs() < 4.0 * error, "{name}: {found:?}, truth {truth}");
    }
    let mass = told["parameters"][0]["value"].as_f64().unwrap();
    assert_eq!(mass, file.parameters.mass.value);

    let run = bench.run("validate oscillator.json sweep.csv train.csv --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    for record in [0, 1] {
        assert!(told["records"][record]["fit_percent"].as_f64().unwrap() > 99.3, "{}", run.stdout);
    }
    // One period alone is recognised as settled by how well that explains it.
    let text = std::fs::read_to_string(bench.path("train.csv")).unwrap();
    bench.write("period.csv", text.lines().take(1025).fold(String::new(), |all, line| all + line + "\n"));
    let run = bench.run("validate oscillator.json period.csv --json");
    assert!(run.stderr.contains("settled on its period of 1024 samples"), "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(told["records"][0]["fit_percent"].as_f64().unwrap() > 99.3, "{}", run.stdout);

    let run = bench.run("simulate oscillator.json sweep.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(
        run.stderr.contains("this drive does not repeat and is taken to start at rest"),
        "{}",
        run.stderr
    );
    let header = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(header.starts_with("t_s,u_N,y_um,y_measured_um\n"), "{}", &header[..40]);
    let settled = bench.run("simulate oscillator.json train.csv -o out.csv --settled 2.048");
    assert_eq!(settled.exit_code, 0, "{}", settled.stderr);
    assert!(!settled.stderr.contains("repeats"), "{}", settled.stderr);
    let run = bench.run("simulate oscillator.json train.csv -o out.csv");
    assert!(run.stderr.contains("repeats every 1024 samples and is taken to have done so"), "{}", run.stderr);
}

#[test]
fn the_result_for_people_names_every_parameter() {
    let bench = bench();
    let run = bench.run(
        "identify train.csv --structure oscillator -o oscillator.json --fix mass=0.002 --n 1 --report \
        oscillator.html",
    );
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(bench.path("oscillator.html")).unwrap();
    for words in ["Numbers", "Measured and model", "std. error"] {
        assert!(page.contains(words), "{words}");
    }
    for word in Oscillator::NAMES.into_iter().chain(["natural_frequency", "damping_ratio", "RMSE", "held"]) {
        assert!(run.stdout.contains(word), "{word}: {}", run.stdout);
    }
    assert_eq!(read(&bench, "oscillator.json").parameters.mass.value, 0.002);
    let again = bench.run("identify train.csv --structure oscillator -o again.json --start oscillator.json");
    assert_eq!(again.exit_code, 0, "{}", again.stderr);
}

#[test]
fn what_does_not_go_with_an_oscillator_is_refused() {
    let bench = bench();
    for flags in [
        "--dynamics integer",
        "--degree 2",
        "--creep fractional",
        "--optimizer de-abc",
        "--figures f",
        "--fix alpha=1",
    ] {
        let run = bench.run(&format!("identify train.csv --structure oscillator -o o.json {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {}", run.stderr);
        assert!(run.stderr.contains("error: "), "{}", run.stderr);
    }
    assert!(!bench.path("o.json").exists());
    let run = bench.run("identify train.csv --structure oscillator -o o.json --start model.json");
    assert!(run.exit_code == 1 && run.stderr.contains("not of \"hammerstein\""), "{}", run.stderr);
    // Columns the wrong way round: the force does not move as a mass does.
    let run = bench.run("identify train.csv --structure oscillator -o o.json --input y --output u");
    assert_eq!(run.exit_code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("because: ") && run.stderr.contains("try: "), "{}", run.stderr);
    bench.run("identify train.csv --structure oscillator -o oscillator.json");
    for (command, wanted) in [
        ("validate oscillator.json train.csv --band", 2),
        ("validate oscillator.json train.csv --rest-voltage 1", 2),
        ("simulate oscillator.json train.csv -o x.csv --band model", 2),
        ("recalibrate oscillator.json train.csv -o x.json", 1),
    ] {
        let run = bench.run(command);
        assert_eq!(run.exit_code, wanted, "{command}: {}", run.stderr);
    }
    // The reason lies in the kind, and is said.
    bench.write("reference.csv", "t_s,y_um\n0,0\n0.001,1\n0.002,2\n0.003,3\n");
    for (command, reason) in [
        ("realise oscillator.json --sample-rate 10000", "no poles to realise"),
        ("export oscillator.json --to c -o out", "no poles to realise"),
        ("invert oscillator.json reference.csv -o drive.csv --range=-1:1", "takes the acceleration"),
        ("track oscillator.json reference.csv --range=-1:1", "takes the acceleration"),
    ] {
        let run = bench.run(command);
        assert!(run.exit_code == 1 && run.stderr.contains(reason), "{command}: {}", run.stderr);
    }
    assert!(!bench.path("out").exists() && !bench.path("drive.csv").exists());
    let text = std::fs::read_to_string(bench.path("oscillator.json")).unwrap();
    bench.write("bad.json", text.replace("\"mass\"", "\"mas\""));
    let run = bench.run("validate bad.json train.csv");
    assert!(run.exit_code == 1 && run.stderr.contains("mas"), "{}", run.stderr);
}
