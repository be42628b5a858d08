//! Step 2, the dynamic block: transfer function from the hysteresis output to the measured displacement
//! (article §4.3, step 2), orders and coefficients at once, as a least-squares problem.
//!
//! y = offset + K · (G₁ ∗ v)(t − τ),  G₁(s) = c₀ / (s^α₂ + c₁ s^α₁ + c₀): the structure of Eq. 13 with b = K
//! c₀, searched as gain K, natural frequency, damping and orders ([`SecondOrder`]). The integer-order model
//! is the same with α₂ = 2, α₁ = 1.

use super::layout::Role;
use super::projection::{Projection, centre};
use hysteron_model::Start;
use hysteron_model::dynamics::{
    DynamicsError, InputSpectrum, Response, Sampling, Scheme, SecondOrder, SimulationPlan, Term,
    TransferFunction, Workspace as PlanWorkspace,
};
use hysteron_model::record::InterSample;
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, root_mean_square};

/// Orders closer than this are one term, whose coefficients are not identifiable separately.
const SMALLEST_ORDER_GAP: f64 = 0.02;

/// One record prepared for the dynamic step.
#[derive(Debug)]
pub(super) struct DynamicRecord {
    /// Where the offset is held: the hysteresis output at rest \[µm\]; `None`: an offset is eliminated.
    rest_beside_held_offset: Option<f64>,
    prologue: usize,
    output: Vec<f64>,
    scored: Vec<usize>,
    plan: SimulationPlan,
    sampling: Sampling,
    spectrum: InputSpectrum,
}

impl DynamicRecord {
    /// `v`: hysteresis output over prologue and record, having rested at `rest`. `offset_is_held`: the known
    /// offset is subtracted from `output`, and none is eliminated.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn new(
        v: &[f64],
        rest: f64,
        prologue: usize,
        output: Vec<f64>,
        scored: Vec<usize>,
        sample_rate_hz: f64,
        scheme: Scheme,
        inter_sample: InterSample,
        offset_is_held: bool,
    ) -> Result<Self, DynamicsError> {
        let moved: Vec<f64> = v.iter().map(|v| v - rest).collect();
        let plan = SimulationPlan::new(moved.len(), sample_rate_hz, scheme, Start::ZERO)?;
        let spectrum = plan.transform(&moved)?;
        let rest_beside_held_offset = offset_is_held.then_some(rest);
        let sampling = Sampling { reconstruction: inter_sample, ..Sampling::of(scheme) };
        Ok(Self { rest_beside_held_offset, prologue, output, scored, plan, sampling, spectrum })
    }
}

/// Roles of the parameters of the dynamic step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DynamicLayout {
    pub(super) gain: Role,
    pub(super) natural_frequency_hz: Role,
    pub(super) damping: Role,
    /// α₂.
    pub(super) high_order: Role,
    /// α₁.
    pub(super) low_order: Role,
    pub(super) delay: Role,
}

/// Values of all parameters of the dynamic step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DynamicSolution {
    /// Gain, natural frequency, damping, orders.
    pub(super) form: SecondOrder,
    pub(super) delay_s: f64,
}

impl DynamicSolution {
    /// The transfer function in the article's form (Eq. 13).
    pub(super) fn transfer_function(&self) -> TransferFunction {
        let mut g = blank();
        // A solution of the search has been simulated, so its form is valid.
        let valid = self.form.write_to(&mut g);
        debug_assert!(valid.is_ok());
        g
    }
}

/// The dynamic step as a problem for [`hysteron_optimize`].
#[derive(Debug)]
pub(super) struct DynamicProblem {
    records: Vec<DynamicRecord>,
    layout: DynamicLayout,
    bounds: Bounds,
    identity: String,
    /// Scored outputs of all records, each less its mean, which eliminates its offset, unless that is held.
    target: Vec<f64>,
}

/// Scratch of one evaluation.
#[derive(Debug)]
pub(super) struct DynamicWorkspace {
    plans: Vec<(PlanWorkspace, Response)>,
    simulated: Vec<f64>,
    column: Vec<f64>,
    target: Vec<f64>,
    projection: Projection,
    unit_gain: TransferFunction,
}

fn blank() -> TransferFunction {
    let term = |order| Term { coefficient: 1.0, order };
    TransferFunction { numerator: vec![term(0.0)], denominator: vec![term(0.0), term(1.0), term(2.0)] }
}

