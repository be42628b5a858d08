//! `design` makes the next drive from a model or from records; `inspect` and `identify` end with the command
//! that does.

use serde_json::Value;

use crate::bench::Bench;

const PLAN: &str = r#"{ "sample_rate_hz": 2000, "loop_periods": 3, "sweep_s": 3, "sweep_end_hz": 80,
    "validation_hz": [12], "validation_s": 0.5 }"#;

/// Numbers of the columns t_s and u_V.
fn drive(bench: &Bench, file: &str) -> Vec<(f64, f64)> {
    let text = std::fs::read_to_string(bench.path(file)).unwrap();
    let numbers = |line: &str| {
        let (t, u) = line.split_once(',')?;
        Some((t.parse().ok()?, u.parse().ok()?))
    };
    text.lines().filter_map(numbers).collect()
}

#[test]
fn a_drive_keeps_its_limits_and_beats_loop_and_sweep() {
    let bench = Bench::new();
    bench.write("plan.json", PLAN);
    assert_eq!(bench.run("rig --out-dir bench --plan plan.json").exit_code, 0);
    let records = "bench/simulated_loop_1hz.csv bench/simulated_sweep_1_80hz.csv";

    // The line that inspect ends with is a command that runs.
    let told = bench.run(&format!("inspect {records}"));
    assert!(told.stdout.contains("Measure next: slow loops"), "{told:?}");
    let command = told.stdout.lines().last().unwrap().trim();
    assert!(
        command.starts_with(&format!("hysteron design {records} --for minor-loops --time 20s --range 0:"))
    );
    let command = command.strip_prefix("hysteron ").unwrap().replace("20s", "1.5s");
    let run = bench.run(&format!("{command} --json"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let aim = found["expected"].as_array().unwrap().iter().find(|e| e["aim"] == true).unwrap();
    let error = |when: &str| aim[when].as_f64().unwrap();
    assert!(error("designed") < error("now") && error("designed") <= error("usual"), "{aim}");
    assert_eq!(found["samples"], 3000);
    let written = drive(&bench, "next.csv");
    assert_eq!(written.len(), 3000);

    // From the model: other limits hold for every sample.
    let fitted = bench.run(&format!("identify {records} --dynamics fractional -o model.json"));
    assert_eq!(fitted.exit_code, 0, "{fitted:?}");
    assert!(fitted.stdout.contains("hysteron design "), "{fitted:?}");
    let run = bench.run("design model.json --for delay --time 1.5s --range 1:9 --slew 500 -o delay.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stdout.contains("delay (aim)") && run.stdout.contains("verdict: "), "{run:?}");
    let written = drive(&bench, "delay.csv");
    assert!(written.iter().all(|(_, u)| (1.0..=9.0).contains(u)));
    assert!(written.windows(2).all(|w| (w[1].1 - w[0].1).abs() * 2000.0 <= 500.0 * (1.0 + 1e-9)));

    let long = bench.run("design model.json --for delay --time 1e9s --range 1:9 -o delay.csv");
    assert_eq!(long.exit_code, 1, "{long:?}");
    assert!(long.stderr.contains("from 0.2 to 2000 s can, 400 to 4 000 000 samples"), "{long:?}");
    let wrong = bench.run("design model.json --for delay --time 1.5s --slew 0.1 -o delay.csv");
    assert_eq!(wrong.exit_code, 1, "{wrong:?}");
    assert!(wrong.stderr.contains("slew rate") && wrong.stderr.contains("--slew"), "{wrong:?}");
    let mixed = bench.run(&format!("design model.json {records} --for delay --time 1s -o delay.csv"));
    assert_eq!(mixed.exit_code, 2, "{mixed:?}");
}
