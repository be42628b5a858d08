//! Derivatives of a record's output at a candidate with computed columns.

use std::sync::Mutex;

use rayon::prelude::*;

use super::super::super::projection::Projection;
use super::{JointRecord, Lane, RecordWorkspace, is_stopped};
use hysteron_model::dynamics::{DynamicsError, PlanInput, PlanResponse};
use hysteron_model::hysteresis::Columns;

/// A direction in which a record's output is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// Coefficient of u^(index + 1), then weights.
    Column(usize),
    /// A shape number of the hysteresis.
    Shape(usize),
    /// Memory of this record.
    Memory,
    /// Tangent number of the response: a parameter of the dynamics, or the delay.
    Dynamics(usize),
}

/// A direction, if any, and the derivative along it.
type WantedDerivative<'a> = (Option<Direction>, &'a mut [f64]);

/// Quantities of a candidate needed for its derivatives.
struct CandidateQuantities<'a> {
    hysteresis: &'a Columns,
    response: &'a PlanResponse,
    total: &'a PlanInput,
    local: &'a Projection,
    columns: &'a [f64],
}

impl RecordWorkspace {
    fn split(&mut self) -> (CandidateQuantities<'_>, &mut [Lane]) {
        let Self { hysteresis, response, total, local, columns, lanes, .. } = self;
        (
            CandidateQuantities {
                hysteresis: &hysteresis.operators.columns,
                response,
                total,
                local,
                columns,
            },
            lanes,
        )
    }
}

impl JointRecord {
    /// Prepares derivatives along the dynamics: the whole input Σ cᵢ uⁱ + s Σ w_j H_j + transients at these
    /// coefficients.
    pub(crate) fn combine(&self, coefficients: &[f64], ws: &mut RecordWorkspace) {
        let columns = self.weighted_inputs(coefficients, &ws.hysteresis.operators);
        // Coefficients of the transients: least squares on the residual of the other columns.
        let measured =
            if self.transients.is_empty() { Vec::new() } else { ws.local.coefficients(&self.target) };
        let transients = self.transients.iter().enumerate().map(|(index, transient)| {
            let at = self.nuisance.len() + index;
            let taken: f64 = coefficients.iter().zip(&ws.transient_shares).map(|(c, s)| c * s[at]).sum();
            (measured[at] - taken, transient)
        });
        ws.total.set_sum(columns.chain(transients));
    }

    /// ∂(Σ cᵢ Φᵢ + Σ w_j Ψ_j)/∂direction at fixed coefficients, weighted and with local columns projected
    /// out, into the slice paired with each direction; zero where there is no direction or no derivative.
    /// After [`Self::respond`] with derivatives and [`Self::combine`].
    pub(crate) fn differentiate(
        &self,
        wanted: Vec<WantedDerivative<'_>>,
        weights: &[f64],
        ws: &mut RecordWorkspace,
    ) {
        let (known, lanes) = ws.split();
        // Scheduled dynamically, since some take three times as long as others.
        let deal = Mutex::new(self.dealt(wanted, lanes.len()).into_iter());
        lanes.par_iter_mut().for_each(|lane| {
            while let Some(group) = deal.lock().ok().and_then(|mut deal| deal.next()) {
                self.derivatives(group, weights, &known, lane);
            }
        });
    }

