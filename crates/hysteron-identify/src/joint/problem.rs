//! The joint fit of all records and both blocks as a least-squares problem by variable projection.
//!
//! The search is over the shape numbers of the hysteresis (β', γ', n), the parameters of the dynamics, the
//! delay and the unknown memory of each record; offset, drift and transients of each record, the coefficients
//! of l\[u\] and the weights of the hysteresis (α) are eliminated by linear least squares at every candidate
//! (Golub, Pereyra 1973, doi:10.1137/0710036); sign-constrained weights by non-negative least squares, where
//! active constraints hold weights at 0. With Φ(θ) the columns, c the eliminated coefficients and P⊥ the
//! projector onto their orthogonal complement, the residual is r = P⊥ y and the Jacobian −P⊥ (∂Φ/∂θ) c:
//! Kaufman's form (doi:10.1007/BF01932995). It omits a term in the span of the columns, to which r is
//! orthogonal, so that the gradient Jᵀr is exact.

mod elimination;
mod held_memory;
mod linearise;
mod workspace;

pub(in super::super) use linearise::Linearisation;
pub(in super::super) use workspace::JointWorkspace;

use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

use super::super::layout::Role;
use super::parameter_layout::{JointLayout, JointSolution};
use super::record::{Candidate, Derivatives, Direction, JointRecord, RecordWorkspace};
use hysteron_model::dynamics::{DynamicForm, Linearised};
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_numeric::dot;
use hysteron_optimize::{
    Bounds, Derivative, Eliminated, LeastSquaresProblem, Problem, Range, Stop, root_mean_square,
};
pub(super) use workspace::SpareWorkspaces;

/// Meaning of one searched number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SearchedNumber {
    /// A number that affects every record.
    Everywhere(Direction),
    /// The memory of one record.
    Memory(usize),
}

/// A joint fit as a problem for [`hysteron_optimize`].
#[derive(Debug)]
pub(in super::super) struct JointProblem {
    records: Arc<[JointRecord]>,
    /// Index of the first residual of each record, and the number of residuals.
    at: Vec<usize>,
    hysteresis: HysteresisForm,
    form: DynamicForm,
    layout: JointLayout,
    searched: Vec<SearchedNumber>,
    /// Shape numbers that are searched.
    shaped: Vec<bool>,
    bounds: Bounds,
    identity: String,
    /// Normalisation frequency of the dynamics \[Hz\].
    normalisation_hz: f64,
    /// Fits hold the memory of every record at that of their start.
    memory_is_kept: bool,
    stop: Stop,
    best: Mutex<Option<Evaluated>>,
    spare: SpareWorkspaces,
}

/// The best point so far, for work that is stopped: an evaluation may take seconds.
#[derive(Clone, Debug)]
struct Evaluated {
    x: Vec<f64>,
    cost: f64,
    residuals: Vec<f64>,
    /// Coefficients of u, u², … and weights.
    coefficients: Vec<f64>,
}

impl JointProblem {
    pub(in super::super) fn new(
        records: Arc<[JointRecord]>,
        (hysteresis, form): (HysteresisForm, DynamicForm),
        layout: JointLayout,
        bounds: Bounds,
        identity: String,
    ) -> Self {
        let mut at = vec![0];
        at.extend(records.iter().scan(0, |sum, record| {
            *sum += record.samples();
            Some(*sum)
        }));
        let mut searched = vec![SearchedNumber::Everywhere(Direction::Column(0)); bounds.dimension()];
        let mut place = |role: Role, what: SearchedNumber| {
            if let Role::Searched(index) = role {
                searched[index] = what;
            }
        };
        for (index, role) in layout.linear().enumerate() {
            place(*role, SearchedNumber::Everywhere(Direction::Column(index)));
        }
        for (index, role) in layout.shape.iter().enumerate() {
            place(*role, SearchedNumber::Everywhere(Direction::Shape(index)));
        }
        for (index, role) in layout.form.iter().chain([&layout.delay]).enumerate() {
            place(*role, SearchedNumber::Everywhere(Direction::Dynamics(index)));
        }
        for (record, role) in layout.memory.iter().enumerate() {
            place(*role, SearchedNumber::Memory(record));
        }
        let shaped = layout.shape.iter().map(|role| matches!(role, Role::Searched(_))).collect();
        let (normalisation_hz, stop) = (1.0, Stop::new());
        let (best, spare) = (Mutex::default(), SpareWorkspaces::default());
        Self {
            records,
            at,
            hysteresis,
            form,
            layout,
            searched,
            shaped,
            bounds,
            identity,
            normalisation_hz,
            memory_is_kept: false,
            stop,
            best,
            spare,
        }
    }

