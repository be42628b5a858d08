//! `recalibrate` writes a model with a new gain, delay and offset, and refuses a record of something else.

use crate::bench::model_data;
use crate::bench::{Bench, static_model, triangle};
use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, SignalUnits};
use serde_json::Value;

/// The triangle and what a device of this gain and sensor offset does with it.
fn record(gain: f64, offset: f64) -> String {
    let model = Model { offset, ..static_model() };
    let u = triangle();
    let y = model.simulate(&u, Some(100.0), &Start::Rest { voltage_v: 0.0 }).unwrap();
    let sensor = |k: usize| 1e-3 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
    let rows = u.iter().zip(&y).enumerate();
    let rows = rows.map(|(k, (u, y))| {
        format!("{},{u},{}\n", k as f64 / 100.0, gain * (y - offset) + offset + sensor(k))
    });
    format!("t_s,u_V,y_um\n{}", rows.collect::<String>())
}

#[test]
fn a_changed_gain_is_found_and_written_with_its_origin() {
    let bench = Bench::new();
    let mut file = ModelFile::from_model(&static_model(), SignalUnits::default());
    file.hysteresis.parameters.get_mut("linear").unwrap().std_error = Some(0.003);
    bench.write("old.json", file.to_json().unwrap());
    bench.write("today.csv", record(1.05, 4.0));
    let run = bench.run("recalibrate old.json today.csv -o new.json --json");
    assert_eq!(run.exit_code, 0, "{run:?}");
    let json: Value = serde_json::from_str(&run.stdout).unwrap();
    let gain = json["gain"]["value"].as_f64().unwrap();
    let error = json["gain"]["std_error"].as_f64().unwrap();
    assert!(error < 1e-3 && (gain - 1.05).abs() < 3.0 * error, "{json}");
    assert_eq!((&json["changed"], &json["gain"]["changed"]), (&true.into(), &true.into()));
    assert!((json["gain"]["old_std_error"].as_f64().unwrap() - 0.01).abs() < 1e-12);
    assert!((json["offset"].as_f64().unwrap() - 4.0).abs() < 0.01, "{json}");

    let new = model_data(&bench.path("new.json"));
    let block = new.to_model().unwrap().hysteresis;
    let number = |name| block.number(name).unwrap();
    assert!((number("alpha") / 0.08 - gain).abs() < 1e-12 && number("beta") == 0.05 && number("n") == 1.0);
    let provenance = new.provenance.unwrap();
    let bytes = std::fs::read(bench.path("old.json")).unwrap();
    assert_eq!(provenance.options["recalibrated model sha256"], hysteron_io::sha256(&bytes));
    assert_eq!(provenance.records[0].path, "today.csv");

    let run = bench.run("recalibrate old.json today.csv -o new.json");
    assert!(run.stdout.contains("the device has changed"), "{}", run.stdout);
    assert!(run.stdout.contains("RMSE [µm] before"), "{}", run.stdout);
    // Against the new model nothing has changed.
    let run = bench.run("recalibrate new.json today.csv -o again.json");
    assert!(run.stdout.contains("verdict: gain: no significant change"), "{}", run.stdout);
}

#[test]
fn a_record_that_contradicts_the_model_is_refused_and_nothing_written() {
    let bench = Bench::new();
    let rows = triangle().into_iter().enumerate();
    let rows = rows.map(|(k, u)| format!("{},{u},{}\n", k as f64 / 100.0, (k as f64 * 0.9).sin()));
    bench.write("run.csv", format!("t_s,u_V,y_um\n{}", rows.collect::<String>()));
    let run = bench.run("recalibrate model.json run.csv -o new.json");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("contradicts the model") && run.stderr.contains("\ntry: "), "{}", run.stderr);
    assert_eq!(bench.files(), ["model.json", "run.csv"]);
    assert_eq!(bench.run("recalibrate model.json").exit_code, 2);
}
