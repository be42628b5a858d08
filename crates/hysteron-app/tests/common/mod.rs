//! A server in a folder of its own, and a small client.
#![allow(dead_code, reason = "each test file uses a part")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests stop at the first surprise"
)]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use hysteron_app::{App, Settings};
use serde_json::{Value, json};

/// A running server; it ends with the process.
pub struct Server {
    pub address: SocketAddr,
    pub folder: tempfile::TempDir,
}

/// An answer.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|e| panic!("{e} in {}", String::from_utf8_lossy(&self.body)))
    }

    /// The JSON of a request that was done.
    pub fn done(self) -> Value {
        assert!(self.status < 300, "{} {}", self.status, String::from_utf8_lossy(&self.body));
        self.json()
    }

    /// The message of a request that was refused with this status.
    pub fn refused(self, status: u16) -> String {
        assert_eq!(self.status, status, "{}", String::from_utf8_lossy(&self.body));
        self.json()["error"]["what"].as_str().expect("a refusal says what went wrong").to_owned()
    }
}

impl Server {
    pub fn start() -> Self {
        Self::with_limit(hysteron_app::MAX_UPLOAD_BYTES)
    }

    pub fn with_limit(max_upload_bytes: u64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let address = serve(folder.path(), max_upload_bytes);
        Self { address, folder }
    }

    pub fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    pub fn get(&self, path: &str) -> Answer {
        request(self.address, "GET", path, &[], b"")
    }

    pub fn delete(&self, path: &str) -> Answer {
        request(self.address, "DELETE", path, &[], b"")
    }

    pub fn send(&self, method: &str, path: &str, body: &Value) -> Answer {
        let body = body.to_string();
        request(self.address, method, path, &[("content-type", "application/json")], body.as_bytes())
    }

    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.send("POST", path, body)
    }

    pub fn upload(&self, name: &str, bytes: &[u8]) -> Answer {
        let path = format!("/api/v1/records?name={}", encoded(name));
        request(self.address, "POST", &path, &[("content-type", "application/octet-stream")], bytes)
    }

    /// Waits until a job is in one of these states.
    pub fn wait_for(&self, job: i64, states: &[&str]) -> Value {
        let begun = Instant::now();
        loop {
            let found = self.get(&format!("/api/v1/jobs/{job}")).done();
            if states.contains(&found["state"].as_str().unwrap()) {
                return found;
            }
            assert!(begun.elapsed() < Duration::from_secs(240), "{found}");
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Identifies a model from a loop, and returns the job.
    pub fn identified(&self, record: &str, model: &str) -> Value {
        let task = json!({"kind": "hammerstein", "options": {"dynamics": "none", "degree": {"given": 2}}});
        let request = json!({"kind": "identify", "records": [record], "model": model, "task": task});
        let job = self.post("/api/v1/jobs", &request).done();
        let job = self.wait_for(job["id"].as_i64().unwrap(), &["done", "failed"]);
        assert_eq!(job["state"], "done", "{job}");
        job
    }

    /// Names of all files of the folder, but the history.
    pub fn files(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .filter(|name| !name.starts_with("hysteron.sqlite"))
            .collect();
        names.sort();
        names
    }
}

/// Serves a folder from a thread.
pub fn serve(folder: &Path, max_upload_bytes: u64) -> SocketAddr {
    let address = "127.0.0.1:0".parse().unwrap();
    let settings = Settings { folder: folder.to_owned(), address, max_upload_bytes, examples: false };
    let app = App::bind(&settings).unwrap();
    let url = app.url();
    std::thread::spawn(move || app.serve());
    url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap()
}

/// Asks, on a connection of its own.
pub fn request(
    address: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &[u8],
) -> Answer {
    let mut stream = TcpStream::connect(address).unwrap();
    let mut head = format!("{method} {path} HTTP/1.1\r\nconnection: close\r\n");
    if !headers.iter().any(|(name, _)| *name == "host") {
        head += &format!("host: {address}\r\n");
    }
    for (name, value) in headers.iter().filter(|(_, value)| !value.is_empty()) {
        head += &format!("{name}: {value}\r\n");
    }
    head += &format!("content-length: {}\r\n\r\n", body.len());
    stream.write_all(head.as_bytes()).unwrap();
    // A server that refuses early may not read the body.
    let _ = stream.write_all(body);
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer);
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("an answer has a head");
    let head = String::from_utf8_lossy(&answer[..end]).to_lowercase();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    let body = answer[end + 4..].to_vec();
    let body = if head.contains("transfer-encoding: chunked") { unchunked(&body) } else { body };
    Answer { status, head, body }
}

fn unchunked(mut bytes: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    while let Some(end) = bytes.windows(2).position(|two| two == b"\r\n") {
        let size = usize::from_str_radix(std::str::from_utf8(&bytes[..end]).unwrap(), 16).unwrap();
        if size == 0 {
            break;
        }
        whole.extend_from_slice(&bytes[end + 2..end + 2 + size]);
        bytes = &bytes[end + 4 + size..];
    }
    whole
}

/// A stream of events: name and data of each.
pub fn events(address: SocketAddr) -> impl Iterator<Item = (String, Value)> {
    let mut stream = TcpStream::connect(address).unwrap();
    let head = format!("GET /api/v1/events HTTP/1.1\r\nhost: {address}\r\n\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut lines = BufReader::new(stream).lines();
    let mut name = String::new();
    std::iter::from_fn(move || {
        loop {
            let line = lines.next()?.ok()?;
            if let Some(found) = line.strip_prefix("event: ") {
                name = found.to_owned();
            } else if let Some(data) = line.strip_prefix("data: ") {
                return Some((name.clone(), serde_json::from_str(data).unwrap_or(Value::Null)));
            }
        }
    })
}

/// An identifier as one segment of a path.
pub fn encoded(id: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    id.bytes().map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") }).collect()
}

/// A record of loops of falling amplitude, as CSV.
pub fn loops(samples: u32) -> String {
    let line = |k: u32| {
        let t = f64::from(k) / 200.0;
        let u = (2.0 - 0.5 * f64::from(k / 200 % 3)) * (1.0 - (std::f64::consts::TAU * t).cos());
        let y = 15.0 * u - 0.25 * u * u + 0.8 * (std::f64::consts::TAU * t).sin();
        format!("{t},{u},{y}\n")
    };
    std::iter::once("t_s,u_V,y_um\n".to_owned()).chain((0..samples).map(line)).collect()
}