    /// This problem with `normalisation_hz` as the normalisation frequency of the dynamics \[Hz\].
    pub(super) fn normalised_at(self, normalisation_hz: f64) -> Self {
        Self { normalisation_hz, ..self }
    }

    /// This problem with the workspaces of others on the same records.
    pub(super) fn sharing(self, spare: &SpareWorkspaces) -> Self {
        Self { spare: Arc::clone(spare), ..self }
    }

    /// This problem for fits that hold the memory of every record at that of their start where this spares
    /// rerunning the operators, which costs more than the rest of an evaluation of few samples; or for fits
    /// with all numbers free.
    pub(super) fn keeping_memory(self, memory_is_kept: bool) -> Self {
        Self { memory_is_kept, ..self }
    }

    /// Whether fits hold the memory.
    pub(super) fn keeps_memory(&self) -> bool {
        self.memory_is_kept
    }

    /// This problem with `stop` as its stop signal, which ends an evaluation early.
    pub(super) fn stopped_by(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// The best point evaluated so far.
    pub(super) fn best(&self) -> Option<Vec<f64>> {
        self.best.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(|best| best.x.clone())
    }

    /// The best evaluation so far, if it is at `x` and a stop is requested.
    fn known(&self, x: &[f64]) -> Option<Evaluated> {
        if self.stop.is_requested() { self.best_at(x) } else { None }
    }

    /// Weighted residuals at `x`; those of the best point so far are reused. `None` where it cannot be
    /// simulated.
    pub(super) fn residuals_of(&self, x: &[f64]) -> Option<Vec<f64>> {
        if let Some(best) = self.best_at(x) {
            return Some(best.residuals);
        }
        let mut residuals = vec![0.0; self.residual_count()];
        self.residuals(x, &mut self.workspace(), &mut residuals).then_some(residuals)
    }

    /// The best evaluation so far, if it is at `x`.
    fn best_at(&self, x: &[f64]) -> Option<Evaluated> {
        let best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
        // Scaling to the optimiser's unit box rounds a point.
        best.as_ref().filter(|best| self.are_near(&best.x, x, 1e-12)).cloned()
    }

    /// True if two points are no farther apart than this share of any range.
    pub(super) fn are_near(&self, a: &[f64], b: &[f64], share: f64) -> bool {
        let apart = |(range, (a, b)): (&Range, (&f64, &f64))| range.to_unit(*a) - range.to_unit(*b);
        self.bounds.ranges.iter().zip(a.iter().zip(b)).map(apart).all(|by| by.abs() <= share)
    }

    /// Keeps the evaluated point if it is the best so far; returns its cost.
    fn keep(&self, x: &[f64], ws: &mut JointWorkspace) -> f64 {
        let cost = root_mean_square(&ws.target);
        let is_best = |best: &Option<Evaluated>| best.as_ref().is_none_or(|best| cost < best.cost);
        if cost.is_finite() && is_best(&self.best.lock().unwrap_or_else(PoisonError::into_inner)) {
            let coefficients = self.coefficients(x, ws);
            let point = Evaluated { x: x.to_vec(), cost, residuals: ws.target.clone(), coefficients };
            let mut best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
            if is_best(&best) {
                *best = Some(point);
            }
        }
        cost
    }

    /// [`Self::eliminate`] for a search; abandoned on a stop.
    fn evaluate(&self, x: &[f64], derivatives: Derivatives<'_>, ws: &mut JointWorkspace) -> bool {
        ws.set_stop(&self.stop);
        self.eliminate(x, derivatives, ws)
    }

    pub(in super::super) fn layout(&self) -> &JointLayout {
        &self.layout
    }

    /// The family of the hysteresis.
    pub(in super::super) fn hysteresis(&self) -> HysteresisForm {
        self.hysteresis
    }

    /// True if shape numbers of the hysteresis are searched, so that its operators must be rerun.
    pub(super) fn searches_shape(&self) -> bool {
        self.shaped.contains(&true)
    }

    /// The family of the dynamics.
    pub(super) fn form(&self) -> DynamicForm {
        self.form
    }

    /// Normalisation frequency of the dynamics \[Hz\].
    pub(super) fn normalisation_hz(&self) -> f64 {
        self.normalisation_hz
    }

    pub(in super::super) fn records(&self) -> &[JointRecord] {
        &self.records
    }

    /// Residuals that belong to record `index`.
    pub(in super::super) fn rows(&self, index: usize) -> std::ops::Range<usize> {
        self.at[index]..self.at[index + 1]
    }

    /// Residuals with weight.
    pub(in super::super) fn valid(&self) -> usize {
        self.records.iter().map(|record| record.valid).sum()
    }

    pub(in super::super) fn degree(&self) -> usize {
        self.layout.polynomial.len()
    }

    pub(in super::super) fn candidate(&self, x: &[f64]) -> Option<Candidate> {
        let l = &self.layout;
        let shape = l.shape.iter().map(|role| role.value(x)).collect::<Option<_>>()?;
        let memory = l.memory.iter().map(|role| role.value(x)).collect::<Option<_>>()?;
        Some(Candidate { shape, delay_s: l.delay.value(x)?, memory })
    }

    fn form_values(&self, x: &[f64]) -> Option<Vec<f64>> {
        self.layout.form.iter().map(|role| role.value(x)).collect()
    }

    /// Candidate `x` with its modes in order ([`DynamicForm::in_order`]), if within the search box. Where `x`
    /// is the best point so far (the only one available after a stop), that is reordered too.
    pub(super) fn in_order(&self, x: Vec<f64>) -> Vec<f64> {
        let Some(values) = self.form_values(&x) else { return x };
        let ordered = self.form.in_order(&values);
        let moves: Option<Vec<(usize, f64)>> = self
            .layout
            .form
            .iter()
            .zip(values.iter().zip(ordered))
            .filter(|(_, (before, after))| *before != after)
            .map(|(role, (_, after))| {
                let index = role.index()?;
                let range = &self.bounds.ranges[index];
                (range.low..=range.high).contains(&after).then_some((index, after))
            })
            .collect();
        let mut moved = x.clone();
        moves.unwrap_or_default().into_iter().for_each(|(index, value)| moved[index] = value);
        if self.best_at(&x).is_some()
            && let Some(best) = self.best.lock().unwrap_or_else(PoisonError::into_inner).as_mut()
        {
            best.x.clone_from(&moved);
        }
        moved
    }

    /// Columns of every record at `x`, in the records' workspaces; not after a stop.
    fn respond(&self, x: &[f64], derivatives: Derivatives<'_>, ws: &mut JointWorkspace) -> bool {
        self.of_each_record(x, ws, |record, candidate, memory, dynamics, ws| {
            record.respond(self.hysteresis, candidate, memory, dynamics, derivatives, ws)
        })
    }

    /// Computes something of every record at `x`; not after a stop.
    fn of_each_record(
        &self,
        x: &[f64],
        ws: &mut JointWorkspace,
        compute: impl Fn(&JointRecord, &Candidate, f64, &Linearised, &mut RecordWorkspace) -> bool + Sync,
    ) -> bool {
        ws.at.clear();
        if self.stop.is_requested() {
            return false;
        }
        let (Some(candidate), Some(form)) = (self.candidate(x), self.form_values(x)) else { return false };
        if self.form.linearise(&form, &mut ws.dynamics).is_err() {
            return false;
        }
        let dynamics = &ws.dynamics;
        self.records
            .par_iter()
            .zip(&mut ws.records)
            .zip(&candidate.memory)
            .map(|((record, ws), &memory)| compute(record, &candidate, memory, dynamics, ws))
            // No short-circuiting: the set of evaluated records must not depend on the threads.
            .reduce(|| true, |a, b| a & b)
    }

    /// All parameter values at `x`, the eliminated ones by linear least squares. After a stop those at the
    /// best point so far, which may be a trial point that the search had not yet accepted.
    pub(in super::super) fn solve(&self, x: &[f64]) -> Option<JointSolution> {
        if !self.stop.is_requested() {
            let mut ws = self.workspace();
            if self.eliminate(x, None, &mut ws) {
                let coefficients = self.coefficients(x, &mut ws);
                return self.solution(x, &coefficients);
            }
            // A stop while it was computed abandoned it.
            if !self.stop.is_requested() {
                return None;
            }
        }
        let best = self.best.lock().unwrap_or_else(PoisonError::into_inner).clone()?;
        self.solution(&best.x, &best.coefficients)
    }

    /// All parameter values at `x` with the coefficients of u, u², … and the weights.
    pub(in super::super) fn solution(&self, x: &[f64], coefficients: &[f64]) -> Option<JointSolution> {
        let candidate = self.candidate(x)?;
        let (polynomial, weights) = coefficients.split_at_checked(self.degree())?;
        Some(JointSolution {
            hysteresis: self.hysteresis.operator(polynomial.to_vec(), weights, &candidate.shape).ok()?,
            shape: candidate.shape,
            form: self.form_values(x)?,
            delay_s: candidate.delay_s,
            memory: candidate.memory,
        })
    }

    fn derivatives(&self) -> Derivatives<'_> {
        Some(&self.shaped)
    }

