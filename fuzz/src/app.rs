//! Requests to the page's server: method, path and body, on one connection.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

use hysteron_app::{App, Settings, document};
use serde_json::Value;
use tempfile::TempDir;

/// Requests after which the workspace begins anew.
const EACH: usize = 2000;
/// One of so many requests to the bench is sent: a campaign takes a second, and `truth-and-plan` plays it.
const OF_BENCH: usize = 200;

struct Client {
    address: SocketAddr,
    folder: TempDir,
    stream: Option<TcpStream>,
    sent: usize,
}

static CLIENT: LazyLock<Mutex<Client>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let address = "127.0.0.1:0".parse().expect("an address");
    let settings =
        Settings { folder: folder.path().to_owned(), address, max_upload_bytes: 1 << 20, examples: false };
    let app = App::bind(&settings).expect("the server listens");
    let address = app.url().trim_start_matches("http://").trim_end_matches('/').parse().expect("an address");
    std::thread::spawn(move || app.serve());
    Mutex::new(Client { address, folder, stream: None, sent: 0 })
});

/// Method and path of every operation; but for streams of events, which do not end.
static OPERATIONS: LazyLock<Vec<(String, String)>> = LazyLock::new(|| {
    let document = document();
    let paths = document["paths"].as_object().expect("paths");
    let of = |(path, operations): (&String, &Value)| -> Vec<(String, String)> {
        let methods = operations.as_object().into_iter().flat_map(|o| o.keys());
        methods.map(|method| (method.to_uppercase(), path.clone())).collect()
    };
    let mut all: Vec<_> = paths.iter().flat_map(of).collect();
    all.retain(|(_, path)| !path.ends_with("/events"));
    all
});

/// Which operation, what stands for its parameters, a byte 0, a query, a byte 0, the body.
pub fn request(data: &[u8]) {
    let Some((first, rest)) = data.split_first() else { return };
    let (method, path) = &OPERATIONS[usize::from(*first) % OPERATIONS.len()];
    let sum = rest.iter().fold(0_usize, |sum, byte| sum.wrapping_mul(31).wrapping_add(usize::from(*byte)));
    if method == "POST" && path.contains("bench") && !sum.is_multiple_of(OF_BENCH) {
        return;
    }
    let mut parts = rest.splitn(3, |byte| *byte == 0);
    let mut next = || parts.next().unwrap_or_default();
    let (name, query, body) = (escaped(next()), escaped(next()), next());
    let mut path: String = path.clone();
    while let (Some(from), Some(to)) = (path.find('{'), path.find('}')) {
        path.replace_range(from..=to, &name);
    }
    let query = query.replace("%3D", "=").replace("%26", "&");
    let mut client = CLIENT.lock().unwrap_or_else(PoisonError::into_inner);
    let status = client.ask(method, &format!("{path}?{query}"), body);
    assert_ne!(status, 500, "{method} {path}?{query}");
}

fn escaped(bytes: &[u8]) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.".contains(byte);
    bytes.iter().map(|b| if plain(b) { char::from(*b).to_string() } else { format!("%{b:02X}") }).collect()
}

impl Client {
    fn ask(&mut self, method: &str, path: &str, body: &[u8]) -> u16 {
        self.sent += 1;
        if self.sent.is_multiple_of(EACH) {
            self.begin_anew();
        }
        let head = format!(
            "{method} {path} HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\ncontent-length: {}\r\n\r\n",
            self.address,
            body.len()
        );
        let sent = [head.as_bytes(), body].concat();
        // A server may close a connection that was idle; once more on a new one.
        let first = self.exchange(&sent);
        first.or_else(|_| self.exchange(&sent)).expect("the server answers")
    }

    fn exchange(&mut self, sent: &[u8]) -> std::io::Result<u16> {
        let mut stream = match self.stream.take() {
            Some(stream) => stream,
            None => {
                let stream = TcpStream::connect(self.address)?;
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(Duration::from_secs(10)))?;
                stream
            }
        };
        stream.write_all(sent)?;
        let mut answer = Vec::new();
        let mut buffer = [0; 1 << 16];
        loop {
            let read = stream.read(&mut buffer)?;
            if read == 0 {
                break;
            }
            answer.extend_from_slice(&buffer[..read]);
            if let Some(whole) = is_whole(&answer) {
                if whole {
                    self.stream = Some(stream);
                }
                break;
            }
        }
        let status = answer.get(9..12).and_then(|s| std::str::from_utf8(s).ok()).and_then(|s| s.parse().ok());
        status.ok_or_else(|| std::io::Error::other("no answer"))
    }

    /// Everything but the history goes; the server sees an empty folder.
    fn begin_anew(&self) {
        for entry in std::fs::read_dir(self.folder.path()).into_iter().flatten().flatten() {
            if !entry.file_name().to_string_lossy().starts_with("hysteron.sqlite") {
                let path = entry.path();
                let _ =
                    if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
            }
        }
    }
}

/// Whether an answer has come to its end, and whether the connection may be used again; `None`: more comes.
fn is_whole(answer: &[u8]) -> Option<bool> {
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n")?;
    let head = String::from_utf8_lossy(&answer[..end]).to_lowercase();
    let length = head.lines().find_map(|line| line.strip_prefix("content-length: "));
    let body = &answer[end + 4..];
    let done = match length.and_then(|length| length.trim().parse::<usize>().ok()) {
        Some(length) => body.len() >= length,
        None if head.contains("transfer-encoding: chunked") => body.ends_with(b"0\r\n\r\n"),
        None => true,
    };
    done.then(|| !head.contains("connection: close"))
}
