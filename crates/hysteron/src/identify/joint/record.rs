//! One record of a joint fit: what is precomputed of it, and the linear columns and their derivatives at a candidate.
//!
//! Output of record r at a candidate θ (SPEC §4), linear in the coefficients c and α and in the record's own nuisance:
//!
//! y = offset (+ drift t) + Σ cᵢ Φᵢ(θ) + α Φ_ζ(θ) (+ transients),  Φᵢ = G(θ) ∗ (uⁱ − uⁱ(rest)),  Φ_ζ = −G(θ) ∗ (ζ(θ) − ζ(rest)).
//!
//! The hysteresis runs over the drive at its own rate or a finer one, so that every turning point is met; what follows is
//! worked out at the rate of the measured output, which may be filtered and thinned.

use super::super::projection::Projection;
use crate::dynamics::{
    DynamicsError, InitialCondition, InputSpectrum, Linearised, Response, Sampling, Scheme, SimulationPlan,
    Workspace as PlanWorkspace,
};
use crate::hysteresis::{BoucWenState, Sensitivities, Start, UnitShape, polygon_of_means};

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
    /// Drive at the record's own rate \[V\].
    pub(super) drive: Vec<f64>,
    /// How the samples that are worked on come from those of the drive.
    thinning: Thinning,
    pub(super) before: Before,
    /// Weight of each scored sample, 0 where it does not count.
    pub(super) weight: Vec<f64>,
    /// Orthonormal weighted columns of offset and drift.
    nuisance: Projection,
    /// Measured output, weighted, without nuisance.
    pub(super) target: Vec<f64>,
    /// Samples with weight.
    pub(super) valid: usize,
    /// Output at rest counts, because the offset is held.
    counts_rest: bool,
    path: Path,
}

/// How the samples that are worked on come from those of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Thinning {
    /// Every so many samples.
    Pick(usize),
    /// The drive is twice as fine: each sample allows for the mean of the curve beside it ([`polygon_of_means`]).
    Means,
}

impl Thinning {
    fn samples(self, drive: usize) -> usize {
        match self {
            Self::Pick(factor) => drive.div_ceil(factor),
            Self::Means => drive.div_ceil(2),
        }
    }

    fn apply(self, fine: &[f64], out: &mut [f64]) {
        match self {
            Self::Pick(factor) => {
                out.iter_mut().zip(fine.iter().step_by(factor)).for_each(|(o, x)| *o = *x);
            }
            Self::Means => polygon_of_means(fine, out),
        }
    }
}

/// How the columns come about.
#[derive(Debug)]
enum Path {
    /// G = 1 without delay: the finished columns of u, u², … (weighted, without nuisance).
    Direct { powers: Vec<Vec<f64>> },
    /// Through the frequency domain.
    Plan {
        plan: Box<SimulationPlan>,
        sampling: Sampling,
        powers: Vec<InputSpectrum>,
        transients: Vec<InputSpectrum>,
    },
}

/// What a joint record is made from.
pub(in super::super) struct Ingredients<'a> {
    pub(in super::super) drive: &'a [f64],
    pub(in super::super) thinning: Thinning,
    /// Output at the reduced rate, less a held offset.
    pub(in super::super) output: &'a [f64],
    /// Weight of each sample at the reduced rate.
    pub(in super::super) weight: Vec<f64>,
    pub(in super::super) before: Before,
    /// Decaying motion from before the record is allowed for.
    pub(in super::super) transients: bool,
    pub(in super::super) offset_is_held: bool,
    /// Further nuisance columns at the reduced rate (drift).
    pub(in super::super) nuisance: Vec<Vec<f64>>,
    /// Highest polynomial degree that will be asked for.
    pub(in super::super) degree: usize,
    /// Rate and scheme of the dynamics; `None` for a static model without delay.
    pub(in super::super) dynamics: Option<(f64, Scheme, Sampling)>,
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
    sensitivities: Sensitivities,
    plan: Option<PlanWorkspace>,
    response: Option<Response>,
    zeta: Option<InputSpectrum>,
    other: Option<InputSpectrum>,
    total: Option<InputSpectrum>,
    /// Nuisance, and the transients of the candidate.
    local: Projection,
    /// Weighted columns of u, u², …, −ζ without local columns, one after the other.
    pub(in super::super) columns: Vec<f64>,
    /// Target without transients.
    pub(in super::super) target: Vec<f64>,
    transient_columns: Vec<Vec<f64>>,
    /// Coefficients of the local columns in each global column.
    transient_shares: Vec<Vec<f64>>,
    signal: Vec<f64>,
}

