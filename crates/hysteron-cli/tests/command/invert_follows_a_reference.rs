//! `invert` writes the drive that lets a model follow, and says where it cannot.

use std::f64::consts::TAU;

use crate::bench::{Bench, static_model};
use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::SignalUnits;
use hysteron_model::record::InterSample;
use serde_json::Value;

/// A lag of 2 ms and a delay of 1.5 samples of 1 kHz, driven through a hold.
fn dynamic_model() -> Model {
    let term = |coefficient, order| Term { coefficient, order };
    let lag = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 0.0), term(2e-3, 1.0)]).unwrap();
    Model {
        dynamics: Dynamics::Integer(lag),
        offset: 0.7,
        delay_s: 1.5e-3,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Hold,
        sample_rate_hz: Some(1e3),
        ..static_model()
    }
}

fn scan(unit: &str, scale: f64) -> String {
    let rows = (0..800).map(|k| {
        let t = f64::from(k) / 1000.0;
        format!("{t},{}\n", scale * (13.0 - 5.0 * (TAU * 5.0 * t).cos()))
    });
    format!("t_s,target_{unit}\n{}", rows.collect::<String>())
}

fn column(csv: &str, name: &str) -> Vec<f64> {
    let at = csv.lines().next().unwrap().split(',').position(|c| c == name).unwrap();
    csv.lines().skip(1).map(|row| row.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

fn summary(run: &crate::bench::Run) -> Value {
    assert_eq!(run.exit_code, 0, "{run:?}");
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn the_model_follows_the_drive_that_was_made_for_it() {
    let bench = Bench::new();
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    // Nanometres become the model's µm.
    bench.write("scan.csv", scan("nm", 1e3));
    let made = summary(&bench.run("invert stage.json scan.csv -o drive.csv --range 1:100 --json"));
    // What is left is the first samples: the drive cannot begin before the reference, the delay
    // notwithstanding.
    assert!(made["predicted_rms_percent_of_stroke"].as_f64().unwrap() < 0.02, "{made}");
    assert_eq!((&made["samples_at_range"], &made["bandwidth_hz"]), (&Value::from(0), &Value::from(50.0)));
    let drive = std::fs::read_to_string(bench.path("drive.csv")).unwrap();
    assert!(drive.starts_with("t_s,u_V,y_um,reference_um\n"), "{}", &drive[..40]);
    let numbered =
        summary(&bench.run("invert stage.json scan.csv -o numbered.csv --range 1:100 --json --reference 2"));
    assert_eq!(numbered["predicted_rms_um"], made["predicted_rms_um"]);
    assert_eq!(std::fs::read_to_string(bench.path("numbered.csv")).unwrap(), drive);
    let rest = made["rest_V"].as_f64().unwrap();
    let run = bench.run(&format!("simulate stage.json drive.csv -o out.csv --rest-voltage {rest}"));
    assert_eq!(run.exit_code, 0, "{run:?}");
    let out = std::fs::read_to_string(bench.path("out.csv")).unwrap();
    for (a, b) in column(&out, "y_um").iter().zip(column(&drive, "y_um")) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    let run = bench.run("invert stage.json scan.csv -o drive.csv --range 0:100");
    assert!(
        run.stdout.contains("Predicted error") && run.stdout.contains("held for 0.001 s"),
        "{}",
        run.stdout
    );
}

#[test]
fn a_drive_made_one_sample_at_a_time_knows_what_it_previews_and_predicts_the_rest() {
    let bench = Bench::new();
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    bench.write("scan.csv", scan("um", 1.0));
    let made = |flags: &str| {
        let made = summary(
            &bench.run(&format!("invert stage.json scan.csv -o drive.csv --range 1:100 --json {flags}")),
        );
        made["predicted_rms_percent_of_stroke"].as_f64().unwrap()
    };
    let (whole, previewed) = (made(""), made("--preview 60"));
    let (predicted, neither) = (made("--predict-to 20"), made("--preview 0"));
    println!("whole {whole} %, preview {previewed} %, prediction {predicted} %, neither {neither} %");
    // Either way the first samples are missed, as many as the delay lasts; one sample at a time the drive
    // sets out from rest, without a jump.
    assert!(whole < 0.02 && previewed < 0.03, "{previewed} {whole}");
    assert!(predicted < 0.1 * neither && neither > 1.0, "{predicted} {neither}");
    for flags in ["--preview 3 --periodic", "--predict-to 20 --learn-from scan.csv", "--predict-to 0"] {
        let run = bench.run(&format!("invert stage.json scan.csv -o drive.csv --range 1:100 {flags}"));
        assert_eq!(run.exit_code, 2, "{flags}: {run:?}");
    }
    let run = bench.run("invert stage.json scan.csv -o drive.csv --range 1:100 --preview 100000");
    assert!(run.exit_code == 0 && run.stdout.contains("Of the preview of 100000 samples "), "{run:?}");
    let run = bench.run("invert stage.json scan.csv -o drive.csv --range 1:100 --preview 2");
    assert!(run.exit_code == 0 && !run.stdout.contains("Of the preview"), "{run:?}");
    let run = bench.run("invert stage.json scan.csv -o drive.csv --range 1:100 --predict-to 700");
    assert!(run.exit_code == 1 && run.stderr.contains("below half the sample rate"), "{run:?}");
}

#[test]
fn the_next_drive_is_learned_from_a_run() {
    let bench = Bench::new();
    // The device is not quite the model.
    let device = Model { delay_s: 2.0e-3, ..dynamic_model() };
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    bench.write_model("device.json", &device, SignalUnits::default());
    bench.write("scan.csv", scan("um", 1.0));
    let follow = "invert stage.json scan.csv -o drive.csv --range 1:100 --json";
    let rest = summary(&bench.run(follow))["rest_V"].as_f64().unwrap();
    let mut errors = Vec::new();
    for _ in 0..3 {
        let run = bench.run(&format!("simulate device.json drive.csv -o run.csv --rest-voltage {rest}"));
        assert_eq!(run.exit_code, 0, "{run:?}");
        let y = column(&std::fs::read_to_string(bench.path("run.csv")).unwrap(), "y_um");
        let r = column(&std::fs::read_to_string(bench.path("drive.csv")).unwrap(), "reference_um");
        let errors_of = y.iter().zip(&r).skip(100).map(|(y, r)| (y - r).powi(2));
        errors.push(errors_of.sum::<f64>().sqrt());
        summary(&bench.run(&format!("{follow} --learn-from run.csv")));
    }
    assert!(errors[1] < 0.05 * errors[0] && errors[2] < errors[1], "{errors:?}");
    bench.write("short.csv", "t_s,u_V,y_um\n0,20,8\n0.001,21,8\n0.002,22,9\n");
    let run = bench.run(&format!("{follow} --learn-from short.csv"));
    assert!(run.exit_code == 1 && run.stderr.contains("the last run has 3 samples"), "{run:?}");
}

#[test]
fn limits_are_kept_and_reported() {
    let bench = Bench::new();
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    bench.write("scan.csv", scan("um", 1.0));
    let made = summary(&bench.run("invert stage.json scan.csv -o drive.csv --range 20:60 --slew 400 --json"));
    let at = |key: &str| made[key].as_f64().unwrap();
    assert!(at("samples_at_range") > 0.0 && at("samples_at_slew") > 0.0, "{made}");
    assert!(at("drive_low_V") >= 20.0 && at("drive_high_V") <= 60.0, "{made}");
    assert!(at("fastest_drive_V_per_s") <= 400.0 * (1.0 + 1e-9), "{made}");
    let drive = std::fs::read_to_string(bench.path("drive.csv")).unwrap();
    let u = column(&drive, "u_V");
    assert!(u.windows(2).all(|w| (w[1] - w[0]).abs() <= 0.4 * (1.0 + 1e-9)));
}

#[test]
fn a_period_of_a_scan_is_followed_in_its_steady_state() {
    let bench = Bench::new();
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    bench.write("scan.csv", scan("um", 1.0));
    let made = summary(&bench.run("invert stage.json scan.csv -o drive.csv --range 0:100 --periodic --json"));
    assert!(made["rest_V"].is_null(), "{made}");
    assert!(made["predicted_rms_percent_of_stroke"].as_f64().unwrap() < 0.01, "{made}");
    let drive = std::fs::read_to_string(bench.path("drive.csv")).unwrap();
    let u = column(&drive, "u_V");
    // It repeats within as it does from end to beginning.
    let apart = |a: usize, b: usize| (u[a] - u[b]).abs();
    assert!((1..200).all(|k| apart(k, k + 200) < 1e-6), "{}", apart(100, 300));
    // Where the range holds it back, the samples of the one record that is written count.
    let made = summary(&bench.run("invert stage.json scan.csv -o held.csv --range 30:60 --periodic --json"));
    let held = std::fs::read_to_string(bench.path("held.csv")).unwrap();
    let at_an_end = column(&held, "u_V").into_iter().filter(|u| [30.0, 60.0].contains(u)).count();
    assert!(at_an_end > 100);
    assert_eq!((&made["samples_at_range"], &made["samples"]), (&Value::from(at_an_end), &Value::from(800)));
}

#[test]
fn what_cannot_be_followed_is_refused_without_a_file() {
    let bench = Bench::new();
    bench.write_model("stage.json", &dynamic_model(), SignalUnits::default());
    bench.write("scan.csv", scan("um", 1.0));
    bench.write("far.csv", scan("um", 1e3));
    bench.write("kilograms.csv", scan("kg", 1.0));
    bench.write("inches.csv", scan("in", 1.0));
    bench.write("huge.csv", "t_s,r_um\n0,1e308\n0.001,1e308\n");
    let rising = BoucWen::of(&static_model().hysteresis).unwrap();
    let falls = Hysteresis::from(BoucWen { polynomial: vec![0.3, -1e-4], ..rising });
    bench.write_model("falls.json", &Model { hysteresis: falls, ..dynamic_model() }, SignalUnits::default());
    let term = |coefficient, order| Term { coefficient, order };
    let creep = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 0.1), term(2e-3, 1.0)]).unwrap();
    let creeps =
        Model { dynamics: Dynamics::Fractional(creep), scheme: Scheme::BandLimited, ..dynamic_model() };
    bench.write_model("creeps.json", &creeps, SignalUnits::default());
    bench.write("uneven.csv", "t_s,r_um\n0,1\n0.1,2\n0.15,3\n0.4,3\n");
    bench.write("text.csv", "t_s,r_um\n0,1\n0.1,two\n");
    bench.write("one.csv", "t_s,r_um\n0,1\n");
    bench.write("volts.csv", "t_s,u_V,r_V\n0,1,1\n0.1,2,1\n");
    for (arguments, said) in [
        ("stage.json scan.csv", "does not say which drive"),
        ("stage.json uneven.csv --range 0:100", "no uniform sample rate"),
        ("stage.json text.csv --range 0:100", "line 3"),
        ("stage.json one.csv --range 0:100", ""),
        ("stage.json volts.csv --range 0:100 --reference r", "the reference in V"),
        ("stage.json scan.csv --range 0:100 --bandwidth 500", "below 500 Hz"),
        (
            "stage.json scan.csv --range 0:10.5 --rest-voltage 99",
            "the device rests at 99 V, outside of the range of its drive, 0 V to 10.5 V",
        ),
        ("stage.json text.csv --range 0:100", "try: --reference"),
        ("stage.json scan.csv --range 0:100 --reference z", "no column `z` to be the reference"),
        (
            "stage.json far.csv --range 0:100",
            "begins at 8000 µm, which no drive from 0 to 100 V holds: at rest these give 0.7 to ",
        ),
        ("falls.json scan.csv --range 0:1e5", "no inverse over the range from 0 V to 100000 V: near "),
        ("stage.json huge.csv --range 0:100", "1e308 is larger than any measured quantity"),
        ("creeps.json scan.csv --range 0:100 --periodic", "there is no periodic steady state"),
        ("creeps.json scan.csv --range 0:100 --periodic", "leave --periodic out"),
        (
            "stage.json kilograms.csv --range 0:100",
            "the model's output is in µm, the reference in kg: expected nm, µm",
        ),
        ("stage.json inches.csv --range 0:100", "the reference in in: expected nm, µm"),
    ] {
        let run = bench.run(&format!("invert {arguments} -o drive.csv"));
        assert_eq!(run.exit_code, 1, "{arguments}: {run:?}");
        assert!(run.stderr.contains(said), "{arguments}: {}", run.stderr);
        assert!(
            !run.stderr.contains("--input") && !run.stderr.contains("--output"),
            "{arguments}: {}",
            run.stderr
        );
        assert!(run.stderr.lines().all(|line| line.len() < 400), "{arguments}: {}", run.stderr);
        assert!(!bench.files().contains(&"drive.csv".to_owned()), "{arguments}");
    }
    for wrong in ["--range 5", "--range 9:1", "--slew 0", "--bandwidth -1", "--periodic --rest-voltage 1"] {
        let run = bench.run(&format!("invert stage.json scan.csv -o drive.csv {wrong}"));
        assert_eq!(run.exit_code, 2, "{wrong}: {run:?}");
    }
}

