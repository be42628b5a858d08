//! `track` plays a reference on the simulated bench and on the model, and says what each controller leaves.

use std::f64::consts::TAU;

use crate::bench::Bench;
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::SignalUnits;
use hysteron_model::record::InterSample;
use hysteron_model::tracking::{Controller, TrackingSummary};
use serde_json::Value;

/// About the default bench: its size, its first mode, its delay.
fn stage() -> Model {
    let natural = TAU * 475.0;
    let term = |coefficient, order| Term { coefficient, order };
    let square = natural * natural;
    let mode = TransferFunction::new(
        vec![term(square, 0.0)],
        vec![term(square, 0.0), term(0.06 * natural, 1.0), term(1.0, 2.0)],
    );
    Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![2.6, 0.01], -0.9, 0.3, 0.0, 1.0).unwrap()),
        dynamics: Dynamics::Integer(mode.unwrap()),
        offset: 0.0,
        delay_s: 2e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Hold,
        sample_rate_hz: Some(1e4),
    }
}

fn scan(samples: usize) -> String {
    let rows = (0..samples).map(|k| {
        let t = k as f64 / 1e4;
        format!("{t},{}\n", 12.0 - 5.0 * (TAU * 20.0 * t).cos())
    });
    format!("t_s,target_um\n{}", rows.collect::<String>())
}

fn bench(samples: usize) -> Bench {
    let bench = Bench::new();
    bench.write_model("stage.json", &stage(), SignalUnits::default());
    bench.write("scan.csv", scan(samples));
    bench
}

fn rms(made: &Value, controller: &str) -> f64 {
    let rows = made["controllers"].as_array().unwrap();
    let row = rows.iter().find(|row| row["controller"] == controller).unwrap();
    row["rms_percent_of_stroke"].as_f64().unwrap()
}

