//! Reports of the workspace.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};

use crate::api::{ReportEntry, Trashed};
use crate::refused::{Answer, Refused};
use crate::server::Shared;
use crate::server::answer::{compute, run};
use crate::server::operation::Operation;
use crate::workspace::{Kind, device_of, shown};

/// A report is a file that anyone may have put there: it runs apart from the page and reaches nothing.
const POLICY: &str = "sandbox allow-scripts allow-downloads; default-src 'none'; \
    style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:; frame-ancestors 'none'";

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::get("/api/v1/reports", "The reports.", list).answers::<Vec<ReportEntry>>(),
        Operation::get("/api/v1/reports/{id}", "A report.", one).answers_with("text/html"),
        Operation::delete("/api/v1/reports/{id}", "Moves a report to the trash folder.", delete)
            .answers::<Trashed>(),
    ]
}

async fn list(State(shared): State<Arc<Shared>>) -> Answer<Json<Vec<ReportEntry>>> {
    compute(move || {
        let listed = shared.workspace.look();
        let entry = |found: &crate::workspace::Found| ReportEntry {
            id: found.id.clone(),
            device: device_of(&found.id).to_owned(),
            bytes: found.bytes,
            modified: found.modified(),
        };
        Ok(listed.of(Kind::Report).map(entry).collect::<Vec<_>>())
    })
    .await
}

async fn one(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Response> {
    let bytes = run(move || {
        let path = shared.workspace.existing(&id)?;
        if !(id.ends_with(".html") || id.ends_with(".htm")) {
            return Err(Refused::missing(format!("`{}` is no report", shown(&id))));
        }
        std::fs::read(path).map_err(Refused::failed)
    })
    .await?;
    let headers = [(CONTENT_TYPE, "text/html; charset=utf-8"), (CONTENT_SECURITY_POLICY, POLICY)];
    Ok((headers, bytes).into_response())
}

async fn delete(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Trashed>> {
    compute(move || shared.workspace.discard(&id, Kind::Report)).await
}
