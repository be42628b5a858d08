//! One record of a joint fit: what is precomputed of it, and the linear columns and their derivatives at a candidate.
//!
//! Output of record r at a candidate θ (SPEC §4), linear in the coefficients c and α and in the record's own nuisance:
//!
//! y = offset (+ drift t) + Σ cᵢ Φᵢ(θ) + α Φ_ζ(θ) (+ transients),  Φᵢ = G(θ) ∗ (uⁱ − uⁱ(rest)),  Φ_ζ = −G(θ) ∗ (ζ(θ) − ζ(rest)).
//!
//! The hysteresis runs over the drive at its own rate or a finer one, so that every turning point is met. Where the record is
//! reduced, its output and the measured one go through the same low-pass before samples are left out ([`Reduction`]).

use super::super::projection::Projection;
use super::drive::Thinning;
use super::reduction::Reduction;
use crate::dynamics::{
    InputSpectrum, Linearised, Response, Sampling, SimulationPlan, Workspace as PlanWorkspace,
};
use crate::hysteresis::{BoucWenState, Sensitivities, Start, UnitShape};

mod preparation;

pub(in super::super) use preparation::Ingredients;

/// What happened before the first sample of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Before {
    /// The device rested at this voltage without hysteresis memory and moves to u(0) in one sample.
    Rest {
        /// Rest voltage \[V\].
        voltage_v: f64,
    },
    /// The device rested at u(0) with an unknown memory ζ(0), which is a parameter of the fit.
    Remembering,
    /// The record repeats for ever; it is a whole number of periods.
    Periodic,
}

/// One record prepared for a joint fit.
#[derive(Debug)]
pub(in super::super) struct JointRecord {
    /// Drive on the grid that the hysteresis runs over \[V\].
    drive: Vec<f64>,
    thinning: Thinning,
    reduction: Option<Reduction>,
    before: Before,
    /// Weight of each sample that is worked on, 0 where it does not count.
    pub(super) weight: Vec<f64>,
    /// Orthonormal weighted columns of offset and drift.
    nuisance: Projection,
    /// Measured output, weighted, without nuisance.
    pub(super) target: Vec<f64>,
    /// Samples with weight.
    pub(super) valid: usize,
    /// What a constant output is, 1 but at the ends of a reduced record, where the output at rest counts: the offset is held.
    rest: Option<Vec<f64>>,
    plan: SimulationPlan,
    sampling: Sampling,
    powers: Vec<InputSpectrum>,
    transients: Vec<InputSpectrum>,
}

/// The nonlinear part of a candidate.
#[derive(Clone, Debug)]
pub(in super::super) struct Candidate {
    pub(in super::super) shape: UnitShape,
    pub(in super::super) delay_s: f64,
    /// ζ(0) of each record \[V\]; 0 where the record's memory is known.
    pub(in super::super) memory: Vec<f64>,
}

/// A direction in which a record's output is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Direction {
    Beta,
    Gamma,
    N,
    /// ζ(0) of this record.
    Memory,
    /// Tangent number of the response: a parameter of the dynamics, or the delay.
    Dynamics(usize),
}

/// Scratch of one record.
#[derive(Debug)]
pub(in super::super) struct RecordWorkspace {
    /// First on the grid of the drive, then as the samples that are worked on.
    sensitivities: Sensitivities,
    plan: PlanWorkspace,
    response: Response,
    zeta: InputSpectrum,
    other: InputSpectrum,
    total: InputSpectrum,
    /// Nuisance, and the transients of the candidate.
    local: Projection,
    /// Weighted columns of u, u², …, −ζ without local columns, one after the other.
    pub(in super::super) columns: Vec<f64>,
    /// Target without transients.
    pub(in super::super) target: Vec<f64>,
    transient_columns: Vec<Vec<f64>>,
    /// Coefficients of the local columns in each global column.
    transient_shares: Vec<Vec<f64>>,
    /// As long as the record at its own rate.
    signal: Vec<f64>,
}

impl JointRecord {
    /// Columns of offset and drift.
    pub(super) fn local_columns(&self) -> usize {
        self.nuisance.len()
    }

    /// Samples that are worked on.
    pub(super) fn samples(&self) -> usize {
        self.weight.len()
    }

