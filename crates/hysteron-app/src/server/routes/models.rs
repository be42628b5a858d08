//! Models.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::response::Response;
use hysteron_identify::Listener;

use crate::api::{
    AdaptRequest, DecoupleRequest, DesignRequest, DownloadQuery, Form, ModelCurves, ModelCurvesQuery,
    ModelDetail, ModelEntry, ModelPatch, Outcome, Preview, RealiseRequest, RecalibrateRequest, ResponseQuery,
    Responses, Scored, ScoresRequest, SimulateRequest, TrackAxesRequest, Trashed,
};
use crate::models::{
    adapt, archive, curves, decouple, design, detail, list, preview, realise, recalibrate, rename, report,
    response, scores, simulate, track_axes,
};
use crate::refused::{Answer, Refused};
use crate::server::Shared;
use crate::server::answer::{Ask, Input, attached, compute};
use crate::server::operation::Operation;
use crate::server::told::{Named, run_told};
use crate::workspace::{Kind, stem_of};

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::get("/api/v1/models", "The models.", all).answers::<Vec<ModelEntry>>(),
        Operation::get("/api/v1/models/{id}", "A model in full.", one).answers::<ModelDetail>(),
        Operation::patch("/api/v1/models/{id}", "Renames a model.", patch)
            .takes::<ModelPatch>()
            .answers::<ModelEntry>(),
        Operation::delete("/api/v1/models/{id}", "Moves a model to the trash folder.", delete)
            .answers::<Trashed>(),
        Operation::get("/api/v1/models/{id}/curves", "A model on a record, with the scores.", on_record)
            .asks::<ModelCurvesQuery>()
            .answers::<ModelCurves>(),
        Operation::post("/api/v1/models/{id}/scores", "Scores on records.", on_records)
            .takes::<ScoresRequest>()
            .answers::<Scored>(),
        Operation::get("/api/v1/models/{id}/response", "Gain and phase at a record's sines.", sines)
            .asks::<ResponseQuery>()
            .answers::<Responses>(),
        Operation::post("/api/v1/models/{id}/simulate", "The output for the drive of a record.", simulated)
            .takes::<SimulateRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/decouple", "Drives of several actuators.", decoupled)
            .takes::<DecoupleRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/track-axes", "Controllers of several axes.", tracked_axes)
            .takes::<TrackAxesRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/design", "The next drive.", next_drive)
            .takes::<DesignRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/recalibrate", "Gain, delay and offset anew.", recalibrated)
            .takes::<RecalibrateRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/adapt", "Corrects a model over a record.", adapted)
            .takes::<AdaptRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/models/{id}/realise", "Poles for a controller's rate.", realised)
            .takes::<RealiseRequest>()
            .answers::<Outcome>(),
        Operation::get("/api/v1/models/{id}/preview", "The files of an export.", files)
            .asks::<DownloadQuery>()
            .answers::<Preview>(),
        Operation::get("/api/v1/models/{id}/download", "Model file, report or export.", download)
            .asks::<DownloadQuery>()
            .answers_with("application/octet-stream"),
    ]
}

async fn all(State(shared): State<Arc<Shared>>) -> Answer<Json<Vec<ModelEntry>>> {
    compute(move || Ok(list(&shared.workspace))).await
}

async fn one(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<ModelDetail>> {
    compute(move || detail(&shared.workspace, &id)).await
}

async fn patch(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(patch): Input<ModelPatch>,
) -> Answer<Json<ModelEntry>> {
    compute(move || rename(&shared.workspace, &id, &patch.name)).await
}

async fn delete(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Trashed>> {
    compute(move || shared.workspace.discard(&id, Kind::Model)).await
}

async fn on_record(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Ask(query): Ask<ModelCurvesQuery>,
) -> Answer<Json<ModelCurves>> {
    compute(move || curves(&shared.workspace, &id, &query)).await
}

async fn on_records(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<ScoresRequest>,
) -> Answer<Json<Scored>> {
    compute(move || scores(&shared.workspace, &id, &request)).await
}

async fn sines(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Ask(query): Ask<ResponseQuery>,
) -> Answer<Json<Responses>> {
    compute(move || response(&shared.workspace, &id, &query.record)).await
}

async fn simulated(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<SimulateRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || simulate(&shared.workspace, &id, &request)).await
}

async fn decoupled(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<DecoupleRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || decouple(&shared.workspace, &id, &request)).await
}

async fn tracked_axes(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<TrackAxesRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || track_axes(&shared.workspace, &id, &request)).await
}

async fn next_drive(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    named: Named,
    Input(request): Input<DesignRequest>,
) -> Answer<Json<Outcome>> {
    let work =
        move |shared: &Shared, listener: Listener<'_>| design(&shared.workspace, &id, &request, listener);
    run_told(shared, named, work).await.map(Json)
}

async fn recalibrated(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<RecalibrateRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || recalibrate(&shared.workspace, &id, &request)).await
}

async fn adapted(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<AdaptRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || adapt(&shared.workspace, &id, &request)).await
}

async fn realised(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<RealiseRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || realise(&shared.workspace, &id, &request.options)).await
}

async fn files(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    named: Named,
    Ask(query): Ask<DownloadQuery>,
) -> Answer<Json<Preview>> {
    let work =
        move |shared: &Shared, listener: Listener<'_>| preview(&shared.workspace, &id, &query, listener);
    run_told(shared, named, work).await.map(Json)
}

async fn download(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    named: Named,
    Ask(query): Ask<DownloadQuery>,
) -> Answer<Response> {
    let (name, kind, bytes) = run_told(shared, named, move |shared, listener| {
        let workspace = &shared.workspace;
        Ok(match query.form {
            Form::Json => {
                let bytes = std::fs::read(workspace.existing(&id)?).map_err(Refused::failed)?;
                (format!("{}.json", stem_of(&id)), "application/json", bytes)
            }
            Form::Report => {
                (format!("{}.html", stem_of(&id)), "text/html; charset=utf-8", report(workspace, &id)?)
            }
            Form::C | Form::Rust | Form::Fmu | Form::Matlab | Form::Simulink => {
                let (name, bytes) = archive(workspace, &id, &query, listener)?;
                (name, "application/zip", bytes)
            }
        })
    })
    .await?;
    Ok(attached(&name, kind, bytes))
}
