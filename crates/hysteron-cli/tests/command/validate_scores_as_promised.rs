//! `validate --json` prints one object of exactly the promised shape; lengths are in µm, other outputs in
//! their unit.

use crate::bench::{Bench, good_record, static_model, triangle};
use hysteron_model::model_file::SignalUnits;
use serde_json::Value;

/// The one object on standard output.
fn report(run: &crate::bench::Run) -> Value {
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert_eq!(run.stdout.trim_end().lines().count(), 1, "one line: {}", run.stdout);
    serde_json::from_str(&run.stdout).unwrap()
}

/// `model.json` becomes a straight line of 0.3 µm/V with offset 0.
fn straight_line(bench: &Bench) {
    let mut model = static_model();
    *model.hysteresis.polynomial_mut() = vec![0.3];
    *model.hysteresis.number_mut("alpha").unwrap() = 0.0;
    bench.write_model("model.json", &model, SignalUnits::default());
}

/// A record of the triangle whose output is `f(k, u)`.
fn record(header: &str, f: impl Fn(usize, f64) -> f64) -> String {
    let rows =
        triangle().into_iter().enumerate().map(|(k, u)| format!("{},{u},{}\n", k as f64 / 100.0, f(k, u)));
    format!("{header}\n{}", rows.collect::<String>())
}

#[test]
fn the_object_has_exactly_the_promised_keys() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let json = report(&bench.run("validate model.json run.csv run.csv --json"));
    let records = json["records"].as_array().unwrap();
    assert_eq!((json.as_object().unwrap().len(), records.len()), (1, 2));
    let keys: Vec<&str> = records[0].as_object().unwrap().keys().map(String::as_str).collect();
    let mut promised = vec![
        "record",
        "samples",
        "skipped_samples",
        "offset_um",
        "rmse_um",
        "max_abs_error_um",
        "rmse_percent_of_stroke",
        "max_percent_of_stroke",
        "fit_percent",
    ];
    promised.sort_unstable();
    let mut sorted = keys.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, promised);
    assert_eq!(records[0]["record"], "run.csv");
}

#[test]
fn a_known_error_gives_the_scores_computed_by_hand() {
    let bench = Bench::new();
    straight_line(&bench);
    // ±0.3 µm by turns about a sensor zero of 7 µm: RMSE 0.3, stroke 30 µm + what the ends add.
    let alternating = |k: usize| if k.is_multiple_of(2) { 0.3 } else { -0.3 };
    bench.write("run.csv", record("t_s,u_V,y_um", |k, u| 0.3 * u + 7.0 + alternating(k)));
    let json = report(&bench.run("validate model.json run.csv --json"));
    let r = &json["records"][0];
    let near = |key: &str, expected: f64| {
        let found = r[key].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-9, "{key}: {found} instead of {expected}");
    };
    assert_eq!((r["samples"].as_u64(), r["skipped_samples"].as_u64()), (Some(200), Some(0)));
    near("offset_um", 7.0);
    near("rmse_um", 0.3);
    near("max_abs_error_um", 0.3);
    // Lowest 0 + 0.3 (k = 0, even) against 0.6 − 0.3 (k = 1); highest 30 + 0.3 (k = 50).
    near("rmse_percent_of_stroke", 1.0);
    near("max_percent_of_stroke", 1.0);

    let json = report(&bench.run("validate model.json run.csv --json --fixed-offset"));
    let r = &json["records"][0];
    assert_eq!(r["offset_um"], 0.0);
    assert!((r["rmse_um"].as_f64().unwrap() - (0.09_f64 + 49.0).sqrt()).abs() < 1e-9);
}

#[test]
fn lengths_are_converted_to_um_whatever_the_header_says() {
    let bench = Bench::new();
    straight_line(&bench);
    for (unit, per_um) in [("um", 1.0), ("nm", 1e3), ("mm", 1e-3), ("m", 1e-6)] {
        let error = |k: usize| if k.is_multiple_of(2) { 0.3 } else { -0.3 };
        bench.write("run.csv", record(&format!("t_s,u_V,y_{unit}"), |k, u| (0.3 * u + error(k)) * per_um));
        let json = report(&bench.run("validate model.json run.csv --json"));
        let rmse = json["records"][0]["rmse_um"].as_f64().unwrap();
        assert!((rmse - 0.3).abs() < 1e-9, "{unit}: {rmse}");
        assert_eq!(json["records"][0].get("unit"), None);
    }
}

