//! Following a reference.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};

use crate::api::{FollowRequest, Followed, TrackRequest, Tracked};
use crate::models;
use crate::refused::Answer;
use crate::server::Shared;
use crate::server::answer::{Input, compute};
use crate::server::operation::Operation;

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
    Input(request): Input<FollowRequest>,
) -> Answer<Json<Followed>> {
    compute(move || models::follow(&shared.workspace, &id, &request)).await
}

async fn track(
    State(shared): State<Arc<Shared>>,
    Path(id): Path<String>,
    Input(request): Input<TrackRequest>,
) -> Answer<Json<Tracked>> {
    compute(move || models::track(&shared.workspace, &id, &request)).await
}
