//! `inspect` tells what is in a record; what stands in the way of a good model is a warning in plain words,
//! there and in `validate`, not a failure.

use serde_json::Value;

use crate::bench::Bench;

/// Ten periods of a 2 Hz sine of 0 to 100 V at 200 Hz and an output that lags, opening the loop. `f` makes of
/// sample k, u and y the delay of its time stamp, u and y.
fn record(header: &str, f: impl Fn(usize, f64, f64) -> (f64, f64, f64)) -> String {
    let rows = (0..1000).map(|k| {
        let t = k as f64 / 200.0;
        let angle = 2.0 * std::f64::consts::TAU * t;
        let (late, u, y) = f(k, 50.0 - 50.0 * angle.cos(), 10.0 - 10.0 * (angle - 0.1).cos());
        format!("{},{u},{y}\n", t + late)
    });
    format!("{header}\n{}", rows.collect::<String>())
}

fn inspected(bench: &Bench, flags: &str) -> Value {
    let run = bench.run(&format!("inspect run.csv --json {flags}"));
    assert_eq!((run.exit_code, run.stdout.trim_end().lines().count()), (0, 1), "{run:?}");
    serde_json::from_str::<Value>(&run.stdout).unwrap()["records"][0].clone()
}

fn warnings(found: &Value) -> String {
    let findings = found["findings"].as_array().unwrap().iter();
    findings.filter(|f| f["warning"] == true).map(|f| f["text"].as_str().unwrap().to_owned() + "\n").collect()
}

#[test]
fn rate_range_periods_and_loop_of_a_sine_are_found() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_um", |_, u, y| (0.0, u, y)));
    let found = inspected(&bench, "");
    let near = |pointer: &str, expected: f64, tolerance: f64| {
        let value =
            found.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer}: {found}"));
        assert!((value - expected).abs() <= tolerance, "{pointer}: {value} instead of {expected}");
    };
    assert_eq!((&found["samples"], &found["drive"]["kind"]), (&Value::from(1000), &Value::from("sine")));
    near("/sample_rate_hz", 200.0, 1e-9);
    near("/input/low", 0.0, 1e-9);
    near("/input/high", 100.0, 1e-9);
    near("/drive/low_hz", 2.0, 0.01);
    near("/periods/count", 10.0, 0.0);
    near("/periods/period_s", 0.5, 1e-3);
    // At mid-range the two branches lie 2 · 10 µm · sin 0.1 apart, of 20 µm stroke.
    near("/loop/opening", 20.0 * 0.1_f64.sin(), 0.02);
    near("/loop/opening_percent_of_stroke", 100.0 * 0.1_f64.sin(), 0.1);
    assert_eq!(found["loop"]["sense"], "counter-clockwise");
    assert_eq!(warnings(&found), "");
}

