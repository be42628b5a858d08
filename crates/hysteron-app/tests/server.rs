//! Who is answered, how, and what describes it.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

mod common;

use common::{Server, encoded, events, loops, request};
use hysteron_app::{App, AppError, Settings, document};
use serde_json::{Value, json};

/// Every operation: method and path.
fn operations() -> Vec<(String, String)> {
    let document = document();
    let paths = document["paths"].as_object().unwrap();
    let of = |(path, methods): (&String, &Value)| {
        let methods = methods.as_object().unwrap().keys();
        methods.map(|method| (method.to_uppercase(), path.clone())).collect::<Vec<_>>()
    };
    paths.iter().flat_map(of).collect()
}

fn concrete(path: &str) -> String {
    path.replace("{id}", "none.csv").replace("{token}", "none").replace("{name}", "none")
}

#[test]
fn a_foreign_host_or_origin_is_refused_on_every_route() {
    let server = Server::start();
    let own = server.address.to_string();
    let mut routes = operations();
    routes.extend(
        ["/", "/app.js", "/app.css", "/icon.svg", "/nothing"].map(|p| ("GET".to_owned(), p.to_owned())),
    );
    assert!(routes.len() > 30, "{}", routes.len());
    for (method, path) in routes {
        let path = concrete(&path);
        for headers in [
            vec![("host", "evil.example")],
            vec![("host", "127.0.0.1:1")],
            vec![("host", "")],
            vec![("host", own.as_str()), ("origin", "http://evil.example")],
            vec![("host", own.as_str()), ("origin", "null")],
        ] {
            let answer = request(server.address, &method, &path, &headers, b"");
            // A request without host is refused below this server already.
            assert!([403, 400].contains(&answer.status), "{method} {path} {headers:?}: {}", answer.status);
            if headers[0].1.is_empty() {
                continue;
            }
            assert_eq!(answer.status, 403, "{method} {path} {headers:?}");
        }
    }
    let origin = format!("http://{own}");
    let answer =
        request(server.address, "GET", "/api/v1/records", &[("host", &own), ("origin", &origin)], b"");
    assert_eq!(answer.status, 200);
}

#[test]
fn every_answer_has_the_headers_of_the_page() {
    let server = Server::start();
    for path in ["/", "/app.js", "/api/v1/records", "/api/v1/nothing", "/api/v1/models/none.json"] {
        let head = server.get(path).head;
        for header in [
            "content-security-policy: default-src 'none'; script-src 'self'; style-src 'self'",
            "x-content-type-options: nosniff",
            "x-frame-options: deny",
            "referrer-policy: no-referrer",
        ] {
            assert!(head.contains(header), "{path}: {head}");
        }
        assert!(!head.contains("unsafe-inline"), "{path}");
    }
    let page = String::from_utf8(server.get("/").body).unwrap();
    assert!(!page.contains("onclick") && !page.contains("http://") && !page.contains("<script>"), "{page}");
}

#[test]
fn the_description_names_every_route_and_every_route_is_there() {
    let server = Server::start();
    let served = server.get("/api/v1/openapi.json").done();
    assert_eq!(served, document());
    assert_eq!(served["openapi"], "3.1.0");
    for (method, path) in operations() {
        if path.ends_with("/events") {
            continue;
        }
        let body = json!({});
        let answer = match method.as_str() {
            "GET" | "DELETE" => request(server.address, &method, &concrete(&path), &[], b""),
            _ => server.send(&method, &concrete(&path), &body),
        };
        let text = String::from_utf8_lossy(&answer.body).into_owned();
        assert!(!text.contains("there is nothing here"), "{method} {path}: {text}");
        assert_ne!(answer.status, 405, "{method} {path}");
        assert_ne!(answer.status, 500, "{method} {path}: {text}");
        if answer.status >= 400 {
            assert!(answer.json()["error"]["what"].is_string(), "{method} {path}: {text}");
        }
    }
    // Every reference of the description leads somewhere.
    let text = served.to_string();
    let schemas = served["components"]["schemas"].as_object().unwrap();
    for name in text.split("\"#/components/schemas/").skip(1) {
        let name = name.split('"').next().unwrap();
        assert!(schemas.contains_key(name), "{name}");
    }
    server.get("/api/v1/nothing").refused(404);
    server.delete("/api/v1/workspace").refused(405);
}

#[test]
fn requests_that_cannot_be_understood_say_where() {
    let server = Server::start();
    let path = "/api/v1/jobs";
    let wrong = server.post(path, &json!({"kind": "identify", "records": "x"}));
    assert_eq!(wrong.status, 400);
    let form = request(server.address, "POST", path, &[("content-type", "text/plain")], b"{}");
    assert_eq!(form.status, 415);
    let broken = request(server.address, "POST", path, &[("content-type", "application/json")], b"{");
    assert_eq!(broken.status, 400);
    for id in ["..", "..%2F..%2Fetc%2Fpasswd", "%2Fetc%2Fpasswd", "hysteron.sqlite", "a%00b"] {
        for path in
            [format!("/api/v1/records/{id}"), format!("/api/v1/models/{id}"), format!("/api/v1/reports/{id}")]
        {
            let answer = server.get(&path);
            assert!([400, 404].contains(&answer.status), "{path}: {}", answer.status);
        }
    }
}

#[test]
fn what_another_program_writes_is_seen_and_two_pages_see_the_same() {
    let server = Server::start();
    let mut first = events(server.address);
    let mut second = events(server.address);
    std::thread::sleep(std::time::Duration::from_millis(200));
    std::fs::write(server.path("loop.csv"), loops(400)).unwrap();
    let a = first.find(|(name, _)| name == "records").unwrap();
    let b = second.find(|(name, _)| name == "records").unwrap();
    assert_eq!(a.1["change"], b.1["change"]);
    assert_eq!(server.get("/api/v1/records").done()[0]["id"], "loop.csv");
}

#[test]
fn a_report_of_anyone_runs_apart_from_the_page() {
    let server = Server::start();
    std::fs::write(server.path("evil.html"), "<script>fetch('/api/v1/records')</script>").unwrap();
    assert_eq!(server.get("/api/v1/reports").done()[0]["id"], "evil.html");
    let report = server.get("/api/v1/reports/evil.html");
    assert!(report.head.contains("content-security-policy: sandbox allow-scripts"), "{}", report.head);
    assert!(report.head.contains("default-src 'none'") && !report.head.contains("allow-same-origin"));
    server.delete("/api/v1/reports/evil.html").done();
    assert_eq!(server.get("/api/v1/reports").done(), json!([]));
    assert_eq!(server.get(&format!("/api/v1/reports/{}", encoded("loop.csv"))).status, 404);
}

#[test]
fn an_address_that_is_taken_and_a_file_for_a_folder_are_errors() {
    let server = Server::start();
    let settings = Settings {
        folder: server.path("new/folder"),
        address: server.address,
        max_upload_bytes: 1,
        examples: true,
    };
    assert!(matches!(App::bind(&settings), Err(AppError::Listen { .. })));
    assert!(server.path("new/folder").is_dir());
    // A second server of the folder would take the jobs of the first for interrupted ones.
    let settings = Settings { folder: server.path(""), address: "127.0.0.1:0".parse().unwrap(), ..settings };
    assert!(matches!(App::bind(&settings), Err(AppError::History(_))));
    let file = server.path("file");
    std::fs::write(&file, "x").unwrap();
    let settings = Settings {
        folder: file,
        address: "127.0.0.1:0".parse().unwrap(),
        max_upload_bytes: 1,
        examples: true,
    };
    assert!(matches!(App::bind(&settings), Err(AppError::Folder { .. })));
}
