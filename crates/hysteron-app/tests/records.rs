//! Records: uploads, contents, curves, settings, trash.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use std::io::{Read, Write};

use common::{Server, encoded, loops, request};
use serde_json::json;

#[test]
fn a_record_goes_from_upload_to_curves() {
    let server = Server::start();
    let entry = server.upload("stage/loop.csv", loops(1200).as_bytes());
    assert_eq!(entry.status, 201);
    let entry = entry.json();
    assert_eq!(entry["id"], "stage/loop.csv");
    assert_eq!(
        (&entry["device"], &entry["samples"], &entry["rate_hz"]),
        (&json!("stage"), &json!(1200), &json!(200.0))
    );
    assert_eq!((&entry["input"], &entry["output_unit"]), (&json!("u"), &json!("µm")));
    assert!(entry["glyph"].as_array().unwrap().len() > 20);
    let listed = server.get("/api/v1/records").done();
    assert_eq!(listed[0]["id"], "stage/loop.csv");
    let id = encoded("stage/loop.csv");
    let detail = server.get(&format!("/api/v1/records/{id}")).done();
    assert_eq!(detail["inspection"]["samples"], 1200);
    let uses: Vec<_> = (0..3).map(|k| detail["columns"][k]["used_as"].clone()).collect();
    assert_eq!(uses, [json!("time"), json!("input"), json!("output")]);
    assert!(!detail["prospects"]["statements"].as_array().unwrap().is_empty());
    assert_eq!(detail["command"]["shell"], "hysteron inspect stage/loop.csv");
    let time = server.get(&format!("/api/v1/records/{id}/curve?pixels=100&from=1&to=2")).done();
    let x: Vec<f64> = serde_json::from_value(time["x"].clone()).unwrap();
    assert!(x.first().unwrap() >= &0.99 && x.last().unwrap() <= &2.01, "{x:?}");
    assert!(x.len() <= 408 && time["across"]["high"] == 5.995);
    let over = server.get(&format!("/api/v1/records/{id}/curve?x=u&y=y")).done();
    assert_eq!(over["shown"], "all 1200 samples");
    let wrong = server.get(&format!("/api/v1/records/{id}/curve?y=nothing")).refused(404);
    assert!(wrong.contains("no column `nothing`"), "{wrong}");
    let file = server.get(&format!("/api/v1/records/{id}/file"));
    assert_eq!(file.body, loops(1200).as_bytes());
    let both = json!({"records": ["stage/loop.csv"]});
    let both = server.post("/api/v1/prospects", &both).done();
    assert_eq!(both["roles"], json!(["quasi-static"]));
    assert_eq!(server.files(), ["stage"]);
}

#[test]
fn a_million_samples_keep_their_extremes_in_a_small_curve() {
    let server = Server::start();
    let mut text = "t_s,u_V,y_um\n".to_owned();
    for k in 0..200_000u32 {
        let u = (f64::from(k) * 0.01).sin();
        let y = if k == 123_456 { 9.0 } else { u };
        text += &format!("{},{u:.6},{y:.6}\n", f64::from(k) / 1000.0);
    }
    server.upload("long.csv", text.as_bytes()).done();
    let curve = server.get("/api/v1/records/long.csv/curve?pixels=500").done();
    let y: Vec<f64> = serde_json::from_value(curve["y"].clone()).unwrap();
    assert!(y.len() <= 2008 && y.contains(&9.0), "{}", y.len());
    let over = server.get("/api/v1/records/long.csv/curve?x=u&pixels=500").done();
    assert!(over["x"].as_array().unwrap().len() <= 4000);
}

