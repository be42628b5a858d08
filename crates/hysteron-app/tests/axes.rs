//! A model of several axes: the drives of its actuators, and its source code.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests stop at the first surprise")]

mod common;

use std::f64::consts::TAU;
use std::fmt::Write;

use common::Server;
use hysteron_model::axes::{LevelLaw, ScheduledModes};
use hysteron_model::model_file::{ModesFile, SignalUnits};
use serde_json::{Value, json};

const RATE: f64 = 2000.0;

/// Two actuators, two sensors, one mode at 200 Hz that both actuators move, and a lag of each.
fn stage() -> String {
    let angle = TAU * 200.0 / RATE;
    let size = (-0.05 * angle).exp();
    let level = LevelLaw { reference: 0.5, exponent: 1.0, lowest: 0.1, highest: 0.5, time_constant_s: 2.0 };
    let stage = ScheduledModes {
        inputs: 2,
        outputs: 2,
        modes: 1,
        sample_rate_hz: RATE,
        steps: 1,
        level,
        transition: vec![size * angle.cos(), size * angle.sin(), 0.3, 0.3],
        transition_slopes: vec![0.0; 4],
        input: vec![angle, 0.4 * angle, 0.0, 0.0, 0.7, 0.0, 0.0, 0.7],
        strain_input: vec![0.0; 8],
        output: vec![0.0, 1.0, 1.5, 0.0, 0.0, 0.4, 0.0, 1.5],
        output_slopes: vec![0.0; 8],
        feedthrough: vec![0.0; 4],
        feedthrough_slopes: vec![0.0; 4],
        strain_feedthrough: vec![0.0; 4],
        feedback: None,
    };
    let names = |prefix: &str| vec![format!("{prefix}1"), format!("{prefix}2")];
    let units = SignalUnits { input: "V".into(), output: "um".into() };
    ModesFile::new(&stage, units, names("u"), names("y")).to_json().unwrap()
}

/// Slow references of both axes, from rest.
fn references() -> String {
    let mut text = "t_s,y1_um,y2_um\n".to_owned();
    for k in 0..1200 {
        let t = k as f64 / RATE;
        let grown = 1.0 - (-(30.0 * t).powi(3)).exp();
        writeln!(text, "{t},{},{}", 0.4 * grown * (20.0 * t).sin(), -0.2 * grown * (31.0 * t).sin()).unwrap();
    }
    text
}

#[test]
fn drives_of_all_actuators_and_their_code() {
    let server = Server::start();
    std::fs::write(server.path("stage.json"), stage()).unwrap();
    server.upload("references.csv", references().as_bytes()).done();
    let at = "/api/v1/models/stage.json";
    let options = json!({"ranges": [[-1.0, 1.0], [-0.8, 0.8]], "bandwidth_hz": 100.0, "preview": 60});
    let request = json!({"references": "references.csv", "options": options, "save": "drives.csv"});
    let found = server.post(&format!("{at}/decouple"), &request).done();
    let shell = "hysteron invert stage.json references.csv -o drives.csv --range -1:1,-0.8:0.8 --bandwidth 100 \
                 --preview 60";
    assert_eq!(found["command"]["shell"], shell);
    let titles: Vec<&Value> = found["figures"].as_array().unwrap().iter().map(|f| &f["title"]).collect();
    assert_eq!(titles, ["Drives", "References", "Predicted errors"]);
    for series in found["figures"][2]["series"].as_array().unwrap() {
        let errors: Vec<f64> = serde_json::from_value(series["curve"]["y"].clone()).unwrap();
        let worst = errors.iter().fold(0.0, |most: f64, e| most.max(e.abs()));
        assert!(worst < 1e-3, "{worst}");
    }
    let written = std::fs::read_to_string(server.path("drives.csv")).unwrap();
    assert!(written.starts_with("t_s,u1_V,u2_V,y1_um,y2_um,reference_y1_um"), "{}", &written[..80]);
    let three = json!({"references": "references.csv", "options": {"ranges": [[-1, 1], [-1, 1], [-1, 1]]}});
    assert!(server.post(&format!("{at}/decouple"), &three).refused(422).contains("limits for 3"));

    let query = "as=c&inverse=true&low=-1&high=1";
    let preview = server.get(&format!("{at}/preview?{query}")).done();
    let names: Vec<&str> =
        preview["files"].as_array().unwrap().iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"stage_inverse.c"), "{names:?}");
    let header = preview["files"][0]["text"].as_str().unwrap();
    assert!(header.contains(&hysteron_io::sha256(stage().as_bytes())), "{header}");
    server.get(&format!("{at}/preview?as=matlab")).refused(422);
}
