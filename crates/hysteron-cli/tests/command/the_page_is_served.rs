//! `hysteron app` as a process: killed, told to end, started again.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

struct Server {
    process: Child,
    address: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Server {
    fn start(folder: &Path, more: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
        command.arg("app").arg(folder).args(["--port", "0"]).args(more);
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
        assert!(!address.is_empty(), "{line}");
        Self { process, address }
    }

    fn ask(&self, method: &str, path: &str, body: &str) -> Value {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        let request = format!(
            "{method} {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\ncontent-type: application/json\r\n\
             content-length: {}\r\n\r\n{body}",
            self.address,
            body.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap_or(Value::Null)
    }

    fn wait_for(&self, job: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let found = self.ask("GET", job, "");
            if wanted(&found) {
                return found;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "{found}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([name, &self.process.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }

    /// Time until the process has ended after a signal.
    fn ends_after(mut self, name: &str) -> Duration {
        self.signal(name);
        let begun = Instant::now();
        while self.process.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < Duration::from_secs(20), "it does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
        begun.elapsed()
    }
}

fn loops() -> String {
    let line = |k: u32| {
        let t = f64::from(k) / 200.0;
        let u = (2.0 - 0.5 * f64::from(k / 200 % 3)) * (1.0 - (std::f64::consts::TAU * t).cos());
        format!("{t},{u},{}\n", 15.0 * u - 0.25 * u * u)
    };
    std::iter::once("t_s,u_V,y_um\n".to_owned()).chain((0..4000).map(line)).collect()
}

/// A fit of minutes.
fn long_fit() -> String {
    let swarm =
        json!({"population": 40, "inertia": 0.7, "cognitive": 1.5, "social": 1.5, "velocity_clamp": 0.5});
    let options = json!({"algorithm": {"pso": swarm}, "generations": 100_000, "degree": {"given": 2}});
    let task = json!({"kind": "hammerstein", "options": options});
    json!({"kind": "identify", "records": ["loop.csv"], "model": "long.json", "task": task}).to_string()
}

fn open_stream(address: &str) -> TcpStream {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET /api/v1/events HTTP/1.1\r\nhost: {address}\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut first = [0; 16];
    stream.read_exact(&mut first).unwrap();
    stream
}

#[test]
fn a_server_that_is_killed_in_a_fit_goes_on_from_there() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("loop.csv"), loops()).unwrap();
    let server = Server::start(folder.path(), &[]);
    server.ask("POST", "/api/v1/jobs", &long_fit());
    server.ask("POST", "/api/v1/jobs", &long_fit().replace("long.json", "later.json"));
    let begun = Instant::now();
    // The best so far as well: searches are kept from their first step, before there is a model.
    while !["long.searches.json", "long.partial.json"].iter().all(|kept| folder.path().join(kept).exists()) {
        assert!(begun.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(server.ends_after("-KILL") < Duration::from_secs(1));
    let server = Server::start(folder.path(), &[]);
    let job = server.ask("GET", "/api/v1/jobs/1", "");
    assert_eq!((&job["state"], &job["resumable"]), (&json!("interrupted"), &json!(true)), "{job}");
    // What waited runs now, and can be stopped.
    server.wait_for("/api/v1/jobs/2", |job| job["state"] == "running");
    server.ask("POST", "/api/v1/jobs/2/stop", "{}");
    server.wait_for("/api/v1/jobs/2", |job| job["state"] == "stopped");
    server.ask("POST", "/api/v1/jobs/1/resume", "{}");
    server.wait_for("/api/v1/jobs/1", |job| job["state"] == "running");
    server.ask("POST", "/api/v1/jobs/1/stop", "{}");
    let job = server.wait_for("/api/v1/jobs/1", |job| job["state"] == "stopped");
    assert_eq!(job["result"]["models"], json!(["long.partial.json"]), "{job}");
    // The command reads what the page kept.
    let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
    command.args(["validate", "long.partial.json", "loop.csv", "--json"]).current_dir(folder.path());
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn both_signals_end_it_within_two_seconds_though_streams_are_open_and_a_fit_runs() {
    for signal in ["-TERM", "-INT"] {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("loop.csv"), loops()).unwrap();
        let server = Server::start(&folder.path().join(""), &[]);
        let streams: Vec<TcpStream> = (0..3).map(|_| open_stream(&server.address)).collect();
        server.ask("POST", "/api/v1/jobs", &long_fit());
        server.wait_for("/api/v1/jobs/1", |job| job["state"] == "running");
        let took = server.ends_after(signal);
        assert!(took < Duration::from_secs(2), "{signal}: {took:?}");
        drop(streams);
        let again = Server::start(folder.path(), &[]);
        let job = again.ask("GET", "/api/v1/jobs/1", "");
        assert_eq!(job["state"], "interrupted", "{signal}");
    }
}

#[test]
fn another_address_is_served_with_a_token_only() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(&folder.path().join("made/here"), &["--listen", "0.0.0.0"]);
    let (address, token) = server.address.split_once("/?token=").unwrap();
    let (address, token) = (address.to_owned(), token.to_owned());
    assert_eq!(token.len(), 32);
    assert!(folder.path().join("made/here").is_dir());
    let ask = |path: &str| {
        let mut stream = TcpStream::connect(&address).unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nhost: {address}\r\nconnection: close\r\n\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    assert!(ask("/api/v1/records").starts_with("HTTP/1.1 403"));
    assert!(ask("/").starts_with("HTTP/1.1 403"));
    let entered = ask(&format!("/?token={token}"));
    assert!(entered.starts_with("HTTP/1.1 303") && entered.contains("set-cookie: hysteron-"), "{entered}");
}
