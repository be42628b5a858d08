//! Runs of a force against a displacement.

use super::{Body, Model, RunError, Simulation};
use crate::force::{ForceModel, Motion};
use crate::hammerstein::SimulationError;
use crate::model_file::ForceFile;
use crate::record::InputOutput;
use crate::start::Start;
use crate::validate::Scoring;

impl Model {
    /// From rest at the first sample, or settled on the whole record.
    pub(super) fn explain_force(
        &self,
        body: &Body<ForceFile, ForceModel>,
        record: &InputOutput,
        scoring: &Scoring,
    ) -> Result<Simulation, RunError> {
        let mut run = self.prepared(record)?;
        run.remark_range(self, record);
        let rest = Start::AsIdentified;
        run.explained(record, scoring, (rest, rest), |start| force(body, record, start))
    }
}

/// The force over a record.
pub(super) fn force(
    body: &Body<ForceFile, ForceModel>,
    record: &InputOutput,
    start: Start,
) -> Result<Vec<f64>, RunError> {
    let motion = Motion { x: &record.u, rate: record.rate.as_deref(), time: &record.time };
    let simulated = body.law.simulate(&motion, start).map_err(SimulationError::from)?;
    Ok(simulated)
}
