//! One record of a joint fit: precomputed quantities, and the linear columns and their derivatives at a
//! candidate.
//!
//! Output of record r at a candidate θ (`docs/theory/joint.md`), linear in the coefficients c and w and in
//! the record's nuisance parameters:
//!
//! y = offset (+ drift t) + Σ cᵢ Φᵢ(θ) + Σ w_j Ψ_j(θ) (+ transients),  Φᵢ = G(θ) ∗ (uⁱ − uⁱ(rest)),  Ψ_j = s
//! G(θ) ∗ (H_j(θ) − H_j(rest)),
//!
//! with the columns H_j, weights w_j and the sign s of the family of hysteresis operators
//! ([`HysteresisForm`]).
//!
//! The hysteresis is simulated at the rate of the drive or a finer one, so that every turning point is
//! resolved. For a reduced record, simulated and measured output pass the same low-pass before decimation
//! ([`Reduction`]).

use super::super::projection::Projection;
use super::drive::Thinning;
use super::reduction::Reduction;
use super::weighting::Weighting;
use hysteron_model::Start;
use hysteron_model::dynamics::{Linearised, PlanInput, PlanResponse, PlanWorkspace, RecordPlan, Sampling};
use hysteron_model::hysteresis::{Columns, DriveGrid, HysteresisForm};
use hysteron_model::record::Pace;
use hysteron_optimize::Stop;
use rayon::prelude::*;
use std::borrow::Cow;

mod derivatives;
mod operators;
mod preparation;

use operators::{LentOperators, Operators, Spare};

pub(in super::super) use derivatives::Direction;
pub(in super::super) use preparation::{Clock, Ingredients};

/// One record prepared for a joint fit.
#[derive(Debug)]
pub(in super::super) struct JointRecord {
    /// Drive on the grid on which the hysteresis is simulated \[V\].
    drive: Vec<f64>,
    /// Time grid of the drive.
    grid: DriveGrid<'static>,
    /// Rate and duration of the move to each sample of the drive, where sampling is non-uniform.
    paces: Option<Vec<Pace>>,
    thinning: Thinning,
    reduction: Option<InputsAndOutput>,
    /// Start of the record; an unknown memory at rest at u(0) is a parameter of the fit.
    before: Start<()>,
    /// Cycles in the record; 1 where it has none.
    pub(super) cycles: usize,
    weighting: Weighting,
    /// Orthonormal weighted columns of offset and drift.
    nuisance: Projection,
    /// Measured output, weighted, nuisance projected out.
    pub(super) target: Vec<f64>,
    /// Samples with weight.
    pub(super) valid: usize,
    /// Where the offset is held: response to the constant output at rest, 1 except at the ends of a reduced
    /// record.
    rest: Option<Vec<f64>>,
    plan: RecordPlan,
    sampling: Sampling,
    powers: Vec<PlanInput>,
    transients: Vec<PlanInput>,
    spare: Spare,
}

/// The same low-pass and decimation for inputs, which may be of every few samples only, and for the output.
#[derive(Debug)]
struct InputsAndOutput {
    inputs: Reduction,
    output: Reduction,
}

/// The nonlinear part of a candidate.
#[derive(Clone, Debug)]
pub(in super::super) struct Candidate {
    /// The family's shape numbers.
    pub(in super::super) shape: Vec<f64>,
    pub(in super::super) delay_s: f64,
    /// Memory of each record \[V\]; 0 where it is known.
    pub(in super::super) memory: Vec<f64>,
}

/// Shorter records are processed by one thread: dispatch would cost more.
const SHARED: usize = 4096;
/// Most threads that share the columns of a record.
const LANES: usize = 8;
/// On time stamps, largest number of inputs of the dynamics in one pass: each pass computes the exponentials
/// of every step anew, and the states of all inputs should stay in the nearest cache.
const MOST_TOGETHER: usize = 32;

/// Scratch of one record.
#[derive(Debug)]
pub(in super::super) struct RecordWorkspace {
    hysteresis: LentOperators,
    response: PlanResponse,
    total: PlanInput,
    /// Nuisance, and the transients of the candidate.
    local: Projection,
    /// Weighted columns of u, u², …, s H_j, local columns projected out, one after the other.
    pub(in super::super) columns: Vec<f64>,
    /// Target with the transients projected out.
    pub(in super::super) target: Vec<f64>,
    transient_columns: Vec<Vec<f64>>,
    /// Coefficients of the local columns in each global column.
    transient_shares: Vec<Vec<f64>>,
    /// One per thread working on this record.
    lanes: Vec<Lane>,
}