/// Number of transient columns: two impulses at the first two samples, and a step.
const TRANSIENTS: usize = 3;

impl JointRecord {
    pub(in super::super) fn new(parts: Ingredients<'_>) -> Result<Self, DynamicsError> {
        let samples = parts.output.len();
        let weight = parts.weight;
        let mut nuisance = Projection::new(samples, 1 + parts.nuisance.len());
        if !parts.offset_is_held {
            nuisance.push(|column| column.copy_from_slice(&weight));
        }
        for extra in &parts.nuisance {
            nuisance.push(|column| {
                for ((c, w), x) in column.iter_mut().zip(&weight).zip(extra) {
                    *c = w * x;
                }
            });
        }
        let mut target: Vec<f64> = parts.output.iter().zip(&weight).map(|(y, w)| y * w).collect();
        nuisance.project(&mut target);
        debug_assert_eq!(samples, parts.thinning.samples(parts.drive.len()));
        let periodic = parts.before == Before::Periodic;
        let rest_v = match parts.before {
            Before::Rest { voltage_v } => voltage_v,
            Before::Remembering | Before::Periodic => parts.drive[0],
        };
        let from_rest = |power: i32| -> Vec<f64> {
            let rest = if periodic { 0.0 } else { rest_v.powi(power) };
            let fine: Vec<f64> = parts.drive.iter().map(|u| u.powi(power) - rest).collect();
            let mut column = vec![0.0; samples];
            parts.thinning.apply(&fine, &mut column);
            column
        };
        let counts_rest = parts.offset_is_held && !periodic;
        let path = match parts.dynamics {
            None => {
                let column = |power| {
                    let rest = if counts_rest { rest_v.powi(power) } else { 0.0 };
                    let mut column: Vec<f64> =
                        from_rest(power).iter().zip(&weight).map(|(x, w)| (x + rest) * w).collect();
                    nuisance.project(&mut column);
                    column
                };
                Path::Direct { powers: (1..=parts.degree as i32).map(column).collect() }
            }
            Some((rate_hz, scheme, sampling)) => {
                let initial = if periodic { InitialCondition::Periodic } else { InitialCondition::Zero };
                let plan = SimulationPlan::new(samples, rate_hz, scheme, initial)?;
                let powers = (1..=parts.degree as i32)
                    .map(|power| plan.transform(&from_rest(power)))
                    .collect::<Result<_, _>>()?;
                let inputs = parts.transients.then(|| transient_inputs(samples));
                let transients =
                    inputs.iter().flatten().map(|x| plan.transform(x)).collect::<Result<_, _>>()?;
                Path::Plan { plan: Box::new(plan), sampling, powers, transients }
            }
        };
        let valid = weight.iter().filter(|w| **w > 0.0).count();
        Ok(Self {
            drive: parts.drive.to_vec(),
            thinning: parts.thinning,
            before: parts.before,
            weight,
            nuisance,
            target,
            valid,
            counts_rest,
            path,
        })
    }

    /// Columns of offset and drift.
    pub(super) fn local_columns(&self) -> usize {
        self.nuisance.len()
    }

    pub(super) fn samples(&self) -> usize {
        self.weight.len()
    }

    /// Scratch for `degree` powers and the tangents of `parameters` parameters of the dynamics.
    pub(super) fn workspace(&self, degree: usize, parameters: usize) -> RecordWorkspace {
        let samples = self.samples();
        let (plan, response, spectrum, transients) = match &self.path {
            Path::Direct { .. } => (None, None, None, 0),
            Path::Plan { plan, transients, .. } => (
                Some(plan.workspace()),
                Some(plan.empty_response(parameters)),
                Some(plan.empty_spectrum()),
                transients.len(),
            ),
        };
        RecordWorkspace {
            sensitivities: Sensitivities::default(),
            plan,
            response,
            zeta: spectrum.clone(),
            other: spectrum.clone(),
            total: spectrum,
            local: self.nuisance.with_capacity(self.nuisance.capacity() + transients),
            columns: vec![0.0; samples * (degree + 1)],
            target: vec![0.0; samples],
            transient_columns: vec![vec![0.0; samples]; transients],
            transient_shares: Vec::new(),
            signal: vec![0.0; samples],
        }
    }

