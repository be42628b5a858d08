//! `adapt` follows a device whose gain changes, says when, writes the model of the last sample, and is silent
//! where nothing changes.

use crate::bench::model_data;
use crate::bench::{Bench, static_model, triangle};
use hysteron_model::Start;
use serde_json::Value;

const NOISE_UM: f64 = 0.01;

/// Ten seconds of the triangle, five times over, and what a device does whose gain is `late` from the sixth
/// second on.
fn record(late: f64) -> String {
    let u = triangle().repeat(5);
    let y = static_model().simulate(&u, Some(100.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
    // Equally spread, standard deviation NOISE_UM: a linear congruential generator (Knuth's MMIX constants).
    let mut state = 1u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        NOISE_UM * 12f64.sqrt() * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
    };
    let rows = u.iter().zip(&y).enumerate().map(|(k, (u, y))| {
        let gain = if k < 500 { 1.0 } else { late };
        format!("{},{u},{}\n", k as f64 / 100.0, gain * y + noise())
    });
    format!("t_s,u_V,y_um\n{}", rows.collect::<String>())
}

fn json(bench: &Bench, arguments: &str) -> Value {
    let run = bench.run(arguments);
    assert_eq!(run.exit_code, 0, "{run:?}");
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn a_jump_of_the_gain_is_found_followed_and_written() {
    let bench = Bench::new();
    bench.write("day.csv", record(1.05));
    for method in ["rls --memory 1 --reopen", "nlms --step 0.05 --terms gain"] {
        let found = json(
            &bench,
            &format!("adapt model.json day.csv --noise {NOISE_UM} --method {method} -o new.json --json"),
        );
        let gain = found["coefficients"].as_array().unwrap().last().unwrap();
        assert_eq!((&gain["term"], &gain["before"]), (&"gain".into(), &1.0.into()));
        assert!((gain["after"].as_f64().unwrap() - 1.05).abs() < 5e-3, "{method}: {found}");
        // 0.3 V a sample: a tenth of a micrometre, ten times the noise, within three samples of the jump.
        let first = found["alarms"][0]["time_s"].as_f64().unwrap();
        assert!((5.0..5.2).contains(&first), "{method}: {found}");
        assert_eq!(found["fits"], false);
        let rmse = |name: &str| found[name].as_f64().unwrap();
        assert!(rmse("rmse_predicted") < 0.2 * rmse("rmse_before"), "{method}: {found}");
        assert_eq!(gain["std_error"].is_null(), method.starts_with("nlms"));

        let new = model_data(&bench.path("new.json"));
        let block = new.to_model().unwrap().hysteresis;
        let ratio = block.number("alpha").unwrap() / static_model().hysteresis.number("alpha").unwrap();
        assert!((ratio / gain["after"].as_f64().unwrap() - 1.0).abs() < 1e-12, "{method}");
        assert_eq!(new.scores[0].rmse, rmse("rmse_last_coefficients"));
        let provenance = new.provenance.unwrap();
        assert_eq!((provenance.options["method"].as_str(), provenance.records[0].samples), ("adapt", 1000));
    }
    let text = bench.run(&format!("adapt model.json day.csv --noise {NOISE_UM} --memory 1")).stdout;
    for part in ["| gain ", "model as it was", "verdict: the corrected model no longer fits: first at 5."] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn where_nothing_changes_there_is_no_alarm_and_the_error_is_the_noise() {
    let bench = Bench::new();
    bench.write("day.csv", record(1.0));
    let arguments = format!(
        "adapt model.json day.csv --noise {NOISE_UM} --every 1 --terms offset,gain,power=2,creep=0.5"
    );
    let found = json(&bench, &format!("{arguments} --json"));
    assert_eq!((&found["fits"], &found["alarms"]), (&true.into(), &Value::Array(Vec::new())));
    assert!(found["model"].is_null());
    assert_eq!(found["coefficients"].as_array().unwrap().len(), 4);
    let rmse = found["rmse_predicted"].as_f64().unwrap();
    assert!((rmse / NOISE_UM - 1.0).abs() < 0.15, "{found}");
    assert!(bench.run(&arguments).stdout.contains("verdict: the corrected model fits"));
}

#[test]
fn what_cannot_be_followed_is_refused_before_anything_is_written() {
    let bench = Bench::new();
    bench.write("day.csv", record(1.0));
    for (arguments, exit_code, says) in [
        ("--terms offset,creep=0.5 -o new.json", 2, "no place for its coefficient"),
        ("--terms offset,delay", 2, "expected offset, gain, power=N or creep=SECONDS"),
        ("--terms gain,gain", 1, "is a duplicate"),
        ("--method nlms --step 2.5", 1, "step"),
    ] {
        let run = bench.run(&format!("adapt model.json day.csv {arguments}"));
        assert_eq!(run.exit_code, exit_code, "{run:?}");
        assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
    }
    bench.write("timeless.csv", "u_V,y_um\n0,0\n1,0.3\n2,0.6\n1,0.3\n0,0\n");
    let run = bench.run("adapt model.json timeless.csv -o new.json");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("--sample-rate"), "{}", run.stderr);
    assert_eq!(bench.files(), ["day.csv", "model.json", "timeless.csv"]);
}