#[test]
fn files_that_are_no_records_give_a_reason_and_leave_nothing() {
    let server = Server::start();
    let bad: [(&str, &[u8], &str); 20] = [
        ("empty.csv", b"", "empty"),
        ("header.csv", b"t_s,u_V,y_um\n", "header"),
        ("word.csv", b"t_s,u_V,y_um\n0,1,nope\n0.1,2,3\n", "nope"),
        ("ragged.csv", b"t_s,u_V,y_um\n0,1,2\n0.1,2\n", "field"),
        ("numbers.csv", b"0,1,2\n1,2,3\n2,3,4\n", "header"),
        ("one.csv", b"t_s,u_V,y_um\n0,1,2\n", "sample"),
        ("back.csv", b"t_s,u_V,y_um\n0,1,2\n1,2,3\n0.5,3,4\n", "time"),
        ("nan.csv", b"t_s,u_V,y_um\n0,1,2\n1,nan,3\n2,3,4\n", "finite"),
        ("missing.csv", b"t_s,u_V,y_um\n0,1,2\n1,,3\n2,3,4\n", ""),
        ("twice.csv", b"t_s,u_V,u_V\n0,1,2\n1,2,3\n", ""),
        ("binary.csv", b"\x00\xff\xfe\x01\x02\x03\n\x00", ""),
        ("quote.csv", b"t_s,\"u_V,y_um\n0,1,2\n", ""),
        ("text.txt", b"this is a letter, not a record\n", ""),
        ("broken.npz", b"PK\x03\x04broken", ""),
        ("broken.mat", b"MATLAB 5.0 MAT-file, broken", ""),
        ("broken.h5", b"\x89HDF\r\n\x1a\nbroken", ""),
        ("broken.npy", b"\x93NUMPY\x01\x00", ""),
        ("broken.tdms", b"TDSmbroken", ""),
        ("broken.xlsx", b"PK\x03\x04", ""),
        ("picture.png", b"\x89PNG\r\n\x1a\n", "ending"),
    ];
    for (name, bytes, word) in bad {
        let answer = server.upload(name, bytes);
        assert!((400..500).contains(&answer.status), "{name} {}", answer.status);
        let error = answer.json()["error"].clone();
        let what = error["what"].as_str().unwrap();
        assert!(what.len() > 20 && what.to_lowercase().contains(word), "{name}: {what}");
        assert!(!what.contains(".upload-") && !what.contains("/tmp"), "{name}: {what}");
    }
    let place = server.upload("word.csv", b"t_s,u_V,y_um\n0,1,nope\n0.1,2,3\n").json();
    assert!(place["error"]["where"].as_str().unwrap().starts_with("line 2, column 3"), "{place}");
    assert_eq!(place["error"]["around"][1], json!({"number": 2, "text": "0,1,nope", "here": true}));
    for name in ["../out.csv", "/etc/x.csv", "a\\b.csv", ".hidden.csv", "trash/x.csv"] {
        assert!(server.upload(name, loops(100).as_bytes()).status == 400, "{name}");
    }
    assert_eq!(server.files(), Vec::<String>::new());
    assert_eq!(server.get("/api/v1/records").done(), json!([]));
}