    fn start(&self, memory: f64) -> Start {
        match self.before {
            Before::Rest { voltage_v } => Start::Rest { u: voltage_v },
            Before::Remembering => Start::State(BoucWenState { u: self.drive[0], z: memory }),
            Before::Periodic => Start::Periodic,
        }
    }

    /// Columns of the candidate into `ws.columns` and the target without transients into `ws.target`; with
    /// `derivatives`, everything that [`Self::differentiate`] needs. `false` where the candidate cannot be simulated.
    pub(super) fn respond(
        &self,
        candidate: &Candidate,
        memory: f64,
        dynamics: Option<&Linearised>,
        derivatives: Derivatives,
        ws: &mut RecordWorkspace,
    ) -> bool {
        let samples = self.samples();
        // Means need every sample of the fine drive.
        let every = if let Thinning::Pick(factor) = self.thinning { factor } else { 1 };
        let start = self.start(memory);
        let fine = &mut ws.sensitivities;
        let simulated = match derivatives {
            Derivatives::None => {
                fine.zeta.resize(self.drive.len().div_ceil(every), 0.0);
                candidate.shape.simulate_every(every, &self.drive, start, &mut fine.zeta)
            }
            Derivatives::Shape { exponent } => {
                candidate.shape.simulate_with_sensitivities(every, &self.drive, start, exponent, fine)
            }
        };
        if simulated.is_err() {
            return false;
        }
        if self.thinning == Thinning::Means {
            for x in [&mut fine.zeta, &mut fine.d_beta, &mut fine.d_gamma, &mut fine.d_n, &mut fine.d_start] {
                if !x.is_empty() {
                    polygon_of_means(x, &mut ws.signal);
                    x[..samples].copy_from_slice(&ws.signal);
                }
            }
        }
        let rest = if self.before == Before::Remembering { memory } else { 0.0 };
        ws.target.copy_from_slice(&self.target);
        ws.local.truncate(self.nuisance.len());
        match &self.path {
            Path::Direct { powers } => {
                for (column, power) in ws.columns.chunks_exact_mut(samples).zip(powers) {
                    column.copy_from_slice(power);
                }
                let at = ws.columns.len() - samples;
                let column = &mut ws.columns[at..];
                let rest = if self.counts_rest { 0.0 } else { rest };
                for ((c, z), w) in column.iter_mut().zip(&ws.sensitivities.zeta).zip(&self.weight) {
                    *c = (rest - z) * w;
                }
                self.nuisance.project(column);
                true
            }
            Path::Plan { plan, sampling, powers, transients } => {
                let (Some(plan_ws), Some(response), Some(zeta), Some(dynamics)) =
                    (&mut ws.plan, &mut ws.response, &mut ws.zeta, dynamics)
                else {
                    return false;
                };
                let responded = match derivatives {
                    Derivatives::None => {
                        plan.response(&dynamics.transfer_function, candidate.delay_s, *sampling, response)
                    }
                    Derivatives::Shape { .. } => {
                        plan.response_with_tangents(dynamics, candidate.delay_s, *sampling, response)
                    }
                };
                if responded.is_err() {
                    return false;
                }
                for (z, s) in ws.signal.iter_mut().zip(&ws.sensitivities.zeta) {
                    *z = rest - s;
                }
                if plan.transform_into(&ws.signal, plan_ws, zeta).is_err() {
                    return false;
                }
                for (column, input) in ws.transient_columns.iter_mut().zip(transients) {
                    if plan.apply(response, input, plan_ws, column).is_err() {
                        return false;
                    }
                    column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
                    ws.local.push(|q| q.copy_from_slice(column));
                }
                if !transients.is_empty() {
                    ws.local.project(&mut ws.target);
                }
                let degree = ws.columns.len() / samples - 1;
                let inputs = powers.iter().take(degree).chain([&*zeta]);
                let mut done = true;
                ws.transient_shares.clear();
                for (index, (column, input)) in ws.columns.chunks_exact_mut(samples).zip(inputs).enumerate() {
                    done &= plan.apply(response, input, plan_ws, column).is_ok();
                    if self.counts_rest {
                        let at_rest =
                            if index < degree { self.rest_v().powi(index as i32 + 1) } else { -rest };
                        column.iter_mut().for_each(|c| *c += at_rest);
                    }
                    column.iter_mut().zip(&self.weight).for_each(|(c, w)| *c *= w);
                    if !transients.is_empty() && derivatives != Derivatives::None {
                        ws.transient_shares.push(ws.local.coefficients(column));
                    }
                    ws.local.project(column);
                }
                done
            }
        }
    }