impl DynamicProblem {
    pub(super) fn new(
        records: Vec<DynamicRecord>,
        layout: DynamicLayout,
        bounds: Bounds,
        identity: String,
    ) -> Self {
        let mut target = Vec::with_capacity(records.iter().map(|r| r.scored.len()).sum());
        for record in &records {
            let at = target.len();
            target.extend(record.scored.iter().map(|&k| record.output[k]));
            if record.rest_beside_held_offset.is_none() {
                centre(&mut target[at..]);
            }
        }
        Self { records, layout, bounds, identity, target }
    }

    /// The candidate, with gain 1 where the gain is projected out.
    pub(super) fn candidate(&self, x: &[f64]) -> Option<DynamicSolution> {
        let l = &self.layout;
        let form = SecondOrder {
            gain: l.gain.value(x).unwrap_or(1.0),
            natural_frequency_hz: l.natural_frequency_hz.value(x)?,
            damping: l.damping.value(x)?,
            alpha2: l.high_order.value(x)?,
            alpha1: l.low_order.value(x)?,
            alpha0: 0.0,
        };
        let delay_s = l.delay.value(x)?;
        (form.alpha2 - form.alpha1 >= SMALLEST_ORDER_GAP).then_some(DynamicSolution { form, delay_s })
    }

    /// Unit-gain response, less its mean on each record whose offset is eliminated, into `ws.column`.
    fn respond(&self, candidate: &DynamicSolution, ws: &mut DynamicWorkspace) -> bool {
        let unit = SecondOrder { gain: 1.0, ..candidate.form };
        if unit.write_to(&mut ws.unit_gain).is_err() {
            return false;
        }
        let mut at = 0;
        for (record, (plan_ws, response)) in self.records.iter().zip(&mut ws.plans) {
            let simulated = &mut ws.simulated[..record.plan.samples()];
            let done = record
                .plan
                .response(&ws.unit_gain, candidate.delay_s, record.sampling, response)
                .and_then(|()| record.plan.apply(response, &record.spectrum, plan_ws, simulated));
            if done.is_err() {
                return false;
            }
            let column = &mut ws.column[at..at + record.scored.len()];
            for (c, &k) in column.iter_mut().zip(&record.scored) {
                *c = simulated[record.prologue + k];
            }
            match record.rest_beside_held_offset {
                Some(rest) => column.iter_mut().for_each(|c| *c += rest),
                None => centre(column),
            }
            at += record.scored.len();
        }
        true
    }

    fn eliminate(&self, x: &[f64], ws: &mut DynamicWorkspace) -> bool {
        let Some(candidate) = self.candidate(x) else { return false };
        if !self.respond(&candidate, ws) {
            return false;
        }
        let DynamicWorkspace { column, target, projection, .. } = ws;
        match self.layout.gain.value(x) {
            Some(gain) => {
                for ((r, t), c) in target.iter_mut().zip(&self.target).zip(column.iter()) {
                    *r = t - gain * c;
                }
            }
            None => {
                projection.clear();
                projection.push(|q| q.copy_from_slice(column));
                target.copy_from_slice(&self.target);
                projection.project(target);
            }
        }
        true
    }

    /// All parameter values at the candidate `x`, a projected gain by linear least squares.
    pub(super) fn solve(&self, x: &[f64]) -> Option<DynamicSolution> {
        let mut ws = self.workspace();
        let mut candidate = self.candidate(x)?;
        if self.layout.gain == Role::Projected {
            if !self.respond(&candidate, &mut ws) {
                return None;
            }
            ws.projection.push(|q| q.copy_from_slice(&ws.column));
            candidate.form.gain = *ws.projection.coefficients(&self.target).first()?;
        }
        Some(candidate)
    }
}

impl Problem for DynamicProblem {
    type Workspace = DynamicWorkspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> DynamicWorkspace {
        let longest = self.records.iter().map(|r| r.plan.samples()).max().unwrap_or(0);
        DynamicWorkspace {
            plans: self.records.iter().map(|r| (r.plan.workspace(), r.plan.empty_response(0))).collect(),
            simulated: vec![0.0; longest],
            column: vec![0.0; self.target.len()],
            target: vec![0.0; self.target.len()],
            projection: Projection::new(self.target.len(), 1),
            unit_gain: blank(),
        }
    }

    fn cost(&self, x: &[f64], ws: &mut DynamicWorkspace) -> f64 {
        if self.eliminate(x, ws) { root_mean_square(&ws.target) } else { f64::INFINITY }
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

impl LeastSquaresProblem for DynamicProblem {
    fn residual_count(&self) -> usize {
        self.target.len()
    }

    fn residuals(&self, x: &[f64], ws: &mut DynamicWorkspace, out: &mut [f64]) -> bool {
        let done = self.eliminate(x, ws);
        out.copy_from_slice(&ws.target);
        done
    }
}