#[test]
fn every_controller_is_played_and_the_files_are_written() {
    let bench = bench(2000);
    let run = bench.run(
        "track stage.json scan.csv --plant rig --range 0:10.5 --json -o track.csv --report track.html --seed \
         3 --sines 10:1000",
    );
    assert_eq!(run.exit_code, 0, "{run:?}");
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    let read: TrackingSummary = serde_json::from_str(&run.stdout).unwrap();
    let others = read.controllers.iter().filter(|c| c.controller != Controller::Uncompensated);
    let best = others.min_by(|a, b| a.rms.unwrap().total_cmp(&b.rms.unwrap())).unwrap().controller.words();
    assert_eq!(serde_json::to_value(read).unwrap(), made);
    assert_eq!((&made["simulated"], &made["plant"]), (&Value::from(true), &Value::from("rig")));
    assert_eq!(made["controllers"].as_array().unwrap().len(), 14);
    for row in made["controllers"].as_array().unwrap() {
        if !row["law"].is_null() {
            assert!(row["gain_margin"].as_f64().is_none_or(|m| m >= 2.0), "{row}");
            assert!(row["phase_margin_deg"].as_f64().is_none_or(|m| m >= 60.0), "{row}");
        }
        assert_eq!(row["adaptation"].is_null(), !row["controller"].as_str().unwrap().ends_with("lms"));
        if let Some(margin) = row["adaptation"]["step_margin"].as_f64() {
            assert!(margin >= 2.0, "{row}");
            assert!(row["adaptation"]["phase_margin_deg"].as_f64().unwrap() > 0.0, "{row}");
        }
        assert!(row["sines"].as_array().unwrap().len() >= 5, "{row}");
    }
    let csv = std::fs::read_to_string(bench.path("track.csv")).unwrap();
    assert!(csv.starts_with("t_s,reference_um,u_uncompensated_V,y_uncompensated_um,"), "{}", &csv[..80]);
    assert_eq!(csv.lines().count(), 2001);
    let page = std::fs::read_to_string(bench.path("track.html")).unwrap();
    // The first figure shows the best of them beside none.
    let first = page.split("<figure ").nth(1).unwrap().split("</figure>").next().unwrap();
    let none = Controller::Uncompensated.words();
    assert!(
        first.contains(&format!(">{best}</text>")) && first.contains(&format!(">{none}</text>")),
        "{best}"
    );
    assert!(page.contains(&format!("{best} leaves the least error of 14 controllers")), "{best}");
    for words in [
        "simulated",
        "Error over time",
        "inverse, preview + observer",
        "phase margin",
        "Tracking error against frequency",
        "best weights",
    ] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn on_the_model_itself_the_inverse_is_exact_and_a_slow_amplifier_is_seen() {
    let bench = bench(3000);
    let flags =
        "--range 0:10.5 --plant model --controller feedforward --controller causal --json --sines 10:1000";
    let run = bench.run(&format!("track stage.json scan.csv {flags}"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(rms(&made, "feedforward") < 1e-3 && rms(&made, "causal") > 0.1, "{made}");
    // 1 mA into 10 µF: 100 V/s, half of what 5 µm of 20 Hz need.
    let run = bench.run(&format!("track stage.json scan.csv {flags} --current 1 --capacitance 10"));
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!((made["slew_V_per_s"].as_f64().unwrap() - 100.0).abs() < 1e-9, "{made}");
    assert!(made["controllers"][0]["samples_at_slew"].as_u64().unwrap() > 100, "{made}");
    assert_eq!(made["reach"].as_array().unwrap().len(), 5);
    let run = bench.run("track stage.json scan.csv --range 0:10.5 --plant model --controller pi");
    assert!(run.stdout.contains("Simulated") && run.stdout.contains("phase margin"), "{}", run.stdout);
}

/// The uncompensated stage leaves its loop, which no formula of a linear model knows of; the inverse of a
/// linear stage is what its formula says.
#[test]
fn bandwidths_are_measured_and_a_difference_is_said() {
    let bench = bench(2000);
    let flags = "--range 0:10.5 --plant model --controller uncompensated --controller causal --sines 5:1000";
    let run = bench.run(&format!("track stage.json scan.csv {flags} --json"));
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    let row = |i: usize| &made["controllers"][i];
    // Below the lowest sine.
    assert!(row(0)["one_percent_error_played_hz"].is_null() && row(0)["bandwidths_differ"] == true, "{made}");
    for key in ["minus_3_db", "one_percent_error"] {
        let [formula, played] =
            ["formula", "played"].map(|how| row(1)[format!("{key}_{how}_hz")].as_f64().unwrap());
        assert!((played / formula - 1.0).abs() < 0.1, "{key}: {formula} {played}");
    }
    assert_eq!(row(1)["bandwidths_differ"], false);
    let run = bench.run(&format!("track stage.json scan.csv {flags}"));
    assert!(run.stdout.contains("For 1 of 2 controllers") && run.stdout.contains("| < 5"), "{}", run.stdout);
}

#[test]
fn a_loop_that_oscillates_is_not_recommended() {
    let bench = bench(2000);
    // The model's only mode lies far above the bench's own, so that the feedback is tuned much too fast.
    let natural = TAU * 4000.0;
    let term = |coefficient, order| Term { coefficient, order };
    let square = natural * natural;
    let fast = TransferFunction::new(
        vec![term(square, 0.0)],
        vec![term(square, 0.0), term(1.4 * natural, 1.0), term(1.0, 2.0)],
    );
    let model = Model { dynamics: Dynamics::Integer(fast.unwrap()), delay_s: 0.0, ..stage() };
    bench.write_model("fast.json", &model, SignalUnits::default());
    let controllers = "--range 0:10.5 --controller feedforward --controller feedforward-pi --sines 10:100";
    let run = bench.run(&format!("track fast.json scan.csv {controllers} --json"));
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(
        [0, 1].map(|i| made["controllers"][i]["runs_away"].as_bool().unwrap()),
        [false, true],
        "{made}"
    );
    let run = bench.run(&format!("track fast.json scan.csv {controllers}"));
    assert!(run.stdout.contains("verdict: Do not use: inverse, preview + PI."), "{}", run.stdout);
    let run = bench.run(&format!("track stage.json scan.csv {controllers}"));
    assert!(!run.stdout.contains("Do not use"), "{}", run.stdout);
}

#[test]
fn what_is_not_known_behind_the_end_is_not_scored() {
    let bench = bench(2000);
    // 2000 samples end at rest of a period; 1987 in mid-swing.
    bench.write("cut.csv", scan(1987));
    let run = bench.run(
        "track stage.json cut.csv --plant model --range 0:10.5 --controller feedforward --json --sines \
                         10:100",
    );
    let made: Value = serde_json::from_str(&run.stdout).unwrap();
    let to = made["scored_to_s"].as_f64().unwrap();
    assert!(0.15 < to && to < 0.1987, "{to}");
    let row = &made["controllers"][0];
    assert!(row["max_percent_of_stroke"].as_f64().unwrap() < 0.02, "{row}");
    let run =
        bench.run("track stage.json cut.csv --plant model --range 0:10.5 --controller feedforward --skip 5");
    assert_eq!(run.exit_code, 2, "{run:?}");
    assert!(run.stderr.contains("nothing is left to score"), "{}", run.stderr);
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let bench = bench(500);
    let refused = |arguments: &str, words: &str, code: i32| {
        let run = bench.run(&format!("track {arguments}"));
        assert_eq!(run.exit_code, code, "{run:?}");
        assert!(run.stderr.contains(words), "{words}: {}", run.stderr);
    };
    refused("stage.json scan.csv", "--range", 1);
    refused("stage.json scan.csv --range 0:1 --controller feedforward", "widen --range", 1);
    refused("model.json scan.csv --range 0:100 --controller notch-integral", "no resonance", 1);
    refused("stage.json scan.csv --range 0:10 --current 5", "capacitance", 2);
    refused("stage.json scan.csv --range 0:10 --sines 10:5000", "--sines", 2);
    // A period of a million samples at 10 kHz.
    refused("stage.json scan.csv --range 0:10 --sines 1e-9:10", "the lowest that is played is 0.01 Hz", 2);
    bench.write("kilograms.csv", scan(2000).replace("_um", "_kg"));
    refused("stage.json kilograms.csv --range 0:10", "the reference in kg", 1);
    refused("stage.json scan.csv --range 0:10 --out missing/track.csv", "mkdir", 1);
    refused("stage.json scan.csv --range 0:10 --truth missing.json", "truth", 1);
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_long_simulation_and_writes_nothing() {
    let bench = bench(20_000);
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(["track", "stage.json", "scan.csv", "--plant", "rig", "--range", "0:10.5", "-o", "out.csv"])
        .current_dir(bench.path("."))
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Its first line of progress comes after ten seconds: the signal is heard from the first sample on.
    std::thread::sleep(std::time::Duration::from_secs(2));
    assert!(child.try_wait().unwrap().is_none(), "fourteen controllers take longer");
    let signal = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(signal.unwrap().success());
    let begun = std::time::Instant::now();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(begun.elapsed().as_secs() < 20 && said.contains("the simulation was interrupted"), "{said}");
    assert!(!bench.path("out.csv").exists());
}