#[test]
fn uploads_are_whole_or_absent_and_within_the_limit() {
    let server = Server::with_limit(20_000);
    let large = server.upload("large.csv", loops(2000).as_bytes()).refused(413);
    assert!(large.contains("20000 bytes"), "{large}");
    // The connection breaks off before the promised end.
    let body = loops(300);
    let path = "/api/v1/records?name=half.csv";
    {
        use std::io::Write;
        let mut stream = std::net::TcpStream::connect(server.address).unwrap();
        let head =
            format!("POST {path} HTTP/1.1\r\nhost: {}\r\ncontent-length: 9000\r\n\r\n", server.address);
        stream.write_all(head.as_bytes()).unwrap();
        stream.write_all(&body.as_bytes()[..1000]).unwrap();
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(server.files(), Vec::<String>::new());
    server.upload("loop.csv", body.as_bytes()).done();
    let taken = server.upload("loop.csv", body.as_bytes()).refused(409);
    assert!(taken.contains("is there already"), "{taken}");
    let other = loops(200);
    let replaced =
        request(server.address, "POST", "/api/v1/records?name=loop.csv&replace=1", &[], other.as_bytes());
    assert_eq!(replaced.done()["samples"], 200);
    assert_eq!(std::fs::read(server.path("loop.csv")).unwrap(), other.as_bytes());
}

#[test]
fn what_is_said_of_a_record_is_kept_beside_it_and_never_in_it() {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    server.upload("next.csv", loops(1200).as_bytes()).done();
    let patch = json!({"role": "validate", "masks": [[1.0, 2.0]], "to_s": 4.995, "continues": "next.csv"});
    let entry = server.send("PATCH", "/api/v1/records/loop.csv", &patch).done();
    assert_eq!((&entry["settings"]["role"], &entry["samples"]), (&json!("validate"), &json!(1000)));
    let detail = server.get("/api/v1/records/loop.csv").done();
    assert_eq!(detail["inspection"]["masked_samples"], 201);
    let entry = server.send("PATCH", "/api/v1/records/loop.csv", &json!({"to_s": null})).done();
    assert_eq!((&entry["samples"], &entry["settings"]["role"]), (&json!(1200), &json!("validate")));
    for wrong in [
        json!({"masks": [[2.0, 1.0]]}),
        json!({"role": "king"}),
        json!({"unknown": 1}),
        json!({"continues": "loop.csv"}),
        json!({"sample_rate_hz": -1.0}),
        json!({"scales": ["y"]}),
        json!({"dead_band": 0.0}),
        json!({"dead_band": 1.0, "dead_zone": 1.0}),
        json!([1]),
    ] {
        let refused = server.send("PATCH", "/api/v1/records/loop.csv", &wrong);
        assert!((400..500).contains(&refused.status), "{wrong}");
    }
    assert_eq!(std::fs::read(server.path("loop.csv")).unwrap(), loops(1200).as_bytes());
}

#[test]
fn a_drive_below_the_threshold_said_counts_as_nothing() {
    let server = Server::start();
    server.upload("loop.csv", loops(1200).as_bytes()).done();
    let largest = || {
        let range = &server.get("/api/v1/records/loop.csv").done()["inspection"]["input"];
        range["high"].as_f64().unwrap()
    };
    let whole = largest();
    let (above, below) = (json!({"dead_zone": whole / 2.0}), json!({"dead_zone": null, "dead_band": 1.0}));
    server.send("PATCH", "/api/v1/records/loop.csv", &above).done();
    assert!((largest() - whole / 2.0).abs() < 1e-9);
    let command = &server.get("/api/v1/records/loop.csv").done()["command"];
    assert!(command["shell"].as_str().unwrap().contains(&format!("--dead-zone {}", whole / 2.0)));
    assert!(command["python"].as_str().unwrap().contains(&format!("dead_zone={}", whole / 2.0)));
    server.send("PATCH", "/api/v1/records/loop.csv", &below).done();
    assert!((largest() - whole).abs() < 1e-9);
}

#[test]
fn deleting_can_be_undone() {
    let server = Server::start();
    server.upload("a/loop.csv", loops(400).as_bytes()).done();
    let id = encoded("a/loop.csv");
    let trashed = server.delete(&format!("/api/v1/records/{id}")).done();
    assert!(!server.path("a/loop.csv").exists());
    assert_eq!(server.get(&format!("/api/v1/records/{id}")).status, 404);
    assert_eq!(server.get("/api/v1/trash").done()[0]["id"], "a/loop.csv");
    let restore = format!("/api/v1/trash/{}/restore", trashed["token"].as_str().unwrap());
    // A file that has the name by now is not replaced.
    std::fs::write(server.path("a/loop.csv"), "other").unwrap();
    server.post(&restore, &json!({})).refused(409);
    std::fs::remove_file(server.path("a/loop.csv")).unwrap();
    assert_eq!(server.post(&restore, &json!({})).done()["id"], "a/loop.csv");
    assert_eq!(std::fs::read(server.path("a/loop.csv")).unwrap(), loops(400).as_bytes());
    server.post(&restore, &json!({})).refused(404);
    assert_eq!(server.get("/api/v1/workspace").done()["trash"], json!([]));
}

/// What was said of a record goes with it: to the trash and back, and to no other record of its name.
#[test]
fn settings_go_with_their_file() {
    let server = Server::start();
    let said = || server.get("/api/v1/records").done()[0]["settings"].clone();
    server.upload("run.csv", loops(600).as_bytes()).done();
    let cut = json!({"from_s": 0.5, "role": "validate"});
    server.send("PATCH", "/api/v1/records/run.csv", &cut).done();
    let before = said();
    assert_eq!(before["from_s"], 0.5);
    let wrong = server.delete("/api/v1/reports/run.csv").refused(404);
    assert!(wrong.contains("is no report"), "{wrong}");
    let deleted = server.delete("/api/v1/records/run.csv").done();
    server.upload("run.csv", loops(800).as_bytes()).done();
    assert_ne!(said()["from_s"], 0.5);
    server.delete("/api/v1/records/run.csv").done();
    let token = deleted["token"].as_str().unwrap();
    server.post(&format!("/api/v1/trash/{token}/restore"), &json!({})).done();
    assert_eq!(said(), before);
    let path = "/api/v1/records?name=run.csv&replace=1";
    request(server.address, "POST", path, &[], loops(900).as_bytes()).done();
    assert_ne!(said()["from_s"], 0.5);
    assert_eq!(server.get("/api/v1/records").done()[0]["samples"], 900);
    // The file is taken away by another program, and another one comes.
    server.send("PATCH", "/api/v1/records/run.csv", &cut).done();
    std::fs::remove_file(server.path("run.csv")).unwrap();
    server.upload("run.csv", loops(700).as_bytes()).done();
    assert_ne!(said()["from_s"], 0.5);
}

#[test]
fn the_folder_is_what_the_command_line_sees_and_names_stay_data() {
    let server = Server::start();
    let name = "<script>alert(1)</script>.csv".replace('/', "_");
    std::fs::write(server.path(&name), loops(300)).unwrap();
    std::fs::write(server.path("notes.md"), "no record").unwrap();
    let listed = server.get("/api/v1/records");
    assert!(listed.head.contains("content-type: application/json"));
    let listed = listed.json();
    assert_eq!(listed.as_array().unwrap().len(), 1);
    assert_eq!(listed[0]["id"], json!(name));
    let text = "t_s,<b>u</b>_V,y_um\n0,1,2\n1,2,3\n2,1,2\n3,0,1\n4,1,2\n";
    let entry = server.upload("html.csv", text.as_bytes());
    assert!(entry.status == 201 || entry.status == 422, "{}", entry.status);
    // A file that disappears is gone from the list.
    std::fs::remove_file(server.path(&name)).unwrap();
    let left = server.get("/api/v1/records").done();
    assert!(left.as_array().unwrap().iter().all(|record| record["id"].as_str() != Some(&name)));
}

#[test]
fn an_example_is_one_request_away() {
    let server = Server::start();
    let opened = server.post("/api/v1/examples/afm-z-scanner", &json!({})).done();
    assert_eq!(opened["records"].as_array().unwrap().len(), 3);
    let second = server.get(&format!("/api/v1/records/{}", encoded(opened["records"][1].as_str().unwrap())));
    let second = second.done();
    assert_eq!(second["settings"]["continues"], opened["records"][0]);
    // Opened again, it leaves what was said of its records.
    let path = format!("/api/v1/records/{}", encoded(opened["records"][1].as_str().unwrap()));
    server.send("PATCH", &path, &json!({"from_s": 0.25})).done();
    server.post("/api/v1/examples/afm-z-scanner", &json!({})).done();
    assert_eq!(server.get(&path).done()["settings"]["from_s"], 0.25);
    assert!(second["segments"].as_u64().unwrap() > 3, "{}", second["segments"]);
    assert_eq!(second["simulated"], false);
    server.post("/api/v1/examples/nothing", &json!({})).refused(404);
}

#[test]
fn an_upload_in_chunks_that_is_too_large_gets_a_readable_answer() {
    let server = Server::with_limit(1000);
    let mut stream = std::net::TcpStream::connect(server.address).unwrap();
    let head = format!(
        "POST /api/v1/records?name=a.csv HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n\
         content-type: application/octet-stream\r\ntransfer-encoding: chunked\r\n\r\n",
        server.address
    );
    stream.write_all(head.as_bytes()).unwrap();
    // Far more than any buffer on the way holds: the server reads it to the end.
    let chunk = vec![b'1'; 0x10000];
    for _ in 0..200 {
        stream.write_all(b"10000\r\n").unwrap();
        stream.write_all(&chunk).unwrap();
        stream.write_all(b"\r\n").unwrap();
    }
    stream.write_all(b"0\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 413") && answer.contains("larger than 1000 bytes"), "{answer}");
    assert_eq!(server.files(), Vec::<String>::new());
}

