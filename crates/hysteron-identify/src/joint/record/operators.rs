//! Cache of the hysteresis operators' outputs of a record, valid while only the dynamics change.

use std::sync::{Arc, Mutex, PoisonError};

use hysteron_model::dynamics::PlanInput;
use hysteron_model::hysteresis::Columns;

/// Outputs of the operators, and the inputs of the dynamics from them.
#[derive(Debug, Default)]
pub(super) struct Operators {
    pub(super) columns: Columns,
    /// s (H_j − H_j(rest)) as inputs of the dynamics.
    pub(super) inputs: Vec<PlanInput>,
    /// Shape and memory of both; `None`: empty.
    pub(super) of: Option<(Vec<f64>, f64)>,
    pub(super) derived: bool,
}

impl Operators {
    /// True if these are the outputs for a shape and memory, with derivatives where `wanted`.
    pub(super) fn are_of(&self, shape: &[f64], memory: f64, wanted: bool) -> bool {
        let same = |(of_shape, of_memory): &(Vec<f64>, f64)| of_shape == shape && *of_memory == memory;
        (self.derived || !wanted) && self.of.as_ref().is_some_and(same)
    }
}

/// Pool of operators of dropped workspaces: successive fits of a search have equal or similar memories, and
/// clearing new buffers takes longer than simulating plays.
pub(super) type Spare = Arc<Mutex<Vec<Operators>>>;

/// Operators of a workspace, returned to the pool on drop.
#[derive(Debug)]
pub(super) struct LentOperators {
    pub(super) operators: Operators,
    spare: Spare,
}

impl LentOperators {
    pub(super) fn new(spare: &Spare) -> Self {
        Self { operators: Operators::default(), spare: Arc::clone(spare) }
    }

    /// True if these operators, or pooled ones that then replace them, are for a shape and memory. Without
    /// buffers, any pooled ones are taken.
    pub(super) fn are_found(&mut self, shape: &[f64], memory: f64, wanted: bool) -> bool {
        if self.operators.are_of(shape, memory, wanted) {
            return true;
        }
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let same = spare.iter().position(|spare| spare.are_of(shape, memory, wanted));
        let any = || if self.operators.inputs.is_empty() { spare.len().checked_sub(1) } else { None };
        if let Some(taken) = same.or_else(any) {
            let stop = self.operators.columns.stop.take();
            std::mem::swap(&mut self.operators, &mut spare[taken]);
            self.operators.columns.stop = stop;
            spare.retain(|spare| !spare.inputs.is_empty());
        }
        same.is_some()
    }
}

impl Drop for LentOperators {
    fn drop(&mut self) {
        if !self.operators.inputs.is_empty() {
            let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
            spare.push(std::mem::take(&mut self.operators));
        }
    }
}
