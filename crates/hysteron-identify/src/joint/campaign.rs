//! The records of a joint fit: initial state, noise level and decimation of each.

use super::super::options::{Choice, Initial, Options};
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
use hysteron_optimize::Stop;

/// Least samples kept by reduction, per swing of the drive and per record: while the start is searched, which
/// three harmonics of the drive determine; afterwards, seven harmonics being in the pass band; and of a long
/// record in the fit of all samples, with forty harmonics.
const COARSE: Least = Least { a_swing: 4, a_record: 700 };
const FINE: Least = Least { a_swing: 12, a_record: 2000 };
const WHOLE: Least = Least { a_swing: 60, a_record: 100_000 };
/// Largest departure of the drive from straight lines between the samples that the hysteresis takes of it, as a
/// share of its range: of a reduced record, and in the fit of all samples.
const STRAIGHT_IF_REDUCED: f64 = 1e-4;
const STRAIGHT: f64 = 1e-5;
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
    /// That of the record; of a long one that is far oversampled the lowest that loses nothing.
    Own,
}

/// Thinning of a record.
#[derive(Clone, Copy, Debug)]
struct Thin {
    /// Decimation factor.
    factor: usize,
    /// Samples of which the drive takes one: the operators take every sample of it. A divisor of the factor.
    every: usize,
}

impl Thin {
    /// Every sample.
    const NOT: Self = Self { factor: 1, every: 1 };
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
    /// The coarse record, of which the output too takes one of `every` samples before it is reduced; the
    /// reduced one; and that of all samples.
    thin: [Thin; 3],
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
        let [fine, coarse] = [factor(&FINE), factor(&COARSE)];
        let thin = |factor, most, share| match uneven {
            true => Thin { factor, every: 1 },
            false => taking(factor, before, |every| {
                // A staircase of fewer steps would be another drive.
                every <= most
                    && options.inter_sample() != InterSample::Hold
                    && is_straight(facts, every, share)
            }),
        };
        let thin = [
            if fine > 1 { thin(coarse, fine, f64::INFINITY) } else { Thin::NOT },
            thin(fine, fine / 2, STRAIGHT_IF_REDUCED),
            // Other schemes are those of the record's own rate.
            match options.scheme {
                Choice::Auto | Choice::Given(Scheme::BandLimited) if !uneven => {
                    let factor = factor(&WHOLE);
                    thin(factor, factor / 2, STRAIGHT)
                }
                _ => Thin::NOT,
            },
        ];
        Ok(Self { facts, before, transients, noise, thin, rate_hz })
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
    pub(in super::super) fn factor_at(&self, rate: Rate) -> usize {
        self.thin[rate as usize].factor
    }

    /// The record prepared for the fit at a rate. `scale` times 1/noise is its weight.
    pub(in super::super) fn prepare(
        &self,
        rate: Rate,
        scale: f64,
        degree: usize,
        (options, stop): (&Options, &Stop),
    ) -> Result<JointRecord, IdentifyError> {
        let Thin { factor, every } = self.thin[rate as usize];
        let (timing, _) = self.facts.require_timing()?;
        if matches!(timing, Timing::Stamps(_)) {
            return self.prepare_stamps(factor > 1, scale, degree, (options, stop));
        }
        // A reduced record is band-limited, independently of the scheme.
        let scheme = if factor > 1 { Scheme::BandLimited } else { options.scheme() };
        let picked = if rate == Rate::Coarse { every } else { 1 };
        let timing = Timing::Rate(self.rate_hz / every as f64);
        let data = &self.facts.data;
        let drive: Vec<f64> = data.u.iter().step_by(every).copied().collect();
        let held = options.demands.fixed(OFFSET);
        let output: Vec<f64> = data.y.iter().step_by(picked).map(|y| y - held.unwrap_or(0.0)).collect();
        let samples = output.len();
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
        let parts = Ingredients {
            drive: fine.as_ref().unwrap_or(&drive),
            thinning,
            factor: factor / every,
            every: every / picked,
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
        };
        JointRecord::new(parts, stop)
    }

    /// [`Self::prepare`] for a non-uniformly sampled record. `thin`: only samples that resolve every swing.
    fn prepare_stamps(
        &self,
        thin: bool,
        scale: f64,
        degree: usize,
        (options, stop): (&Options, &Stop),
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
        let parts = Ingredients {
            drive: fine.as_ref().unwrap_or(&drive),
            thinning,
            factor: 1,
            every: 1,
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
        };
        JointRecord::new(parts, stop)
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

/// A decimation factor of at most `most`, 1 or more, and the most samples of which the drive may take one.
fn taking(most: usize, before: Start<()>, may_be: impl Fn(usize) -> bool) -> Thin {
    let is_periodic = matches!(before, Start::Settled { .. });
    let mut every = most;
    while every > 1 && !((!is_periodic || most.is_multiple_of(every)) && may_be(every)) {
        // A longer way down takes longer than it saves.
        every = if is_periodic || every < 8 { every - 1 } else { every * 7 / 8 };
    }
    Thin { factor: most / every * every, every }
}

/// True if the drive departs from straight lines between every so many samples by no more than this share of its
/// range; behind the last of them from their continuation.
fn is_straight(facts: &RecordFacts, every: usize, share: f64) -> bool {
    let (u, most) = (&facts.data.u, share * facts.range_v());
    let starts = (0..u.len()).step_by(every);
    let slope = |from: usize| match (u.get(from + every), from.checked_sub(every)) {
        (Some(to), _) => (to - u[from]) / every as f64,
        (None, Some(before)) => (u[from] - u[before]) / every as f64,
        (None, None) => 0.0,
    };
    most.is_infinite()
        || starts.map(|from| (from, slope(from))).all(|(from, slope)| {
            let next = &u[from..u.len().min(from + every)];
            next.iter().enumerate().all(|(k, x)| (x - u[from] - k as f64 * slope).abs() <= most)
        })
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

#[cfg(test)]
mod tests;
