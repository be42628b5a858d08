//! The records of a joint fit: what came before each, how noisy it is, at what rate it is worked on.

use super::super::options::{Initial, Options};
use super::super::static_step::{self, OFFSET};
use super::super::{Engine, IdentifyError, RecordFacts};
use super::record::{Before, Ingredients, JointRecord, Thinning};
use crate::dynamics::{Sampling, Scheme};
use crate::hammerstein::{FINER, SimulationError, Start, joins_means};
use crate::hysteresis::RecordEnds;
use crate::record::{InterSample, noise_floor, quantisation_step, thinned};

/// Samples kept a swing of the drive, and in a record, when it is reduced.
const SAMPLES_A_SWING: usize = 8;
const SAMPLES_A_RECORD: usize = 2000;
/// A record without visible noise is taken to be right to this share of its stroke.
const LEAST_NOISE: f64 = 1e-6;
/// A first sample off 0 V by more than this share of the range may be a start from 0 V.
const JUMP: f64 = 0.02;

/// One record of a joint fit.
#[derive(Debug)]
pub(in super::super) struct JointMember<'a> {
    pub(in super::super) facts: &'a RecordFacts,
    pub(in super::super) before: Before,
    /// Motion left over from before the record is allowed for.
    pub(in super::super) transients: bool,
    /// Standard deviation of the output's noise \[output unit\].
    pub(in super::super) noise: f64,
    /// Every how many samples one is worked on while searching.
    pub(in super::super) factor: usize,
    /// The output at that rate.
    thinned: Vec<f64>,
    pub(in super::super) rate_hz: f64,
}

impl<'a> JointMember<'a> {
    pub(in super::super) fn new(
        facts: &'a RecordFacts,
        options: &Options,
        engine: &mut Engine<'_>,
    ) -> Result<Self, IdentifyError> {
        let rate_hz = facts.require_sample_rate()?;
        let first = facts.data.u[0];
        let (before, transients) = match options.initial {
            Initial::Rest => (Before::Remembering, false),
            Initial::Free => (Before::Remembering, true),
            Initial::Zero => (Before::Rest { voltage_v: 0.0 }, false),
            Initial::Periodic => (periodic(facts)?, false),
            Initial::Auto if first.abs() > JUMP * facts.range_v() => {
                match static_step::choose_start(facts, options, engine)? {
                    Start::Rest { voltage_v } if voltage_v != first => (Before::Rest { voltage_v }, false),
                    _ => (Before::Remembering, false),
                }
            }
            Initial::Auto => (Before::Remembering, false),
        };
        let floor = noise_floor(&facts.data, facts.periods.as_ref()).map_or(0.0, |floor| floor.rms);
        // A converter's steps are uniform noise of step/√12 that differences of a slow signal do not show.
        let step = quantisation_step(&facts.data.y).unwrap_or(0.0) / 12f64.sqrt();
        let noise = floor.max(step).max(LEAST_NOISE * facts.stroke());
        let whole = facts.scored(0).len() == facts.data.y.len();
        let factor = if whole { reduction(facts, before) } else { 1 };
        let thinned = thinned(&facts.data.y, factor);
        Ok(Self { facts, before, transients, noise, factor, thinned, rate_hz })
    }

    /// The same record, seen through `facts` with other samples valid.
    pub(in super::super) fn masked<'b>(&self, facts: &'b RecordFacts) -> JointMember<'b> {
        let Self { before, transients, noise, factor, rate_hz, .. } = *self;
        JointMember { facts, before, transients, noise, factor, thinned: self.thinned.clone(), rate_hz }
    }

    /// The record as the fit sees it. `reduced`: at its lower rate. `scale` times 1/noise is its weight.
    pub(in super::super) fn prepare(
        &self,
        reduced: bool,
        scale: f64,
        degree: usize,
        scheme: Scheme,
        options: &Options,
    ) -> Result<JointRecord, IdentifyError> {
        let factor = if reduced { self.factor } else { 1 };
        let data = &self.facts.data;
        let held = options.demands.fixed(OFFSET);
        let y = if reduced { &self.thinned } else { &data.y };
        let samples = y.len();
        let output: Vec<f64> = y.iter().map(|y| y - held.unwrap_or(0.0)).collect();
        // White noise falls with the root of the factor in the filter.
        let height = scale * (factor as f64).sqrt() / self.noise;
        let mut weight = vec![height; samples];
        if let Some(valid) = &data.valid {
            for (weight, valid) in weight.iter_mut().zip(valid.iter().step_by(factor)) {
                if !valid {
                    *weight = 0.0;
                }
            }
        }
        let mut nuisance = Vec::new();
        if options.drift {
            nuisance.push((0..samples).map(|k| k as f64 / samples as f64 - 0.5).collect());
        }
        let ends = if self.before == Before::Periodic { RecordEnds::Periodic } else { RecordEnds::Open };
        let (fine, thinning) = fine_drive(&data.u, factor, scheme, options.inter_sample, ends)?;
        let mut sampling = Sampling::of(scheme);
        if factor == 1 {
            // At a lower rate than the drive's own, the drive is as good as band-limited.
            sampling.reconstruction = options.inter_sample;
        }
        Ok(JointRecord::new(Ingredients {
            drive: fine.as_ref().unwrap_or(&data.u),
            thinning,
            output: &output,
            weight,
            before: self.before,
            transients: self.transients,
            offset_is_held: held.is_some(),
            nuisance,
            degree,
            dynamics: Some((self.rate_hz / factor as f64, scheme, sampling)),
        })?)
    }

    /// The start for the identified model; `memory`: z(0) \[output unit\].
    pub(in super::super) fn start(&self, memory: f64) -> Start {
        match self.before {
            Before::Rest { voltage_v } => Start::Rest { voltage_v },
            Before::Remembering => Start::Remembering { voltage_v: self.facts.data.u[0], z: memory },
            Before::Periodic => Start::Settled {
                period_samples: self.facts.period_samples().unwrap_or(self.facts.data.u.len()),
            },
        }
    }
}