/// A bench outside the model class (simulated), by the commands alone: records, model, drive, and the drive played.
/// The expected error is that of the device, where an exact model would err by a tenth of it, and a drive that is
/// corrected by the misfit follows better.
#[test]
fn the_error_expected_of_a_drive_is_that_of_the_device() {
    let bench = Bench::new();
    bench.identify_outside_the_class();
    let run = |arguments: &str| bench.run_well(arguments);
    run(
        "excite random --to 50 --duration 1 --sample-rate 2500 --low 2 --high 8 --soft-start 0.2 --seed 5 --out a.csv",
    );
    let reference = std::fs::read_to_string(bench.path("a.csv")).unwrap().replace("u_V", "r_um");
    bench.write("reference.csv", reference);
    let read = |path: &str| {
        let text = std::fs::read_to_string(bench.path(path)).unwrap();
        text.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect::<String>()
    };
    let wanted = column(&read("reference.csv"), "r_um");
    // Expected error, and that on the device, about its mean.
    let played = |name: &str, flags: &str| {
        let made = summary(&run(&format!(
            "invert stage.json reference.csv -o {name}.csv --range 0:12 --json {flags}"
        )));
        run(&format!("rig --truth rig/truth.json --drive {name}.csv --out-dir {name} --with-truth"));
        let moved = column(&read(&format!("{name}/simulated_{name}.csv")), "y_true_um");
        let errors: Vec<f64> = moved.iter().zip(&wanted).map(|(moved, wanted)| moved - wanted).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let error = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        let told = |name: &str| made[name].as_f64().unwrap();
        let (expected, exact) = (told("expected_rms_error_um"), told("predicted_rms_error_um"));
        println!("{name}: {error} µm on the device, expected {expected} µm, of an exact model {exact} µm");
        assert!((0.5..2.0).contains(&(expected / error)) && exact < 0.5 * error, "{name}: {made}");
        error
    };
    let (plain, corrected) = (played("plain", ""), played("corrected", "--correct"));
    assert!(corrected < 0.6 * plain, "{corrected} {plain}");
}
