//! `identify --structure force` turns records of displacement and force into a file that `validate` and
//! `simulate` accept, and that `invert` and the like refuse with the reason. The records are simulated.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::bench::Bench;
use serde_json::Value;

const RATE: f64 = 500.0;

/// Displacement in mm, from rest.
fn displacement(amplitude: f64, frequency: f64, t: f64) -> f64 {
    amplitude * (1.0 - (-(2.0 * frequency * t).powi(2)).exp()) * (TAU * frequency * t).sin()
}

/// Its rate.
fn rate(amplitude: f64, frequency: f64, t: f64) -> f64 {
    const STEP: f64 = 1e-5;
    let x = |t: f64| displacement(amplitude, frequency, t);
    (x(t + STEP) - x(t - STEP)) / (2.0 * STEP)
}

/// Force in N of a damper: spring, friction, dashpot, a force that saturates with the rate.
fn csv(amplitude: f64, frequency: f64) -> String {
    let x = |t: f64| displacement(amplitude, frequency, t);
    let v = |t: f64| rate(amplitude, frequency, t);
    let mut text = "t_s,u_mm,y_N\n".to_owned();
    let mut friction = 0.0_f64;
    for k in 0..(4.0 * RATE / frequency) as usize {
        let t = k as f64 / RATE;
        let moved = x(t) - x(t - 1.0 / RATE);
        friction += if k == 0 { 0.0 } else { (moved - moved.abs() * friction) / 0.5 };
        let force = 10.0 + 2.0 * x(t) + 80.0 * friction + 0.5 * v(t) + 200.0 * (v(t) / 10.0).tanh();
        writeln!(text, "{t},{},{force}", x(t)).unwrap();
    }
    text
}

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("slow.csv", csv(10.0, 0.5));
    bench.write("fast.csv", csv(3.0, 3.0));
    bench.write("unseen.csv", csv(6.0, 1.5));
    bench
}

const IDENTIFY: &str = "identify slow.csv fast.csv --structure force -o damper.json";