    /// Scratch for `degree` powers and the tangents of `parameters` parameters of the dynamics.
    pub(super) fn workspace(&self, degree: usize, parameters: usize) -> RecordWorkspace {
        let samples = self.samples();
        let transients = self.transients.len();
        RecordWorkspace {
            sensitivities: Sensitivities::default(),
            plan: self.plan.workspace(),
            response: self.plan.empty_response(parameters),
            zeta: self.plan.empty_spectrum(),
            other: self.plan.empty_spectrum(),
            total: self.plan.empty_spectrum(),
            local: self.nuisance.with_capacity(self.nuisance.capacity() + transients),
            columns: vec![0.0; samples * (degree + 1)],
            target: vec![0.0; samples],
            transient_columns: vec![vec![0.0; samples]; transients],
            transient_shares: Vec::new(),
            signal: vec![0.0; samples.max(self.thinning.samples(self.drive.len()))],
        }
    }

    /// ζ ahead of the first sample, where it is not known from the record itself.
    fn memory_before(&self, memory: f64) -> f64 {
        if self.before == Before::Remembering { memory } else { 0.0 }
    }

    /// Runs the hysteresis. `false` where the candidate cannot be simulated.
    fn run(&self, shape: UnitShape, memory: f64, wanted: Derivatives, ws: &mut RecordWorkspace) -> bool {
        let every = self.thinning.every();
        let start = match self.before {
            Before::Rest { voltage_v } => Start::Rest { u: voltage_v },
            Before::Remembering => Start::State(BoucWenState { u: self.drive[0], z: memory }),
            Before::Periodic => Start::Periodic,
        };
        let out = &mut ws.sensitivities;
        let simulated = match wanted {
            Derivatives::None => {
                out.zeta.resize(self.drive.len().div_ceil(every), 0.0);
                shape.simulate_every(every, &self.drive, start, &mut out.zeta)
            }
            Derivatives::Shape { exponent } => {
                shape.simulate_with_sensitivities(every, &self.drive, start, exponent, out)
            }
        };
        if simulated.is_err() {
            return false;
        }
        self.sample(&mut out.zeta, self.memory_before(memory), &mut ws.signal);
        if wanted != Derivatives::None {
            for x in [&mut out.d_beta, &mut out.d_gamma, &mut out.d_n] {
                self.sample(x, 0.0, &mut ws.signal);
            }
            self.sample(&mut out.d_start, self.memory_before(1.0), &mut ws.signal);
        }
        true
    }

    /// From the operator's output `x`, which is `before` ahead of the first sample, to the samples that are worked on, which
    /// are then the first ones of `x`.
    fn sample(&self, x: &mut [f64], before: f64, signal: &mut [f64]) {
        if x.is_empty() {
            return;
        }
        let samples = self.samples();
        match (&self.reduction, self.thinning) {
            (None, Thinning::Pick(_)) => {}
            (None, Thinning::Means) => {
                self.thinning.apply(x, &mut signal[..samples]);
                x[..samples].copy_from_slice(&signal[..samples]);
            }
            (Some(reduction), Thinning::Pick(_)) => {
                reduction.input(x, before, &mut signal[..samples]);
                x[..samples].copy_from_slice(&signal[..samples]);
            }
            (Some(reduction), Thinning::Means) => {
                let own = &mut signal[..self.thinning.samples(self.drive.len())];
                self.thinning.apply(x, own);
                reduction.input(own, before, &mut x[..samples]);
            }
        }
    }

    /// Columns of the candidate into `ws.columns` and the target without transients into `ws.target`; with
    /// `derivatives`, everything that [`Self::differentiate`] needs. `false` where the candidate cannot be simulated.
    pub(super) fn respond(
        &self,
        candidate: &Candidate,
        memory: f64,
        dynamics: &Linearised,
        derivatives: Derivatives,
        ws: &mut RecordWorkspace,
    ) -> bool {
        if !self.run(candidate.shape, memory, derivatives, ws) {
            return false;
        }
        let (plan, delay_s) = (&self.plan, candidate.delay_s);
        let responded = match derivatives {
            Derivatives::None => {
                plan.response(&dynamics.transfer_function, delay_s, self.sampling, &mut ws.response)
            }
            Derivatives::Shape { .. } => {
                plan.response_with_tangents(dynamics, delay_s, self.sampling, &mut ws.response)
            }
        };
        if responded.is_err() {
            return false;
        }
        let samples = self.samples();
        let rest = self.memory_before(memory);
        let input = &mut ws.signal[..samples];
        input.iter_mut().zip(&ws.sensitivities.zeta).for_each(|(w, zeta)| *w = rest - zeta);
        if plan.transform_into(input, &mut ws.plan, &mut ws.zeta).is_err() {
            return false;
        }
        let mut done = self.respond_to_transients(ws);
        let degree = ws.columns.len() / samples - 1;
        let inputs = self.powers.iter().take(degree).chain([&ws.zeta]);
        ws.transient_shares.clear();
        for (index, (column, input)) in ws.columns.chunks_exact_mut(samples).zip(inputs).enumerate() {
            done &= plan.apply(&ws.response, input, &mut ws.plan, column).is_ok();
            self.end(column);
            if let Some(unit) = &self.rest {
                let rest_v = rest_voltage(self.before, &self.drive);
                let at_rest = if index < degree { rest_v.powi(index as i32 + 1) } else { -rest };
                column.iter_mut().zip(unit).for_each(|(c, unit)| *c += at_rest * unit);
            }
            column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
            if !self.transients.is_empty() && derivatives != Derivatives::None {
                ws.transient_shares.push(ws.local.coefficients(column));
            }
            ws.local.project(column);
        }
        done
    }

