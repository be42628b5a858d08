//! `simulate` writes a record that `validate` reads, equal to the library's simulation to the last bit.

use crate::bench::{Bench, good_record, static_model};
use hysteron_model::dynamics::{Arx, Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, ScoreEntry, ScoreRole, SignalUnits};
use nalgebra::DMatrix;

#[test]
fn what_was_simulated_validates_without_any_error() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let run = bench.run("simulate model.json run.csv -o out.csv");
    assert_eq!((run.exit_code, run.stdout.as_str()), (0, ""), "{run:?}");
    let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(out.starts_with("t_s,u_V,y_um,y_measured_um\n0,0,"), "{}", &out[..40]);
    assert_eq!(out.lines().count(), 201);
    let run = bench.run("validate model.json out.csv --fixed-offset --json");
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(json["records"][0]["rmse_um"], 0.0, "{}", run.stdout);
}

#[test]
fn a_drive_alone_is_enough_and_its_voltage_is_converted() {
    let bench = Bench::new();
    bench.write("drive.csv", "u_mV\n0\n1000\n2000\n1000\n");
    let run = bench.run("simulate model.json drive.csv -o out.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    let u: Vec<&str> = out.lines().map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(u, ["u_V", "0", "1", "2", "1"]);
    // By number, as --help promises.
    bench.write("two.csv", "a_V,b_V\n9,0\n9,1\n9,2\n9,1\n");
    let run = bench.run("simulate model.json two.csv --input 2 -o two_out.csv");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let two = std::fs::read_to_string(bench.path("two_out.csv")).unwrap();
    let rows = |text: &str| -> Vec<String> { text.lines().skip(1).map(str::to_owned).collect() };
    assert_eq!(rows(&two), rows(&out));
    let run = bench.run("simulate model.json two.csv --input 3 -o three_out.csv");
    assert!(run.exit_code == 1 && run.stderr.contains("`3`"), "{run:?}");
}

#[test]
fn a_band_holds_what_the_errors_in_the_file_mean() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let run = bench.run("simulate model.json run.csv -o out.csv --band model");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("holds no correlation") && run.stderr.contains("\ntry: "), "{}", run.stderr);

    // The error of the linear coefficient alone: half the width is 1.96 σ |u − ū|.
    let mut file = ModelFile::from_model(&static_model(), SignalUnits::default());
    file.set_covariance(&["linear".to_owned()], &DMatrix::from_element(1, 1, 1e-4));
    bench.write("model.json", file.to_json().unwrap());
    let refused = bench.run("simulate model.json run.csv -o out.csv --band measurement");
    assert!(refused.exit_code == 1 && refused.stderr.contains("holds no scores"), "{refused:?}");
    let run = bench.run("simulate model.json run.csv -o out.csv --band model");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(out.starts_with("t_s,u_V,y_um,y_low_um,y_high_um,y_measured_um\n"), "{}", &out[..60]);
    let rows: Vec<Vec<f64>> =
        out.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let mean = rows.iter().map(|r| r[1]).sum::<f64>() / rows.len() as f64;
    for r in &rows {
        let half = 1.959_964 * 1e-2 * (r[1] - mean).abs();
        assert!((r[4] - r[2] - half).abs() < 1e-6 && (r[2] - r[3] - half).abs() < 1e-6, "{r:?} {half}");
    }
    // It is still a record with one output.
    let run = bench.run("validate model.json out.csv --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
}

#[test]
fn a_band_is_held_against_a_record() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let mut file = ModelFile::from_model(&static_model(), SignalUnits::default());
    file.set_covariance(&["linear".to_owned()], &DMatrix::from_element(1, 1, 1e-10));
    let clean = bench.run("simulate model.json run.csv -o out.csv");
    assert_eq!(clean.exit_code, 0, "{clean:?}");
    // A triangle of ± 1 beside the model, whose scatter about it was 0.5: 98 % of it lie within ± 0.98.
    let text = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    let mut lines = text.lines();
    let mut noisy = lines.next().unwrap().to_owned() + "\n";
    for (k, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let error = (k % 101) as f64 / 50.0 - 1.0;
        noisy += &format!("{},{},{},{}\n", cells[0], cells[1], cells[2] + error, cells[3]);
    }
    bench.write("noisy.csv", noisy);
    file.scores = vec![ScoreEntry {
        record: "r".into(),
        role: ScoreRole::Training,
        unit: "um".into(),
        samples: 100,
        skipped_samples: 0,
        offset: 0.0,
        rmse: 0.5,
        max_abs_error: 1.0,
        rmse_percent_of_stroke: None,
        max_percent_of_stroke: None,
        fit_percent: None,
        relative_error: None,
        loop_width_error_percent: None,
    }];
    bench.write("model.json", file.to_json().unwrap());
    let run = bench.run("validate model.json noisy.csv --rest-voltage 0 --band --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let record = &json["records"][0];
    let share = record["within_band_percent"].as_f64().unwrap();
    assert!((97.0..99.0).contains(&share), "{record}");
    assert!((record["band_of_measurement_um"].as_f64().unwrap() - 0.98).abs() < 1e-3, "{record}");
    assert!(record["band_of_model_um"].as_f64().unwrap() < 1e-2, "{record}");
    let run = bench.run("validate model.json noisy.csv --rest-voltage 0 --band");
    assert!(run.stdout.contains("% of the samples lie within the 95 % band"), "{}", run.stdout);
}

