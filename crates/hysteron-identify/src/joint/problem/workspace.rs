//! Scratch of an evaluation, kept by its problem between fits.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use hysteron_model::dynamics::Linearised;
use hysteron_optimize::{LeastSquaresProblem, Stop};

use super::super::super::projection::Projection;
use super::super::record::{JointRecord, RecordWorkspace};
use super::JointProblem;

/// Workspaces that are not in use, of all problems on the same records: a fit often begins where another one
/// ended, and clearing new buffers takes as long as an evaluation.
pub(in super::super) type SpareWorkspaces = Arc<Mutex<Vec<JointWorkspace>>>;

/// Scratch of one evaluation.
#[derive(Debug, Default)]
pub(in super::super::super) struct JointWorkspace {
    pub(super) records: Vec<RecordWorkspace>,
    pub(super) dynamics: Linearised,
    pub(super) column: Vec<f64>,
    pub(super) target: Vec<f64>,
    pub(super) projection: Projection,
    /// Columns of the sign-constrained weights times their signs, orthogonal to those of the projection, and
    /// the absolute weights.
    pub(super) signed: Vec<f64>,
    pub(super) absolute: Vec<f64>,
    /// Coefficients that are eliminated: those of the columns of `projection`, then positive weights.
    pub(super) eliminated: Vec<usize>,
    /// Coefficients of u, u², … and weights; empty: not yet computed.
    pub(super) coefficients: Vec<f64>,
    /// Point of the columns, sensitivities and residual in this workspace; empty: none.
    pub(super) at: Vec<f64>,
    /// Identity of the problem that it was last of, if any, and its number of parameters of the dynamics.
    of: Option<String>,
    parameters: usize,
    /// Where it goes when it is dropped.
    home: Weak<Mutex<Vec<JointWorkspace>>>,
}

impl JointWorkspace {
    pub(super) fn of(problem: &JointProblem) -> Self {
        if problem.stop.is_requested() {
            // Nothing is evaluated then, and clearing the buffers of long records takes time.
            return Self::default();
        }
        let spare = problem.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut workspace = spare.unwrap_or_default();
        if workspace.of.as_ref() != Some(&problem.identity) {
            workspace.become_that_of(problem);
        }
        workspace
    }

    /// Makes it one of `problem`: new, or of another one on the same records.
    fn become_that_of(&mut self, problem: &JointProblem) {
        let (degree, weights) = (problem.degree(), problem.layout.weights.len());
        let (parameters, count) = (problem.layout.form.len(), problem.residual_count());
        if self.records.is_empty() {
            self.records = problem.records.iter().map(|record| record.workspace(parameters)).collect();
        } else if self.parameters != parameters {
            let records = problem.records.iter().zip(&mut self.records);
            records.for_each(|(record, ws)| record.take_parameters(parameters, ws));
        }
        let records = problem.records.iter().zip(&mut self.records);
        records.for_each(|(record, ws)| record.take_columns(degree + weights, ws));
        self.column.resize(count, 0.0);
        self.target.resize(count, 0.0);
        self.projection.empty(count, degree + weights);
        self.at.clear();
        self.coefficients.clear();
        (self.of, self.parameters) = (Some(problem.identity.clone()), parameters);
        self.home = Arc::downgrade(&problem.spare);
    }

    /// Sets the stop signal that ends an evaluation early.
    pub(super) fn set_stop(&mut self, stop: &Stop) {
        self.records.iter_mut().for_each(|record| record.set_stop(stop));
    }
}

impl Drop for JointWorkspace {
    fn drop(&mut self) {
        if let Some(home) = self.home.upgrade() {
            let mut workspace = std::mem::take(self);
            workspace.records.iter_mut().for_each(RecordWorkspace::return_operators);
            home.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
        }
    }
}

impl JointProblem {
    /// Frees the scratch that is not in use: of a long record a large part of all memory.
    pub(in super::super) fn free_scratch(&self) {
        let mut spare = std::mem::take(&mut *self.spare.lock().unwrap_or_else(PoisonError::into_inner));
        spare.iter_mut().for_each(|workspace| workspace.home = Weak::new());
        self.records.iter().for_each(JointRecord::free_operators);
    }

    /// Hands the outputs of the operators that are not in use to the problem on all samples of the same records.
    pub(in super::super) fn hand_outputs_to(&self, whole: &Self) {
        self.records.iter().zip(whole.records.iter()).for_each(|(own, whole)| own.hand_outputs_to(whole));
    }

    /// True if columns, sensitivities and residual in the workspace are those at `x`.
    pub(super) fn is_at(&self, x: &[f64], ws: &mut JointWorkspace) -> bool {
        if x.is_empty() || ws.at != x {
            return false;
        }
        let Some(candidate) = self.candidate(x) else { return false };
        ws.set_stop(&self.stop);
        let records = self.records.iter().zip(&mut ws.records).zip(&candidate.memory);
        records.fold(true, |all, ((record, ws), &memory)| {
            record.has_operators(self.hysteresis, &candidate, memory, ws) && all
        })
    }
}
