//! `simulate` writes a record that `validate` reads, equal to the library's simulation to the last bit.

use crate::bench::{Bench, good_record, static_model};
use hysteron::dynamics::{Arx, Dynamics, Scheme, Term, TransferFunction};
use hysteron::hammerstein::Model;
use hysteron::model_file::SignalUnits;

#[test]
fn what_was_simulated_validates_without_any_error() {
    let bench = Bench::new();
    bench.write("run.csv", good_record());
    let run = bench.run("simulate model.json run.csv -o out.csv");
    assert_eq!((run.exit_code, run.stdout.as_str()), (0, ""), "{run:?}");
    let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    assert!(out.starts_with("t_s,u_V,y_um\n0,0,"), "{}", &out[..40]);
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
            for part in ["200", "100", "try: resample the record to 200 Hz"] {
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
        out.lines().skip(1).map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect()
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