fn with(dynamics: Dynamics, scheme: Scheme) -> Model {
    Model { dynamics, scheme, sample_rate_hz: Some(200.0), ..static_model() }
}

fn lag() -> Dynamics {
    let term = |coefficient, order| Term { coefficient, order };
    Dynamics::Integer(TransferFunction {
        numerator: vec![term(1.0, 0.0)],
        denominator: vec![term(1.0, 0.0), term(0.02, 1.0)],
    })
}

#[test]
fn models_bound_to_their_sample_rate_refuse_another_and_say_what_to_do() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let arx = Dynamics::Arx(Arx { a: vec![-0.5], b: vec![0.5] });
    for model in [with(lag(), Scheme::GrunwaldLetnikov), with(arx, Scheme::Tustin)] {
        bench.write_model("model.json", &model, SignalUnits::default());
        for arguments in ["simulate model.json run.csv -o out.csv", "validate model.json run.csv --json"] {
            let run = bench.run(arguments);
            assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{arguments}");
            for part in ["200", "100", "try: hysteron prepare run.csv --rate 200Hz"] {
                assert!(run.stderr.contains(part), "{arguments}: {}", run.stderr);
            }
        }
        assert!(!bench.path("out.csv").exists());
    }
    bench.write_model("model.json", &with(lag(), Scheme::Tustin), SignalUnits::default());
    assert_eq!(bench.run("simulate model.json run.csv -o out.csv").exit_code, 0);
}

#[test]
fn dynamics_without_a_sample_rate_are_refused_with_the_flag_that_helps() {
    let bench = Bench::new();
    bench.write_model("model.json", &with(lag(), Scheme::Tustin), SignalUnits::default());
    bench.write("run.csv", "u_V,y_um\n0,0\n1,0.3\n2,0.6\n1,0.3\n");
    let run = bench.run("simulate model.json run.csv -o out.csv");
    assert_eq!(run.exit_code, 1);
    assert!(run.stderr.contains("--sample-rate"), "{}", run.stderr);
    assert_eq!(bench.run("simulate model.json run.csv -o out.csv --sample-rate 200").exit_code, 0);
}

#[test]
fn a_start_is_taken_from_the_model_file_and_from_flags() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let y = |flags: &str| -> Vec<f64> {
        let run = bench.run(&format!("simulate model.json run.csv -o out.csv {flags}"));
        assert_eq!(run.exit_code, 0, "{flags}: {run:?}");
        let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
        out.lines().skip(1).map(|l| l.split(',').nth(2).unwrap().parse().unwrap()).collect()
    };
    let rest = y("");
    assert_eq!(rest, y("--rest-voltage 0"), "the record begins at 0 V");
    assert_ne!(rest, y("--rest-voltage -50"));
    // Settled on its period, the second period of the triangle repeats the first; from rest it does not.
    let change = |y: &[f64]| (0..100).map(|k| (y[k] - y[k + 100]).abs()).fold(0.0, f64::max);
    let settled = y("--settled 1");
    assert!(change(&settled) < 1e-9 && change(&rest) > 1e-3, "{} {}", change(&settled), change(&rest));

    let text = std::fs::read_to_string(bench.path("model.json")).unwrap();
    let kind = text.replacen("\"kind\": \"rest\"", "\"kind\": \"settled\"", 1);
    assert_ne!(kind, text);
    bench.write("model.json", kind);
    assert_eq!(y(""), settled, "the period is found in the drive");
    assert_eq!(bench.run("simulate model.json run.csv -o out.csv --settled 1 --rest-voltage 0").exit_code, 2);
}
