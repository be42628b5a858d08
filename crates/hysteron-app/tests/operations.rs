//! Operations that answer with tables and sentences: prepare, simulate, recalibrate, adapt, realise, the fit
//! of a frequency response; and the start of a search.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use common::{Server, events, loops};
use serde_json::{Value, json};

/// The loop record with its output scaled.
fn scaled(text: &str, gain: f64) -> String {
    let mut lines = text.lines();
    let mut scaled = lines.next().unwrap().to_owned() + "\n";
    for line in lines {
        let (before, y) = line.rsplit_once(',').unwrap();
        scaled += &format!("{before},{}\n", gain * y.parse::<f64>().unwrap());
    }
    scaled
}

fn with_model() -> Server {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    server.identified("loop.csv", "stage.json");
    server
}

fn cell(outcome: &Value, table: usize, row: usize, column: usize) -> f64 {
    let text = outcome["tables"][table]["rows"][row][column].as_str().unwrap();
    text.parse().unwrap_or_else(|_| panic!("{text} in {outcome}"))
}

#[test]
fn records_are_prepared_into_a_new_one() {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    server.send("PATCH", "/api/v1/records/loop.csv", &json!({"from_s": 1.0, "to_s": 2.0})).done();
    let options = json!({"scales": ["y=2um/um"], "remove_mean": ["y"], "sample_rate_hz": 100.0});
    let request = json!({"records": ["loop.csv"], "options": options, "save": "part/new.csv"});
    let made = server.post("/api/v1/prepare", &request).done();
    assert_eq!(made["files"], json!(["part/new.csv"]));
    let command = made["command"]["shell"].as_str().unwrap();
    assert_eq!(
        command,
        "hysteron prepare loop.csv -o part/new.csv --from 1 --to 2 --scale y=2um/um --remove-mean y --rate 100"
    );
    let sentences = made["sentences"].to_string();
    assert!(sentences.contains("kept 201 of 1200 samples") && sentences.contains("100 Hz"), "{sentences}");
    let entry = server.get("/api/v1/records/part%2Fnew.csv").done();
    assert_eq!((&entry["samples"], &entry["rate_hz"]), (&json!(101), &json!(100.0)));
    for (options, says) in [
        (json!({"scales": ["z=2um/um"]}), "z"),
        (json!({"scales": ["y"]}), "y"),
        (json!({"sample_rate_hz": -1.0}), "positive"),
        (json!({"turns": "x"}), "x"),
    ] {
        let request = json!({"records": ["loop.csv"], "options": options, "save": "bad.csv"});
        let answer = server.post("/api/v1/prepare", &request);
        assert!((400..500).contains(&answer.status), "{options}");
        assert!(answer.json()["error"]["what"].as_str().unwrap().contains(says), "{options}");
        assert!(!server.path("bad.csv").exists());
    }
    let elsewhere = json!({"records": ["loop.csv"], "save": "../new.csv"});
    server.post("/api/v1/prepare", &elsewhere).refused(400);
    let table = json!({"records": ["loop.csv"], "save": "new.exe"});
    assert!(server.post("/api/v1/prepare", &table).refused(400).contains(".csv, .npz, .mat"));
}

