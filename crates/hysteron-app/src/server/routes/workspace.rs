//! Workspace, events, options, history, trash, examples, and the description of the interface.

use std::collections::BTreeSet;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use serde_json::Value;

use crate::api::{Example, ExampleOpened, History, OptionsOffered, Trashed, Workspace};
use crate::clock::PROGRAM;
use crate::command::scripts;
use crate::options::offered;
use crate::refused::Answer;
use crate::server::Shared;
use crate::server::answer::{compute, run};
use crate::server::events::events;
use crate::server::openapi::document;
use crate::server::operation::Operation;
use crate::workspace::{Kind, device_of, open_example};

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::get("/api/v1/workspace", "The folder that is served.", workspace).answers::<Workspace>(),
        Operation::get("/api/v1/events", "Changes as they happen, as server-sent events.", events)
            .answers_with("text/event-stream"),
        Operation::get("/api/v1/options", "What can be asked of fits, bench and drives.", options)
            .answers::<OptionsOffered>(),
        Operation::get("/api/v1/history", "What was done, and scripts that repeat it.", history)
            .answers::<History>(),
        Operation::get("/api/v1/trash", "What was deleted, newest first.", trash).answers::<Vec<Trashed>>(),
        Operation::post("/api/v1/trash/{token}/restore", "Undoes a deletion.", restore).answers::<Trashed>(),
        Operation::post("/api/v1/examples/{name}", "Copies an example into the workspace.", example)
            .answers::<ExampleOpened>(),
        Operation::get("/api/v1/openapi.json", "This description.", openapi).answers::<Value>(),
    ]
}

async fn workspace(State(shared): State<Arc<Shared>>) -> Answer<Json<Workspace>> {
    compute(move || {
        let workspace = &shared.workspace;
        let listed = workspace.look();
        let ids = listed.of(Kind::Record).chain(listed.of(Kind::Model));
        let devices: BTreeSet<String> = ids.map(|found| device_of(&found.id).to_owned()).collect();
        let examples = hysteron_examples::EXAMPLES.iter().map(|example| Example {
            name: example.name.to_owned(),
            title: example.title.to_owned(),
            open: devices.contains(example.name),
        });
        Ok(Workspace {
            folder: workspace.folder().display().to_string(),
            program: PROGRAM.to_owned(),
            change: workspace.notices.last_change(),
            max_upload_bytes: workspace.max_upload_bytes,
            examples: examples.collect(),
            trash: workspace.trash()?,
            devices: devices.into_iter().collect(),
        })
    })
    .await
}

async fn options() -> Json<OptionsOffered> {
    Json(offered())
}

async fn history(State(shared): State<Arc<Shared>>) -> Answer<Json<History>> {
    compute(move || {
        let (shell, python) = scripts(&shared.workspace.history.actions()?);
        Ok(History { jobs: shared.jobs.all(), shell, python })
    })
    .await
}

async fn trash(State(shared): State<Arc<Shared>>) -> Answer<Json<Vec<Trashed>>> {
    compute(move || shared.workspace.trash()).await
}

async fn restore(State(shared): State<Arc<Shared>>, Path(token): Path<String>) -> Answer<Json<Trashed>> {
    compute(move || shared.workspace.restore(&token)).await
}

async fn example(State(shared): State<Arc<Shared>>, Path(name): Path<String>) -> Answer<Json<ExampleOpened>> {
    compute(move || open_example(&shared.workspace, &name)).await
}

async fn openapi() -> Answer<Json<Value>> {
    Ok(Json(run(|| Ok(document())).await?))
}
