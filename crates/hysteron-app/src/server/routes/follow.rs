//! Following a reference.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use hysteron_identify::Listener;

use crate::api::{FollowRequest, Followed, TrackRequest, Tracked};
use crate::models;
use crate::refused::Answer;
use crate::server::Shared;
use crate::server::answer::Input;
use crate::server::operation::Operation;
use crate::server::told::{Named, run_told};

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::post("/api/v1/models/{id}/follow", "The drive for a reference.", follow)
            .takes::<FollowRequest>()
            .answers::<Followed>(),
        Operation::post("/api/v1/models/{id}/track", "Controllers on a simulated plant.", track)
            .takes::<TrackRequest>()
            .answers::<Tracked>(),
    ]
}

async fn follow(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    named: Named,
    Input(request): Input<FollowRequest>,
) -> Answer<Json<Followed>> {
    let work = move |shared: &Shared, listener: Listener<'_>| {
        models::follow(&shared.workspace, &id, &request, listener)
    };
    run_told(shared, named, work).await.map(Json)
}

async fn track(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    named: Named,
    Input(request): Input<TrackRequest>,
) -> Answer<Json<Tracked>> {
    let work = move |shared: &Shared, listener: Listener<'_>| {
        models::track(&shared.workspace, &id, &request, listener)
    };
    run_told(shared, named, work).await.map(Json)
}
