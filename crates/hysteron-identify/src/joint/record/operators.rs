//! Outputs of the hysteresis operators of a record as inputs of the dynamics, kept while only the dynamics
//! change; of another memory, only what depends on it is computed anew.

use std::sync::{Arc, Mutex, PoisonError};

use hysteron_model::dynamics::PlanInput;
use hysteron_model::hysteresis::{Columns, DriveGrid, HysteresisForm};
use rayon::prelude::*;

use super::super::drive::Thinning;
use super::super::reduction::Reduction;
use super::{Candidate, Derivatives, InputsAndOutput, JointRecord, Lane, RecordWorkspace, is_stopped};

/// Outputs of the operators, and the inputs of the dynamics from them.
#[derive(Debug, Default)]
pub(super) struct Operators {
    pub(super) columns: Columns,
    /// H_j at the rate of a reduced record; empty where the record is not reduced.
    pub(super) reduced: Vec<Vec<f64>>,
    /// s (H_j − H_j(rest)) as inputs of the dynamics, and which of them are those of the columns.
    pub(super) inputs: Vec<PlanInput>,
    pub(super) prepared: Vec<bool>,
    /// Shape and memory of the columns; `None`: empty.
    pub(super) of: Option<(Vec<f64>, f64)>,
    pub(super) derived: bool,
}

impl Operators {
    /// True without buffers.
    fn is_empty(&self) -> bool {
        self.columns.values.is_empty()
    }

    /// False where the outputs were handed to another problem; what was made of them remains.
    fn have_outputs(&self) -> bool {
        self.columns.values.iter().any(|values| !values.is_empty())
    }

    /// The outputs, for a record at another rate; what this one made of them remains.
    fn hand_over(&mut self) -> Self {
        let count = self.columns.values.len();
        let values = std::mem::replace(&mut self.columns.values, vec![Vec::new(); count]);
        let mut columns = self.columns.clone();
        columns.values = values;
        let (of, derived) = (self.of.clone(), self.derived);
        Self { columns, prepared: vec![false; count], of, derived, ..Self::default() }
    }

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
        let any = || if self.operators.is_empty() { spare.len().checked_sub(1) } else { None };
        if let Some(taken) = same.or_else(any) {
            let stop = self.operators.columns.stop.take();
            std::mem::swap(&mut self.operators, &mut spare[taken]);
            self.operators.columns.stop = stop;
            spare.retain(|spare| !spare.is_empty());
        }
        same.is_some()
    }

    /// Returns the operators to the pool.
    pub(super) fn give_back(&mut self) {
        if !self.operators.is_empty() {
            let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
            spare.push(std::mem::take(&mut self.operators));
        }
    }
}

impl Drop for LentOperators {
    fn drop(&mut self) {
        self.give_back();
    }
}

impl JointRecord {
    /// Hands pooled outputs of the operators to the same record at its own rate, where the drive is the same: running
    /// them again would take as much time, and as much memory once more.
    pub(in super::super) fn hand_outputs_to(&self, whole: &Self) {
        let is_same = self.drive == whole.drive && self.grid == whole.grid && self.paces == whole.paces;
        if !is_same || self.reduction.is_none() || whole.reduction.is_some() {
            return;
        }
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(latest) = spare.iter_mut().rfind(|spare| spare.of.is_some() && spare.have_outputs()) {
            let handed = latest.hand_over();
            whole.spare.lock().unwrap_or_else(PoisonError::into_inner).push(handed);
        }
    }

    /// Frees the pooled operators.
    pub(in super::super) fn free_operators(&self) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Input of the dynamics: `scale` times the output `x` of an operator less its value `before` the first
    /// sample.
    pub(super) fn prepare_input(&self, x: &[f64], before: f64, scale: f64, lane: &mut Lane) -> bool {
        let Lane { plan, prepared, own, input, .. } = lane;
        match (&self.reduction, self.thinning) {
            (None, Thinning::Pick(_)) => input.copy_from_slice(x),
            (None, Thinning::Means) => self.thinning.apply(x, input),
            (Some(reduction), _) => self.reduce(&reduction.inputs, (x, before), x.len(), own, input),
        }
        input.iter_mut().for_each(|x| *x = scale * (*x - before));
        self.plan.prepare_into(input, plan, prepared).is_ok()
    }

    /// The output `x` of an operator, `before` ahead of its first sample, at the rate of the reduced record:
    /// the part of `reduced` that depends on the first `changed` samples.
    fn reduce(
        &self,
        reduction: &Reduction,
        (x, before): (&[f64], f64),
        changed: usize,
        own: &mut [f64],
        reduced: &mut [f64],
    ) {
        let Thinning::Means = self.thinning else {
            let (rows, samples) = reduction.beginning(changed);
            return reduction.input(&x[..samples], before, &mut reduced[..rows]);
        };
        // A mean depends on the samples next to it.
        let (rows, samples) = reduction.beginning(self.thinning.samples(changed) + 1);
        let own = &mut own[..samples];
        self.thinning.apply(&x[..x.len().min(2 * samples + 1)], own);
        reduction.input(own, before, &mut reduced[..rows]);
    }

