//! Search box of a joint fit.

use super::super::dynamic_step::{LONGEST_DELAY_PERIODS, LONGEST_DELAY_SAMPLES};
use super::super::layout::{BoxBuilder, Role};
use super::super::options::{Choice, DynamicsChoice, Options};
use super::super::static_step::{HIGHEST_AUTOMATIC_DEGREE, Scales};
use super::super::{IdentifyError, RecordFacts, fingerprint};
use super::campaign::{JointMember, Rate};
use super::parameter_layout::{DELAY, JointLayout};
use super::problem::{JointProblem, SpareWorkspaces};
use super::record::JointRecord;
use super::resonances::{Resonance, resonances};
use hysteron_model::Start;
use hysteron_model::dynamics::{DynamicForm, FormParameter, Modes, ParameterKind, Scheme};
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::model_file::polynomial_name;
use hysteron_optimize::{Bounds, Problem, Range, Stop};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Longest delay searched after a fit ended at the upper bound of the first search, as a share of the fastest
/// period in the data.
const FAR_DELAY_PERIODS: f64 = 1.6;

/// Normalisation frequency of the dynamics' coefficients, over the fastest frequency of the drive.
pub(super) const NORMALISATION: f64 = 2.0;

/// Order of a resonance with a lag: the dynamics where they are not asked for.
pub(in super::super) const RESONANCE_AND_LAG: usize = 3;
const WHOLE: Modes = Modes::Integer { order: RESONANCE_AND_LAG };

/// Data and options from which a joint problem of any degree is built.
#[derive(Clone)]
pub(in super::super) struct JointSetup<'a> {
    pub(in super::super) members: &'a [JointMember<'a>],
    pub(in super::super) scales: Scales,
    pub(in super::super) hysteresis: HysteresisForm,
    pub(in super::super) form: DynamicForm,
    pub(in super::super) options: &'a Options,
    pub(in super::super) fastest_hz: f64,
    pub(in super::super) rate_hz: f64,
    /// Largest half-width of a play; `None`: the largest that the drives may move.
    pub(super) reach: Option<f64>,
    /// Longest delay searched \[s\].
    longest_delay_s: f64,
    /// Records of each rate, prepared when first needed.
    prepared: Arc<[Mutex<Option<Prepared>>; 3]>,
    /// Computed when first needed.
    resonances: Arc<OnceLock<Vec<Resonance>>>,
    /// After a stop, starts are no longer compared.
    pub(super) stop: Stop,
}

/// Prepared records, independent of the held parameters.
#[derive(Clone)]
struct Prepared {
    /// Highest polynomial degree prepared.
    degree: usize,
    records: Arc<[JointRecord]>,
    spare: SpareWorkspaces,
    fingerprint: u64,
}

/// Name of the memory of a record in the search.
pub(in super::super) fn memory_name(record: usize) -> String {
    format!("memory_{}", record + 1)
}

