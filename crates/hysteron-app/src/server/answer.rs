//! Requests into the types of the interface, and answers out of computations.

use axum::Json;
use axum::body::Bytes;
use axum::extract::{FromRequest, FromRequestParts, Query, Request};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::request::Parts;
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::de::DeserializeOwned;

use crate::api::Problem;
use crate::refused::{Answer, Refused};

/// A JSON body.
pub(super) struct Input<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequest<S> for Input<T> {
    type Rejection = Refused;

    async fn from_request(request: Request, state: &S) -> Result<Self, Refused> {
        let is_json = request.headers().get("content-type").and_then(|kind| kind.to_str().ok());
        // A form of another page cannot send this type without asking.
        if !is_json.is_some_and(|kind| kind.starts_with("application/json")) {
            let problem = Problem::new("the request is not of the type application/json", None);
            return Err(Refused::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, problem));
        }
        let bytes = Bytes::from_request(request, state)
            .await
            .map_err(|e| Refused::new(e.status(), Problem::new(e.body_text(), None)))?;
        let mut reader = serde_json::Deserializer::from_slice(&bytes);
        let value = serde_path_to_error::deserialize(&mut reader).map_err(|e| {
            let place = Some(e.path().to_string()).filter(|path| path != ".");
            let what = format!("the request cannot be understood: {}", e.inner());
            Refused::new(StatusCode::BAD_REQUEST, Problem { place, ..Problem::new(what, None) })
        })?;
        Ok(Self(value))
    }
}

/// A query.
pub(super) struct Ask<T>(pub T);

impl<S: Send + Sync, T: DeserializeOwned> FromRequestParts<S> for Ask<T> {
    type Rejection = Refused;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, Refused> {
        let query = Query::<T>::from_request_parts(parts, state).await;
        query.map(|Query(value)| Self(value)).map_err(|e| Refused::bad(e.body_text()))
    }
}

/// Runs a computation beside the server and answers with its result.
///
/// # Errors
/// Those of the computation.
pub(super) async fn compute<T: Send + 'static>(
    work: impl FnOnce() -> Answer<T> + Send + 'static,
) -> Answer<Json<T>> {
    Ok(Json(run(work).await?))
}

/// Runs a computation beside the server.
///
/// # Errors
/// Those of the computation.
pub(super) async fn run<T: Send + 'static>(work: impl FnOnce() -> Answer<T> + Send + 'static) -> Answer<T> {
    tokio::task::spawn_blocking(work).await?
}

/// A file to be saved under a name.
pub(super) fn attached(name: &str, kind: &'static str, bytes: Vec<u8>) -> Response {
    let mut response = ([(CONTENT_TYPE, kind)], bytes).into_response();
    // A name in a header is quoted: plain letters only.
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let plain: String = name.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
    if let Ok(value) = HeaderValue::from_str(&format!("attachment; filename=\"{plain}\"")) {
        response.headers_mut().insert(CONTENT_DISPOSITION, value);
    }
    response
}
