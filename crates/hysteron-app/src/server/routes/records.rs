//! Records.

use std::sync::{Arc, PoisonError};

use axum::Json;
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::HeaderMap;
use axum::http::StatusCode;
use axum::http::header::CONTENT_LENGTH;
use axum::response::Response;
use serde_json::Value;

use crate::api::{
    Curve, CurveQuery, Outcome, PrepareRequest, ProspectsRequest, ProspectsTogether, RecordDetail,
    RecordEntry, RecordSettings, ResponseFitRequest, Trashed, UploadQuery,
};
use crate::draw::{Along, between, over, over_time};
use crate::notice::Change;
use crate::prepare::prepare;
use crate::refused::{Answer, Refused};
use crate::response::explain;
use crate::server::Shared;
use crate::server::answer::{Ask, Input, attached, compute, run};
use crate::server::arriving::Arriving;
use crate::server::operation::Operation;
use crate::workspace::{Kind, Workspace, too_large};
use hysteron_identify::recognised_roles;
use hysteron_identify::structure::prospects;

/// Bytes of an upload that are written at once.
const UPLOAD_PART: usize = 1 << 20;

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::get("/api/v1/records", "The records.", list).answers::<Vec<RecordEntry>>(),
        Operation::post("/api/v1/records", "Uploads a record: whole and readable, or not at all.", upload)
            .asks::<UploadQuery>()
            .takes_bytes()
            .with_status(201)
            .answers::<RecordEntry>(),
        Operation::get("/api/v1/records/{id}", "A record in full.", one).answers::<RecordDetail>(),
        Operation::patch(
            "/api/v1/records/{id}",
            "Changes what is said of a record (JSON merge patch of its settings).",
            settings,
        )
        .takes::<RecordSettings>()
        .answers::<RecordEntry>(),
        Operation::delete("/api/v1/records/{id}", "Moves a record to the trash folder.", delete)
            .answers::<Trashed>(),
        Operation::get("/api/v1/records/{id}/file", "The file of a record.", file)
            .answers_with("application/octet-stream"),
        Operation::get("/api/v1/records/{id}/curve", "A curve of a record, as a drawing shows it.", curve)
            .asks::<CurveQuery>()
            .answers::<Curve>(),
        Operation::post("/api/v1/prepare", "Records cut, joined, scaled, resampled to a new one.", prepared)
            .takes::<PrepareRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/frequency-response", "Structures fitted to a response.", explained)
            .takes::<ResponseFitRequest>()
            .answers::<Outcome>(),
        Operation::post("/api/v1/prospects", "What records determine together.", together)
            .takes::<ProspectsRequest>()
            .answers::<ProspectsTogether>(),
    ]
}

async fn list(State(shared): State<Arc<Shared>>) -> Answer<Json<Vec<RecordEntry>>> {
    let workspace = Arc::clone(&shared.workspace);
    let (entries, unread) = run(move || workspace.records()).await?;
    read_beside(shared, unread);
    Ok(Json(entries))
}

/// Reads and inspects records beside the answer; the pages are told of each.
fn read_beside(shared: Arc<Shared>, unread: Vec<String>) {
    let fresh: Vec<String> = {
        let mut reading = shared.reading.lock().unwrap_or_else(PoisonError::into_inner);
        unread.into_iter().filter(|id| reading.insert(id.clone())).collect()
    };
    if fresh.is_empty() {
        return;
    }
    tokio::task::spawn_blocking(move || {
        for id in fresh {
            // A file that breaks its reader must not keep the others from being read.
            let read = std::panic::AssertUnwindSafe(|| shared.workspace.entry(&id).map(drop));
            let _ = std::panic::catch_unwind(read);
            shared.reading.lock().unwrap_or_else(PoisonError::into_inner).remove(&id);
            shared.workspace.notices.changed(Change::Records);
        }
    });
}

async fn upload(
    State(shared): State<Arc<Shared>>,
    Ask(query): Ask<UploadQuery>,
    headers: HeaderMap,
    body: Body,
) -> Answer<(StatusCode, Json<RecordEntry>)> {
    let most = shared.workspace.max_upload_bytes;
    let length = headers.get(CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > most) {
        return Err(too_large(most));
    }
    let mut upload = shared.workspace.begin_upload(&query.name, query.replace == 1)?;
    // A slow disk must not keep the server's only thread from its other requests.
    let mut arrived = Vec::new();
    let mut body = Arriving::new(body);
    while body.next(&mut arrived).await? {
        if arrived.len() >= UPLOAD_PART || arrived.len() as u64 > most {
            let written = run(move || {
                upload.write(&arrived)?;
                arrived.clear();
                Ok((upload, arrived))
            });
            (upload, arrived) = match written.await {
                Ok(written) => written,
                Err(refused) => {
                    body.discard().await;
                    return Err(refused);
                }
            };
        }
    }
    let workspace = Arc::clone(&shared.workspace);
    let ended = run(move || {
        upload.write(&arrived)?;
        workspace.end_upload(upload)
    });
    let entry = ended.await?;
    if entry.reading {
        read_beside(shared, vec![entry.id.clone()]);
    }
    Ok((StatusCode::CREATED, Json(entry)))
}