impl<'a> JointSetup<'a> {
    pub(in super::super) fn new(
        members: &'a [JointMember<'a>],
        form: DynamicForm,
        options: &'a Options,
    ) -> Self {
        let facts: Vec<&RecordFacts> = members.iter().map(|member| member.facts).collect();
        let fastest_hz = facts.iter().map(|f| f.highest_frequency_hz()).fold(0.0, f64::max);
        let rate_hz = members.iter().map(|m| m.rate_hz).fold(0.0, f64::max);
        Self {
            scales: Scales::of(&facts),
            hysteresis: options.searched_family(),
            form,
            options,
            fastest_hz,
            rate_hz,
            longest_delay_s: (LONGEST_DELAY_SAMPLES / rate_hz).max(LONGEST_DELAY_PERIODS / fastest_hz),
            members,
            reach: None,
            prepared: Arc::default(),
            resonances: Arc::default(),
            stop: Stop::new(),
        }
    }

    /// This setup with `stop` as its stop signal.
    pub(in super::super) fn stopped_by(self, stop: &Stop) -> Self {
        Self { stop: stop.clone(), ..self }
    }

    /// The options.
    pub(super) fn options(&self) -> &'a Options {
        self.options
    }

    /// This setup with records prepared anew under other options.
    pub(super) fn anew<'b>(&self, options: &'b Options) -> JointSetup<'b>
    where
        'a: 'b,
    {
        JointSetup {
            longest_delay_s: self.longest_delay_s,
            reach: self.reach,
            ..JointSetup::new(self.members, self.form, options).stopped_by(&self.stop)
        }
    }

    /// True if the orders of the dynamics are chosen from the records, and are whole ones as yet.
    pub(super) fn chooses_orders(&self) -> bool {
        self.options.dynamics == DynamicsChoice::Auto
            && self.form.modes == WHOLE
            && !demands(self.options, &[ParameterKind::Lag])
    }

    /// This setup with longer delays, where a fit ended at the upper bound of the delay; else `None`.
    pub(super) fn with_longer_delays(&self, problem: &JointProblem, x: &[f64]) -> Option<JointSetup<'a>> {
        let asked = self.options.demands.names().any(|name| name == DELAY);
        let mut ranges = problem.bounds().ranges.iter().zip(x);
        let at_end = ranges.any(|(range, &x)| range.name == DELAY && range.is_upper_end(x));
        let longer = FAR_DELAY_PERIODS / self.fastest_hz;
        let widen = at_end && !asked && longer > self.longest_delay_s;
        widen.then(|| JointSetup { longest_delay_s: longer, ..self.clone() })
    }

    /// This setup with other half-widths of plays, up to this share of the largest that the drives may move;
    /// `None` where that is below half of their range.
    pub(super) fn with_reach(&self, share: f64) -> Option<Self> {
        let reach = share * self.farthest();
        (reach >= 0.499 * self.scales.range_v).then(|| Self { reach: Some(reach), ..self.clone() })
    }

    /// True if a record is so far oversampled that the fit of all samples too is of a thinned one.
    pub(super) fn is_thinned(&self) -> bool {
        self.members.iter().any(|member| member.factor_at(Rate::Own) > 1)
    }

    /// True if uniformly sampled records have fewer than `samples` samples per cycle of the fastest drive and
    /// the model has dynamics.
    pub(super) fn samples_coarsely(&self, samples: f64) -> bool {
        let even = self.members.iter().all(|m| m.facts.data.sample_rate_hz().is_some());
        !self.form.parameters().is_empty() && even && self.rate_hz < samples * self.fastest_hz
    }

    /// This setup with another form of the dynamics, or other parameters held.
    pub(super) fn with<'b>(&self, form: DynamicForm, options: &'b Options) -> JointSetup<'b>
    where
        'a: 'b,
    {
        JointSetup { form, options, ..self.clone() }
    }

    /// The problem of this polynomial degree, on records of this rate.
    pub(in super::super) fn problem(&self, degree: usize, rate: Rate) -> Result<JointProblem, IdentifyError> {
        let (layout, bounds) = self.layout(degree);
        let Prepared { records, spare, fingerprint, .. } = self.prepared(degree, rate)?;
        let identity = format!(
            "joint {degree} {rate:?} {:?} {:?} {layout:?} {:?} {fingerprint:x}",
            self.hysteresis,
            self.form,
            self.options.scheme(),
        );
        let problem = JointProblem::new(records, (self.hysteresis, self.form), layout, bounds, identity);
        let problem = problem.normalised_at(NORMALISATION * self.fastest_hz).stopped_by(&self.stop);
        let problem = problem.sharing(&spare);
        Ok(problem.keeping_memory(rate == Rate::Coarse))
    }

    fn prepared(&self, degree: usize, rate: Rate) -> Result<Prepared, IdentifyError> {
        let mut kept = self.prepared[rate as usize].lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(prepared) = kept.as_ref().filter(|prepared| prepared.degree >= degree) {
            return Ok(prepared.clone());
        }
        let degree = match self.options.degree {
            Choice::Given(given) => degree.max(given),
            Choice::Auto => degree.max(HIGHEST_AUTOMATIC_DEGREE),
        };
        // Scaled such that the cost is the RMSE in the output's unit where all records are equally noisy.
        let (mut information, mut samples) = (0.0, 0);
        for member in self.members {
            information += member.facts.scored(0).len() as f64 / (member.noise * member.noise);
            samples += member.facts.data.u.len().div_ceil(member.factor_at(rate));
        }
        let scale = (samples as f64 / information).sqrt();
        let records = self
            .members
            .par_iter()
            .map(|member| member.prepare(rate, scale, degree, (self.options, &self.stop)))
            .collect::<Result<Vec<_>, _>>()?;
        let values = self
            .members
            .iter()
            .flat_map(|m| m.facts.data.u.iter().chain(&m.facts.data.y).map(|x| x.to_bits()));
        let (records, spare) = (records.into(), SpareWorkspaces::default());
        let prepared = Prepared { degree, records, spare, fingerprint: fingerprint(values) };
        *kept = Some(prepared.clone());
        Ok(prepared)
    }

    fn layout(&self, degree: usize) -> (JointLayout, Bounds) {
        let Scales { largest_v, slope, .. } = self.scales;
        let demands = &self.options.demands;
        let mut space = BoxBuilder::new(demands);
        let polynomial = (1..=degree)
            .map(|power| {
                let unit = slope.abs() / largest_v.powi(power as i32 - 1);
                space.projected(Range::linear(&polynomial_name(power), -4.0 * unit, 4.0 * unit))
            })
            .collect();
        let (weights, shape) = self.family(&mut space);
        // Without a hysteretic part there is no memory.
        let hysteretic = weights.iter().any(|weight| *weight != Role::Fixed(0.0));
        let form =
            self.form.parameters().iter().map(|parameter| space.searched(self.range(parameter))).collect();
        let delay = match self.options.delay_s {
            Choice::Given(delay) => Role::Fixed(delay),
            Choice::Auto => space.searched(Range::linear(DELAY, 0.0, self.longest_delay_s)),
        };
        let memory = self
            .members
            .iter()
            .enumerate()
            .map(|(index, member)| match member.before {
                Start::Remembering { .. } if hysteretic => {
                    let (low, high) = self.memory_range(index);
                    space.searched(Range::linear(&memory_name(index), low, high))
                }
                _ => Role::Fixed(0.0),
            })
            .collect();
        let layout = JointLayout { polynomial, weights, shape, form, delay, memory };
        (layout, space.finish())
    }

    /// Resonances measured in the records, for a form with several pairs of poles.
    pub(super) fn resonances(&self) -> &[Resonance] {
        match pairs(&self.form) {
            0 | 1 => &[],
            count => self.resonances.get_or_init(|| resonances(self.members, count)),
        }
    }

    /// Search range of a parameter of the dynamics.
    fn range(&self, parameter: &FormParameter) -> Range {
        // The flank of a resonance determines it even well above the fastest drive.
        let low = (0.5 * self.fastest_hz).min(0.05 * self.rate_hz);
        // Several resonances are determined only within the excited band.
        let (low, lightest) = if pairs(&self.form) > 1 { (0.02 * low, 5e-4) } else { (low, 0.005) };
        let high = (20.0 * self.fastest_hz).min(0.45 * self.rate_hz);
        // Creep is slower than the fastest drive and faster than the longest record (else drift).
        let longest = self.members.iter().map(JointMember::duration_s).fold(0.0, f64::max);
        let fastest_creep = 1.0 / (TAU * self.fastest_hz);
        let linear = |low, high| Range::linear(parameter.name, low, high);
        let logarithmic = |low, high| Range::logarithmic(parameter.name, low, high);
        match parameter.kind {
            ParameterKind::NaturalFrequency(_) => logarithmic(low, high),
            ParameterKind::Damping(_) => logarithmic(lightest, 20.0),
            ParameterKind::HighestOrder(_) => linear(1.2, 2.6),
            ParameterKind::MiddleOrder(_) => linear(0.02, 1.6),
            ParameterKind::LowestOrder => linear(0.0, 0.5),
            // A mode may be in antiphase with the others.
            ParameterKind::Share(_) if matches!(self.form.modes, Modes::Resonances { .. }) => {
                linear(-1.0, 2.0)
            }
            ParameterKind::Share(_) => linear(0.0, 1.0),
            ParameterKind::Lag => logarithmic(0.02 / self.rate_hz, 3.0 / self.fastest_hz),
            ParameterKind::CreepSize => logarithmic(1e-4, 1.0),
            ParameterKind::CreepOrder => linear(0.01, 0.6),
            ParameterKind::CreepPerDecade => logarithmic(1e-5, 0.3),
            // The chain spans five decades.
            ParameterKind::CreepStart => logarithmic((0.5 / self.rate_hz).max(1e-5 * longest), 0.3 * longest),
            ParameterKind::CreepShare(_) => linear(0.0, 1.0),
            ParameterKind::CreepTime(_) => logarithmic(fastest_creep.min(0.1 * longest), 3.0 * longest),
        }
    }
}