#[test]
fn records_become_a_file_that_predicts_another_record() {
    let bench = bench();
    let run = bench.run(&format!("{IDENTIFY} --json --report report.html"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(told["structure"], "force");
    let parameters = told["parameters"].as_array().unwrap();
    let value =
        |name: &str| parameters.iter().find(|p| p["name"] == name).unwrap()["value"].as_f64().unwrap();
    // mm are µm in the model.
    assert!((value("saturating_force") / 200.0 - 1.0).abs() < 0.05, "{parameters:?}");
    assert!((value("saturating_rate") / 10e3 - 1.0).abs() < 0.1, "{parameters:?}");
    assert!((value("reach") / 500.0 - 1.0).abs() < 0.1, "{parameters:?}");

    let run = bench.run("validate damper.json unseen.csv --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(told["records"][0]["fit_percent"].as_f64().unwrap() > 95.0, "{}", run.stdout);

    let run = bench.run("simulate damper.json unseen.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let header = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(header.lines().next().is_some_and(|line| line.contains("y_N")), "{header:.60}");
}

/// Columns as a test rig names them, no flag.
#[test]
fn a_force_over_a_displacement_is_identified_as_one() {
    let bench = Bench::new();
    for (name, amplitude, frequency) in [("slow.csv", 10.0, 0.5), ("fast.csv", 3.0, 3.0)] {
        let text = csv(amplitude, frequency);
        let rows = text.lines().skip(1).map(|line| {
            let [t, x, force] = line.split(',').collect::<Vec<_>>()[..] else { panic!("three columns") };
            let rate = rate(amplitude, frequency, t.parse().unwrap());
            format!("{t},{x},{rate},{force}\n")
        });
        bench.write(name, "t_s,x_mm,v_mm_per_s,F_N\n".to_owned() + &rows.collect::<String>());
    }
    let run = bench.run("identify slow.csv fast.csv -o damper.json --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("a model of the kind force"), "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(told["structure"], "force");
    let run = bench.run("identify slow.csv fast.csv --structure hammerstein -o x.json");
    assert_eq!(run.exit_code, 1, "{}", run.stdout);
    assert!(run.stderr.contains("--structure force; --least-fit 0"), "{}", run.stderr);
    assert!(!bench.path("x.json").exists());
    let run = bench.run("identify slow.csv fast.csv --structure hammerstein -o x.json --least-fit 0");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("A model of the kind force leaves"), "{}", run.stdout);
}

#[test]
fn a_measured_rate_takes_the_place_of_the_computed_one() {
    let bench = bench();
    for (name, amplitude, frequency) in [("slow", 10.0, 0.5), ("fast", 3.0, 3.0)] {
        let rate =
            |line: &str| rate(amplitude, frequency, line.split(',').next().unwrap().parse::<f64>().unwrap());
        let text = csv(amplitude, frequency);
        let (header, rows) = text.split_once('\n').unwrap();
        let rows: String = rows.lines().map(|line| format!("{line},{}\n", rate(line))).collect();
        bench.write(&format!("{name}.csv"), format!("{header},v_mm_per_s\n{rows}"));
    }
    let run = bench.run(&format!("{IDENTIFY} --rate v"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("rate as measured"), "{}", run.stdout);
    let run = bench.run("validate damper.json fast.csv --rate v_mm_per_s --json");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(told["records"][0]["fit_percent"].as_f64().unwrap() > 99.0, "{}", run.stdout);
    // The simulation is the one that was scored.
    let simulated = |flags: &str| {
        let run = bench.run(&format!("simulate damper.json fast.csv -o out.csv {flags}"));
        assert_eq!(run.exit_code, 0, "{}", run.stderr);
        let text = std::fs::read_to_string(bench.path("out.csv")).unwrap();
        let cells = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
        let errors: Vec<f64> = text.lines().skip(1).map(cells).map(|row| row[3] - row[2]).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let rmse = told["records"][0]["rmse_N"].as_f64().unwrap();
    assert!((simulated("--rate v") / rmse - 1.0).abs() < 1e-6 && simulated("") != rmse);
    assert_eq!(
        bench.run("simulate damper.json fast.csv fast.csv --continued --rate v -o x.csv").exit_code,
        2
    );
    for (column, reason) in [("y", "expected a unit like um/s"), ("w", "there is no column `w`")] {
        let run = bench.run(&format!("{IDENTIFY} --rate {column}"));
        assert_eq!(run.exit_code, 1, "{column}: {}", run.stderr);
        assert!(run.stderr.contains(reason), "{}", run.stderr);
    }
    let run = bench.run("identify slow.csv -o x.json --rate v --structure hammerstein");
    assert!(run.exit_code == 2 && run.stderr.contains("--structure force"), "{}", run.stderr);
}

#[test]
fn what_does_not_go_with_a_force_is_refused() {
    let bench = bench();
    for flags in [
        "--dynamics integer",
        "--creep fractional",
        "--delay 0.1",
        "--initial free",
        "--hysteresis auto",
        "--elements 3",
        "--fix mass=1",
        "--inputs a,b --outputs c,d",
    ] {
        let run = bench.run(&format!("{IDENTIFY} {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {}", run.stderr);
        assert!(run.stderr.contains("error: "), "{}", run.stderr);
    }
    assert!(!bench.path("damper.json").exists());
    let text = csv(10.0, 0.5);
    let still = text.lines().map(|line| match line.split(',').collect::<Vec<_>>()[..] {
        [t, x, force] if t != "t_s" => format!("{t},{},{force}\n", x.len().min(1)),
        _ => format!("{line}\n"),
    });
    bench.write("still.csv", still.collect::<String>());
    let timeless = text.lines().map(|line| line.split_once(',').unwrap().1.to_owned() + "\n");
    bench.write("timeless.csv", timeless.collect::<String>());
    for (record, reason) in [("still.csv", "constant"), ("timeless.csv", "sample rate")] {
        let run = bench.run(&format!("identify {record} --structure force -o x.json"));
        assert_eq!(run.exit_code, 1, "{record}: {}", run.stderr);
        assert!(run.stderr.contains(reason), "{record}: {}", run.stderr);
    }
}

#[test]
fn a_force_has_no_inverse_and_says_so() {
    let bench = bench();
    assert_eq!(bench.run(IDENTIFY).exit_code, 0);
    let motion = ": its input is a motion, not a drive";
    for (command, why) in [
        ("invert damper.json unseen.csv -o x.csv --range 0:1", motion),
        ("track damper.json unseen.csv -o x.csv --range 0:1", motion),
        ("realise damper.json --sample-rate 1000", motion),
        ("export damper.json --sample-rate 1000 --to c --out-dir x", motion),
        ("recalibrate damper.json unseen.csv -o x.json", " yet"),
    ] {
        let run = bench.run(command);
        assert_ne!(run.exit_code, 0, "{command}");
        let reason = format!("is not supported for a model of the kind \"force\"{why}");
        assert!(run.stderr.contains(&reason), "{command}: {}", run.stderr);
    }
}