    /// The directions in groups computed together, the longest first: on time stamps the derivatives with
    /// respect to the dynamics take one pass, and others share one.
    fn dealt<'a>(&self, wanted: Vec<WantedDerivative<'a>>, lanes: usize) -> Vec<Vec<WantedDerivative<'a>>> {
        if !self.is_on_stamps() {
            return wanted.into_iter().map(|wanted| vec![wanted]).collect();
        }
        let is_dynamic =
            |(direction, _): &WantedDerivative<'_>| matches!(direction, Some(Direction::Dynamics(_)));
        let (dynamics, others): (Vec<_>, Vec<_>) = wanted.into_iter().partition(is_dynamic);
        let together = self.together(others.len().div_ceil(lanes.max(1)));
        let mut groups = vec![dynamics];
        let mut others = others.into_iter().peekable();
        while others.peek().is_some() {
            groups.push(others.by_ref().take(together).collect());
        }
        groups
    }

    /// The derivatives in some directions; zero where they cannot be computed.
    fn derivatives(
        &self,
        wanted: Vec<WantedDerivative<'_>>,
        weights: &[f64],
        known: &CandidateQuantities<'_>,
        lane: &mut Lane,
    ) {
        let samples = self.samples();
        let driven = self.outputs();
        let (mut tangents, mut outputs, mut rests) = (Vec::new(), Vec::new(), Vec::new());
        for (direction, out) in wanted {
            let rest = match direction.filter(|_| !is_stopped(known.hysteresis)) {
                Some(Direction::Column(index)) => {
                    out.copy_from_slice(&known.columns[index * samples..(index + 1) * samples]);
                    continue;
                }
                Some(Direction::Dynamics(which)) => {
                    tangents.push((which, out));
                    continue;
                }
                Some(Direction::Shape(which)) => {
                    let of_shape = known.hysteresis.partials.iter().filter(|partial| partial.shape == which);
                    let parts = of_shape.map(|p| (weights[p.column], &p.values[..], p.rest));
                    self.input_of_sum(parts, driven, lane)
                }
                Some(Direction::Memory) => {
                    let Columns { by_memory, rest_by_memory, standing_by_memory, .. } = known.hysteresis;
                    let parts = weights.iter().zip(by_memory).zip(rest_by_memory);
                    let parts = parts.map(|((&w, values), &rest)| (w, &values[..], rest));
                    let standing: f64 = weights.iter().zip(standing_by_memory).map(|(w, by)| w * by).sum();
                    self.input_of_sum(parts, driven, lane).map(|rest| rest + standing)
                }
                None => None,
            };
            let Some(rest) = rest else {
                out.fill(0.0);
                continue;
            };
            if lane.inputs.len() == rests.len() {
                lane.inputs.push(PlanInput::none());
            }
            std::mem::swap(&mut lane.inputs[rests.len()], &mut lane.prepared);
            outputs.push(out);
            rests.push(rest);
        }
        let Lane { plan, inputs, .. } = lane;
        let inputs: Vec<&PlanInput> = inputs.iter().take(rests.len()).collect();
        let done = self.plan.apply_each(known.response, &inputs, plan, &mut outputs);
        for (out, rest) in outputs.into_iter().zip(rests) {
            // A non-finite derivative must not affect others in the group, which depends on the threads.
            let done = match done {
                Err(DynamicsError::OutputNotFinite) => out.iter().all(|x| x.is_finite()),
                ref done => done.is_ok(),
            };
            self.finish(known, done, rest, out);
        }
        let done = self.plan.apply_tangents(known.response, &mut tangents, known.total, plan).is_ok();
        for (_, out) in tangents {
            self.finish(known, done, 0.0, out);
        }
    }

    /// Input from the weighted sum of `parts` (weight, operator output, zero-padded, and its value before the
    /// first sample), less the sum before the first sample, which is returned; `None` without parts.
    pub(super) fn input_of_sum<'a>(
        &self,
        parts: impl Iterator<Item = (f64, &'a [f64], f64)>,
        samples: usize,
        lane: &mut Lane,
    ) -> Option<f64> {
        let mut parts = parts.filter(|(weight, ..)| *weight != 0.0).peekable();
        let (weight, values, before) = parts.next()?;
        if parts.peek().is_none() && values.len() == samples {
            return self.prepare_input(values, before, weight, lane).then_some(weight * before);
        }
        let mut sum = std::mem::take(&mut lane.sum);
        sum.clear();
        sum.extend(values.iter().map(|x| weight * x));
        sum.resize(samples, 0.0);
        let mut rest = weight * before;
        for (weight, values, before) in parts {
            sum.iter_mut().zip(values).for_each(|(sum, x)| *sum += weight * x);
            rest += weight * before;
        }
        let done = self.prepare_input(&sum, rest, 1.0, lane);
        lane.sum = sum;
        done.then_some(rest)
    }

    /// Adds the response at `rest` to a derivative, weights it and projects out the local columns; zero where
    /// it is not `done`.
    fn finish(&self, known: &CandidateQuantities<'_>, done: bool, rest: f64, out: &mut [f64]) {
        if !done {
            out.fill(0.0);
            return;
        }
        self.end(out);
        if let Some(unit) = self.rest.as_ref().filter(|_| rest != 0.0) {
            out.iter_mut().zip(unit).for_each(|(o, unit)| *o += rest * unit);
        }
        self.weighting.apply(out);
        known.local.project(out);
    }
}
