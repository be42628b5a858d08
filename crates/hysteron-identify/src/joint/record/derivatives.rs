//! Derivatives of a record's output at a candidate whose columns are known.

use std::sync::Mutex;

use rayon::prelude::*;

use super::super::super::projection::Projection;
use super::{JointRecord, Lane, RecordWorkspace, is_stopped};
use hysteron_model::dynamics::{PlanInput, PlanResponse};
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

/// A direction, where there is one, and the derivative along it.
type Wanted<'a> = (Option<Direction>, &'a mut [f64]);

/// Tangent numbers of the response, and the derivatives along them.
type Together<'a> = Vec<(usize, &'a mut [f64])>;

/// What is known of a candidate when its derivatives are worked out.
struct Known<'a> {
    hysteresis: &'a Columns,
    response: &'a PlanResponse,
    total: &'a PlanInput,
    local: &'a Projection,
    columns: &'a [f64],
}

impl RecordWorkspace {
    fn split(&mut self) -> (Known<'_>, &mut [Lane]) {
        let Self { hysteresis, response, total, local, columns, lanes, .. } = self;
        (Known { hysteresis: &hysteresis.columns, response, total, local, columns }, lanes)
    }
}

impl JointRecord {
    /// Prepares derivatives along the dynamics: the whole input Σ cᵢ uⁱ + s Σ w_j H_j + transients at these
    /// coefficients.
    pub(crate) fn combine(&self, coefficients: &[f64], ws: &mut RecordWorkspace) {
        ws.total.clear();
        let degree = coefficients.len().saturating_sub(ws.hysteresis.inputs.len());
        for (c, input) in
            coefficients.iter().zip(self.powers.iter().take(degree).chain(&ws.hysteresis.inputs))
        {
            if *c != 0.0 {
                ws.total.add(*c, input);
            }
        }
        if !self.transients.is_empty() {
            // What the transients take of the measured output, beside all else.
            let measured = ws.local.coefficients(&self.target);
            for (index, transient) in self.transients.iter().enumerate() {
                let at = self.nuisance.len() + index;
                let taken: f64 = coefficients.iter().zip(&ws.transient_shares).map(|(c, s)| c * s[at]).sum();
                ws.total.add(measured[at] - taken, transient);
            }
        }
    }

    /// ∂(Σ cᵢ Φᵢ + Σ w_j Ψ_j)/∂direction at fixed coefficients, weighted and without local columns, into the
    /// slice beside each direction; zero where there is no direction or no derivative. After
    /// [`Self::respond`] with derivatives and [`Self::combine`].
    pub(crate) fn differentiate(&self, wanted: Vec<Wanted<'_>>, weights: &[f64], ws: &mut RecordWorkspace) {
        let (known, lanes) = ws.split();
        let (dynamics, others) = self.dealt(wanted);
        // Dealt out one by one, since some take three times as long as others; what is made together first.
        let deal = Mutex::new(dynamics.into_iter());
        let singly = Mutex::new(others.into_iter());
        lanes.par_iter_mut().for_each(|lane| {
            while let Some(wanted) = deal.lock().ok().and_then(|mut deal| deal.next()) {
                self.derivatives_of_dynamics(wanted, &known, lane);
            }
            while let Some((direction, out)) = singly.lock().ok().and_then(|mut deal| deal.next()) {
                let written = !is_stopped(known.hysteresis)
                    && direction.is_some_and(|d| self.derivative(d, weights, &known, lane, out));
                if !written {
                    out.fill(0.0);
                }
            }
        });
    }

    /// Derivatives along the dynamics, which take one pass together on stamps, and those that are worked out
    /// one by one.
    fn dealt<'a>(&self, wanted: Vec<Wanted<'a>>) -> (Option<Together<'a>>, Vec<Wanted<'a>>) {
        if !self.is_on_stamps() {
            return (None, wanted);
        }
        let (mut together, mut others) = (Vec::new(), Vec::new());
        for (direction, out) in wanted {
            match direction {
                Some(Direction::Dynamics(which)) => together.push((which, out)),
                _ => others.push((direction, out)),
            }
        }
        ((!together.is_empty()).then_some(together), others)
    }

    /// The derivatives along the dynamics, in one pass; zero where they cannot be worked out.
    fn derivatives_of_dynamics(&self, mut wanted: Together<'_>, known: &Known<'_>, lane: &mut Lane) {
        let written = !is_stopped(known.hysteresis)
            && self.plan.apply_tangents(known.response, &mut wanted, known.total, &mut lane.plan).is_ok();
        for (_, out) in wanted {
            if written {
                self.end(out);
                self.finish(known, out);
            } else {
                out.fill(0.0);
            }
        }
    }

    /// The derivative in one direction. `false` where it cannot be worked out.
    fn derivative(
        &self,
        direction: Direction,
        weights: &[f64],
        known: &Known<'_>,
        lane: &mut Lane,
        out: &mut [f64],
    ) -> bool {
        let samples = self.samples();
        let rest = match direction {
            Direction::Column(index) => {
                out.copy_from_slice(&known.columns[index * samples..(index + 1) * samples]);
                return true;
            }
            Direction::Shape(which) => {
                let of_shape = known.hysteresis.partials.iter().filter(|partial| partial.shape == which);
                let parts = of_shape.map(|p| (weights[p.column], &p.values[..], p.rest));
                self.input_of_sum(parts, lane)
            }
            Direction::Memory => {
                let Columns { by_memory, rest_by_memory, .. } = known.hysteresis;
                let parts = weights.iter().zip(by_memory).zip(rest_by_memory);
                self.input_of_sum(parts.map(|((&w, values), &rest)| (w, &values[..], rest)), lane)
            }
            Direction::Dynamics(which) => {
                if self.plan.apply_tangent(known.response, which, known.total, &mut lane.plan, out).is_err() {
                    return false;
                }
                self.end(out);
                self.finish(known, out);
                return true;
            }
        };
        let Some(rest) = rest else { return false };
        if self.plan.apply(known.response, &lane.prepared, &mut lane.plan, out).is_err() {
            return false;
        }
        self.end(out);
        if let Some(unit) = &self.rest {
            out.iter_mut().zip(unit).for_each(|(o, unit)| *o += rest * unit);
        }
        self.finish(known, out);
        true
    }

    /// Input made of the weighted sum of `parts` (weight, output of an operator, the same before the first
    /// sample), less the sum before the first sample, which is returned; `None` where there is nothing.
    fn input_of_sum<'a>(
        &self,
        parts: impl Iterator<Item = (f64, &'a [f64], f64)>,
        lane: &mut Lane,
    ) -> Option<f64> {
        let mut parts = parts.filter(|(weight, ..)| *weight != 0.0);
        let (weight, first, mut rest) = parts.next()?;
        let Some((next_weight, next, next_rest)) = parts.next() else {
            return self.prepare_input(first, rest, weight, lane).then_some(weight * rest);
        };
        let mut sum = std::mem::take(&mut lane.sum);
        sum.clear();
        sum.extend(first.iter().zip(next).map(|(a, b)| weight * a + next_weight * b));
        rest = weight * rest + next_weight * next_rest;
        for (weight, values, before) in parts {
            sum.iter_mut().zip(values).for_each(|(sum, x)| *sum += weight * x);
            rest += weight * before;
        }
        let done = self.prepare_input(&sum, rest, 1.0, lane);
        lane.sum = sum;
        done.then_some(rest)
    }

    /// Weights a derivative and takes its part in the local columns off.
    fn finish(&self, known: &Known<'_>, out: &mut [f64]) {
        self.weighting.apply(out);
        known.local.project(out);
    }
}