#[test]
fn spoiled_records_are_warned_about_by_inspect_and_validate_alike() {
    let saturated = record("t_s,u_V,y_um", |_, u, y| (0.0, u, y.min(17.0)));
    let uneven = record("t_s,u_V,y_um", |k, u, y| (if k % 3 == 1 { 1e-3 } else { 0.0 }, u, y));
    let timed = record("t_s,u_V,y_um", |_, u, y| (0.0, u, y));
    let timeless = timed.lines().map(|line| line.split_once(',').unwrap().1.to_owned() + "\n").collect();
    let swapped = record("t_s,u_V,y_um", |_, u, y| (0.0, y, u));
    for (content, part) in [
        (record("t_s,u_V,y_mm", |_, u, y| (0.0, u, 2.5 * y)), "A stroke of 49.984 mm is implausible"),
        (record("t_ms,u_V,y_um", |_, u, y| (0.0, u, y)), "200 kHz is a very fast sampling"),
        (record("t_s,u_kV,y_um", |_, u, y| (0.0, u, y)), "A drive of 100 kV is implausible"),
        (saturated, "output `y` looks saturated"),
        (uneven, "time stamps are not uniform"),
        (timeless, "no time column and no sample rate"),
        (swapped, "clockwise"),
    ] {
        let bench = Bench::new();
        bench.write("run.csv", content);
        let said = warnings(&inspected(&bench, ""));
        assert!(said.contains(part), "{part}: {said}");
        let run = bench.run("validate model.json run.csv --json");
        assert_eq!(run.exit_code, 0, "{part}: {run:?}");
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
        serde_json::from_str::<Value>(&run.stdout).unwrap();
        let run = bench.run("inspect run.csv");
        assert!(run.stdout.contains("WARNING: ") && run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

#[test]
fn constant_signals_are_warned_about() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_um", |_, _, _| (0.0, 5.0, 0.1 + 0.2)));
    let said = warnings(&inspected(&bench, ""));
    for part in ["input `u` is constant (5 V)", "output `y` is constant (0.3 µm)"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn one_or_two_samples_are_inspected_or_refused() {
    let bench = Bench::new();
    bench.write("run.csv", "t_s,u_V,y_um\n0,1,2\n0.1,2,3\n");
    assert_eq!(inspected(&bench, "")["samples"], 2);
    bench.write("run.csv", "t_s,u_V,y_um\n0,1,2\n");
    assert_eq!(bench.run("inspect run.csv").exit_code, 1);
}

#[test]
fn identify_asks_about_an_implausible_unit_on_stderr_and_in_its_findings() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_mm", |_, u, y| (0.0, u, 2.5 * y)));
    let run = bench.run("identify run.csv -o new.json --dynamics none --degree 1 --report new.html --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let part = "A stroke of 49.984 mm is implausible for a piezo actuator";
    assert_eq!(run.stderr.matches(part).count(), 1, "{}", run.stderr);
    let told: Value = serde_json::from_str(&run.stdout).unwrap();
    let mut findings = told["findings"].as_array().unwrap().iter();
    assert!(findings.any(|f| f["kind"] == "warning" && f["text"].as_str().unwrap().contains(part)));
    assert!(std::fs::read_to_string(bench.path("new.html")).unwrap().contains(part));
}

#[test]
fn identify_warns_of_a_saturated_sensor() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_um", |_, u, y| (0.0, u, y.min(17.0))));
    let run =
        bench.run("identify run.csv -o new.json --dynamics none --degree 1 --n 1 --generations 3 --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stderr.contains("output `y` looks saturated"), "{}", run.stderr);
}

#[test]
fn plots_are_drawn_by_the_ending_of_their_name() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_um", |_, u, y| (0.0, u, y)));
    assert_eq!(bench.run("inspect run.csv --plot run.svg").exit_code, 0);
    assert!(std::fs::read_to_string(bench.path("run.svg")).unwrap().starts_with("<svg"));
    assert_eq!(bench.run("inspect run.csv run.csv --plot run.html").exit_code, 0);
    let page = std::fs::read_to_string(bench.path("run.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("<svg"));
    for (arguments, code) in [
        ("inspect run.csv --plot run.pdf", 2),
        ("inspect run.csv run.csv --plot two.svg", 2),
        ("inspect run.csv --plot no/run.svg", 1),
    ] {
        let run = bench.run(arguments);
        assert_eq!(run.exit_code, code, "{arguments}: {run:?}");
    }
    assert!(!bench.path("two.svg").exists());
}

#[test]
fn columns_are_chosen_by_flags() {
    let bench = Bench::new();
    bench.write("run.csv", "time;drive;other;sensor_nm\n0;1;5;100\n0,5;2;6;200\n1;3;7;300\n1,5;2;6;200\n");
    let found = inspected(&bench, "--input other --output 4");
    assert_eq!(
        (&found["input"]["name"], &found["output"]["name"]),
        (&Value::from("other"), &Value::from("sensor"))
    );
    assert_eq!(found["output"]["high"].as_f64(), Some(0.3));
    assert_eq!(found["sample_rate_hz"].as_f64(), Some(2.0));
}

#[test]
fn a_sensor_in_volts_is_scaled_to_a_length_and_a_command_to_the_actuators_voltage() {
    let bench = Bench::new();
    bench.write("run.csv", "t_s,u_V,y_mV\n0,1,100\n0.1,2,200\n0.2,3,300\n0.3,2,200\n");
    assert!(bench.run("inspect run.csv").stderr.contains("--scale y=2.5um/V"));
    let found = inspected(&bench, "--scale y=2.5um/V --scale u=15V/V");
    assert_eq!(found["output"]["unit"], "um");
    assert!((found["output"]["high"].as_f64().unwrap() - 0.75).abs() < 1e-12);
    assert_eq!(found["input"]["high"].as_f64(), Some(45.0));
    assert_eq!(bench.run("inspect run.csv --scale y=fast").exit_code, 2);
    let run = bench.run("inspect run.csv --scale z=2um");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("no channel `z`"), "{}", run.stderr);
}

#[test]
fn an_npz_file_is_a_record_too_and_its_errors_name_file_and_array() {
    let bench = Bench::new();
    bench.write("loop.npz", include_bytes!("../../../hysteron-io/tests/data/loop.npz"));
    let run = bench.run("inspect loop.npz --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let found = &serde_json::from_str::<Value>(&run.stdout).unwrap()["records"][0];
    assert_eq!((&found["samples"], &found["sample_rate_hz"]), (&Value::from(500), &Value::from(200.0)));
    assert_eq!((&found["input"]["name"], &found["output"]["unit"]), (&Value::from("u"), &Value::from("um")));
    assert_eq!(found["drive"]["kind"], "sine");
    let run = bench.run("inspect loop.npz --input drive");
    assert_eq!(run.exit_code, 1, "{run:?}");
    for part in ["`loop.npz`: no column `drive` to be the input", "try: --input COL", "`u_V`, `y_um`"] {
        assert!(run.stderr.contains(part), "{run:?}");
    }
    bench.write("bad.npy", b"\x93NUMPY\x01\x00\x76\x00");
    let run = bench.run("inspect bad.npy");
    assert!(run.exit_code == 1 && run.stderr.contains("no sound NPY file: it ends in its header"), "{run:?}");
}

#[test]
fn segments_of_a_scanner_are_described_one_by_one() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/afm-z-scanner/cycle_1_300hz_01.csv");
    let bench = Bench::new();
    bench.write("run.csv", std::fs::read_to_string(example).unwrap());
    let found = inspected(&bench, "--input u_V --output y_um");
    let sines: Vec<(f64, f64, f64)> = found["segments"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|s| {
            Some((s["drive"]["high_hz"].as_f64()?.round(), s["gain"].as_f64()?, s["phase_deg"].as_f64()?))
        })
        .collect();
    assert_eq!(sines.iter().map(|s| s.0).collect::<Vec<_>>(), [300.0, 3.0, 100.0, 30.0, 1.0, 10.0]);
    // By least squares over the sines of all 16 cycles, with a spread of 0.0004 µm/V from cycle to cycle.
    let known =
        [(300.0, 0.0888), (100.0, 0.0892), (30.0, 0.0901), (10.0, 0.0905), (3.0, 0.0925), (1.0, 0.0922)];
    for (hz, gain) in known {
        let found = sines.iter().find(|s| s.0 == hz).unwrap();
        assert!((found.1 - gain).abs() < 0.001, "{found:?}");
    }
    assert!((sines[0].2 + 14.1).abs() < 0.7, "{sines:?}");
    let run = bench.run("inspect run.csv --input u_V --output y_um");
    for said in [
        "two amplitudes or more",
        "creep shows",
        "sine, 300.0 Hz",
        "creep                  | yes",
        "1 to 300 Hz",
    ] {
        assert!(run.stdout.contains(said), "{said}: {}", run.stdout);
    }
    for wrong in ["slow", "silent on dynamics", "not uniform"] {
        assert!(!run.stdout.contains(wrong), "{wrong}: {}", run.stdout);
    }
}

#[test]
fn a_file_of_named_arrays_is_listed_and_its_record_chosen_by_path() {
    let bench = Bench::new();
    bench.write("run.csv", record("t_s,u_V,y_um", |_, u, y| (0.0, u, y)));
    assert_eq!(bench.run("prepare run.csv -o run.mat").exit_code, 0);
    let run = bench.run("inspect run.mat");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(
        run.stdout.starts_with("run.mat holds\n")
            && run.stdout.contains("| y_um | 1000 × 1 | um   | numbers |")
    );
    let from_text = inspected(&bench, "");
    let run = bench.run("inspect run.mat --json");
    let of_mat = serde_json::from_str::<Value>(&run.stdout).unwrap()["records"][0].clone();
    assert_eq!(of_mat["input"], from_text["input"]);
    // Two columns could be the input: both are named, none is guessed.
    bench.write(
        "two.csv",
        record("t_s,u1_V,y_um,u2_V", |_, u, y| (0.0, u, y)).replace('\n', ",1\n").replacen(",1\n", "\n", 1),
    );
    assert_eq!(bench.run("prepare two.csv -o two.mat").exit_code, 0);
    let run = bench.run("inspect two.mat");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stdout.contains("u1_V") && run.stdout.contains("u2_V"), "{run:?}");
    assert!(run.stderr.contains("--input"), "{run:?}");
    assert_eq!(bench.run("inspect two.mat --input u1_V").exit_code, 0);
}

#[test]
fn drives_and_simulations_are_written_by_extension() {
    let bench = Bench::new();
    let sine = "excite sine --frequency 10 --sample-rate 1000 --high 3";
    for name in ["drive.csv", "drive.npz", "drive.mat"] {
        assert_eq!(bench.run(&format!("{sine} -o {name}")).exit_code, 0);
        let run = bench.run(&format!("simulate model.json {name} -o y_of_{name}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
    }
    let magic = |name: &str| std::fs::read(bench.path(name)).unwrap()[..4].to_vec();
    assert_eq!(
        (magic("y_of_drive.npz"), magic("y_of_drive.mat")),
        (b"PK\x03\x04".to_vec(), b"MATL".to_vec())
    );
    let as_text = |name: &str| {
        assert_eq!(bench.run(&format!("prepare {name} -o same.csv")).exit_code, 0);
        std::fs::read_to_string(bench.path("same.csv")).unwrap()
    };
    assert_eq!(as_text("y_of_drive.csv"), as_text("y_of_drive.mat"));
}
