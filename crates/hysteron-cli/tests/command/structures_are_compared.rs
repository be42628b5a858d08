//! `compare` ranks structures by what they predict, refuses where nothing is left to predict; `inspect` says
//! before any fit what the records determine.

use crate::bench::model_data;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::bench::Bench;

/// The article's campaign, shorter and slower.
const PLAN: &str = r#"{ "sample_rate_hz": 2000, "loop_periods": 3, "sweep_s": 3, "sweep_end_hz": 80,
    "validation_hz": [12, 40], "validation_s": 0.5 }"#;

fn measured() -> Bench {
    let bench = Bench::new();
    bench.write("plan.json", PLAN);
    assert_eq!(bench.run("rig --out-dir bench --plan plan.json").exit_code, 0);
    bench
}

const LOOP: &str = "bench/simulated_loop_1hz.csv";
const SWEEP: &str = "bench/simulated_sweep_1_80hz.csv";
const SINES: &str = "bench/simulated_sine_12hz.csv bench/simulated_sine_40hz.csv";

#[test]
fn identify_chooses_the_family_by_held_out_error_on_request() {
    let bench = measured();
    let run = bench.run(&format!("identify {LOOP} {SWEEP} --hysteresis auto --json -o auto.json"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let family = &found["family"];
    // The bench is a stack of plays.
    let chosen = family["chosen"].as_str().unwrap();
    assert_ne!(chosen, "bouc-wen", "{family}");
    let error = |name: &str| family["errors"][name].as_f64().unwrap();
    assert!(error(chosen) < 0.5 * error("bouc-wen") && family["errors"].as_object().unwrap().len() == 3);
    assert_eq!(found["findings"][0]["text"], family["verdict"]);
    assert_eq!(found["hysteresis"]["kind"], family["chosen"]);
    let one = bench.run(&format!("identify {LOOP} --hysteresis auto --json -o one.json"));
    let found: Value = serde_json::from_str(&one.stdout).unwrap();
    assert!(found["family"]["verdict"].as_str().unwrap().contains("one amplitude and one frequency"));
    assert_eq!(found["family"]["errors"].as_object().unwrap().len(), 0);
}

#[test]
fn a_campaign_ranks_dynamics_before_none_and_writes_the_model_that_it_prefers() {
    let bench = measured();
    let run = bench.run(&format!(
        "compare {LOOP} {SWEEP} {SINES} --candidates none,integer2,fractional+degree2 --json --report \
         compare.html -o new.json"
    ));
    assert_eq!((run.exit_code, run.stdout.trim_end().lines().count()), (0, 1), "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let folds = found["folds"].as_array().unwrap();
    assert_eq!(folds.len(), 4);
    assert!(folds.iter().any(|f| f["left_out"] == "simulated_sine_12hz.csv" && f["content"] == "5 V, 12 Hz"));
    let candidates = found["candidates"].as_array().unwrap();
    let names: Vec<&str> = candidates.iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names[0], "fractional+degree2", "{found}");
    let error = |name: &str| {
        let place = names.iter().position(|n| *n == name).unwrap();
        candidates[place]["error"].as_f64().unwrap()
    };
    assert!(error("fractional+degree2") < 0.8 * error("none"), "{found}");
    assert!(found["noise_floor"].as_f64().unwrap() < error("fractional+degree2"));
    assert_eq!(found["interrupted"], false);
    assert!(found.get("baselines").is_none(), "{found}");
    // Every candidate runs sample by sample; dynamics cost more than none.
    let cost = |name: &str| {
        let place = names.iter().position(|n| *n == name).unwrap();
        let entry = &candidates[place];
        assert!(["always", "on records"].contains(&entry["invertible"].as_str().unwrap()), "{entry}");
        (entry["states"].as_u64().unwrap(), entry["nanoseconds_per_sample"].as_f64().unwrap())
    };
    assert_eq!((cost("none").0, cost("integer2").0), (0, 2));
    assert!(cost("fractional+degree2").0 > 2 && cost("fractional+degree2").1 > cost("none").1, "{found}");
    let page = std::fs::read_to_string(bench.path("compare.html")).unwrap();
    assert!(page.contains("Error against cost") && page.contains("inverse"));
    assert!(page.contains("<svg") && page.contains("noise floor") && page.contains("fractional+degree2"));
    assert!(run.stderr.contains(&format!("model of {} written", found["preferred"].as_str().unwrap())));
    model_data(&bench.path("new.json")).to_model().unwrap();
}

#[test]
fn the_table_is_for_people() {
    let bench = measured();
    let run = bench.run(&format!("compare {LOOP} {SWEEP} --candidates none,integer2"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    for part in [
        "held-out error [µm]",
        "ns per sample",
        "inverse",
        "Preferred: ",
        "loop_1hz.csv",
        "sweep_1_80hz.csv 2/2",
        "one amplitude",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
}

#[test]
fn baselines_stand_beside_the_structures_on_the_same_folds() {
    let bench = Bench::new();
    let plan = r#"{ "sample_rate_hz": 200, "loop_periods": 2, "sweep_s": 2.5, "sweep_end_hz": 10,
        "validation_hz": [5], "validation_s": 0.8 }"#;
    bench.write("plan.json", plan);
    assert_eq!(bench.run("rig --out-dir bench --plan plan.json").exit_code, 0);
    let records =
        "bench/simulated_loop_1hz.csv bench/simulated_sweep_1_10hz.csv bench/simulated_sine_5hz.csv";
    let run =
        bench.run(&format!("compare {records} --candidates none --baselines --json --report compare.html"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let baselines = found["baselines"].as_array().unwrap();
    let names: Vec<&str> = baselines.iter().map(|b| b["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["polynomial-narx", "kernel-narx", "neural-narx"]);
    let folds = found["folds"].as_array().unwrap();
    let sine = folds.iter().position(|f| f["left_out"] == "simulated_sine_5hz.csv").unwrap();
    for baseline in baselines {
        let errors = baseline["fold_errors"].as_array().unwrap();
        assert_eq!(errors.len(), folds.len(), "{baseline}");
        // An error or the reason why there is none.
        let missing = errors.iter().filter(|e| e.is_null()).count();
        assert_eq!(missing, baseline["failures"].as_array().unwrap().len(), "{baseline}");
        assert_eq!(baseline["error"].is_null(), missing > 0, "{baseline}");
        assert!(baseline["parameters"].as_u64().unwrap() > 0, "{baseline}");
        // The stroke is 30 µm; the sweep holds this frequency at this amplitude.
        assert!(errors[sine].as_f64().unwrap() < 1.0, "{baseline}");
    }
    let page = std::fs::read_to_string(bench.path("compare.html")).unwrap();
    assert!(page.contains("Black-box baselines") && page.contains("kernel-narx"));
}

#[test]
fn one_loop_many_times_is_refused_with_what_to_measure() {
    let record = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples/piezo-p885-200hz/identification_1hz.csv")
        .canonicalize()
        .unwrap();
    let run = Bench::new().run(&format!("compare {}", record.display()));
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{run:?}");
    for part in ["cannot be ranked", "one amplitude and one frequency (1.8 V, 1 Hz)", "try: measure a sweep"]
    {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
}

#[test]
fn a_comparison_without_time_says_so() {
    let run =
        measured().run(&format!("compare {LOOP} {SWEEP} {SINES} --quick --time-limit 1e-6 -o new.json"));
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("the time given was over before the first candidate"), "{}", run.stderr);
    let run = Bench::new().run("compare run.csv --quick --candidates none");
    assert_eq!(run.exit_code, 2, "{run:?}");
    assert!(run.stderr.contains("--quick") && run.stderr.contains("--candidates"), "{}", run.stderr);
}

#[cfg(unix)]
#[test]
fn an_interrupted_comparison_keeps_the_model_preferred_so_far() {
    let bench = measured();
    bench.write("new.json", "precious");
    // The second candidate takes far longer than the first; wait longer on a slow machine.
    let kept = [2, 6, 20].into_iter().any(|seconds| {
        let child = Command::new(env!("CARGO_BIN_EXE_hysteron"))
            .args(format!("compare {LOOP} {SWEEP} {SINES} -o new.json").split_whitespace())
            .current_dir(bench.path("."))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_secs(seconds));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{said}");
        let kept = said.contains("is in new.partial.json");
        assert!(kept || said.contains("no structure could be compared"), "{said}");
        if kept {
            assert!(String::from_utf8(output.stdout).unwrap().contains("Preferred: "));
        }
        kept
    });
    assert!(kept);
    assert_eq!(std::fs::read_to_string(bench.path("new.json")).unwrap(), "precious");
    let run = bench.run(&format!("validate new.partial.json {SWEEP}"));
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
}

/// Waits until a file is there.
#[cfg(unix)]
fn wait_for(path: &std::path::Path) {
    let begun = std::time::Instant::now();
    while !path.exists() {
        assert!(begun.elapsed() < Duration::from_secs(120), "{} does not come", path.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[cfg(unix)]
#[test]
fn a_killed_comparison_resumes_to_the_same_model() {
    let bench = measured();
    let of = |model: &str, more: &str| {
        format!(
            "compare {LOOP} {SWEEP} {SINES} --candidates none+degree1,none,integer1 -o {model} --json {more}"
        )
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(of("cut.json", "").split_whitespace())
        .current_dir(bench.path("."))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    wait_for(&bench.path("cut.searches.json"));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!bench.path("cut.json").exists());
    let other = bench.run(&of("cut.json", "--resume cut.searches.json").replace("none,", ""));
    assert_eq!(other.exit_code, 1, "{other:?}");
    assert!(other.stderr.contains("other records or options"), "{}", other.stderr);
    let resumed = bench.run(&of("cut.json", "--resume cut.searches.json"));
    let whole = bench.run(&of("whole.json", ""));
    assert_eq!((resumed.exit_code, whole.exit_code), (0, 0), "{}", resumed.stderr);
    // Not the times that were measured.
    let errors = |text: &str| -> Vec<Value> {
        let found: Value = serde_json::from_str(text).unwrap();
        let all = found["candidates"].as_array().unwrap();
        all.iter().map(|c| serde_json::json!([c["name"], c["error"], c["fold_errors"], c["bic"]])).collect()
    };
    assert_eq!(errors(&resumed.stdout), errors(&whole.stdout));
    let numbers = |name: &str| -> Value {
        let text = std::fs::read_to_string(bench.path(name)).unwrap();
        let mut file: Value = serde_json::from_str(&text).unwrap();
        file.as_object_mut().unwrap().remove("provenance");
        file
    };
    assert_eq!(numbers("cut.json"), numbers("whole.json"));
    // What a comparison that came to its end kept on the way is gone.
    assert!(!bench.path("cut.searches.json").exists() && !bench.path("whole.searches.json").exists());
}

#[test]
fn a_structure_that_does_not_exist_is_wrong_usage() {
    let run = Bench::new().run("compare run.csv --candidates none,fractal");
    assert_eq!(run.exit_code, 2, "{run:?}");
    assert!(
        run.stderr.contains("'fractal' is no structure") && run.stderr.contains("two-fractional"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_slow_loop_does_not_pass_its_width_off_as_a_delay() {
    let bench = measured();
    let json = |records: &str| -> Value {
        let run = bench.run(&format!("inspect {records} --json"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        serde_json::from_str(&run.stdout).unwrap()
    };
    let statement = |found: &Value, topic: &str| {
        let list = found["campaign"]["statements"].as_array().unwrap();
        list.iter().find(|s| s["topic"] == topic).unwrap_or_else(|| panic!("{topic}: {found}")).clone()
    };
    let slow = json(LOOP);
    assert_eq!(slow["records"][0]["delay"]["from"], "one-frequency");
    // The true delay is 0.123 ms; loop width alone looks like many milliseconds.
    assert!(slow["records"][0]["delay"]["at_most_s"].as_f64().unwrap() > 5e-3, "{slow}");
    let delay = statement(&slow, "delay");
    assert_eq!(delay["determined"], false);
    assert!(delay["text"].as_str().unwrap().contains("cannot be distinguished from loop width"), "{delay}");
    assert!(
        bench
            .run(&format!("inspect {LOOP}"))
            .stdout
            .contains("delay cannot be distinguished from loop width")
    );
    assert_eq!(statement(&slow, "dynamics")["determined"], false);
    assert!(slow["campaign"]["measure_next"].as_str().unwrap().starts_with("a sweep"), "{slow}");

    // With a sweep the part of the phase that grows with frequency is told from the part that does not.
    let both = json(&format!("{LOOP} {SWEEP}"));
    let delay = statement(&both, "delay");
    assert_eq!(delay["determined"], true, "{delay}");
    let milliseconds: f64 = delay["text"].as_str().unwrap().split(' ').next().unwrap().parse().unwrap();
    // Dead time 0.123 ms, amplifier and mechanics below their resonance add to it; far from the 20 ms of the
    // loop.
    assert!((0.123..0.4).contains(&milliseconds), "{delay}");
    assert_eq!(statement(&both, "dynamics")["determined"], true);
    assert!(both["campaign"]["measure_next"].as_str().unwrap().contains("half and a quarter"), "{both}");

    // So do records of one frequency each, together.
    let sines = json(&format!("{LOOP} {SINES}"));
    let delay = statement(&sines, "delay");
    assert_eq!(delay["determined"], true, "{delay}");
    let milliseconds: f64 = delay["text"].as_str().unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((0.1..0.5).contains(&milliseconds), "{delay}");
}

#[test]
fn the_report_of_an_identification_shows_its_neighbours_and_its_bands() {
    let bench = measured();
    let run = bench.run(&format!("identify {LOOP} {SWEEP} -o new.json --report report.html"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let page = std::fs::read_to_string(bench.path("report.html")).unwrap();
    for part in [
        "Other structures on the same records",
        "<td><bdi>integer2+",
        "BIC above the lowest",
        "95 % of new measurements",
        "95 % band of the model",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // The file carries what the bands come from.
    let file = model_data(&bench.path("new.json"));
    let (names, _) = file.covariance().unwrap();
    assert!(names.iter().any(|n| n == "denominator[0].coefficient"), "{names:?}");
    let run = bench.run(&format!("validate new.json {SINES} --band --json"));
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let share = found["records"][0]["within_band_percent"].as_f64().unwrap();
    assert!((0.0..=100.0).contains(&share), "{found}");
}