#[test]
fn another_unit_is_scored_in_itself_and_named() {
    let bench = Bench::new();
    let units = SignalUnits { input: "A_per_m".into(), output: "T".into() };
    bench.write_model("model.json", &static_model(), units);
    bench.write("run.csv", record("t_s,H_A_per_m,B_T", |_, u| 0.3 * u));
    let json = report(&bench.run("validate model.json run.csv --json --input H --output B"));
    let r = &json["records"][0];
    assert_eq!(r["unit"], "T");
    assert!(r["rmse_T"].is_f64() && r["offset_T"].is_f64() && r["max_abs_error_T"].is_f64());
    assert_eq!(r.get("rmse_um"), None);

    bench.write("run.csv", good_record());
    let run = bench.run("validate model.json run.csv --json");
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""));
    assert!(run.stderr.contains("the model's input is in A/m, the record's in V"), "{}", run.stderr);
}

#[test]
fn skipped_seconds_and_masked_samples_are_counted_and_not_scored() {
    let bench = Bench::new();
    straight_line(&bench);
    let rows = triangle().into_iter().enumerate().map(|(k, u)| {
        let (spike, valid) = if k == 150 {
            (1e3, 0)
        } else if k < 25 {
            (50.0, 1)
        } else {
            (0.0, 1)
        };
        format!("{},{u},{},{valid}\n", k as f64 / 100.0, 0.3 * u + spike)
    });
    bench.write("run.csv", format!("t_s,u_V,y_um,valid\n{}", rows.collect::<String>()));
    let json = report(&bench.run("validate model.json run.csv --skip 0.25 --json"));
    let r = &json["records"][0];
    assert_eq!((r["samples"].as_u64(), r["skipped_samples"].as_u64()), (Some(174), Some(26)));
    assert!(r["max_abs_error_um"].as_f64().unwrap() < 1e-9);
}

#[test]
fn the_table_says_that_the_offset_was_estimated_or_not() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let run = bench.run("validate model.json run.csv");
    assert_eq!(run.exit_code, 0);
    assert!(
        run.stdout.contains("sensor was estimated") && run.stdout.contains("RMSE [unit]: root mean square")
    );
    let run = bench.run("validate model.json run.csv --fixed-offset");
    assert!(run.stdout.contains("the model's own (--fixed-offset)"), "{}", run.stdout);
}

#[test]
fn an_input_beyond_the_identified_range_is_remarked_on_standard_error() {
    let bench = Bench::new();
    let text = std::fs::read_to_string(bench.path("model.json")).unwrap();
    let range = r#""valid_range": {"input": {"low": 0, "high": 50, "unit": "V"}}"#;
    bench.write("model.json", text.replace("\"valid_range\": null", range));
    bench.write("run.csv", good_record());
    let run = bench.run("validate model.json run.csv --json");
    assert!(
        run.stderr.contains("from 0 to 100 V, the model was identified from 0 to 50 V"),
        "{}",
        run.stderr
    );
    report(&run);
}

/// Scores and curves of every record, in one file.
#[test]
fn the_page_has_scores_and_curves() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    bench.write("simulated_run.csv", good_record());
    let run = bench.run("validate model.json run.csv simulated_run.csv --report page.html");
    assert_eq!(run.exit_code, 0, "{}", run.stderr);
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    for part in ["RMSE", "Hysteresis loop: run.csv", "Time curves: simulated_run.csv", "<svg"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains("simulated bench"), "figures of simulated records say so");
    // Nothing is printed differently for it.
    assert_eq!(run.stdout, bench.run("validate model.json run.csv simulated_run.csv").stdout);
}

