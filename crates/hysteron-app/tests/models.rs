//! From records to a model, its scores, curves, drive and code; jobs on the way.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use common::{Server, encoded, events, loops};
use serde_json::{Value, json};

fn with_model() -> Server {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    server.upload("unseen.csv", loops(800).as_bytes()).done();
    server.identified("loop.csv", "stage.json");
    server
}

fn waveform(amplitude: f64) -> Value {
    let waveform = json!({"kind": "sine", "frequency_hz": 1.0, "periods": 2.0});
    json!({"from": "waveform", "specification":
        {"sample_rate_hz": 200.0, "low_v": 5.0, "high_v": 5.0 + amplitude, "waveform": waveform}})
}

#[test]
fn the_chain_from_record_to_code() {
    let server = with_model();
    let listed = server.get("/api/v1/models").done();
    let entry = &listed[0];
    assert_eq!(
        (&entry["id"], &entry["kind"], &entry["unit"]),
        (&json!("stage.json"), &json!("hammerstein"), &json!("µm"))
    );
    assert_eq!(entry["records"], json!(["loop.csv"]));
    assert!(
        entry["command"].as_str().unwrap().starts_with("hysteron identify loop.csv -o stage.json"),
        "{entry}"
    );
    let detail = server.get("/api/v1/models/stage.json").done();
    assert!(detail["parameters"].as_array().unwrap().len() > 3);
    assert!(!detail["findings"].as_array().unwrap().is_empty());
    assert_eq!(detail["file"]["format"], "hysteron-model");
    let curves = "/api/v1/models/stage.json/curves?record=unseen.csv&view=";
    for (view, names) in [("loop", vec!["measured", "model"]), ("residual-loop", vec!["residual"])] {
        let drawn = server.get(&format!("{curves}{view}")).done();
        let found: Vec<&str> =
            drawn["series"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
        assert_eq!(found, names);
    }
    let scores = json!({"records": ["unseen.csv", "none.csv"]});
    let scored = server.post("/api/v1/models/stage.json/scores", &scores).done();
    let residual = server.get(&format!("{curves}residual")).done();
    assert_eq!(residual["scores"]["rmse"], scored["records"][0]["score"]["rmse"]);
    // What is drawn is what was scored.
    let e: Vec<f64> = serde_json::from_value(residual["series"][0]["curve"]["y"].clone()).unwrap();
    let largest = e.iter().fold(0.0, |largest: f64, e| largest.max(e.abs()));
    assert!((largest - residual["scores"]["max_abs_error"].as_f64().unwrap()).abs() < 1e-9, "{largest}");
    assert!(scored["records"][1]["error"]["what"].as_str().unwrap().contains("none.csv"));
    assert!(scored["definitions"].as_array().unwrap().len() > 5);
    let saved = json!({"records": ["unseen.csv"], "save": "scored.csv"});
    let saved = server.post("/api/v1/models/stage.json/scores", &saved).done();
    let shell = saved["command"]["shell"].as_str().unwrap();
    assert!(shell.contains("validate stage.json unseen.csv -o scored.csv"), "{shell}");
    let series = std::fs::read_to_string(server.path("scored.csv")).unwrap();
    assert_eq!(series.lines().count(), 801, "{}", &series[..200]);
    let two = json!({"records": ["unseen.csv", "loop.csv"], "save": "scored.csv"});
    let two = server.post("/api/v1/models/stage.json/scores", &two).done();
    assert!(two["records"][0]["error"]["what"].as_str().unwrap().contains("of one record"), "{two}");
    let run = json!({"records": ["unseen.csv"], "continued": true});
    let run = server.post("/api/v1/models/stage.json/scores", &run).done();
    let names: Vec<&str> =
        run["records"].as_array().unwrap().iter().map(|judged| judged["record"].as_str().unwrap()).collect();
    assert_eq!(names, ["unseen.csv", "whole run"]);
    assert!(run["command"]["shell"].as_str().unwrap().contains("--continued"));
    let response = server.get("/api/v1/models/stage.json/response?record=unseen.csv").done();
    assert!(response["rows"].is_array());
    let follow = json!({"reference": waveform(10.0), "save": "drive.csv"});
    let followed = server.post("/api/v1/models/stage.json/follow", &follow).done();
    assert_eq!(followed["samples"], 400);
    assert!(followed["predicted_max_error"].as_f64().unwrap() < 0.2, "{followed}");
    assert!(!followed["shown"].as_array().unwrap().is_empty());
    assert_eq!(followed["command"]["shell"], "hysteron invert stage.json drive-reference.csv -o drive.csv");
    assert!(server.path("drive.csv").is_file() && server.path("drive-reference.csv").is_file());
    let again = json!({"reference": {"from": "record", "id": "drive-reference.csv"}});
    let again = server.post("/api/v1/models/stage.json/follow", &again).done();
    assert_eq!(again["drive_high"], followed["drive_high"]);
    let options = json!({"controllers": ["uncompensated", "feedforward"]});
    let track =
        json!({"reference": waveform(10.0), "on_model": true, "options": options, "save": "track.csv"});
    let tracked = server.post("/api/v1/models/stage.json/track", &track).done();
    let shell = "hysteron track stage.json track-reference.csv -o track.csv --controller uncompensated \
                 --controller feedforward --plant model";
    assert_eq!((&tracked["command"]["shell"], &tracked["file"]), (&json!(shell), &json!("track.csv")));
    let written = std::fs::read_to_string(server.path("track.csv")).unwrap();
    assert!(written.contains("reference_um,u_uncompensated_V,y_uncompensated_um"), "{}", &written[..200]);
    let rms = |k: usize| tracked["controllers"][k]["rms"].as_f64().unwrap();
    assert!(rms(1) < rms(0), "{} {}", rms(0), rms(1));
    let query = "as=c&inverse=true&name=axis&accuracy=0.001&bandwidth_hz=5&preview=3&low=0&high=12";
    let named = server.get(&format!("/api/v1/models/stage.json/preview?{query}")).done();
    let shell = "hysteron export stage.json --to c -o axis --name axis --accuracy 0.001 --inverse --range \
                 0:12 --bandwidth 5 --preview 3";
    assert_eq!(named["command"]["shell"], shell);
    assert_eq!(named["files"][0]["name"], "axis.h");
    let text = named["files"][0]["text"].as_str().unwrap();
    let file = std::fs::read(server.path("stage.json")).unwrap();
    assert!(text.contains(&hysteron_io::sha256(&file)), "the header names the file: {text}");
    let preview = server.get("/api/v1/models/stage.json/preview?as=c&inverse=true").done();
    let names: Vec<&str> =
        preview["files"].as_array().unwrap().iter().map(|f| f["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"stage.h") && names.contains(&"stage_inverse.c"), "{names:?}");
    let zip = server.get("/api/v1/models/stage.json/download?as=c");
    assert!(zip.body.starts_with(b"PK") && zip.head.contains("filename=\"stage-c.zip\""), "{}", zip.head);
    let json = server.get("/api/v1/models/stage.json/download?as=json");
    assert_eq!(json.body, std::fs::read(server.path("stage.json")).unwrap());
    let report = server.get("/api/v1/models/stage.json/download?as=report");
    assert!(String::from_utf8_lossy(&report.body).contains("<svg"), "the model on its record is drawn");
    assert!(
        String::from_utf8(report.body).unwrap().contains("<!doctype html>")
            || report.head.contains("text/html")
    );
    let history = server.get("/api/v1/history").done();
    let shell = history["shell"].as_str().unwrap();
    for command in ["hysteron identify", "hysteron validate", "hysteron invert", "hysteron export"] {
        assert!(shell.contains(command), "{shell}");
    }
    assert!(
        history["python"].as_str().unwrap().contains("hy.Hammerstein(dynamics=\"none\", degree=2)"),
        "{history}"
    );
}

#[test]
fn a_model_can_be_renamed_deleted_and_restored() {
    let server = with_model();
    let renamed = server.send(
        "PATCH",
        "/api/v1/models/stage.json",
        &json!({"name": "a <b>name</b>".replace('/', "_")}),
    );
    let id = renamed.done()["id"].as_str().unwrap().to_owned();
    let detail = server.get(&format!("/api/v1/models/{}", encoded(&id))).done();
    assert!(!detail["findings"].as_array().unwrap().is_empty(), "what the fit found goes with the name");
    server.send("PATCH", &format!("/api/v1/models/{}", encoded(&id)), &json!({"name": "../x"})).refused(400);
    let trashed = server.delete(&format!("/api/v1/models/{}", encoded(&id))).done();
    assert_eq!(server.get("/api/v1/models").done(), json!([]));
    server.post(&format!("/api/v1/trash/{}/restore", trashed["token"].as_str().unwrap()), &json!({})).done();
    assert_eq!(server.get("/api/v1/models").done()[0]["id"], json!(id));
    std::fs::write(server.path("bad.json"), "{\"format\": \"hysteron-model\", \"version\": 99}").unwrap();
    std::fs::write(server.path("other.json"), "{\"a\": 1}").unwrap();
    let listed = server.get("/api/v1/models").done();
    assert_eq!(listed.as_array().unwrap().len(), 2, "{listed}");
    assert!(listed[1]["error"]["what"].is_string(), "{listed}");
}

#[test]
fn jobs_queue_and_are_watched_stopped_resumed_and_deleted() {
    let server = Server::start();
    server.upload("loop.csv", loops(6000).as_bytes()).done();
    let mut told = events(server.address);
    // Many generations: it would take minutes.
    let swarm = json!({"population": 40, "inertia": 0.7, "cognitive": 1.5, "social": 1.5,
        "velocity_clamp": 0.5});
    let options = json!({"algorithm": {"pso": swarm}, "generations": 100_000, "degree": {"given": 2}});
    let task = json!({"kind": "hammerstein", "options": options});
    let request = json!({"kind": "identify", "records": ["loop.csv"], "model": "long.json", "task": task});
    let command = server.post("/api/v1/commands", &request).done();
    assert!(command["shell"].as_str().unwrap().contains("--optimizer pso --population 40"), "{command}");
    let long = server.post("/api/v1/jobs", &request).done();
    let long_id = long["id"].as_i64().unwrap();
    let next = server.post("/api/v1/jobs", &json!({"kind": "identify", "records": ["loop.csv"]})).done();
    let next_id = next["id"].as_i64().unwrap();
    assert_eq!((&next["state"], &next["ahead"]), (&json!("waiting"), &json!(1)));
    let last = server
        .post("/api/v1/jobs", &json!({"kind": "compare", "records": ["loop.csv"], "quick": true}))
        .done();
    let last_id = last["id"].as_i64().unwrap();
    let stopped = server.post(&format!("/api/v1/jobs/{last_id}/stop"), &json!({})).done();
    assert_eq!(stopped["state"], "stopped");
    // The picture of the best model so far arrives while it runs.
    let drawn = told.find(|(name, data)| name == "live" && data["latest"].is_object()).unwrap().1;
    assert_eq!((&drawn["job"], &drawn["latest"]["record"]), (&json!(long_id), &json!("loop.csv")));
    assert!(drawn["latest"]["model"]["x"].as_array().unwrap().len() > 20);
    assert!(drawn["latest"]["rmse"].as_f64().unwrap() >= 0.0);
    let live = server.get(&format!("/api/v1/jobs/{long_id}/live")).done();
    assert!(live["measured"].is_object() && !live["costs"].as_array().unwrap().is_empty(), "{live}");
    assert_eq!(live["job"]["state"], "running");
    assert_eq!(server.delete(&format!("/api/v1/jobs/{long_id}")).status, 409);
    // A checkpoint is written while it runs.
    let begun = std::time::Instant::now();
    while !server.path("long.searches.json").exists() {
        assert!(begun.elapsed().as_secs() < 60, "no checkpoint");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    server.post(&format!("/api/v1/jobs/{long_id}/stop"), &json!({})).done();
    let stopped = server.wait_for(long_id, &["stopped", "failed", "done"]);
    assert_eq!((&stopped["state"], &stopped["resumable"]), (&json!("stopped"), &json!(true)), "{stopped}");
    assert_eq!(stopped["result"]["models"], json!(["long.partial.json"]));
    let partial = server.get("/api/v1/models/long.partial.json").done();
    assert_eq!(partial["interrupted"], true);
    let done = server.wait_for(next_id, &["done", "failed"]);
    assert_eq!(done["state"], "done", "{done}");
    assert_eq!(done["result"]["models"], json!(["loop.json"]));
    let resumed = server.post(&format!("/api/v1/jobs/{long_id}/resume"), &json!({})).done();
    assert_eq!(resumed["state"], "waiting");
    server.wait_for(long_id, &["running"]);
    server.post(&format!("/api/v1/jobs/{long_id}/stop"), &json!({})).done();
    let again = server.wait_for(long_id, &["stopped", "failed"]);
    assert_eq!(again["state"], "stopped", "{again}");
    server.post(&format!("/api/v1/jobs/{long_id}/stop"), &json!({})).refused(409);
    assert_eq!(server.delete(&format!("/api/v1/jobs/{long_id}")).status, 204);
    server.get(&format!("/api/v1/jobs/{long_id}")).refused(404);
    assert_eq!(server.get("/api/v1/jobs").done().as_array().unwrap().len(), 2);
}

#[test]
fn fits_that_wait_have_names_of_their_own() {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    let request = json!({"kind": "identify", "records": ["loop.csv"]});
    let queued = |_| server.post("/api/v1/jobs", &request).done();
    let jobs: Vec<Value> = (0..3).map(queued).collect();
    let mut names: Vec<_> = jobs.iter().map(|job| job["request"]["model"].as_str().unwrap()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 3, "{jobs:?}");
}

#[test]
fn a_job_that_cannot_be_done_says_why() {
    let server = Server::start();
    server.upload("loop.csv", loops(400).as_bytes()).done();
    for (wrong, status) in [
        (json!({"kind": "identify", "records": []}), 400),
        (json!({"kind": "identify", "records": ["none.csv"]}), 404),
        (json!({"kind": "identify", "records": ["loop.csv"], "model": "../x.json"}), 400),
        (json!({"kind": "identify", "records": ["loop.csv"], "structure": "nonsense"}), 400),
        (json!({"kind": "identify", "records": ["loop.csv"], "task": {"kind": "modes", "options": {}}}), 400),
        (json!({"kind": "compare", "records": ["loop.csv"], "candidates": ["nonsense"]}), 400),
        (json!({"kind": "compare", "records": ["loop.csv"], "time_limit_s": -1}), 400),
        (json!({"kind": "dance"}), 400),
    ] {
        assert_eq!(server.post("/api/v1/jobs", &wrong).status, status, "{wrong}");
    }
    let constant = "t_s,u_V,y_um\n".to_owned() + &(0..50).map(|k| format!("{k},1,{k}\n")).collect::<String>();
    server.upload("constant.csv", constant.as_bytes()).done();
    let job = server.post("/api/v1/jobs", &json!({"kind": "identify", "records": ["constant.csv"]})).done();
    let failed = server.wait_for(job["id"].as_i64().unwrap(), &["failed", "done"]);
    assert_eq!(failed["state"], "failed");
    assert!(failed["error"]["what"].as_str().unwrap().contains("constant"), "{failed}");
    assert_eq!(failed["result"]["models"], json!([]));
}

#[test]
fn the_bench_makes_records_that_say_so() {
    let server = Server::start();
    let plan = json!({"sample_rate_hz": 1000.0, "loop_periods": 2.0, "sweep_end_hz": 20.0, "sweep_s": 2.0,
        "validation_hz": [5.0], "validation_s": 1.0});
    let made = server.post("/api/v1/bench", &json!({"plan": plan, "seed": 3})).done();
    let records = made["records"].as_array().unwrap();
    assert_eq!(records.len(), 3, "{made}");
    let mut listed = server.get("/api/v1/records").done();
    let begun = std::time::Instant::now();
    while listed.as_array().unwrap().iter().any(|record| record["reading"] == true) {
        assert!(begun.elapsed().as_secs() < 60);
        std::thread::sleep(std::time::Duration::from_millis(30));
        listed = server.get("/api/v1/records").done();
    }
    assert!(listed.as_array().unwrap().iter().all(|record| record["simulated"] == true), "{listed}");
    let roles: Vec<&str> =
        listed.as_array().unwrap().iter().map(|r| r["settings"]["role"].as_str().unwrap()).collect();
    assert!(roles.contains(&"validate") && roles.contains(&"auto"), "{roles:?}");
    server.post("/api/v1/bench", &json!({"plan": {"sample_rate_hz": -1.0}})).refused(400);
    let drive = json!({"specification": {"sample_rate_hz": 1000.0, "low_v": 0.0, "high_v": 10.0,
        "waveform": {"kind": "triangle", "frequency_hz": 2.0, "periods": 3.0}}, "save": "drives/slow.csv"});
    let drive = server.post("/api/v1/drives", &drive).done();
    assert_eq!(drive["summary"]["high_v"], 10.0);
    assert!(server.path("drives/slow.csv").is_file());
    let offered = server.get("/api/v1/options").done();
    assert!(offered["choices"][0]["choices"].as_array().unwrap().len() > 5);
    assert_eq!(offered["defaults"][0]["kind"], "hammerstein");
    assert!(offered["task"]["$defs"]["HammersteinOptions"].is_object(), "schema of the library's options");
}

#[test]
fn a_race_shows_who_has_arrived_and_the_winner_can_be_taken() {
    let server = Server::start();
    let plan = json!({"sample_rate_hz": 500.0, "loop_periods": 2.0, "sweep_end_hz": 20.0, "sweep_s": 3.0,
        "validation_hz": [5.0], "validation_s": 1.0});
    let made = server.post("/api/v1/bench", &json!({"plan": plan, "seed": 3})).done();
    let mut told = events(server.address);
    let request = json!({"kind": "compare", "records": made["records"], "report": "race.html",
        "candidates": ["none+degree1", "integer2+degree1"]});
    let job = server.post("/api/v1/jobs", &request).done();
    let arrived = |data: &Value| {
        data["state"] == "running"
            && data["result"]["candidates"].as_array().is_some_and(|all| !all.is_empty())
    };
    let (_, running) = told.find(|(name, data)| name == "job" && arrived(data)).unwrap();
    assert_eq!(running["result"]["candidates"][0]["name"], "none+degree1");
    let done = server.wait_for(job["id"].as_i64().unwrap(), &["done", "failed"]);
    assert_eq!(done["state"], "done", "{done}");
    let comparison = &done["result"]["comparison"];
    assert_eq!(comparison["candidates"].as_array().unwrap().len(), 2);
    assert_eq!(server.get("/api/v1/reports").done()[0]["id"], "race.html");
    let name = &comparison["preferred"];
    let take = json!({"kind": "identify", "records": [made["records"][0]], "structure": name});
    let command = server.post("/api/v1/commands", &take).done();
    assert!(command["shell"].as_str().unwrap().contains("--dynamics"), "{command}");
}

#[test]
fn a_drive_by_sample_and_one_that_learns_are_those_of_the_command() {
    let server = with_model();
    let at = "/api/v1/models/stage.json/follow";
    let inverse = json!({"preview": 4, "virgin_voltage": 0.0, "range": [0.0, 12.0]});
    let ahead = json!({"reference": waveform(10.0), "inverse": inverse, "save": "drive.csv"});
    let ahead = server.post(at, &ahead).done();
    let shell = "hysteron invert stage.json drive-reference.csv -o drive.csv --range 0:12 --virgin-voltage 0 \
                 --preview 4";
    assert_eq!(ahead["command"]["shell"], shell);
    assert!(ahead["preview_samples"].as_u64().unwrap() <= 4, "{ahead}");
    let inverse = json!({"preview": 4, "predict_to_hz": -1.0});
    server.post(at, &json!({"reference": waveform(10.0), "inverse": inverse})).refused(422);
    // The model's own output as the last run: nothing is left to learn.
    let reference = json!({"from": "record", "id": "drive-reference.csv"});
    let whole = json!({"reference": reference, "save": "first.csv"});
    let first = server.post(at, &whole).done();
    let learned = json!({"reference": reference, "learn_from": "first.csv"});
    let learned = server.post(at, &learned).done();
    let shell = learned["command"]["shell"].as_str().unwrap();
    assert!(shell.ends_with("--learn-from first.csv"), "{shell}");
    let high = |of: &Value| of["drive_high"].as_f64().unwrap();
    assert!((high(&learned) - high(&first)).abs() < 1e-3, "{} {}", high(&learned), high(&first));
    let both = json!({"reference": reference, "learn_from": "first.csv", "inverse": {"preview": 1}});
    server.post(at, &both).refused(422);
}

#[test]
fn the_next_drive_is_designed_for_a_model() {
    let server = with_model();
    let options = json!({"purpose": "minor-loops", "time_s": 4.0, "slew_per_s": 200.0});
    let request = json!({"options": options, "save": "next.csv"});
    let found = server.post("/api/v1/models/stage.json/design", &request).done();
    let shell = "hysteron design stage.json --for minor-loops --time 4s --slew 200 -o next.csv";
    assert_eq!(found["command"]["shell"], shell);
    let row = &found["tables"][0]["rows"][0];
    let error = |column: usize| row[column].as_str().unwrap().parse::<f64>().unwrap();
    assert!(error(3) < error(2) && error(3) <= error(4), "{row}");
    let drive = std::fs::read_to_string(server.path("next.csv")).unwrap();
    assert_eq!((drive.lines().next(), drive.lines().count()), (Some("t_s,u_V"), 801));
    let long = json!({"options": {"time_s": -1.0}, "save": "other.csv"});
    server.post("/api/v1/models/stage.json/design", &long).refused(422);
    assert!(!server.path("other.csv").exists());
}
