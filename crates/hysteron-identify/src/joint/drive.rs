//! Drive grid for the hysteresis, and resampling of its output to the record's rate.

use super::record::Clock;
use hysteron_model::dynamics::{Knots, Scheme};
use hysteron_model::hammerstein::{FINER, SETTLING_PERIODS, SimulationError, joins_means, times_before};
use hysteron_model::hysteresis::{RecordEnds, polygon_of_means};
use hysteron_model::record::{Dependence, InterSample, Timing, even_times};

/// Resampling from the fine drive to the record's rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Thinning {
    /// Decimation by this factor.
    Pick(usize),
    /// The drive is twice as fine: samples preserve the mean of the curve between them
    /// ([`polygon_of_means`]).
    Means,
}

impl Thinning {
    /// Decimation factor of the operator's output on the fine drive.
    pub(super) fn every(self) -> usize {
        match self {
            Self::Pick(factor) => factor,
            // Means need every one.
            Self::Means => 1,
        }
    }

    /// Oversampling factor of the fine drive.
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

    /// Resamples a signal on the fine grid to the record's rate.
    pub(super) fn apply(self, fine: &[f64], out: &mut [f64]) {
        match self {
            Self::Pick(factor) => {
                out.iter_mut().zip(fine.iter().step_by(factor)).for_each(|(o, x)| *o = *x);
            }
            Self::Means => polygon_of_means(fine, out),
        }
    }
}

/// A drive on the grid on which the hysteresis is simulated.
pub(super) struct TimedDrive {
    /// The fine drive; `None`: its own samples.
    pub(super) fine: Option<Vec<f64>>,
    pub(super) thinning: Thinning,
    pub(super) clock: Clock,
}

impl TimedDrive {
    /// A drive on time stamps, with its history `before` the first sample, which has no output.
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

    /// The drive `u` at the samples of `timing`; `averaged`: dynamics after the hysteresis respond to its
    /// means; `depends_on`: dependence of the hysteresis.
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
                let Knots { times: knots, drive_v, paces } =
                    Knots::new(&outputs_s, u, inter_sample, depends_on);
                // Without dynamics a sample is read from the polygon itself.
                let knots = if averaged { knots } else { knots.times_s.into() };
                let held = inter_sample == InterSample::Hold;
                let clock = Clock::Stamps { knots, paces, outputs_s, held };
                Ok(Self { fine: Some(drive_v), thinning: Thinning::Pick(1), clock })
            }
        }
    }
}

/// Times and values of the drive before a record whose first `period` samples repeat (a settled start), at
/// the samples `rows` of every period.
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

/// The drive on the grid for the hysteresis (`None`: its own), and the resampling from there.
pub(super) fn fine_drive(
    drive: &[f64],
    (scheme, averaged): (Scheme, bool),
    inter_sample: InterSample,
    ends: RecordEnds,
) -> Result<(Option<Vec<f64>>, Thinning), SimulationError> {
    let (finer, thinning) = if joins_means(scheme, inter_sample) {
        // Also without averaging: a family's limits on the drive are checked between samples too.
        (2, if averaged { Thinning::Means } else { Thinning::Pick(2) })
    } else if inter_sample == InterSample::BandLimited {
        (FINER, Thinning::Pick(FINER))
    } else {
        return Ok((None, Thinning::Pick(1)));
    };
    Ok((Some(inter_sample.upsample(drive, finer, ends)?), thinning))
}
