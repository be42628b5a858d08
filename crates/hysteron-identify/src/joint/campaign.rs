//! The records of a joint fit: initial state, noise level and decimation of each.

use super::super::options::{Initial, Options};
use super::super::static_step::{self, OFFSET};
use super::super::{Engine, IdentifyError, RecordFacts};
use super::drive::{TimedDrive, cycles_before};
use super::record::{Ingredients, JointRecord};
use super::weighting::{Weighting, by_swing, thinned};
use hysteron_model::Start;
use hysteron_model::dynamics::{Sampling, Scheme};
use hysteron_model::hysteresis::{Hysteresis, RecordEnds};
use hysteron_model::record::{Dependence, InterSample, Timing, noise_floor, quantisation_step};
use hysteron_model::validate::{first_cycle, unfollowed_start};

/// Least samples kept by reduction, per swing of the drive and per record: while the start is searched, which
/// three harmonics of the drive determine, and afterwards, seven harmonics being in the pass band.
const COARSE: Least = Least { a_swing: 4, a_record: 700 };
const FINE: Least = Least { a_swing: 12, a_record: 2000 };
/// Least noise assumed, as a share of the stroke.
const LEAST_NOISE: f64 = 1e-6;
/// Weight of the first of several cycles, with unknown history, relative to the others.
pub(in super::super) const UNKNOWN_PAST: f64 = 0.01;
/// A first sample off 0 V by more than this share of the range may be a step from 0 V.
const JUMP: f64 = 0.02;

/// Least samples.
struct Least {
    a_swing: usize,
    a_record: usize,
}

/// Rate at which the records are fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Rate {
    /// The lowest, for the search from many starts.
    Coarse,
    /// The lowest at which the optimum is nearly that of all samples.
    Reduced,
    /// That of the record.
    Own,
}

/// One record of a joint fit.
#[derive(Debug)]
pub(in super::super) struct JointMember<'a> {
    pub(in super::super) facts: &'a RecordFacts,
    pub(in super::super) before: Start<()>,
    /// A free transient from before the record is fitted.
    pub(in super::super) transients: bool,
    /// Standard deviation of the output's noise \[output unit\].
    pub(in super::super) noise: f64,
    /// Decimation factor of the reduced record, and of the coarse one.
    pub(in super::super) factor: usize,
    coarse_factor: usize,
    /// Samples of which the coarse record takes one before it is reduced, so that its drive, of which every
    /// operator takes every sample, is as long as a reduced record.
    picked: usize,
    pub(in super::super) rate_hz: f64,
}

impl<'a> JointMember<'a> {
    pub(super) fn duration_s(&self) -> f64 {
        self.facts.duration_s()
    }

