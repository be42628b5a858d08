//! The server: listens, answers, ends.

mod answer;
mod arriving;
mod events;
mod guard;
mod openapi;
mod operation;
mod page;
mod routes;
mod told;

use std::future::IntoFuture;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::DefaultBodyLimit;
use axum::http::header::{CONTENT_TYPE, HOST};
use axum::http::{Request, StatusCode};
use axum::{Router, middleware};
use http_body_util::BodyExt;
use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};
use tokio::sync::watch;
use tower_service::Service;

pub use openapi::document;

use crate::error::AppError;
use crate::jobs::Jobs;
use crate::refused::Refused;
use crate::workspace::{Workspace, open_example};
use guard::Access;

/// Largest body of a request other than an upload \[bytes\]: a reference of a few million samples.
const MOST_JSON_BYTES: usize = 64 << 20;
/// Largest upload unless set otherwise \[bytes\].
pub const MAX_UPLOAD_BYTES: u64 = 1 << 30;
/// Memory for records that were read \[bytes\].
const RECORD_MEMORY: u64 = 1 << 30;
/// Time between two looks at the folder while a page is open.
const BETWEEN_LOOKS: Duration = Duration::from_secs(2);
/// Time for a running job to keep its last state when the program ends.
const PATIENCE: Duration = Duration::from_millis(1200);
/// Time for requests to be answered when the program ends.
const GRACE: Duration = Duration::from_millis(300);

/// What is served, and where.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The workspace's folder; made if missing.
    pub folder: PathBuf,
    /// Address and port; port 0: any that is free.
    pub address: SocketAddr,
    /// Largest upload \[bytes\].
    pub max_upload_bytes: u64,
    /// Copy the measured examples into the folder first.
    pub examples: bool,
}

/// What the handlers share.
pub(crate) struct Shared {
    pub(crate) workspace: Arc<Workspace>,
    pub(crate) jobs: Arc<Jobs>,
    pub(crate) closing: watch::Receiver<bool>,
    pub(crate) reading: std::sync::Mutex<std::collections::HashSet<String>>,
    access: Access,
}

impl Drop for Shared {
    /// The thread of the jobs ends with the last that could ask it for one.
    fn drop(&mut self) {
        self.jobs.close(Duration::ZERO);
    }
}

/// A server that listens and does not answer yet.
pub struct App {
    runtime: Runtime,
    listener: TcpListener,
    shared: Arc<Shared>,
    router: Router,
    close: watch::Sender<bool>,
    address: SocketAddr,
}

impl App {
    /// Opens the workspace and listens. On another address than that of this machine itself, requests need
    /// the token of [`Self::url`].
    ///
    /// # Errors
    /// [`AppError`]: a folder or an address that cannot be used.
    pub fn bind(settings: &Settings) -> Result<Self, AppError> {
        let workspace = Workspace::open(&settings.folder, settings.max_upload_bytes, RECORD_MEMORY)?;
        if settings.examples {
            hysteron_examples::EXAMPLES.iter().try_for_each(|example| {
                let opened = open_example(&workspace, example.name);
                opened.map(drop).map_err(|refused| AppError::Examples(refused.into_problem().what))
            })?;
        }
        let workspace = Arc::new(workspace);
        let runtime = Builder::new_current_thread().enable_all().build()?;
        let address = settings.address;
        let listener = runtime.block_on(TcpListener::bind(address));
        let listener = listener.map_err(|source| AppError::Listen { address, source })?;
        let address = listener.local_addr()?;
        let access = Access::to(address)?;
        let jobs = Jobs::open(Arc::clone(&workspace))?;
        let (close, closing) = watch::channel(false);
        let shared = Arc::new(Shared { workspace, jobs, closing, reading: Default::default(), access });
        let router = router(Arc::clone(&shared));
        Ok(Self { runtime, listener, shared, router, close, address })
    }

    /// Address of the page, with the token where one is needed. Of a server that listens on all addresses,
    /// it is the one that other machines reach.
    pub fn url(&self) -> String {
        let token = self.shared.access.token.as_ref();
        let token = token.map_or_else(String::new, |token| format!("?token={token}"));
        let ip = if self.address.ip().is_unspecified() { outward() } else { self.address.ip() };
        format!("http://{}/{token}", SocketAddr::new(ip, self.address.port()))
    }