#[test]
fn a_drive_is_simulated_with_its_band() {
    let server = with_model();
    let request =
        json!({"records": ["loop.csv"], "options": {"band": "measurement"}, "save": "simulated.csv"});
    let found = server.post("/api/v1/models/stage.json/simulate", &request).done();
    let names: Vec<&str> = found["figures"][0]["series"]
        .as_array()
        .unwrap()
        .iter()
        .map(|series| series["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["measured", "model", "band-low", "band-high"]);
    let command = found["command"]["shell"].as_str().unwrap();
    assert_eq!(command, "hysteron simulate stage.json loop.csv -o simulated.csv --band measurement");
    let header = std::fs::read_to_string(server.path("simulated.csv")).unwrap();
    assert!(header.starts_with("t_s,u_V,y_um,y_low_um,y_high_um,y_measured_um"), "{}", &header[..80]);
    // A drive without a measured output.
    let drive: String =
        loops(300).lines().fold(String::new(), |all, line| all + line.rsplit_once(',').unwrap().0 + "\n");
    server.upload("drive.csv", drive.as_bytes());
    std::fs::write(server.path("drive.csv"), drive).unwrap();
    let found = server.post("/api/v1/models/stage.json/simulate", &json!({"records": ["drive.csv"]})).done();
    assert_eq!(found["figures"][0]["series"].as_array().unwrap().len(), 1);
    assert_eq!(found["files"], json!([]));
}

#[test]
fn a_changed_gain_is_recalibrated_and_followed() {
    let server = with_model();
    server.upload("today.csv", scaled(&loops(600), 1.05).as_bytes()).done();
    let request = json!({"records": ["today.csv"], "save": "today.json"});
    let found = server.post("/api/v1/models/stage.json/recalibrate", &request).done();
    assert!((cell(&found, 0, 0, 5) - 1.05).abs() < 2e-3, "{found}");
    assert!(found["sentences"][0].as_str().unwrap().contains("the device has changed"), "{found}");
    let before = server.get("/api/v1/models/stage.json/curves?record=today.csv&view=residual").done();
    let after = server.get("/api/v1/models/today.json/curves?record=today.csv&view=residual").done();
    let rmse = |drawn: &Value| drawn["scores"]["rmse"].as_f64().unwrap();
    assert!(rmse(&after) < 0.3 * rmse(&before), "{} {}", rmse(&before), rmse(&after));
    let request =
        json!({"record": "today.csv", "save": "followed.json", "options": {"terms": ["offset", "gain"]}});
    let found = server.post("/api/v1/models/stage.json/adapt", &request).done();
    assert!((cell(&found, 0, 1, 2) - 1.05).abs() < 5e-3, "{found}");
    assert_eq!(found["command"]["shell"], "hysteron adapt stage.json today.csv -o followed.json");
    assert!(server.path("followed.json").is_file());
    let creep = json!({"record": "today.csv", "save": "x.json", "options": {"terms": ["creep=1"]}});
    let says = server.post("/api/v1/models/stage.json/adapt", &creep).refused(400);
    assert!(says.contains("no place"), "{says}");
    let unknown = json!({"record": "today.csv", "options": {"terms": ["speed"]}});
    server.post("/api/v1/models/stage.json/adapt", &unknown).refused(400);
}

#[test]
fn a_model_is_realised_and_starts_a_search() {
    let server = with_model();
    let request = json!({"options": {"sample_rate_hz": 10_000.0}});
    let found = server.post("/api/v1/models/stage.json/realise", &request).done();
    assert_eq!(found["tables"].as_array().unwrap().len(), 2);
    assert_eq!(found["command"]["shell"], "hysteron realise stage.json --sample-rate 10000");
    server.post("/api/v1/models/stage.json/realise", &json!({"options": {"accuracy": 2.0}})).refused(400);
    let task = json!({"kind": "hammerstein", "options": {"dynamics": "none", "degree": {"given": 2}}});
    let request = json!({"kind": "identify", "records": ["loop.csv"], "task": task, "start": "stage.json"});
    let job = server.post("/api/v1/jobs", &request).done();
    assert!(job["command"]["shell"].as_str().unwrap().contains("--start stage.json"), "{job}");
    assert!(job["command"]["python"].as_str().unwrap().contains("start=hy.load(\"stage.json\")"), "{job}");
    let job = server.wait_for(job["id"].as_i64().unwrap(), &["done", "failed"]);
    assert_eq!(job["state"], "done", "{job}");
    let none = json!({"kind": "identify", "records": ["loop.csv"], "start": "none.json"});
    server.post("/api/v1/jobs", &none).refused(404);
}

#[test]
fn structures_are_fitted_to_a_frequency_response() {
    let server = Server::start();
    // A first-order lag, 2 µm/V, corner at 10 Hz.
    let mut text = "f_Hz,re_um_per_V,im_um_per_V\n".to_owned();
    for k in 0..40 {
        let f = 0.5 * 10f64.powf(f64::from(k) / 13.0);
        let d = 1.0 + (f / 10.0).powi(2);
        text += &format!("{f},{},{}\n", 2.0 / d, -2.0 * f / 10.0 / d);
    }
    std::fs::write(server.path("response.csv"), text).unwrap();
    let options = json!({"structures": ["integer", "power-law"], "low_hz": 1.0});
    let request = json!({"files": ["response.csv"], "options": options, "save": "lag.json",
        "report": "response.html"});
    let found = server.post("/api/v1/frequency-response", &request).done();
    assert_eq!(found["files"], json!(["lag.json", "response.html"]));
    assert_eq!(found["figures"].as_array().unwrap().len(), 2);
    assert!(found["tables"][0]["rows"].to_string().contains("power"), "{found}");
    assert!(
        found["command"]["shell"].as_str().unwrap().contains("--structure integer --structure power-law")
    );
    let listed = server.get("/api/v1/models").done();
    assert_eq!(listed[0]["id"], "lag.json");
    let unknown = json!({"files": ["response.csv"], "options": {"structures": ["none"]}});
    server.post("/api/v1/frequency-response", &unknown).refused(400);
}

#[test]
fn a_long_request_tells_how_far_it_is_and_ends_with_its_connection() {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    server.identified("loop.csv", "stage.json");
    let waveform = |periods: f64| {
        json!({"from": "waveform", "specification": {"sample_rate_hz": 200.0, "low_v": 20.0, "high_v": 25.0,
            "waveform": {"kind": "triangle", "frequency_hz": 1.0, "periods": periods}}})
    };
    let ask = |name: &str, periods: f64| {
        let body = json!({"reference": waveform(periods)}).to_string();
        let mut stream = std::net::TcpStream::connect(server.address).unwrap();
        let head = format!(
            "POST /api/v1/models/stage.json/track HTTP/1.1\r\nhost: {}\r\nx-request: {name}\r\n\
             content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
            server.address,
            body.len()
        );
        std::io::Write::write_all(&mut stream, head.as_bytes()).unwrap();
        stream
    };
    let progress = |found: (String, Value)| (found.0 == "progress").then_some(found.1);
    let mut told = events(server.address).filter_map(progress);
    let long = ask("long", 20_000.0);
    let first = told.next().unwrap();
    assert_eq!(first["request"], "long");
    let later = told.find(|event| event["left_s"].as_f64().is_some_and(|left| left > 0.0)).unwrap();
    assert!(later["fraction"].as_f64().unwrap() <= 1.0 && later["stage"].is_string(), "{later}");
    drop(long);
    // A request that is asked after the computation has ended is the only one that reports.
    std::thread::sleep(std::time::Duration::from_secs(3));
    let mut told = events(server.address).filter_map(progress);
    let _next = ask("next", 20.0);
    let names: Vec<Value> = told.by_ref().take(3).map(|event| event["request"].clone()).collect();
    assert_eq!(names, ["next", "next", "next"]);
}