    pub(in super::super) fn new(
        facts: &'a RecordFacts,
        options: &Options,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Self, IdentifyError> {
        let (timing, rate_hz) = facts.require_timing()?;
        let uneven = matches!(timing, Timing::Stamps(_));
        let first = facts.data.u[0];
        let remembering = Start::Remembering { voltage_v: first, memory: () };
        let (before, transients) = match options.initial {
            Initial::Rest => (remembering, false),
            Initial::Free => (remembering, true),
            Initial::Zero => (Start::Rest { voltage_v: 0.0 }, false),
            Initial::Periodic if uneven => match first_cycle(&facts.data) {
                Some(period) => (Start::settled(period), false),
                None => {
                    return Err(IdentifyError::NotPeriodic {
                        record: facts.data.name.clone(),
                        found: "its time stamps are not uniform, and the drive does not come back to where \
                                it began"
                            .into(),
                    });
                }
            },
            Initial::Periodic => (periodic(facts)?, false),
            // The unknown history of the first of several cycles does not justify a parameter: fitting a
            // memory to it biases the other parameters.
            Initial::Auto if facts.first_of_several_cycles().is_some() => {
                (Start::Rest { voltage_v: first }, false)
            }
            // Non-uniform stamps come from a logger that was already running: the drive did not step to its
            // first sample.
            Initial::Auto if !uneven && first.abs() > JUMP * facts.range_v() => {
                match static_step::choose_start(facts, options, engine)? {
                    Start::Rest { voltage_v } if voltage_v != first => (Start::Rest { voltage_v }, false),
                    _ => (remembering, false),
                }
            }
            Initial::Auto => (remembering, false),
        };
        let floor = noise_floor(&facts.data, facts.periods.as_ref()).map_or(0.0, |floor| floor.rms);
        // Quantisation is uniform noise of step/√12, which differences of a slow signal do not show.
        let step = quantisation_step(&facts.data.y).unwrap_or(0.0) / 12f64.sqrt();
        let noise = floor.max(step).max(LEAST_NOISE * facts.stroke());
        let whole = facts.scored(0).len() == facts.data.y.len();
        let factor = |least| match timing {
            // A rate-dependent family needs the rate of the drive between all samples: no thinning.
            Timing::Stamps(_) if options.family().depends_on() == Dependence::Rate => 1,
            Timing::Stamps(_) => facts.data.len() / thinned(&facts.data).len().max(1),
            _ if whole => reduction(facts, before, least),
            _ => 1,
        };
        let [factor, coarse_factor] = [factor(&FINE), factor(&COARSE)];
        let coarse_factor = if factor > 1 { coarse_factor } else { 1 };
        // A staircase of fewer steps would be another drive.
        let is_picked = !uneven && options.inter_sample() != InterSample::Hold;
        let divides = |every: &usize| is_picked && coarse_factor.is_multiple_of(*every);
        let picked = (1..=factor.min(coarse_factor)).rev().find(divides).unwrap_or(1);
        Ok(Self { facts, before, transients, noise, factor, coarse_factor, picked, rate_hz })
    }

    /// Number of initial samples that a model without dynamics cannot follow.
    pub(super) fn unfollowed(&self) -> usize {
        match self.before {
            Start::Rest { voltage_v } => unfollowed_start(&self.facts.data, &Start::Rest { voltage_v }),
            _ => 0,
        }
    }

    /// This record with the valid samples of `facts`.
    pub(in super::super) fn masked<'b>(&self, facts: &'b RecordFacts) -> JointMember<'b> {
        JointMember { facts, ..*self }
    }

    /// Decimation factor.
    pub(super) fn factor_at(&self, rate: Rate) -> usize {
        match rate {
            Rate::Coarse => self.coarse_factor,
            Rate::Reduced => self.factor,
            Rate::Own => 1,
        }
    }

    /// The record prepared for the fit at a rate. `scale` times 1/noise is its weight.
    pub(in super::super) fn prepare(
        &self,
        rate: Rate,
        scale: f64,
        degree: usize,
        options: &Options,
    ) -> Result<JointRecord, IdentifyError> {
        let factor = self.factor_at(rate);
        let (timing, _) = self.facts.require_timing()?;
        if matches!(timing, Timing::Stamps(_)) {
            return self.prepare_stamps(factor > 1, scale, degree, options);
        }
        // A reduced record is band-limited, independently of the scheme.
        let scheme = if factor > 1 { Scheme::BandLimited } else { options.scheme() };
        let picked = if rate == Rate::Coarse { self.picked } else { 1 };
        let (factor, timing) = (factor / picked, Timing::Rate(self.rate_hz / picked as f64));
        let every = |x: &[f64]| x.iter().step_by(picked).copied().collect::<Vec<f64>>();
        let data = &self.facts.data;
        let drive = every(&data.u);
        let samples = drive.len();
        let held = options.demands.fixed(OFFSET);
        let output: Vec<f64> = every(&data.y).into_iter().map(|y| y - held.unwrap_or(0.0)).collect();
        let mut weighting = Weighting::from(vec![scale / self.noise; samples]);
        let valid: Option<Vec<bool>> =
            data.valid.as_ref().map(|valid| valid.iter().step_by(picked).copied().collect());
        weighting.mask(valid.as_deref());
        let mut nuisance = Vec::new();
        if options.drift {
            nuisance.push((0..samples).map(|k| k as f64 / samples as f64 - 0.5).collect());
        }
        let ends = if self.before == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
        let TimedDrive { fine, thinning, clock } = TimedDrive::new(
            (&drive, ends),
            timing,
            (scheme, is_averaged(options)),
            options.inter_sample(),
            Dependence::Order,
        )?;
        Ok(JointRecord::new(Ingredients {
            drive: fine.as_ref().unwrap_or(&drive),
            thinning,
            factor,
            output,
            weighting,
            before: self.before,
            transients: self.transients,
            offset_is_held: held.is_some(),
            nuisance,
            cycles: 1,
            degree,
            clock,
            scheme,
            sampling: Sampling { reconstruction: options.inter_sample(), ..Sampling::of(scheme) },
        })?)
    }

    /// [`Self::prepare`] for a non-uniformly sampled record. `thin`: only samples that resolve every swing.
    fn prepare_stamps(
        &self,
        thin: bool,
        scale: f64,
        degree: usize,
        options: &Options,
    ) -> Result<JointRecord, IdentifyError> {
        let data = &self.facts.data;
        let depends_on = options.family().depends_on();
        let kept = if thin { thinned(data) } else { (0..data.len()).collect() };
        let pick = |x: &[f64]| -> Vec<f64> { kept.iter().map(|&k| x[k]).collect() };
        let times_s = data.time.times_s(data.len()).unwrap_or_default();
        let held = options.demands.fixed(OFFSET);
        let mut weighting = by_swing(data, scale / self.noise, self.noise, self.facts.stroke());
        weighting.mask(data.valid.as_deref());
        // Memory and creep from before the record are unknown: the error they cause must not be attributed to
        // the device.
        if let Some(cycle) = self.facts.first_of_several_cycles()
            && !matches!(self.before, Start::Settled { .. })
        {
            weighting.weight[..cycle].iter_mut().for_each(|weight| *weight *= UNKNOWN_PAST);
        }
        if thin {
            weighting = weighting.of_rows(&kept);
        }
        let first = times_s.first().copied().unwrap_or(0.0);
        let duration = self.facts.duration_s();
        let drift = || kept.iter().map(|&k| (times_s[k] - first) / duration - 0.5).collect();
        let (before, cycles) = match self.before {
            // Samples that resolve every swing suffice for the history, unless the operator depends on time.
            Start::Settled { period_samples: Some(period), .. } => {
                let every = depends_on != Dependence::Order;
                let rows = if every { (0..data.len()).collect() } else { thinned(data) };
                let cycles = cycles_before(&times_s, &data.u, period, rows.iter().copied());
                (Start::Rest { voltage_v: data.u[0] }, cycles)
            }
            other => (other, Default::default()),
        };
        let drive = pick(&data.u);
        let scheme = options.scheme();
        let TimedDrive { fine, thinning, clock } = TimedDrive::on_stamps(
            cycles,
            (&pick(&times_s), &drive),
            (scheme, is_averaged(options)),
            options.inter_sample(),
            depends_on,
        )?;
        Ok(JointRecord::new(Ingredients {
            drive: fine.as_ref().unwrap_or(&drive),
            thinning,
            factor: 1,
            output: pick(&data.y).into_iter().map(|y| y - held.unwrap_or(0.0)).collect(),
            weighting,
            before,
            transients: self.transients,
            offset_is_held: held.is_some(),
            nuisance: if options.drift { vec![drift()] } else { Vec::new() },
            cycles: self.facts.cycles(),
            degree,
            clock,
            scheme,
            sampling: Sampling { reconstruction: options.inter_sample(), ..Sampling::of(scheme) },
        })?)
    }

    /// The first start tried for an unknown memory.
    pub(in super::super) fn fresh_start(&self) -> Start {
        match self.before {
            Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => Start::Rest { voltage_v },
            Start::AsIdentified => Start::Rest { voltage_v: self.facts.data.u[0] },
            Start::Settled { period_samples: Some(_), .. } => Start::Rest { voltage_v: self.facts.data.u[0] },
            Start::Settled { period_samples: None, .. } => self.settled(),
        }
    }

    fn settled(&self) -> Start {
        Start::settled(self.facts.period_samples().unwrap_or(self.facts.data.u.len()))
    }

    /// The start for the identified model; `memory` as it is searched \[V\].
    pub(in super::super) fn start(&self, hysteresis: &Hysteresis, memory: f64) -> Start {
        match self.before {
            Start::AsIdentified => Start::AsIdentified,
            Start::Rest { voltage_v } => Start::Rest { voltage_v },
            Start::Remembering { voltage_v, .. } => {
                let own = hysteresis.form().own_memory(memory, hysteresis.weights());
                Start::Remembering { voltage_v, memory: hysteresis.memory(own) }
            }
            Start::Settled { period_samples: Some(period), .. } => Start::settled(period),
            Start::Settled { period_samples: None, .. } => self.settled(),
        }
    }
}