    /// Derivative of the fit with respect to every searched number at fixed linear coefficients, each
    /// record's local columns projected out, into `out` column by column. After [`Self::respond`] with
    /// derivatives.
    fn differentiate(&self, coefficients: &[f64], records: &mut [RecordWorkspace], out: &mut [f64]) {
        let count = self.residual_count();
        let weights: Vec<f64> =
            coefficients.iter().skip(self.degree()).map(|w| self.hysteresis.sign() * w).collect();
        // One entry per record: its rows of every column.
        let mut slices: Vec<Vec<&mut [f64]>> = self.records.iter().map(|_| Vec::new()).collect();
        for mut column in out.chunks_exact_mut(count) {
            for (r, slices) in slices.iter_mut().enumerate() {
                let (here, rest) = column.split_at_mut(self.records[r].samples());
                slices.push(here);
                column = rest;
            }
        }
        self.records.par_iter().zip(records).zip(slices).enumerate().for_each(
            |(r, ((record, ws), slices))| {
                let directions = self.searched.iter().map(|what| match *what {
                    SearchedNumber::Everywhere(direction) => Some(direction),
                    SearchedNumber::Memory(owner) => (owner == r).then_some(Direction::Memory),
                });
                record.combine(coefficients, ws);
                record.differentiate(directions.zip(slices).collect(), &weights, ws);
            },
        );
    }