    /// The local columns of the candidate, and the target without them.
    fn respond_to_transients(&self, ws: &mut RecordWorkspace) -> bool {
        ws.target.copy_from_slice(&self.target);
        ws.local.truncate(self.nuisance.len());
        for (column, input) in ws.transient_columns.iter_mut().zip(&self.transients) {
            if self.plan.apply(&ws.response, input, &mut ws.plan, column).is_err() {
                return false;
            }
            self.end(column);
            column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
            ws.local.push(|q| q.copy_from_slice(column));
        }
        if !self.transients.is_empty() {
            ws.local.project(&mut ws.target);
        }
        true
    }

    /// Prepares derivatives along the dynamics: the whole input Σ cᵢ uⁱ − α ζ + transients at these coefficients.
    pub(super) fn combine(&self, coefficients: &[f64], ws: &mut RecordWorkspace) {
        ws.total.clear();
        let Some((alpha, polynomial)) = coefficients.split_last() else { return };
        for (c, power) in polynomial.iter().zip(&self.powers) {
            ws.total.add(*c, power);
        }
        ws.total.add(*alpha, &ws.zeta);
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

    /// ∂(Σ cᵢ Φᵢ + α Φ_ζ)/∂direction at fixed coefficients, weighted and without local columns, into `out`. `false`
    /// where it cannot be worked out. After [`Self::respond`] with derivatives and [`Self::combine`].
    pub(super) fn differentiate(
        &self,
        direction: Direction,
        alpha: f64,
        ws: &mut RecordWorkspace,
        out: &mut [f64],
    ) -> bool {
        let s = &ws.sensitivities;
        let (source, rest) = match direction {
            Direction::Beta => (&s.d_beta, 0.0),
            Direction::Gamma => (&s.d_gamma, 0.0),
            Direction::N => (&s.d_n, 0.0),
            Direction::Memory => (&s.d_start, self.memory_before(1.0)),
            Direction::Dynamics(which) => {
                if self.plan.apply_tangent(&ws.response, which, &ws.total, &mut ws.plan, out).is_err() {
                    return false;
                }
                self.end(out);
                return self.finish(ws, out);
            }
        };
        let input = &mut ws.signal[..self.samples()];
        input.iter_mut().zip(source).for_each(|(w, d)| *w = alpha * (rest - d));
        if self.plan.transform_into(input, &mut ws.plan, &mut ws.other).is_err()
            || self.plan.apply(&ws.response, &ws.other, &mut ws.plan, out).is_err()
        {
            return false;
        }
        self.end(out);
        if let Some(unit) = &self.rest {
            out.iter_mut().zip(unit).for_each(|(o, unit)| *o -= alpha * rest * unit);
        }
        self.finish(ws, out)
    }

    /// Takes off a response what belongs beyond the end of the record.
    fn end(&self, column: &mut [f64]) {
        if let Some(reduction) = &self.reduction {
            reduction.end(column);
        }
    }

    /// Weights a column and takes its part in the local columns off.
    fn finish(&self, ws: &RecordWorkspace, column: &mut [f64]) -> bool {
        column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
        ws.local.project(column);
        true
    }
}

/// Voltage before the first sample \[V\].
fn rest_voltage(before: Before, drive: &[f64]) -> f64 {
    match before {
        Before::Rest { voltage_v } => voltage_v,
        Before::Remembering | Before::Periodic => drive[0],
    }
}

/// What is worked out beside the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Derivatives {
    None,
    Shape { exponent: bool },
}