/// The drive on the grid that the hysteresis runs over (`None`: its own), and how every `factor`-th sample follows from it.
pub(super) fn fine_drive(
    drive: &[f64],
    factor: usize,
    scheme: Scheme,
    inter_sample: InterSample,
    ends: RecordEnds,
) -> Result<(Option<Vec<f64>>, Thinning), SimulationError> {
    let means = factor == 1 && joins_means(scheme, inter_sample);
    let finer = match inter_sample {
        InterSample::BandLimited => FINER,
        _ if means => 2,
        _ => 1,
    };
    if finer > 1 {
        let fine = inter_sample.upsample(drive, finer, ends)?;
        let thinning = if means { Thinning::Means } else { Thinning::Pick(factor * finer) };
        return Ok((Some(fine), thinning));
    }
    let shorter = if factor > 1 { extremes_between(drive, factor) } else { None };
    Ok(match shorter {
        Some((drive, step)) => (Some(drive), Thinning::Pick(step)),
        None => (None, Thinning::Pick(factor)),
    })
}

/// The record must repeat from its first sample to its last.
fn periodic(facts: &RecordFacts) -> Result<Before, IdentifyError> {
    let samples = facts.data.u.len();
    match facts.period_samples() {
        Some(period) if period > 0 && samples.is_multiple_of(period) => Ok(Before::Periodic),
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

/// By how much a record can be thinned and still show every swing of its drive.
fn reduction(facts: &RecordFacts, before: Before) -> usize {
    let samples = facts.data.u.len();
    let most = (facts.shortest_swing / SAMPLES_A_SWING).min(samples / SAMPLES_A_RECORD).max(1);
    match before {
        Before::Periodic => (1..=most).rev().find(|&factor| samples.is_multiple_of(factor)).unwrap_or(1),
        _ => most,
    }
}

/// The drive at every `factor`-th sample and at its turning points between these, as many samples an interval everywhere
/// (turning points first, the last value repeated), and that number; `None` where it would not be shorter. A
/// rate-independent operator that is stepped exactly does not notice what was left out.
fn extremes_between(u: &[f64], factor: usize) -> Option<(Vec<f64>, usize)> {
    // Samples after which the drive moves the other way, a rest on the way included.
    let mut turns = vec![false; u.len()];
    let mut direction = 0.0;
    for (k, pair) in u.windows(2).enumerate() {
        let step = pair[1] - pair[0];
        if step != 0.0 {
            turns[k] = step * direction < 0.0;
            direction = step;
        }
    }
    let inside = |start: usize| (start + 1..(start + factor).min(u.len())).filter(|&k| turns[k]);
    let intervals = (0..u.len().saturating_sub(1)).step_by(factor);
    let most = intervals.clone().map(|start| inside(start).count()).max()?;
    let step = most + 1;
    if step >= factor {
        return None;
    }
    let mut drive = Vec::with_capacity(u.len().div_ceil(factor) * step);
    drive.push(u[0]);
    for start in intervals {
        let end = start + factor;
        if end >= u.len() {
            // Nothing follows the last sample that is worked on.
            break;
        }
        let before = drive.len();
        drive.extend(inside(start).map(|k| u[k]));
        drive.resize(before + most, drive.last().copied().unwrap_or(u[0]));
        drive.push(u[end]);
    }
    Some((drive, step))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::{Start, UnitShape};

    #[test]
    fn what_lies_on_the_way_can_be_left_out_of_a_drive() {
        // Its peaks are cut off flat.
        let u: Vec<f64> = (0..1003)
            .map(|k| ((0.031 * f64::from(k)).sin() * (4.0 - 0.003 * f64::from(k))).min(3.1))
            .collect();
        for factor in [4, 7, 10] {
            let (drive, step) = extremes_between(&u, factor).unwrap();
            assert_eq!(step, 2, "one turning point an interval at most");
            for n in [1.0, 1.6, 2.0] {
                let shape = UnitShape { beta: 0.4, gamma: 0.1, n };
                let samples = u.len().div_ceil(factor);
                let (mut all, mut few) = (vec![0.0; samples], vec![0.0; samples]);
                shape.simulate_every(factor, &u, Start::Rest { u: -1.0 }, &mut all).unwrap();
                shape.simulate_every(step, &drive, Start::Rest { u: -1.0 }, &mut few).unwrap();
                let worst = all.iter().zip(&few).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
                assert!(worst < 1e-12, "{factor} {n}: {worst:e}");
            }
        }
        let rough: Vec<f64> = (0..100).map(|k| f64::from(k % 2)).collect();
        assert!(extremes_between(&rough, 5).is_none());
    }
}