    /// −(∂Φ/∂θ) c at `x` into `out`, orthogonal to the columns of the projection; to the sign-constrained ones
    /// with positive weights `too`.
    fn differentiate_beside(
        &self,
        x: &[f64],
        ws: &mut JointWorkspace,
        out: &mut [f64],
        too: bool,
    ) -> Derivative {
        if !self.is_at(x, ws) && !self.evaluate(x, self.derivatives(), ws) {
            return Derivative::Infeasible;
        }
        let coefficients = self.coefficients(x, ws);
        self.differentiate(&coefficients, &mut ws.records, out);
        let JointWorkspace { records, projection, eliminated, .. } = ws;
        let free = projection.len();
        for &index in eliminated.iter().skip(free).filter(|_| too) {
            projection.push(|q| self.gather(index, records, q));
        }
        let rows = self.residual_count();
        out.par_chunks_exact_mut(rows).for_each(|column| {
            projection.project(column);
            column.iter_mut().for_each(|d| *d = -*d);
        });
        projection.truncate(free);
        // A candidate is differentiable where every derivative is finite.
        if out.par_chunks_exact(rows).all(|column| dot(column, column).is_finite()) {
            Derivative::Written
        } else {
            Derivative::Infeasible
        }
    }
}

impl Problem for JointProblem {
    type Workspace = JointWorkspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> JointWorkspace {
        JointWorkspace::of(self)
    }

    fn cost(&self, x: &[f64], ws: &mut JointWorkspace) -> f64 {
        match self.known(x) {
            Some(known) => known.cost,
            None if self.evaluate(x, None, ws) => self.keep(x, ws),
            None => f64::INFINITY,
        }
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

impl LeastSquaresProblem for JointProblem {
    fn residual_count(&self) -> usize {
        self.at.last().copied().unwrap_or(0)
    }

    fn residuals(&self, x: &[f64], ws: &mut JointWorkspace, out: &mut [f64]) -> bool {
        if let Some(known) = self.known(x) {
            out.copy_from_slice(&known.residuals);
            return true;
        }
        if self.is_at(x, ws) {
            out.copy_from_slice(&ws.target);
            // The workspace may come from an equal problem.
            self.keep(x, ws);
            return true;
        }
        // Most trial points are accepted and differentiated next.
        let done = self.evaluate(x, self.derivatives(), ws);
        if done {
            out.copy_from_slice(&ws.target);
            self.keep(x, ws);
            ws.at.extend_from_slice(x);
        }
        done
    }

    fn jacobian(&self, x: &[f64], ws: &mut JointWorkspace, out: &mut [f64]) -> Derivative {
        self.differentiate_beside(x, ws, out, true)
    }

    fn jacobian_with_eliminated<'w>(
        &self,
        x: &[f64],
        ws: &'w mut JointWorkspace,
        out: &mut [f64],
    ) -> (Derivative, Eliminated<'w>) {
        let derivative = self.differentiate_beside(x, ws, out, false);
        (derivative, Eliminated { columns: &ws.signed, coefficients: &ws.absolute })
    }
}
