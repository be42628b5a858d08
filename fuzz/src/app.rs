//! Requests to the page's server, answered without a connection: method, path and body.

use std::sync::{LazyLock, Mutex, PoisonError};

use hysteron_app::{App, Settings, document};
use serde_json::Value;
use tempfile::TempDir;

/// Requests after which the workspace begins anew.
const EACH: usize = 2000;
/// Those that may have changed something after which it does.
const CHANGES: usize = 50;
/// One of so many requests to the bench is sent: a campaign takes a second, and `truth-and-plan` plays it.
const OF_BENCH: usize = 200;

/// A server and its workspace.
struct Served {
    app: App,
    asked: usize,
    changed: usize,
    // Goes after the server.
    _folder: TempDir,
}

static SERVED: LazyLock<Mutex<Option<Served>>> = LazyLock::new(Mutex::default);

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
    let mut kept = SERVED.lock().unwrap_or_else(PoisonError::into_inner);
    let mut served = kept.take().unwrap_or_else(served);
    let status = served.ask(method, &format!("{path}?{query}"), body);
    assert_ne!(status, 500, "{method} {path}?{query}");
    // A fit that was asked for would run on beside all that follows; that it is accepted was seen.
    let fits = method == "POST" && path.contains("/jobs") && status < 300;
    if served.asked < EACH && served.changed < CHANGES && !fits {
        *kept = Some(served);
    }
}

fn escaped(bytes: &[u8]) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.".contains(byte);
    bytes.iter().map(|b| if plain(b) { char::from(*b).to_string() } else { format!("%{b:02X}") }).collect()
}

fn served() -> Served {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let address = "127.0.0.1:0".parse().expect("an address");
    let settings =
        Settings { folder: folder.path().to_owned(), address, max_upload_bytes: 1 << 20, examples: false };
    let app = App::bind(&settings).expect("the server listens");
    Served { app, asked: 0, changed: 0, _folder: folder }
}

impl Served {
    fn ask(&mut self, method: &str, target: &str, body: &[u8]) -> u16 {
        let (status, _) = self.app.answer(method, target, body).expect("the server answers");
        self.asked += 1;
        self.changed += usize::from(method != "GET" && status < 300);
        status
    }
}
