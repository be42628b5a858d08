//! The simulated bench, and drives for a real one.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;

use crate::api::{BenchMade, BenchRequest, DriveMade, DriveRequest};
use crate::bench::{make_drive, measure};
use crate::refused::Answer;
use crate::server::Shared;
use crate::server::answer::{Input, compute};
use crate::server::operation::Operation;

pub(in crate::server) fn operations() -> Vec<Operation> {
    vec![
        Operation::post("/api/v1/bench", "Measures on the simulated bench.", bench)
            .takes::<BenchRequest>()
            .answers::<BenchMade>(),
        Operation::post("/api/v1/drives", "Makes a drive, and writes it where asked.", drive)
            .takes::<DriveRequest>()
            .answers::<DriveMade>(),
    ]
}

async fn bench(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<BenchRequest>,
) -> Answer<Json<BenchMade>> {
    compute(move || measure(&shared.workspace, &request)).await
}

async fn drive(
    State(shared): State<Arc<Shared>>,
    Input(request): Input<DriveRequest>,
) -> Answer<Json<DriveMade>> {
    compute(move || make_drive(&shared.workspace, &request)).await
}