#[test]
fn the_series_is_what_was_scored() {
    let bench = Bench::new();
    straight_line(&bench);
    let alternating = |k: usize| if k.is_multiple_of(2) { 0.3 } else { -0.3 };
    bench.write("run.csv", record("t_s,u_V,y_um", |k, u| 0.3 * u + 7.0 + alternating(k)));
    let json = report(&bench.run("validate model.json run.csv --json -o scored.csv"));
    let text = std::fs::read_to_string(bench.path("scored.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("t_s,u_V,y_um,y_model_um,residual_um"));
    let residuals: Vec<f64> = lines.map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    let rmse = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
    assert_eq!(residuals.len(), 200);
    assert!((rmse - json["records"][0]["rmse_um"].as_f64().unwrap()).abs() < 1e-9, "{rmse}");

    let two = bench.run("validate model.json run.csv run.csv -o both.csv");
    assert_eq!(two.exit_code, 2, "{two:?}");
    assert!(two.stderr.contains("one record at a time") && !bench.path("both.csv").exists(), "{two:?}");
}

/// The stack of the example, its output times `gain` and its drive times `reach`.
fn stack(gain: f64, reach: f64) -> String {
    let example =
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/piezo-p885-200hz/identification_1hz.csv");
    let text = std::fs::read_to_string(example).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let rows = lines.map(|line| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        format!("{},{},{}\n", cells[0], reach * cells[1], gain * cells[2])
    });
    format!("{header}\n{}", rows.collect::<String>())
}

#[test]
fn another_device_and_another_range_are_told() {
    let bench = Bench::new();
    for (name, gain, reach) in [("own", 1.0, 1.0), ("device", 1.3, 1.0), ("range", 1.0, 2.0)] {
        bench.write(&format!("{name}.csv"), stack(gain, reach));
    }
    let run = bench.run("identify own.csv -o own.json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let range =
        "The model holds for an input from 0 to 3.6 V, its swings at 1 Hz: beyond that it extrapolates.";
    assert!(run.stdout.contains(range), "{}", run.stdout);
    let export = bench.run("export own.json --to c -o source --sample-rate 1000");
    assert!(export.exit_code == 0 && export.stderr.contains(range), "{export:?}");
    // Ten times as fast.
    let fast: String = stack(1.0, 1.0)
        .lines()
        .map(|line| match line.split_once(',') {
            Some((t, rest)) => t.parse::<f64>().map_or(line.to_owned(), |t| format!("{},{rest}", t / 10.0)),
            None => line.to_owned(),
        } + "\n")
        .collect();
    bench.write("fast.csv", fast);
    let run = bench.run("validate own.json fast.csv");
    assert!(
        run.stderr.contains("the input swings at up to 10 Hz, the model was identified up to 1 Hz"),
        "{run:?}"
    );
    let json = report(&bench.run("validate own.json own.csv device.csv range.csv --json"));
    let verdict = |k: usize| json["records"][k]["verdict"]["judgement"].as_str().unwrap().to_owned();
    assert_eq!(verdict(0), "as-in-training");
    assert_eq!(verdict(1), "another-device");
    assert_eq!(verdict(2), "another-device-or-range");
    let text = bench.run("validate own.json device.csv").stdout;
    assert!(
        text.contains("device.csv: another device: rms error") && text.contains("1.3 times as far"),
        "{text}"
    );
}

/// Slow drive tells a delay from the width of a loop only where it starts with a jump from rest: without one,
/// none is put into the model. A training record scores the same whoever scores it.
#[test]
fn a_slow_record_gives_a_delay_where_it_jumps_alone_and_the_same_score_twice() {
    let bench = Bench::new();
    bench.write("own.csv", stack(1.0, 1.0));
    for family in ["bouc-wen", "prandtl-ishlinskii"] {
        for (part, jumps) in [("", true), ("--from 1", false)] {
            let run =
                bench.run(&format!("identify own.csv {part} --hysteresis {family} -o slow.json --json"));
            assert_eq!(run.exit_code, 0, "{run:?}");
            let delay = crate::bench::model_data(&bench.path("slow.json")).delay.value;
            assert_eq!(delay > 0.0, jumps, "{family} {part}: {delay}");
            let edges = run.stderr.matches("search range").count();
            assert_eq!(edges, 0, "what is left out ended nowhere: {}", run.stderr);
            if !jumps {
                continue;
            }
            let trained: Value = serde_json::from_str(&run.stdout).unwrap();
            let scored = report(&bench.run("validate slow.json own.csv --json"));
            for key in ["samples", "rmse_um", "max_abs_error_um"] {
                let (trained, scored) = (&trained["records"][0][key], &scored["records"][0][key]);
                let close = (trained.as_f64().unwrap() / scored.as_f64().unwrap() - 1.0).abs() < 1e-6;
                assert!(close, "{family}: {key}: {trained} {scored}");
            }
        }
    }
}

#[test]
fn several_models_stand_side_by_side() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    std::fs::copy(bench.path("model.json"), bench.path("second.json")).unwrap();
    let json = report(&bench.run("validate model.json second.json run.csv --json"));
    let models = json["models"].as_array().unwrap();
    assert_eq!(
        (models[0]["model"].as_str(), models[1]["model"].as_str()),
        (Some("model.json"), Some("second.json"))
    );
    assert_eq!(models[0]["records"], models[1]["records"]);
    let run = bench.run("validate model.json second.json run.csv --report page.html");
    assert!(run.stdout.contains("| model ") && run.stdout.contains("second.json"), "{run:?}");
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(page.contains("second.json: run.csv"));
    assert_eq!(bench.run("validate model.json second.json").exit_code, 2);
}

#[test]
fn a_record_that_cannot_be_scored_does_not_discard_the_others() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    bench.write("bad.csv", "t_s,u_V,y_um\n0,1,x\n");
    let run = bench.run("validate model.json bad.csv run.csv --json");
    assert_eq!(run.exit_code, 1, "{run:?}");
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["records"][0]["record"], "run.csv");
    assert_eq!(json["failed"][0]["record"], "bad.csv");
    assert!(run.stderr.contains("bad.csv") && run.stderr.contains("1 of 2"), "{}", run.stderr);
    // The table has the same columns however many records there are.
    let header = |arguments: &str| bench.run(arguments).stdout.lines().next().unwrap_or_default().to_owned();
    let one = header("validate model.json run.csv");
    assert_eq!(one, header("validate model.json run.csv run.csv run.csv run.csv run.csv"));
}
