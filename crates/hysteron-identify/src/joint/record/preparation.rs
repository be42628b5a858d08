//! Quantities computed once per record: its weights, the columns of offset and drift, and u, u², … as inputs
//! of the dynamics.

use super::super::super::IdentifyError;
use super::super::super::projection::Projection;
use super::super::drive::Thinning;
use super::super::reduction::Reduction;
use super::super::weighting::Weighting;
use super::{InputsAndOutput, JointRecord, Spare, rest_voltage};
use hysteron_model::Start;
use hysteron_model::dynamics::{
    KnotTimes, PlanInput, RecordPlan, Sampling, Scheme, SimulationPlan, StampedPlan,
};
use hysteron_model::hysteresis::DriveGrid;
use hysteron_model::record::Pace;
use hysteron_optimize::Stop;

/// When the samples of a record were taken.
pub(crate) enum Clock {
    /// At this rate \[Hz\].
    Rate(f64),
    /// At these times \[s\]; the drive is given at separate knots, with zero-order hold or linear
    /// interpolation between them.
    Stamps {
        knots: KnotTimes,
        /// Rate and duration of the move to each knot, where the hysteresis depends on either.
        paces: Option<Vec<Pace>>,
        outputs_s: Vec<f64>,
        held: bool,
    },
}

/// Data of a joint record, all of it at the record's own rate, but for a drive of which samples are left out.
pub(crate) struct Ingredients<'a> {
    /// Drive, which may be on a finer grid.
    pub(crate) drive: &'a [f64],
    pub(crate) thinning: Thinning,
    /// Decimation factor of the inputs.
    pub(crate) factor: usize,
    /// Samples of the output for one of the drive.
    pub(crate) every: usize,
    /// Measured output, less a held offset.
    pub(crate) output: Vec<f64>,
    /// Weight of each sample.
    pub(crate) weighting: Weighting,
    pub(crate) before: Start<()>,
    /// A free transient from before the record is fitted.
    pub(crate) transients: bool,
    pub(crate) offset_is_held: bool,
    /// Further nuisance columns (drift).
    pub(crate) nuisance: Vec<Vec<f64>>,
    /// Cycles in the record; 1 where it has none.
    pub(crate) cycles: usize,
    /// Highest polynomial degree needed.
    pub(crate) degree: usize,
    pub(crate) clock: Clock,
    pub(crate) scheme: Scheme,
    pub(crate) sampling: Sampling,
}

impl JointRecord {
    /// Computes the spectra of all inputs, which takes seconds for millions of samples.
    ///
    /// # Errors
    /// [`IdentifyError::Dynamics`]; [`IdentifyError::Stopped`] where `stop` is requested while it computes them.
    pub(crate) fn new(parts: Ingredients<'_>, stop: &Stop) -> Result<Self, IdentifyError> {
        let periodic = parts.before == Start::PERIODIC;
        let count = parts.output.len();
        // Samples of the inputs before reduction.
        let inputs = match &parts.clock {
            Clock::Rate(_) => count.div_ceil(parts.every),
            Clock::Stamps { knots, .. } => knots.times_s.len(),
        };
        debug_assert_eq!(inputs, parts.thinning.samples(parts.drive.len()));
        // Without a reduction of the inputs those of the output would differ by the low-pass.
        debug_assert!(parts.every == 1 || parts.factor > 1);
        let reduction = (parts.factor > 1).then(|| InputsAndOutput {
            inputs: Reduction::new(parts.factor, inputs, periodic),
            output: Reduction::new(parts.factor * parts.every, count, periodic),
        });
        let output = |x: Vec<f64>| match &reduction {
            None => x,
            Some(reduction) => {
                let mut out = vec![0.0; reduction.output.rows()];
                reduction.output.output(&x, &mut out);
                out
            }
        };
        let weighting = match &reduction {
            None => parts.weighting,
            Some(reduction) => reduction.output.weights(&parts.weighting.weight).into(),
        };
        let samples = weighting.weight.len();
        let weighted = |mut x: Vec<f64>| {
            weighting.apply(&mut x);
            x
        };
        let unit = output(vec![1.0; count]);
        let mut nuisance = Projection::new(samples, 1 + parts.nuisance.len());
        if !parts.offset_is_held {
            nuisance.push(|column| column.copy_from_slice(&weighted(unit.clone())));
        }
        for extra in parts.nuisance {
            nuisance.push(|column| column.copy_from_slice(&weighted(output(extra))));
        }
        let mut target = weighted(output(parts.output));
        nuisance.project(&mut target);

        let initial = if periodic { Start::PERIODIC } else { Start::ZERO };
        let (finer, every) = (parts.thinning.finer(), parts.thinning.every());
        let (plan, grid, paces) = match parts.clock {
            Clock::Rate(own_hz) => {
                let rate_hz = own_hz / parts.factor as f64;
                let plan = SimulationPlan::new(samples, rate_hz, parts.scheme, initial)?;
                let plan = plan.of_thinned_inputs(parts.factor);
                (RecordPlan::Uniform(Box::new(plan)), DriveGrid::new(Some(own_hz), finer, every), None)
            }
            Clock::Stamps { knots, paces, outputs_s, held } => {
                let plan = StampedPlan::new(knots, outputs_s, held)?;
                (RecordPlan::Stamped(Box::new(plan)), DriveGrid::from(every), paces)
            }
        };
        let rest_v = rest_voltage(parts.before, parts.drive);
        // Buffers of all inputs: new ones for each take as long as what is computed in them.
        let mut workspace = plan.workspace();
        let (mut fine, mut own) = (vec![0.0; parts.drive.len()], vec![0.0; inputs]);
        let mut rows = vec![0.0; reduction.as_ref().map_or(0, |reduction| reduction.inputs.rows())];
        let mut prepared = |own: &[f64]| {
            if stop.is_requested() {
                return Err(IdentifyError::Stopped);
            }
            let mut prepared = PlanInput::none();
            let input = match &reduction {
                None => own,
                Some(reduction) => {
                    reduction.inputs.input(own, 0.0, &mut rows);
                    &rows
                }
            };
            plan.prepare_into(input, &mut workspace, &mut prepared)?;
            Ok(prepared)
        };
        let mut powers = Vec::with_capacity(parts.degree);
        for power in 1..=parts.degree as i32 {
            let rest = if periodic { 0.0 } else { rest_v.powi(power) };
            fine.iter_mut().zip(parts.drive).for_each(|(x, u)| *x = u.powi(power) - rest);
            parts.thinning.apply(&fine, &mut own);
            powers.push(prepared(&own)?);
        }
        let mut transients = Vec::new();
        if parts.transients {
            // Impulses at the first two samples, and a step: their responses span the free transient.
            for at in [0, 1] {
                own.fill(0.0);
                own.iter_mut().skip(at).take(1).for_each(|x| *x = 1.0);
                transients.push(prepared(&own)?);
            }
            own.fill(1.0);
            transients.push(prepared(&own)?);
        }
        let valid = weighting.weight.iter().filter(|w| **w > 0.0).count();
        Ok(Self {
            drive: parts.drive.to_vec(),
            grid,
            paces,
            thinning: parts.thinning,
            before: parts.before,
            cycles: parts.cycles,
            nuisance,
            target,
            valid,
            rest: (parts.offset_is_held && !periodic).then_some(unit),
            sampling: parts.sampling,
            powers,
            transients,
            plan,
            weighting,
            reduction,
            spare: Spare::default(),
        })
    }
}