    /// Voltage before the first sample \[V\].
    fn rest_v(&self) -> f64 {
        match self.before {
            Before::Rest { voltage_v } => voltage_v,
            Before::Remembering | Before::Periodic => self.drive[0],
        }
    }

    /// Prepares derivatives along the dynamics: the whole input Σ cᵢ uⁱ − α ζ + transients at these coefficients.
    pub(super) fn combine(&self, coefficients: &[f64], ws: &mut RecordWorkspace) {
        let Path::Plan { powers, transients, .. } = &self.path else { return };
        let (Some(total), Some(zeta)) = (&mut ws.total, &ws.zeta) else { return };
        total.clear();
        let Some((alpha, polynomial)) = coefficients.split_last() else { return };
        for (c, power) in polynomial.iter().zip(powers) {
            total.add(*c, power);
        }
        total.add(*alpha, zeta);
        if !transients.is_empty() {
            // What the transients take of the measured output, beside all else.
            let measured = ws.local.coefficients(&self.target);
            for (index, transient) in transients.iter().enumerate() {
                let at = self.nuisance.len() + index;
                let taken: f64 = coefficients.iter().zip(&ws.transient_shares).map(|(c, s)| c * s[at]).sum();
                total.add(measured[at] - taken, transient);
            }
        }
    }

    /// ∂(Σ cᵢ Φᵢ + α Φ_ζ)/∂direction at fixed coefficients, weighted and without local columns, into `out`. `false`
    /// where it is zero. After [`Self::respond`] with derivatives and [`Self::combine`].
    pub(super) fn differentiate(
        &self,
        direction: Direction,
        alpha: f64,
        ws: &mut RecordWorkspace,
        out: &mut [f64],
    ) -> bool {
        let s = &ws.sensitivities;
        let source = match direction {
            Direction::Beta => &s.d_beta,
            Direction::Gamma => &s.d_gamma,
            Direction::N => &s.d_n,
            Direction::Memory => &s.d_start,
            Direction::Dynamics(_) => &s.zeta,
        };
        let rest = if direction == Direction::Memory { 1.0 } else { 0.0 };
        match (&self.path, direction) {
            (Path::Direct { .. }, Direction::Dynamics(_)) => return false,
            (Path::Direct { .. }, _) => {
                let rest = if self.counts_rest { 0.0 } else { rest };
                for (o, d) in out.iter_mut().zip(source) {
                    *o = alpha * (rest - d);
                }
            }
            (Path::Plan { plan, .. }, Direction::Dynamics(which)) => {
                let (Some(plan_ws), Some(response), Some(total)) = (&mut ws.plan, &ws.response, &ws.total)
                else {
                    return false;
                };
                if plan.apply_tangent(response, which, total, plan_ws, out).is_err() {
                    return false;
                }
            }
            (Path::Plan { plan, .. }, _) => {
                let (Some(plan_ws), Some(response), Some(other)) =
                    (&mut ws.plan, &ws.response, &mut ws.other)
                else {
                    return false;
                };
                for (o, d) in ws.signal.iter_mut().zip(source) {
                    *o = alpha * (rest - d);
                }
                if plan.transform_into(&ws.signal, plan_ws, other).is_err()
                    || plan.apply(response, other, plan_ws, out).is_err()
                {
                    return false;
                }
                if self.counts_rest {
                    out.iter_mut().for_each(|o| *o -= alpha * rest);
                }
            }
        }
        out.iter_mut().zip(&self.weight).for_each(|(o, w)| *o *= w);
        ws.local.project(out);
        true
    }
}

/// What is worked out beside the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Derivatives {
    None,
    Shape { exponent: bool },
}

/// Inputs whose responses span the motion left over from before the record: impulses at the first two samples and a step.
fn transient_inputs(samples: usize) -> [Vec<f64>; TRANSIENTS] {
    let impulse = |at: usize| (0..samples).map(|k| f64::from(u8::from(k == at))).collect();
    [impulse(0), impulse(1), vec![1.0; samples]]
}