    /// Simulates the hysteresis. `false` where the candidate cannot be simulated.
    pub(super) fn operate(
        &self,
        form: HysteresisForm,
        (shape, memory): (&[f64], f64),
        derivatives: Derivatives<'_>,
        lent: &mut LentOperators,
        lanes: &mut [Lane],
    ) -> bool {
        let wanted = derivatives.is_some();
        if lent.are_found(shape, memory, wanted) {
            return true;
        }
        let is_again = lent.operators.of.take().is_some() && lent.operators.have_outputs();
        let Operators { columns, reduced, prepared, of, derived, .. } = &mut lent.operators;
        let run = if is_again { HysteresisForm::run_again } else { HysteresisForm::run };
        let grid = DriveGrid { paces: self.paces.as_deref(), ..self.grid };
        if run(form, shape, grid, &self.drive, self.origin(memory), derivatives, columns).is_err() {
            return false;
        }
        let count = columns.values.len();
        prepared.resize(count, false);
        prepared.iter_mut().zip(&columns.changed).for_each(|(prepared, changed)| *prepared &= *changed == 0);
        let mut done = true;
        if let Some(InputsAndOutput { inputs: reduction, .. }) = &self.reduction {
            // Filled one by one: allocating dozens at once would delay a stop.
            reduced.resize_with(count, Vec::new);
            let share = count.div_ceil(lanes.len().max(1)).max(1);
            let (values, rests, changed) = (&columns.values, &columns.rest, &columns.changed);
            done = reduced
                .par_chunks_mut(share)
                .zip(values.par_chunks(share).zip(rests.par_chunks(share)).zip(changed.par_chunks(share)))
                .zip(lanes)
                .map(|((reduced, ((values, rests), changed)), lane)| {
                    let of_columns = values.iter().zip(rests).zip(changed);
                    for (reduced, ((values, rest), &changed)) in reduced.iter_mut().zip(of_columns) {
                        if changed > 0 && !is_stopped(columns) {
                            reduced.resize(reduction.rows(), 0.0);
                            self.reduce(reduction, (values, *rest), changed, &mut lane.own, reduced);
                        }
                    }
                    !is_stopped(columns)
                })
                .reduce(|| true, |a, b| a & b);
        }
        if done {
            (*of, *derived) = (Some((shape.to_vec(), memory)), wanted);
        }
        done
    }

    /// True if the outputs of the operators, with derivatives, are those of a candidate, as inputs of the
    /// dynamics too; some that are not in use are taken.
    pub(in super::super) fn has_operators(
        &self,
        form: HysteresisForm,
        candidate: &Candidate,
        memory: f64,
        ws: &mut RecordWorkspace,
    ) -> bool {
        ws.hysteresis.are_found(&candidate.shape, memory, true)
            && self.transform(form.sign(), &mut ws.hysteresis.operators, &mut ws.lanes)
    }

    /// Transforms the outputs of the operators that are not yet; `false` where they are not finite.
    pub(super) fn transform(&self, sign: f64, operators: &mut Operators, lanes: &mut [Lane]) -> bool {
        let Operators { columns, reduced, inputs, prepared, .. } = operators;
        if prepared.iter().all(|prepared| *prepared) {
            return true;
        }
        inputs.resize_with(columns.values.len(), PlanInput::none);
        let share = inputs.len().div_ceil(lanes.len().max(1)).max(1);
        let (columns, reduced) = (&*columns, &*reduced);
        inputs
            .par_chunks_mut(share)
            .zip(prepared.par_chunks_mut(share))
            .zip(lanes)
            .enumerate()
            .map(|(at, ((inputs, prepared), lane))| {
                let stale = inputs.iter_mut().zip(prepared).zip(at * share..);
                for ((input, prepared), index) in stale.filter(|((_, prepared), _)| !**prepared) {
                    let rest = columns.rest[index];
                    *prepared = !is_stopped(columns)
                        && match reduced.get(index) {
                            Some(reduced) => self.prepare_sum([(sign, &reduced[..], rest)], lane),
                            None => self.prepare_input(&columns.values[index], rest, sign, lane),
                        };
                    if !*prepared {
                        return false;
                    }
                    std::mem::swap(&mut lane.prepared, input);
                }
                true
            })
            .reduce(|| true, |a, b| a & b)
    }

    /// Input from the weighted sum of `parts` (weight, input of the dynamics, its value before the first
    /// sample).
    pub(super) fn prepare_sum<'a>(
        &self,
        parts: impl IntoIterator<Item = (f64, &'a [f64], f64)>,
        lane: &mut Lane,
    ) -> bool {
        let Lane { plan, prepared, input, .. } = lane;
        let mut parts = parts.into_iter().filter(|(weight, ..)| *weight != 0.0);
        match parts.next() {
            Some((weight, x, before)) => {
                input.iter_mut().zip(x).for_each(|(sum, x)| *sum = weight * (x - before));
            }
            None => input.fill(0.0),
        }
        for (weight, x, before) in parts {
            input.iter_mut().zip(x).for_each(|(sum, x)| *sum += weight * (x - before));
        }
        self.plan.prepare_into(input, plan, prepared).is_ok()
    }
}