#[test]
fn files_as_spreadsheets_and_old_machines_write_them_are_read() {
    let server = Server::start();
    let rows: String = (0..60).map(|k| format!("{},{},{}\n", k, k % 7, k % 5)).collect();
    let units = format!("time,voltage,displacement\n[s],[V],[um]\n{rows}");
    server.upload("units.csv", units.as_bytes()).done();
    server.upload("mac.csv", format!("t_s,u_V,y_um\n{rows}").replace('\n', "\r").as_bytes()).done();
    for id in ["units.csv", "mac.csv"] {
        let detail = server.get(&format!("/api/v1/records/{id}")).done();
        let read = (&detail["samples"], &detail["input_unit"], &detail["output_unit"]);
        assert_eq!(read, (&json!(60), &json!("V"), &json!("µm")), "{detail}");
    }
}

#[test]
fn a_name_that_no_system_takes_is_refused_with_the_reason() {
    let server = Server::start();
    server.upload("loop.csv", loops(400).as_bytes()).done();
    server.identified("loop.csv", "stage.json");
    let long = "x".repeat(300);
    let refused = server.send("PATCH", "/api/v1/models/stage.json", &json!({ "name": long })).refused(400);
    assert!(refused.contains("200 bytes"), "{refused}");
    assert!(server.upload(&format!("{long}.csv"), b"t_s,u_V\n").refused(400).contains("200 bytes"));
}
