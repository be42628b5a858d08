//! One command turns a measured record into a model file and a report; what cannot be identified is refused
//! with a reason, and nothing half-written stays behind.

use crate::bench::model_data;
use crate::bench::{Bench, Run, static_model};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::record::Timing;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The measured example record (PI P-885.91, MIT), its first `rows` samples.
fn measured(rows: usize) -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/piezo-p885-200hz/identification_1hz.csv");
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().take(rows + 1).map(|line| line.to_owned() + "\n").collect()
}

/// Loops of growing amplitude of a Bouc–Wen device, simulated.
fn simulated() -> String {
    let u: Vec<f64> =
        (0..400).map(|k| (1.0 + k as f64 / 200.0) * (1.0 - (TAU * k as f64 / 100.0).cos())).collect();
    let y = crate::bench::static_model().simulate(&u, None, &Start::Rest { voltage_v: 0.0 }).unwrap();
    let mut text = "t_s,u_V,y_um\n".to_owned();
    for (k, (u, y)) in u.iter().zip(&y).enumerate() {
        writeln!(text, "{},{u},{}", k as f64 / 100.0, y + 2.0).unwrap();
    }
    text
}

fn json(run: &Run) -> Value {
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap()
}

fn value(quantity: &Value) -> f64 {
    quantity["value"].as_f64().unwrap()
}

#[test]
fn the_measured_stack_gives_loop_delay_and_lag_with_no_flag() {
    let bench = Bench::new();
    bench.write("stack.csv", measured(2000));
    let run = bench.run("identify stack.csv -o stack.json --report stack.html --figures figures --json");
    let told = json(&run);
    assert_eq!(told["records"][0]["record"], "stack.csv");
    assert!(told["records"][0]["rmse_um"].as_f64().unwrap() < 0.3);
    let model: Value =
        serde_json::from_str(&std::fs::read_to_string(bench.path("stack.json")).unwrap()).unwrap();
    assert_eq!(model["hysteresis"]["kind"], "bouc-wen");
    assert!(value(&model["hysteresis"]["parameters"]["alpha"]) > 0.0, "counter-clockwise");
    assert_eq!(model["dynamics"]["kind"], "integer");
    let lag = value(&model["dynamics"]["denominator"][1]["coefficient"]);
    assert!((0.0125..0.0150).contains(&lag), "lag {lag} s");
    let delay = value(&model["delay"]);
    assert!((0.004..0.010).contains(&delay), "delay {delay} s: one to two samples");
    assert!(model["delay"]["std_error"].as_f64().unwrap() > 0.0);
    let findings = told["findings"].to_string();
    assert!(findings.contains("do not determine the frequency dependence of the loop"), "{findings}");
    assert!(findings.contains("counter-clockwise"), "{findings}");
    let report = std::fs::read_to_string(bench.path("stack.html")).unwrap();
    assert!(report.contains("<svg") && report.contains("SHA-256"));
    assert!(std::fs::read_dir(bench.path("figures")).unwrap().count() >= 4);
    let scored = json(&bench.run("validate stack.json stack.csv --json"));
    assert_eq!(scored["records"][0]["rmse_um"], told["records"][0]["rmse_um"]);
}

#[test]
fn parameters_come_back_and_demands_are_kept() {
    let bench = Bench::new();
    bench.write("loop.csv", simulated());
    json(&bench.run("identify loop.csv -o all.json --json"));
    let file = model_data(&bench.path("all.json"));
    for (name, truth) in
        [("linear", 0.3), ("quadratic", 1e-4), ("alpha", 0.08), ("beta", 0.05), ("gamma", 0.01)]
    {
        let found = file.hysteresis.parameters.get(name).unwrap().value;
        assert!((found / truth - 1.0).abs() < 1e-3, "{name} = {found}");
    }
    json(&bench.run(
        "identify loop.csv -o held.json --degree 2 --fix gamma=0 --bound beta=0.04:0.06 --delay 0 --json",
    ));
    let held = model_data(&bench.path("held.json"));
    assert_eq!(held.hysteresis.parameters.get("gamma").unwrap().value, 0.0);
    assert_eq!(held.provenance.unwrap().options["fix gamma"], "0");
    json(&bench.run(
        "identify loop.csv -o again.json --degree 2 --optimizer de --generations 5 --start all.json --json",
    ));
    let again = model_data(&bench.path("again.json"));
    // A search that begins at the optimum ends there, to what its last step rounds.
    let [again, first] = [again, file].map(|file| file.hysteresis.parameters.get("beta").unwrap().value);
    assert!((again / first - 1.0).abs() < 1e-9, "{again} {first}");
}

