//! The page, inside the program.

use std::sync::Arc;

use axum::Router;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::routing::get;

use super::Shared;

/// A file of the built page: path, type, bytes.
macro_rules! asset {
    ($path:literal, $name:literal, $kind:literal) => {
        ($path, $kind, include_bytes!(concat!("../../page/dist/", $name)).as_slice())
    };
}

static ASSETS: [(&str, &str, &[u8]); 4] = [
    asset!("/", "index.html", "text/html; charset=utf-8"),
    asset!("/app.js", "app.js", "text/javascript; charset=utf-8"),
    asset!("/app.css", "app.css", "text/css; charset=utf-8"),
    asset!("/icon.svg", "icon.svg", "image/svg+xml"),
];

pub(super) fn routes() -> Router<Arc<Shared>> {
    ASSETS.iter().fold(Router::new(), |router, (path, kind, bytes)| {
        let answer = || async { ([(CONTENT_TYPE, *kind), (CACHE_CONTROL, "no-cache")], *bytes) };
        router.route(path, get(answer))
    })
}