    /// The workspace's folder.
    pub fn folder(&self) -> &std::path::Path {
        self.shared.workspace.folder()
    }

    /// Answers one request of the page as [`Self::serve`] does, without a connection: status and body. The body
    /// that is sent is JSON, or the bytes of a file.
    ///
    /// # Errors
    /// For a method or a target that HTTP does not know, and an answer that breaks off.
    pub fn answer(&self, method: &str, target: &str, body: &[u8]) -> std::io::Result<(u16, Vec<u8>)> {
        let request = Request::builder()
            .method(method)
            .uri(target)
            .header(HOST, self.address.to_string())
            .header(CONTENT_TYPE, "application/json")
            .body(Body::from(body.to_vec()))
            .map_err(std::io::Error::other)?;
        self.runtime.block_on(async {
            let Ok(answer) = self.router.clone().call(request).await;
            let status = answer.status().as_u16();
            let body = answer.into_body().collect().await.map_err(std::io::Error::other)?;
            Ok((status, body.to_bytes().to_vec()))
        })
    }

    /// Serves until SIGINT or SIGTERM, then ends within two seconds: what runs is interrupted, and kept.
    ///
    /// # Errors
    /// If the system refuses to listen for signals.
    pub fn serve(self) -> Result<(), AppError> {
        let Self { runtime, listener, shared, router, close, .. } = self;
        let jobs = Arc::clone(&shared.jobs);
        let outcome = runtime.block_on(async {
            let mut closing = shared.closing.clone();
            let closed = async move {
                let _ = closing.wait_for(|closing| *closing).await;
            };
            let server = axum::serve(listener, router).with_graceful_shutdown(closed);
            let server = tokio::spawn(server.into_future());
            tokio::spawn(look(Arc::clone(&shared)));
            signal().await?;
            // Event streams end by it; what still waits after the grace is cut off.
            let _ = close.send(true);
            let _ = tokio::time::timeout(GRACE, server).await;
            Ok(())
        });
        jobs.close(PATIENCE);
        // Computations of requests may still run; nothing waits for them.
        runtime.shutdown_background();
        outcome
    }
}

/// Address of this machine in its network, this machine itself where it has none. Nothing is sent: the system
/// says from where it would.
fn outward() -> IpAddr {
    let documentation = (Ipv4Addr::new(192, 0, 2, 1), 9);
    let found = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).and_then(|socket| {
        socket.connect(documentation)?;
        socket.local_addr()
    });
    found.map_or(Ipv4Addr::LOCALHOST.into(), |address| address.ip())
}

/// Looks at the folder while a page is open, as other programs write into it.
async fn look(shared: Arc<Shared>) {
    loop {
        tokio::time::sleep(BETWEEN_LOOKS).await;
        if shared.workspace.notices.is_heard() {
            let workspace = Arc::clone(&shared.workspace);
            let _ = tokio::task::spawn_blocking(move || drop(workspace.look())).await;
        }
    }
}

#[cfg(unix)]
async fn signal() -> std::io::Result<()> {
    use std::pin::pin;

    use futures_util::future::select;
    use tokio::signal::unix::{SignalKind, signal};
    let mut interrupt = signal(SignalKind::interrupt())?;
    let mut terminate = signal(SignalKind::terminate())?;
    let _ = select(pin!(interrupt.recv()), pin!(terminate.recv())).await;
    Ok(())
}

#[cfg(not(unix))]
async fn signal() -> std::io::Result<()> {
    tokio::signal::ctrl_c().await
}

fn router(shared: Arc<Shared>) -> Router {
    let mut router = Router::new();
    for operation in operation::all() {
        router = router.route(operation.path, operation.route);
    }
    router
        .merge(page::routes())
        .fallback(|| async { Refused::missing("there is nothing here") })
        .method_not_allowed_fallback(|| async {
            let problem = crate::api::Problem::new("this cannot be done here", None);
            Refused::new(StatusCode::METHOD_NOT_ALLOWED, problem)
        })
        .layer(DefaultBodyLimit::max(MOST_JSON_BYTES))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard::guard))
        .with_state(shared)
}