/// Pairs of integer-order poles.
fn pairs(form: &DynamicForm) -> usize {
    match form.modes {
        Modes::Integer { order } => order / 2,
        Modes::Resonances { count, .. } => count,
        _ => 0,
    }
}

/// The dynamics that the user asked for, or what the records support.
pub(in super::super) fn form(options: &Options) -> DynamicForm {
    let modes = match options.dynamics {
        DynamicsChoice::None => Modes::None,
        DynamicsChoice::Integer => Modes::Integer { order: options.order },
        DynamicsChoice::Modes => Modes::Resonances { count: options.order / 2, lag: options.order % 2 == 1 },
        DynamicsChoice::FractionalFreeLowest => Modes::FractionalFreeLowest,
        DynamicsChoice::TwoFractional => Modes::TwoFractional,
        DynamicsChoice::Auto if begins_with_whole_orders(options) => WHOLE,
        _ => Modes::Fractional,
    };
    DynamicForm { modes, creep: options.creep }
}

/// True if the search begins with a resonance and a lag: no fractional order was asked for, and neither a method of
/// the search nor a model to start from.
fn begins_with_whole_orders(options: &Options) -> bool {
    let orders = [ParameterKind::HighestOrder(1), ParameterKind::MiddleOrder(1)];
    options.algorithm.is_none() && options.start.is_none() && !demands(options, &orders)
}

/// True if a parameter of the dynamics of one of these kinds is held or bounded.
fn demands(options: &Options, kinds: &[ParameterKind]) -> bool {
    let is_one = |name: &str| DynamicForm::parameter_named(name).is_some_and(|own| kinds.contains(&own.kind));
    options.demands.names().any(is_one)
}

/// The scheme that the user asked for, or what the records support.
pub(in super::super) fn scheme(options: &Options, members: &[JointMember<'_>]) -> Scheme {
    match options.scheme {
        Choice::Given(scheme) => scheme,
        // A jump is not band-limited.
        Choice::Auto if members.iter().any(|m| matches!(m.before, Start::Rest { .. })) => Scheme::Tustin,
        Choice::Auto => Scheme::BandLimited,
    }
}