#[test]
fn a_search_cut_short_is_not_trusted() {
    let bench = Bench::new();
    bench.write("loop.csv", simulated());
    let part = "The search of the joint fit was too short to be trusted";
    let flags = "--degree 2 --optimizer de-abc --report new.html --json";
    let run = bench.run(&format!("identify loop.csv -o new.json {flags} --generations 5"));
    assert!(run.stderr.contains(&format!("warning: {part}")), "{}", run.stderr);
    assert!(json(&run)["findings"].to_string().contains(part));
    assert!(std::fs::read_to_string(bench.path("new.html")).unwrap().contains(part));
    // Least squares ends by itself, and a population does once it stands still.
    for (out, flags) in [
        ("all.json", "--degree 2"),
        ("again.json", "--degree 2 --optimizer de --generations 60 --start all.json --delay 0"),
    ] {
        let run = bench.run(&format!("identify loop.csv -o {out} {flags} --json"));
        assert!(!run.stderr.contains("too short") && run.exit_code == 0, "{flags}: {}", run.stderr);
    }
}

/// Content, flags, parts of the message.
const REFUSED: &[(&str, &str, &[&str])] = &[
    ("", "", &["`run.csv` is empty"]),
    ("t_s,u_V,y_um\n0,1,2\n", "", &["one sample only"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,NaN,3\n0.2,3,4\n", "", &["line 3, column 2 (`u_V`)"]),
    ("t_s,u_V,y_um\n0,1,2\n0.1,2,3\n0.2,3,4\n0.3,2,3\n", "", &["need at least 20 valid samples but found 4"]),
];

#[test]
fn unusable_records_leave_no_model_behind() {
    for (content, flags, parts) in REFUSED {
        let bench = Bench::new();
        bench.write("run.csv", content);
        let run = bench.run(&format!("identify run.csv -o new.json --report new.html {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{run:?}");
        for part in *parts {
            assert!(run.stderr.contains(part), "{part} in {}", run.stderr);
        }
        assert_eq!(bench.files(), ["model.json", "run.csv"]);
    }
}

fn record(sample: impl Fn(f64) -> (f64, f64)) -> String {
    let mut text = "t_s,u_V,y_um\n".to_owned();
    for k in 0..400 {
        let t = f64::from(k) / 100.0;
        let (u, y) = sample(t);
        writeln!(text, "{t},{u},{y}").unwrap();
    }
    text
}

#[test]
fn what_cannot_be_identified_is_said_with_the_reason() {
    let swing = |t: f64| 5.0 - 5.0 * (TAU * t).cos();
    let cases = [
        (record(|t| (5.0, t)), "", "the input is constant (5)"),
        (record(|t| (swing(t), 1.5)), "", "the output is constant (1.5)"),
        (
            record(|t| (swing(t) - 5.0, (swing(t) - 5.0).abs() * (1.0 + (7.0 * t).sin()))),
            "",
            "does not describe record",
        ),
        (record(|t| (swing(t), 2.0 * swing(t))), "--dynamics fractional", "holds quasi-static records only"),
    ];
    for (content, flags, part) in cases {
        let bench = Bench::new();
        bench.write("run.csv", content);
        let run = bench.run(&format!("identify run.csv -o new.json {flags}"));
        assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{run:?}");
        assert!(run.stderr.contains(part), "{part} in {}", run.stderr);
        assert_eq!(bench.files(), ["model.json", "run.csv"]);
    }
}

#[test]
fn uneven_time_is_fitted_statically_and_with_dynamics_as_it_is() {
    let bench = Bench::new();
    let model = Model {
        dynamics: Dynamics::Integer(TransferFunction::new(vec![Term::new(1.0, 0.0)], lag(0.01)).unwrap()),
        delay_s: 0.002,
        ..static_model()
    };
    // A slow loop at 200 Hz and a pause, then a fast sine at 2 kHz, on stamps that are rounded.
    let slow = (0..600).map(|k| f64::from(k) / 200.0);
    let times_s: Vec<f64> = slow.chain((0..1000).map(|k| 3.2 + f64::from(k) / 2000.0)).collect();
    let drive = |t: f64| 5.0 - 5.0 * (TAU * t).cos() + if t > 3.1 { (TAU * 30.0 * t).sin() } else { 0.0 };
    let u: Vec<f64> = times_s.iter().map(|t| drive(*t)).collect();
    let y = model.simulate(&u, Timing::Stamps(&times_s), &Start::Rest { voltage_v: 0.0 }).unwrap();
    let mut parts = ["t_s,u_V,y_um\n".to_owned(), "t_s,u_V,y_um\n".to_owned()];
    for ((t, u), y) in times_s.iter().zip(&u).zip(&y) {
        writeln!(parts[usize::from(*t > 3.1)], "{t:.6},{u},{y}").unwrap();
    }
    let [slow, fast] = &parts;
    bench.write("slow.csv", slow);
    bench.write("fast.csv", fast);
    bench.write("both.csv", format!("{slow}{}", fast.split_once('\n').unwrap().1));
    json(&bench.run("identify both.csv -o static.json --dynamics none --delay 0 --json"));
    let flags = "--dynamics integer --order 1 --degree 1 --json";
    let one = json(&bench.run(&format!("identify both.csv -o one.json {flags}")));
    let run = bench.run(&format!("identify slow.csv fast.csv --continued -o parts.json {flags}"));
    let two = json(&run);
    assert_eq!(one["records"][0]["samples"], 1600);
    let samples: Vec<_> = two["records"].as_array().unwrap().iter().map(|r| r["samples"].clone()).collect();
    assert_eq!(samples, [600, 1000]);
    assert_eq!(two["whole"]["samples"], 1600);
    for found in [&one, &two] {
        let value = |name: &str| {
            let of_name = |p: &&serde_json::Value| p["name"] == name;
            found["parameters"].as_array().unwrap().iter().find(of_name).unwrap()["value"].as_f64().unwrap()
        };
        assert!((value("lag") - 0.01).abs() < 2e-4, "{found}");
        assert!((value("delay") - 0.002).abs() < 2e-4, "{found}");
    }
    let scored = json(&bench.run("validate parts.json slow.csv fast.csv --continued --json"));
    let rmse = |score: &serde_json::Value| score["rmse_um"].as_f64().unwrap();
    assert!((rmse(&scored["whole"]) - rmse(&two["whole"])).abs() < 1e-3, "{scored}");
    // Parts simulated at one go are the whole; what was measured stays beside it.
    for (files, out) in [("slow.csv fast.csv --continued", "in_parts.csv"), ("both.csv", "whole.csv")] {
        assert_eq!(bench.run(&format!("simulate parts.json {files} -o {out}")).exit_code, 0);
    }
    let written = |name: &str| {
        let text = std::fs::read_to_string(bench.path(name)).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        assert_eq!(header, "t_s,u_V,y_um,y_measured_um");
        rows.lines().map(|row| row.split(',').nth(2).unwrap().parse().unwrap()).collect::<Vec<f64>>()
    };
    let (parts, whole) = (written("in_parts.csv"), written("whole.csv"));
    assert_eq!((parts.len(), whole.len()), (1600, 1600));
    assert!(parts.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-9));
    assert_eq!(bench.run("simulate parts.json slow.csv fast.csv -o x.csv").exit_code, 2);
    assert_eq!(bench.run("simulate parts.json fast.csv slow.csv --continued -o x.csv").exit_code, 1);
    // Each part is left out in turn, memory carries over.
    let compared = "compare slow.csv fast.csv --continued --candidates none,integer1 --json -o best.json";
    let compared = json(&bench.run(compared));
    let left_out: Vec<_> =
        compared["folds"].as_array().unwrap().iter().map(|f| f["left_out"].clone()).collect();
    assert_eq!(left_out, ["slow.csv", "fast.csv"], "{compared}");
    assert!(bench.path("best.json").exists());
    // Gain and delay of a device that has not changed, from the parts.
    let again = json(&bench.run("recalibrate parts.json slow.csv fast.csv --continued -o again.json --json"));
    assert!((again["gain"]["measured"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{again}");
    assert!((again["delay_s"]["measured"].as_f64().unwrap() - 0.002).abs() < 2e-4, "{again}");
    assert_eq!(scored["records"].as_array().unwrap().len(), 2);
    // On their own they are two records, and the command says that they could be parts of one run.
    let apart = bench.run(&format!("identify slow.csv fast.csv -o apart.json {flags}"));
    assert!(apart.stdout.contains("continue-run"), "{apart:?}");
}

fn lag(time_s: f64) -> Vec<Term> {
    vec![Term::new(1.0, 0.0), Term::new(time_s, 1.0)]
}

#[test]
fn usage_errors_exit_2() {
    let bench = Bench::new();
    bench.write("run.csv", simulated());
    for flags in [
        "--optimizer magic",
        "--n soft",
        "--fix gamma",
        "--bound beta=1",
        "--generations -3",
        "--scheme euler",
    ] {
        let run = bench.run(&format!("identify run.csv -o new.json {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {}", run.stderr);
    }
    for (flags, part) in [
        ("--fix gama=1", "there is no parameter 'gama'"),
        ("--fix cubic=1 --degree 2", "there is no parameter 'cubic'"),
        ("--fix delay=0.1 --delay 0.2", "there is no parameter 'delay'"),
        ("--degree 12", "a whole number from 1 to 9"),
    ] {
        let run = bench.run(&format!("identify run.csv -o new.json {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {}", run.stderr);
        assert!(run.stderr.contains(part), "{part} in {}", run.stderr);
    }
    assert_eq!(bench.run("identify -o new.json").exit_code, 2);
    assert_eq!(bench.run("identify run.csv").exit_code, 2);
}