async fn one(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<RecordDetail>> {
    compute(move || shared.workspace.detail(&id)).await
}

async fn file(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Response> {
    let name = id.rsplit('/').next().unwrap_or_default().to_owned();
    let bytes = run(move || {
        shared.workspace.found_record(&id)?;
        std::fs::read(shared.workspace.path(&id)?).map_err(Refused::failed)
    });
    Ok(attached(&name, "application/octet-stream", bytes.await?))
}

async fn settings(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(patch): Input<Value>,
) -> Answer<Json<RecordEntry>> {
    compute(move || {
        let workspace = &shared.workspace;
        workspace.existing(&id)?;
        let Value::Object(patch) = patch else { return Err(Refused::bad("the patch must be an object")) };
        workspace.history.change_settings(&id, |before| {
            let mut merged = serde_json::to_value(before).map_err(Refused::failed)?;
            for (key, value) in patch {
                match value {
                    // A field that is taken away has its default again.
                    Value::Null => {
                        merged.as_object_mut().and_then(|settings| settings.remove(&key));
                    }
                    value => merged[key] = value,
                }
            }
            let settings: RecordSettings = serde_json::from_value(merged).map_err(Refused::bad)?;
            check(workspace, &id, &settings)?;
            Ok(settings)
        })?;
        workspace.notices.changed(Change::Records);
        workspace.entry(&id)
    })
    .await
}

/// Refuses settings that cannot hold for any file.
fn check(workspace: &Workspace, id: &str, settings: &RecordSettings) -> Answer<()> {
    if let Some(before) = &settings.continues {
        if before == id {
            return Err(Refused::bad("a record does not continue itself"));
        }
        workspace.existing(before)?;
    }
    let is_finite = |x: &f64| x.is_finite();
    let ends = settings.masks.iter().flatten().chain(&settings.from_s).chain(&settings.to_s);
    if !ends.chain(&settings.sample_rate_hz).all(is_finite) || settings.masks.iter().any(|[a, b]| a > b) {
        return Err(Refused::bad("masks and cuts run from an earlier to a later time"));
    }
    if settings.sample_rate_hz.is_some_and(|rate| rate <= 0.0) {
        return Err(Refused::bad("the sample rate must be positive"));
    }
    settings.band().map_err(Refused::bad)?;
    for scale in &settings.scales {
        scale.parse::<hysteron_model::record::Scale>().map_err(Refused::bad)?;
    }
    Ok(())
}

async fn delete(State(shared): State<Arc<Shared>>, Path(id): Path<String>) -> Answer<Json<Trashed>> {
    compute(move || shared.workspace.discard(&id, Kind::Record)).await
}

async fn curve(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Ask(query): Ask<CurveQuery>,
) -> Answer<Json<Curve>> {
    compute(move || drawn(&shared.workspace, &id, &query)).await
}

fn drawn(workspace: &Workspace, id: &str, query: &CurveQuery) -> Answer<Curve> {
    let read = workspace.read(id)?;
    let record = &read.record;
    let part = between(&record.time, record.len(), query.from, query.to);
    let data = read.data.as_ref().ok();
    // Input and output in the units that a fit works in; other columns in their own.
    let along = |name: &str| -> Answer<Along<'_>> {
        if let Some(data) = data {
            if name == data.input {
                return Ok(Along::new(&data.input, &data.u_unit, &data.u));
            }
            if name == data.output {
                return Ok(Along::new(&data.output, &data.y_unit, &data.y));
            }
        }
        let named = |c: &&hysteron_model::record::Channel| c.name == name || c.header() == name;
        let channel = record.channels.iter().find(named);
        let channel =
            channel.ok_or_else(|| Refused::missing(format!("the record has no column `{name}`")))?;
        Ok(Along::new(&channel.name, &channel.unit, &channel.samples))
    };
    let output = match (&query.y, data) {
        (Some(name), _) => name.clone(),
        (None, Some(data)) => data.output.clone(),
        (None, None) => return Err(Refused::bad("name the column to draw")),
    };
    let y = along(&output)?;
    if query.x == "t" {
        return Ok(over_time(&record.time, &y, part, query.pixels));
    }
    let x = along(&query.x)?;
    let periods = read.periods();
    Ok(over(&x, &y, part, query.pixels, periods))
}

async fn prepared(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<PrepareRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || prepare(&shared.workspace, &request)).await
}

async fn explained(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<ResponseFitRequest>,
) -> Answer<Json<Outcome>> {
    compute(move || explain(&shared.workspace, &request)).await
}

async fn together(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<ProspectsRequest>,
) -> Answer<Json<ProspectsTogether>> {
    compute(move || {
        if request.records.is_empty() {
            return Err(Refused::bad("no record is given"));
        }
        let read = |id: &String| Ok(shared.workspace.read(id)?.data()?.clone());
        let records = request.records.iter().map(read).collect::<Answer<Vec<_>>>()?;
        Ok(ProspectsTogether {
            prospects: prospects(&records),
            roles: recognised_roles(&records),
            command: shared.workspace.inspect_command(&request.records)?,
        })
    })
    .await
}
