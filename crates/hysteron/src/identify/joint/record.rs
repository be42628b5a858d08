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
use rayon::prelude::*;

mod derivatives;
mod preparation;

pub(in super::super) use derivatives::Direction;
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

/// Shorter records are worked on by one thread: handing work over would cost more.
const SHARED: usize = 4096;
/// Most threads that share the columns of a record.
const LANES: usize = 8;

/// Scratch of one record.
#[derive(Debug)]
pub(in super::super) struct RecordWorkspace {
    /// As the operator puts them out.
    sensitivities: Sensitivities,
    response: Response,
    zeta: InputSpectrum,
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
    /// One a thread that works on this record.
    lanes: Vec<Lane>,
}

/// Scratch of one column.
#[derive(Debug)]
struct Lane {
    plan: PlanWorkspace,
    spectrum: InputSpectrum,
    /// As long as the record at its own rate, where that is not what is worked on.
    own: Vec<f64>,
    input: Vec<f64>,
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
        let own = match (&self.reduction, self.thinning) {
            (Some(_), Thinning::Means) => self.thinning.samples(self.drive.len()),
            _ => 0,
        };
        let lane = || Lane {
            plan: self.plan.workspace(),
            spectrum: self.plan.empty_spectrum(),
            own: vec![0.0; own],
            input: vec![0.0; samples],
        };
        let lanes = if samples < SHARED { 1 } else { rayon::current_num_threads().min(LANES) };
        RecordWorkspace {
            sensitivities: Sensitivities::default(),
            response: self.plan.empty_response(parameters),
            zeta: self.plan.empty_spectrum(),
            total: self.plan.empty_spectrum(),
            local: self.nuisance.with_capacity(self.nuisance.capacity() + transients),
            columns: vec![0.0; samples * (degree + 1)],
            target: vec![0.0; samples],
            transient_columns: vec![vec![0.0; samples]; transients],
            transient_shares: Vec::new(),
            lanes: (0..lanes).map(|_| lane()).collect(),
        }
    }

    /// ζ ahead of the first sample, where it is not known from the record itself.
    fn memory_before(&self, memory: f64) -> f64 {
        if self.before == Before::Remembering { memory } else { 0.0 }
    }

    /// Runs the hysteresis. `false` where the candidate cannot be simulated.
    fn run(&self, shape: UnitShape, memory: f64, wanted: Derivatives, out: &mut Sensitivities) -> bool {
        let every = self.thinning.every();
        let start = match self.before {
            Before::Rest { voltage_v } => Start::Rest { u: voltage_v },
            Before::Remembering => Start::State(BoucWenState { u: self.drive[0], z: memory }),
            Before::Periodic => Start::Periodic,
        };
        let simulated = match wanted {
            Derivatives::None => {
                out.zeta.resize(self.drive.len().div_ceil(every), 0.0);
                shape.simulate_every(every, &self.drive, start, &mut out.zeta)
            }
            Derivatives::Shape { exponent } => {
                shape.simulate_with_sensitivities(every, &self.drive, start, exponent, out)
            }
        };
        simulated.is_ok()
    }

    /// Spectrum of `scale` times what an output `x` of the operator takes off its value `before` the first sample.
    fn input_spectrum(&self, x: &[f64], before: f64, scale: f64, lane: &mut Lane) -> bool {
        let Lane { plan, spectrum, own, input } = lane;
        match (&self.reduction, self.thinning) {
            (None, Thinning::Pick(_)) => input.copy_from_slice(x),
            (None, Thinning::Means) => self.thinning.apply(x, input),
            (Some(reduction), Thinning::Pick(_)) => reduction.input(x, before, input),
            (Some(reduction), Thinning::Means) => {
                self.thinning.apply(x, own);
                reduction.input(own, before, input);
            }
        }
        input.iter_mut().for_each(|x| *x = scale * (before - *x));
        self.plan.transform_into(input, plan, spectrum).is_ok()
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
        let rest = self.memory_before(memory);
        let RecordWorkspace { sensitivities, response, zeta, lanes, .. } = &mut *ws;
        let Some(lane) = lanes.first_mut() else { return false };
        let mut hysteresis = || {
            self.run(candidate.shape, memory, derivatives, sensitivities)
                && self.input_spectrum(&sensitivities.zeta, rest, 1.0, lane)
        };
        let (plan, delay_s) = (&self.plan, candidate.delay_s);
        let mut linear = || match derivatives {
            Derivatives::None => plan.response(&dynamics.transfer_function, delay_s, self.sampling, response),
            Derivatives::Shape { .. } => {
                plan.response_with_tangents(dynamics, delay_s, self.sampling, response)
            }
        };
        let (hysteretic, responded) =
            if self.samples() < SHARED { (hysteresis(), linear()) } else { rayon::join(hysteresis, linear) };
        if !hysteretic || responded.is_err() {
            return false;
        }
        if let Some(lane) = lanes.first_mut() {
            std::mem::swap(&mut lane.spectrum, zeta);
        }
        self.respond_to_transients(ws) && self.respond_to_inputs(rest, derivatives, ws)
    }

    /// The columns of u, u², …, −ζ, which is `rest` ahead of the first sample, from their spectra.
    fn respond_to_inputs(&self, rest: f64, derivatives: Derivatives, ws: &mut RecordWorkspace) -> bool {
        let RecordWorkspace { response, zeta, local, columns, transient_shares, lanes, .. } = ws;
        let samples = self.samples();
        let degree = columns.len() / samples - 1;
        let column = |index: usize, column: &mut [f64], lane: &mut Lane| {
            let input = if index < degree { &self.powers[index] } else { &*zeta };
            let done = self.plan.apply(response, input, &mut lane.plan, column).is_ok();
            self.end(column);
            if let Some(unit) = &self.rest {
                let rest_v = rest_voltage(self.before, &self.drive);
                let at_rest = if index < degree { rest_v.powi(index as i32 + 1) } else { -rest };
                column.iter_mut().zip(unit).for_each(|(c, unit)| *c += at_rest * unit);
            }
            column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
            done
        };
        let share = (degree + 1).div_ceil(lanes.len());
        let done = columns
            .par_chunks_mut(share * samples)
            .zip(&mut *lanes)
            .enumerate()
            .map(|(at, (columns, lane))| {
                let columns = columns.chunks_exact_mut(samples).enumerate();
                columns.map(|(index, own)| column(at * share + index, own, lane)).fold(true, |a, b| a & b)
            })
            .reduce(|| true, |a, b| a & b);
        transient_shares.clear();
        if !self.transients.is_empty() && derivatives != Derivatives::None {
            transient_shares.extend(columns.chunks_exact(samples).map(|column| local.coefficients(column)));
        }
        columns.par_chunks_exact_mut(samples).for_each(|column| local.project(column));
        done
    }

    /// The local columns of the candidate, and the target without them.
    fn respond_to_transients(&self, ws: &mut RecordWorkspace) -> bool {
        ws.target.copy_from_slice(&self.target);
        ws.local.truncate(self.nuisance.len());
        let Some(lane) = ws.lanes.first_mut() else { return false };
        for (column, input) in ws.transient_columns.iter_mut().zip(&self.transients) {
            if self.plan.apply(&ws.response, input, &mut lane.plan, column).is_err() {
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

    /// Takes off a response what belongs beyond the end of the record.
    fn end(&self, column: &mut [f64]) {
        if let Some(reduction) = &self.reduction {
            reduction.end(column);
        }
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
