//! The drive as the hysteresis runs over it, and how the samples at its own rate follow from what that puts
//! out.

use super::record::Clock;
use hysteron_model::dynamics::{Knots, Scheme};
use hysteron_model::hammerstein::{FINER, SETTLING_PERIODS, SimulationError, joins_means, times_before};
use hysteron_model::hysteresis::{RecordEnds, polygon_of_means};
use hysteron_model::record::{Dependence, InterSample, Timing, even_times};

/// Rule that takes the samples at the record's own rate from those of the fine drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Thinning {
    /// Every so many samples.
    Pick(usize),
    /// The drive is twice as fine: each sample allows for the mean of the curve beside it
    /// ([`polygon_of_means`]).
    Means,
}

impl Thinning {
    /// Every how many samples of the fine drive the operator puts one out.
    pub(super) fn every(self) -> usize {
        match self {
            Self::Pick(factor) => factor,
            // Means need every one.
            Self::Means => 1,
        }
    }

    /// By how much the fine drive is finer than the record.
    pub(super) fn finer(self) -> usize {
        match self {
            Self::Pick(factor) => factor,
            Self::Means => 2,
        }
    }

    /// Samples at the record's rate.
    pub(super) fn samples(self, drive: usize) -> usize {
        match self {
            Self::Pick(factor) => drive.div_ceil(factor),
            Self::Means => drive.div_ceil(2),
        }
    }

    /// A function of the fine drive at the record's rate.
    pub(super) fn apply(self, fine: &[f64], out: &mut [f64]) {
        match self {
            Self::Pick(factor) => {
                out.iter_mut().zip(fine.iter().step_by(factor)).for_each(|(o, x)| *o = *x);
            }
            Self::Means => polygon_of_means(fine, out),
        }
    }
}

/// A drive as the hysteresis runs over it.
pub(super) struct TimedDrive {
    /// The drive where that is not on its own samples.
    pub(super) fine: Option<Vec<f64>>,
    pub(super) thinning: Thinning,
    pub(super) clock: Clock,
}

impl TimedDrive {
    /// A drive on time stamps, and what it did `before` its first sample, of which there is no output.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub(super) fn on_stamps(
        before: (Vec<f64>, Vec<f64>),
        (times_s, u): (&[f64], &[f64]),
        (scheme, averaged): (Scheme, bool),
        inter_sample: InterSample,
        depends_on: Dependence,
    ) -> Result<Self, SimulationError> {
        let (mut knots_s, mut drive) = before;
        let count = knots_s.len();
        knots_s.extend_from_slice(times_s);
        drive.extend_from_slice(u);
        let timing = Timing::Stamps(&knots_s);
        let mut timed =
            Self::new((&drive, RecordEnds::Open), timing, (scheme, averaged), inter_sample, depends_on)?;
        if let Clock::Stamps { outputs_s, .. } = &mut timed.clock {
            outputs_s.drain(..count);
        }
        Ok(timed)
    }

    /// The drive `u` sampled as `timing` says; `averaged`: dynamics behind the hysteresis see its means;
    /// `depends_on`: what the hysteresis does.
    ///
    /// # Errors
    /// [`SimulationError::NoSampleRate`] where that is unknown; a drive that cannot be interpolated.
    pub(super) fn new(
        (u, ends): (&[f64], RecordEnds),
        timing: Timing<'_>,
        (scheme, averaged): (Scheme, bool),
        inter_sample: InterSample,
        depends_on: Dependence,
    ) -> Result<Self, SimulationError> {
        match timing {
            Timing::Unknown => Err(SimulationError::NoSampleRate),
            Timing::Rate(sample_rate_hz) => {
                let (fine, thinning) = fine_drive(u, (scheme, averaged), inter_sample, ends)?;
                Ok(Self { fine, thinning, clock: Clock::Rate(sample_rate_hz) })
            }
            Timing::Stamps(times_s) => {
                let outputs_s = even_times(times_s);
                let Knots { times_s: knots_s, drive_v, paces } =
                    Knots::new(&outputs_s, u, inter_sample, depends_on);
                let held = inter_sample == InterSample::Hold;
                let clock = Clock::Stamps { knots_s, paces, outputs_s, held };
                Ok(Self { fine: Some(drive_v), thinning: Thinning::Pick(1), clock })
            }
        }
    }
}

/// Times and values of the drive before a record whose first `period` samples repeat (a settled start): in
/// every period those of `rows`.
pub(super) fn cycles_before(
    times_s: &[f64],
    u: &[f64],
    period: usize,
    rows: impl Iterator<Item = usize> + Clone,
) -> (Vec<f64>, Vec<f64>) {
    let rows = rows.filter(|k| *k < period);
    let drive = (0..SETTLING_PERIODS).flat_map(|_| rows.clone().map(|k| u[k])).collect();
    (times_before(times_s, period, rows).collect(), drive)
}

/// The drive on the grid that the hysteresis runs over (`None`: its own), and how its samples follow from
/// that.
pub(super) fn fine_drive(
    drive: &[f64],
    (scheme, averaged): (Scheme, bool),
    inter_sample: InterSample,
    ends: RecordEnds,
) -> Result<(Option<Vec<f64>>, Thinning), SimulationError> {
    let (finer, thinning) = if joins_means(scheme, inter_sample) {
        // Without averaging too: a family's limits on the drive are checked between the samples as well.
        (2, if averaged { Thinning::Means } else { Thinning::Pick(2) })
    } else if inter_sample == InterSample::BandLimited {
        (FINER, Thinning::Pick(FINER))
    } else {
        return Ok((None, Thinning::Pick(1)));
    };
    Ok((Some(inter_sample.upsample(drive, finer, ends)?), thinning))
}