/// Scratch of one column.
#[derive(Debug)]
struct Lane {
    plan: PlanWorkspace,
    prepared: PlanInput,
    /// Inputs of derivatives that are computed together.
    inputs: Vec<PlanInput>,
    /// Buffer at the record's own rate, where the record is reduced.
    own: Vec<f64>,
    input: Vec<f64>,
    /// Weighted sum of operator outputs.
    sum: Vec<f64>,
}

impl RecordWorkspace {
    /// Makes the outputs of the operators available to other workspaces of the record.
    pub(super) fn return_operators(&mut self) {
        self.hysteresis.give_back();
    }

    /// Sets the stop signal that ends an evaluation early.
    pub(super) fn set_stop(&mut self, stop: &Stop) {
        self.hysteresis.operators.columns.stop = Some(stop.clone());
    }
}

/// True if a stop is requested.
fn is_stopped(columns: &Columns) -> bool {
    columns.stop.as_ref().is_some_and(Stop::is_requested)
}

impl JointRecord {
    /// Columns of offset and drift.
    pub(super) fn local_columns(&self) -> usize {
        self.nuisance.len()
    }

    /// A column at the samples of the record, by straight lines where it is reduced.
    pub(super) fn at_samples<'c>(&self, column: &'c [f64]) -> Cow<'c, [f64]> {
        match &self.reduction {
            Some(reduction) => reduction.output.at_samples(column).into(),
            None => column.into(),
        }
    }

    /// Samples of the drive that the operators take.
    pub(super) fn drive_samples(&self) -> usize {
        self.drive.len()
    }

    /// Samples of an output of the operators.
    fn outputs(&self) -> usize {
        self.drive.len().div_ceil(self.grid.factor)
    }

    /// Number of samples, after reduction.
    pub(super) fn samples(&self) -> usize {
        self.weighting.weight.len()
    }

    /// Weight of each sample, after reduction; 0 for excluded samples.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weighting.weight
    }

    /// True if the record has time stamps instead of a uniform rate.
    pub(super) fn is_on_stamps(&self) -> bool {
        matches!(self.plan, RecordPlan::Stamped(_))
    }

    /// Residuals of white noise that carry the information of one that is independent.
    pub(super) fn correlation_time_of_white(&self) -> f64 {
        self.reduction.as_ref().map_or(1.0, |reduction| reduction.output.correlation_time_of_white())
    }

    /// True if the weights are those of samples, not of periods.
    pub(super) fn weighs_samples_alone(&self) -> bool {
        self.weighting.periods.is_empty()
    }

    /// Removes the weights from a column.
    pub(super) fn unweigh(&self, column: &mut [f64]) {
        self.weighting.undo(column);
    }

    /// Scratch for the tangents of `parameters` parameters of the dynamics, and no columns
    /// ([`Self::take_columns`]).
    pub(super) fn workspace(&self, parameters: usize) -> RecordWorkspace {
        let samples = self.samples();
        let transients = self.transients.len();
        let own = match (&self.reduction, self.thinning) {
            (Some(_), Thinning::Means) => self.thinning.samples(self.drive.len()),
            _ => 0,
        };
        let lane = || Lane {
            plan: self.plan.workspace(),
            prepared: PlanInput::none(),
            inputs: Vec::new(),
            own: vec![0.0; own],
            input: vec![0.0; self.plan.inputs()],
            sum: Vec::new(),
        };
        let lanes = if samples < SHARED { 1 } else { rayon::current_num_threads().min(LANES) };
        RecordWorkspace {
            hysteresis: LentOperators::new(&self.spare),
            response: self.plan.empty_response(parameters),
            total: self.plan.empty_input(),
            local: self.nuisance.with_capacity(self.nuisance.capacity() + transients),
            columns: Vec::new(),
            target: vec![0.0; samples],
            transient_columns: vec![vec![0.0; samples]; transients],
            transient_shares: Vec::new(),
            lanes: (0..lanes).map(|_| lane()).collect(),
        }
    }

    /// Makes room for `count` columns.
    pub(super) fn take_columns(&self, count: usize, ws: &mut RecordWorkspace) {
        ws.columns.resize(self.samples() * count, 0.0);
    }

    /// Makes room for another number of tangents.
    pub(super) fn take_parameters(&self, parameters: usize, ws: &mut RecordWorkspace) {
        ws.response = self.plan.empty_response(parameters);
    }

    /// State of the operators before the first sample.
    fn origin(&self, memory: f64) -> Start<f64> {
        match self.before {
            Start::Remembering { .. } => Start::Remembering { voltage_v: self.drive[0], memory },
            Start::Rest { voltage_v } => Start::Rest { voltage_v },
            Start::AsIdentified => Start::AsIdentified,
            Start::Settled { .. } => Start::PERIODIC,
        }
    }

    /// Columns of the candidate into `ws.columns` and the target, transients projected out, into `ws.target`;
    /// with `derivatives`, everything that [`Self::differentiate`] needs. `false` where the candidate cannot
    /// be simulated.
    pub(super) fn respond(
        &self,
        form: HysteresisForm,
        candidate: &Candidate,
        memory: f64,
        dynamics: &Linearised,
        derivatives: Derivatives<'_>,
        ws: &mut RecordWorkspace,
    ) -> bool {
        self.prepare_response(form, candidate, memory, dynamics, derivatives, ws)
            && self.transform(form.sign(), &mut ws.hysteresis.operators, &mut ws.lanes)
            && self.respond_to_inputs(form.sign(), derivatives, ws)
    }

    /// Residual at given coefficients of u, u², … and weights into `ws.target`, local columns projected out:
    /// one response to the sum of all inputs instead of one to each. `false` where the candidate cannot be
    /// simulated.
    pub(super) fn residual(
        &self,
        form: HysteresisForm,
        candidate: &Candidate,
        memory: f64,
        dynamics: &Linearised,
        coefficients: &[f64],
        ws: &mut RecordWorkspace,
    ) -> bool {
        if !self.prepare_response(form, candidate, memory, dynamics, None, ws) {
            return false;
        }
        let RecordWorkspace { hysteresis, response, total, local, columns, target, lanes, .. } = ws;
        let Operators { columns: operated, reduced, .. } = &hysteresis.operators;
        let (Some(lane), Some(output)) = (lanes.first_mut(), columns.get_mut(..self.samples())) else {
            return true;
        };
        let degree = coefficients.len().saturating_sub(operated.values.len());
        let (polynomial, weights) = coefficients.split_at(degree);
        let sign = form.sign();
        let signed = || weights.iter().map(|weight| sign * weight).zip(&operated.rest);
        let done = if self.reduction.is_some() {
            let parts = signed().zip(reduced).map(|((weight, rest), x)| (weight, &x[..], *rest));
            self.prepare_sum(parts, lane)
        } else if weights.iter().all(|weight| *weight == 0.0) {
            self.prepare_sum([], lane)
        } else {
            let parts = signed().zip(&operated.values).map(|((weight, rest), x)| (weight, &x[..], *rest));
            self.input_of_sum(parts, self.outputs(), lane).is_some()
        };
        if !done {
            return false;
        }
        let powers = polynomial.iter().copied().zip(&self.powers);
        total.set_sum(powers.chain([(1.0, &lane.prepared)]));
        if self.plan.apply(response, total, &mut lane.plan, output).is_err() {
            return false;
        }
        self.end(output);
        if let Some(unit) = &self.rest {
            let at_rest = |(index, c)| c * self.at_rest(index, degree, sign, operated);
            let at_rest: f64 = coefficients.iter().enumerate().map(at_rest).sum();
            output.iter_mut().zip(unit).for_each(|(out, unit)| *out += at_rest * unit);
        }
        self.weighting.apply(output);
        local.project(output);
        target.iter_mut().zip(output).for_each(|(target, output)| *target -= *output);
        true
    }

    /// Simulates the hysteresis of a candidate, and computes the response of its dynamics and the columns of
    /// the transients. `false` where the candidate cannot be simulated.
    fn prepare_response(
        &self,
        form: HysteresisForm,
        candidate: &Candidate,
        memory: f64,
        dynamics: &Linearised,
        derivatives: Derivatives<'_>,
        ws: &mut RecordWorkspace,
    ) -> bool {
        let RecordWorkspace { hysteresis, response, lanes, .. } = &mut *ws;
        let mut operate = || self.operate(form, (&candidate.shape, memory), derivatives, hysteresis, lanes);
        let (plan, delay_s) = (&self.plan, candidate.delay_s);
        let mut linear = || match derivatives {
            None => plan.response(&dynamics.transfer_function, delay_s, self.sampling, response),
            Some(_) => plan.response_with_tangents(dynamics, delay_s, self.sampling, response),
        };
        let (simulated, responded) =
            if self.samples() < SHARED { (operate(), linear()) } else { rayon::join(operate, linear) };
        simulated && responded.is_ok() && self.respond_to_transients(ws)
    }

    /// Inputs of u, u², … and s H_j with their coefficients, those that are not 0.
    fn weighted_inputs<'a>(
        &'a self,
        coefficients: &'a [f64],
        operators: &'a Operators,
    ) -> impl Iterator<Item = (f64, &'a PlanInput)> {
        let degree = coefficients.len().saturating_sub(operators.inputs.len());
        let inputs = self.powers.iter().take(degree).chain(&operators.inputs);
        coefficients.iter().copied().zip(inputs).filter(|(c, _)| *c != 0.0)
    }

    /// Value of u^(`index` + 1), or of s H_j from `degree` on, before the first sample.
    fn at_rest(&self, index: usize, degree: usize, sign: f64, columns: &Columns) -> f64 {
        match index.checked_sub(degree) {
            None => rest_voltage(self.before, &self.drive).powi(index as i32 + 1),
            Some(column) => sign * (columns.rest[column] + columns.standing[column]),
        }
    }

    /// The columns of u, u², …, s H_j from their inputs.
    fn respond_to_inputs(&self, sign: f64, derivatives: Derivatives<'_>, ws: &mut RecordWorkspace) -> bool {
        let RecordWorkspace { hysteresis, response, local, columns, transient_shares, lanes, .. } = ws;
        let hysteresis = &hysteresis.operators;
        let samples = self.samples();
        let count = columns.len() / samples;
        let degree = count - hysteresis.inputs.len();
        let input = |index: usize| {
            if index < degree { &self.powers[index] } else { &hysteresis.inputs[index - degree] }
        };
        let finish = |index: usize, column: &mut [f64]| {
            self.end(column);
            if let Some(unit) = &self.rest {
                let at_rest = self.at_rest(index, degree, sign, &hysteresis.columns);
                column.iter_mut().zip(unit).for_each(|(c, unit)| *c += at_rest * unit);
            }
            self.weighting.apply(column);
        };
        let share = count.div_ceil(lanes.len());
        let together = self.together(share);
        let done = columns
            .par_chunks_mut(share * samples)
            .zip(&mut *lanes)
            .enumerate()
            .map(|(at, (columns, lane))| {
                let mut done = true;
                for (group, columns) in columns.chunks_mut(together * samples).enumerate() {
                    let first = at * share + group * together;
                    let mut columns: Vec<&mut [f64]> = columns.chunks_exact_mut(samples).collect();
                    let inputs: Vec<&PlanInput> = (first..first + columns.len()).map(input).collect();
                    done = done
                        && !is_stopped(&hysteresis.columns)
                        && self.plan.apply_each(response, &inputs, &mut lane.plan, &mut columns).is_ok();
                    columns.into_iter().enumerate().for_each(|(k, column)| finish(first + k, column));
                }
                done
            })
            .reduce(|| true, |a, b| a & b);
        if !done {
            return false;
        }
        transient_shares.clear();
        if !self.transients.is_empty() && derivatives.is_some() {
            transient_shares.extend(columns.chunks_exact(samples).map(|column| local.coefficients(column)));
        }
        columns.par_chunks_exact_mut(samples).for_each(|column| local.project(column));
        true
    }

    /// The local columns of the candidate, and the target with them projected out.
    fn respond_to_transients(&self, ws: &mut RecordWorkspace) -> bool {
        ws.target.copy_from_slice(&self.target);
        ws.local.truncate(self.nuisance.len());
        let Some(lane) = ws.lanes.first_mut() else { return false };
        for (column, input) in ws.transient_columns.iter_mut().zip(&self.transients) {
            if self.plan.apply(&ws.response, input, &mut lane.plan, column).is_err() {
                return false;
            }
            self.end(column);
            self.weighting.apply(column);
            ws.local.push(|q| q.copy_from_slice(column));
        }
        if !self.transients.is_empty() {
            ws.local.project(&mut ws.target);
        }
        true
    }

    /// Number of inputs of the dynamics processed in one pass.
    fn together(&self, inputs: usize) -> usize {
        if self.is_on_stamps() { inputs.clamp(1, MOST_TOGETHER) } else { 1 }
    }

    /// Subtracts from a response its part beyond the end of the record.
    fn end(&self, column: &mut [f64]) {
        if let Some(reduction) = &self.reduction {
            reduction.output.end(column);
        }
    }
}

/// Voltage before the first sample \[V\].
fn rest_voltage(before: Start<()>, drive: &[f64]) -> f64 {
    match before {
        Start::Rest { voltage_v } => voltage_v,
        Start::AsIdentified | Start::Remembering { .. } | Start::Settled { .. } => drive[0],
    }
}

/// Shape numbers of the hysteresis to differentiate with respect to; `None`: columns without derivatives.
pub(in super::super) type Derivatives<'a> = Option<&'a [bool]>;
