//! Jobs.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;

use crate::api::{Command, Job, JobRequest, Live};
use crate::refused::{Answer, Refused};
use crate::server::Shared;
use crate::server::answer::{Input, compute, run};
use crate::server::operation::Operation;

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::get("/api/v1/jobs", "The jobs, newest first.", list).answers::<Vec<Job>>(),
        Operation::post("/api/v1/jobs", "Queues a job.", add)
            .takes::<JobRequest>()
            .with_status(202)
            .answers::<Job>(),
        Operation::post("/api/v1/commands", "The commands of a job that is not queued yet.", commands)
            .takes::<JobRequest>()
            .answers::<Command>(),
        Operation::get("/api/v1/jobs/{id}", "A job.", one).answers::<Job>(),
        Operation::delete("/api/v1/jobs/{id}", "Deletes a job that does not run.", delete).with_status(204),
        Operation::post("/api/v1/jobs/{id}/stop", "Stops a job; the best so far is kept.", stop)
            .answers::<Job>(),
        Operation::post("/api/v1/jobs/{id}/resume", "Goes on with a job.", resume)
            .with_status(202)
            .answers::<Job>(),
        Operation::get("/api/v1/jobs/{id}/live", "What is drawn of a running fit.", live).answers::<Live>(),
    ]
}

fn number(id: &str) -> Answer<i64> {
    id.parse().map_err(|_| Refused::missing(format!("there is no job `{}`", crate::workspace::shown(id))))
}

async fn list(State(shared): State<Arc<Shared>>) -> Json<Vec<Job>> {
    Json(shared.jobs.all())
}

async fn add(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<JobRequest>,
) -> Answer<(StatusCode, Json<Job>)> {
    Ok((StatusCode::ACCEPTED, compute(move || shared.jobs.add(request)).await?))
}

async fn commands(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<JobRequest>,
) -> Answer<Json<Command>> {
    compute(move || shared.jobs.command(request)).await
}

async fn one(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Job>> {
    Ok(Json(shared.jobs.one(number(&id)?)?))
}

async fn delete(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<StatusCode> {
    let id = number(&id)?;
    run(move || shared.jobs.delete(id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

async fn stop(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Job>> {
    let id = number(&id)?;
    compute(move || shared.jobs.stop(id)).await
}

async fn resume(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
) -> Answer<(StatusCode, Json<Job>)> {
    let id = number(&id)?;
    Ok((StatusCode::ACCEPTED, compute(move || shared.jobs.resume(id)).await?))
}

async fn live(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Live>> {
    Ok(Json(shared.jobs.live(number(&id)?)?))
}
