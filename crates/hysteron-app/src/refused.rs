//! A request that is refused: status and problem.

use std::fmt::Display;

use axum::Json;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

use crate::api::{Problem, Refusal};

/// Result of a request.
pub(crate) type Answer<T> = Result<T, Refused>;

/// A refusal.
#[derive(Debug)]
pub(crate) struct Refused {
    status: StatusCode,
    problem: Problem,
}

impl Refused {
    /// With a status and a problem.
    pub(crate) fn new(status: StatusCode, problem: Problem) -> Self {
        Self { status, problem }
    }

    fn said(status: StatusCode, what: impl Display) -> Self {
        Self::new(status, Problem { what: what.to_string(), ..Problem::default() })
    }

    /// The request itself is wrong.
    pub(crate) fn bad(what: impl Display) -> Self {
        Self::said(StatusCode::BAD_REQUEST, what)
    }

    /// What it names is not there.
    pub(crate) fn missing(what: impl Display) -> Self {
        Self::said(StatusCode::NOT_FOUND, what)
    }

    /// It conflicts with what is there.
    pub(crate) fn conflict(what: impl Display) -> Self {
        Self::said(StatusCode::CONFLICT, what)
    }

    /// It is understood but cannot be done.
    pub(crate) fn cannot(problem: impl Into<Problem>) -> Self {
        Self::new(StatusCode::UNPROCESSABLE_ENTITY, problem.into())
    }

    /// The server failed, e.g. to write a file.
    pub(crate) fn failed(what: impl Display) -> Self {
        Self::said(StatusCode::INTERNAL_SERVER_ERROR, what)
    }

    /// Adds a remedy.
    pub(crate) fn hint(mut self, remedy: impl Into<String>) -> Self {
        self.problem.remedy = Some(remedy.into());
        self
    }

    /// The problem.
    pub(crate) fn into_problem(self) -> Problem {
        self.problem
    }
}

impl IntoResponse for Refused {
    fn into_response(self) -> Response {
        (self.status, Json(Refusal { error: self.problem })).into_response()
    }
}

impl From<rusqlite::Error> for Refused {
    fn from(e: rusqlite::Error) -> Self {
        Self::failed(format!("the history of the workspace cannot be used: {e}"))
    }
}

impl From<tokio::task::JoinError> for Refused {
    fn from(e: tokio::task::JoinError) -> Self {
        Self::failed(format!("the computation ended early: {e}"))
    }
}