/// The record must repeat from its first sample to its last.
fn periodic(facts: &RecordFacts) -> Result<Start<()>, IdentifyError> {
    let samples = facts.data.u.len();
    match facts.period_samples() {
        Some(period) if period > 0 && samples.is_multiple_of(period) => Ok(Start::PERIODIC),
        Some(period) => Err(IdentifyError::NotPeriodic {
            record: facts.data.name.clone(),
            found: format!("{samples} samples are not a whole number of its periods of {period} samples"),
        }),
        None => Err(IdentifyError::NotPeriodic {
            record: facts.data.name.clone(),
            found: "the drive does not repeat from its first sample on".into(),
        }),
    }
}

/// True if dynamics after the hysteresis average its output between samples.
fn is_averaged(options: &Options) -> bool {
    !super::setup::form(options).parameters().is_empty()
}

/// Largest decimation factor that resolves every swing of the drive. An initial step is not band-limited, and
/// the first samples determine its response.
fn reduction(facts: &RecordFacts, before: Start<()>, least: &Least) -> usize {
    let samples = facts.data.u.len();
    let most = (facts.shortest_swing / least.a_swing).min(samples / least.a_record).max(1);
    match before {
        Start::Rest { voltage_v } if voltage_v != facts.data.u[0] => 1,
        Start::Settled { .. } => (1..=most).rev().find(|&factor| samples.is_multiple_of(factor)).unwrap_or(1),
        Start::AsIdentified | Start::Rest { .. } | Start::Remembering { .. } => most,
    }
}
