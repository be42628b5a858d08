//! The Hammerstein model: hysteresis block followed by the dynamic block (article Fig. 3).
//!
//! y(t) = offset + (G ∗ v)(t − delay), v = hysteresis\[u\] (`docs/theory/hammerstein.md`). A delay commutes
//! with rate-independent hysteresis, so it is applied to v: band-limited under the `band-limited` scheme,
//! else by linear interpolation. Where G(0) is infinite (creep), creep from before the record counts as
//! offset, and the static gain of G as 1.
//!
//! On time stamps that are not uniform every step is exact ([`StampedPlan`]), whatever the scheme; the drive
//! is linear between them, or held.

use crate::Memory;
use crate::dynamics::delay::delay_in_place;
use crate::dynamics::{
    Dynamics, Knots, Readings, Sampling, Scheme, SimulationPlan, StampedPlan, StampedWorkspace,
};
use crate::dynamics_error::check_length;
use crate::hysteresis::{DriveGrid, Hysteresis, RecordEnds, polygon_of_means};
use crate::record::{Dependence, InterSample, Pace, Timing, even_times, paces_on};
pub use crate::simulation_error::SimulationError;
use crate::start::Start;
use hysteron_numeric::Complex64;
use std::borrow::Cow;

/// A Hammerstein model: all that is needed to predict a displacement from a drive voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Static block.
    pub hysteresis: Hysteresis,
    /// Dynamic block.
    pub dynamics: Dynamics,
    /// Output offset \[µm\].
    pub offset: f64,
    /// Pure delay \[s\].
    pub delay_s: f64,
    /// Simulation scheme the dynamic block was identified with.
    pub scheme: Scheme,
    /// Inter-sample behaviour of the drive.
    pub inter_sample: InterSample,
    /// Sample rate the model was identified at \[Hz\]; `None` for a static model of a record without one.
    pub sample_rate_hz: Option<f64>,
}

/// Periods simulated before a record that starts [`Start::Settled`]: memory that fades does so as e^(−path
/// length/length of saturation).
pub const SETTLING_PERIODS: usize = 4;

/// Hysteresis steps per sample period under a band-limited drive: a turning point between samples is missed
/// by less than (π/2/8)²/2 = 2 % of the amplitude at half the sample rate, falling as the square of the
/// frequency.
pub const FINER: usize = 8;

/// True if the hysteresis output is approximated by a polygon that preserves its means: for a piecewise
/// linear drive and a scheme that implies no inter-sample rule.
#[doc(hidden)]
pub fn joins_means(scheme: Scheme, inter_sample: InterSample) -> bool {
    scheme == Scheme::BandLimited && inter_sample == InterSample::Linear
}

/// Drive with its prologue, the number of prologue samples, and the voltage before the prologue.
#[doc(hidden)]
pub fn extend<'a>(start: &Start, u: &'a [f64]) -> Result<(Cow<'a, [f64]>, usize, f64), SimulationError> {
    match *start {
        Start::AsIdentified => Ok((Cow::Borrowed(u), 0, u.first().copied().unwrap_or(0.0))),
        Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => {
            Ok((Cow::Borrowed(u), 0, voltage_v))
        }
        Start::Settled { period_samples, .. } => {
            let period_samples = period_samples.unwrap_or(u.len());
            let period = u.get(..period_samples).filter(|_| period_samples >= 2);
            let Some(period) = period else {
                return Err(SimulationError::Period { samples: u.len(), period_samples });
            };
            let mut extended = period.repeat(SETTLING_PERIODS);
            let prologue = extended.len();
            extended.extend_from_slice(u);
            Ok((Cow::Owned(extended), prologue, period[0]))
        }
    }
}

impl Model {
    /// Response of the dynamic block with its delay at frequencies \[Hz\]: G(iω) e^(−iωτ); a static model is
    /// its delay.
    ///
    /// # Errors
    /// [`SimulationError::NoSampleRate`] for an ARX block without its rate.
    pub fn frequency_response(&self, frequency_hz: &[f64]) -> Result<Vec<Complex64>, SimulationError> {
        Ok(match &self.dynamics {
            Dynamics::None => {
                let turned = |f: &f64| Complex64::from_polar(1.0, -std::f64::consts::TAU * f * self.delay_s);
                frequency_hz.iter().map(turned).collect()
            }
            Dynamics::Integer(g) | Dynamics::Fractional(g) => {
                g.frequency_response(frequency_hz, self.delay_s)
            }
            Dynamics::Arx(arx) => {
                let rate = self.sample_rate_hz.ok_or(SimulationError::NoSampleRate)?;
                arx.frequency_response(frequency_hz, rate)?
            }
        })
    }

    /// Simulates the model (infinite horizon: no measured output is used) over the drive `u` \[V\].
    ///
    /// # Errors
    /// [`SimulationError`]: no or another sample rate where one is needed, an operator that blows up, a
    /// dynamic block that cannot be simulated by the model's scheme.
    pub fn simulate<'a>(
        &self,
        u: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
    ) -> Result<Vec<f64>, SimulationError> {
        let timing = timing.into();
        if let Timing::Stamps(times_s) = timing
            && !(self.dynamics == Dynamics::None && self.delay_s == 0.0)
        {
            return self.simulate_on_stamps(u, times_s, start);
        }
        let sample_rate_hz = timing.sample_rate_hz();
        let (mut v, prologue, rest) = self.simulate_hysteresis_extended(u, timing, start)?;
        self.check_sample_rate(sample_rate_hz)?;
        if let (Some(rate), Dynamics::None | Dynamics::Arx(_)) = (sample_rate_hz, &self.dynamics) {
            delay_in_place(&mut v, self.delay_s * rate, rest);
        }
        let mut y = self.simulate_dynamics(v, rest, sample_rate_hz)?;
        y.drain(..prologue);
        y.iter_mut().for_each(|y| *y += self.offset);
        Ok(y)
    }

    /// [`Self::simulate`] for a model that belongs to one sample rate (an ARX block, the `grunwald-letnikov`
    /// scheme) over a drive of another rate: the drive is resampled to the model's rate and the output to the
    /// record's, both by linear interpolation. Valid for a drive that is slow against both rates. Other
    /// models are simulated directly.
    ///
    /// # Errors
    /// Those of [`Self::simulate`] except [`SimulationError::SampleRate`].
    pub fn simulate_at_own_rate<'a>(
        &self,
        u: &[f64],
        timing: impl Into<Timing<'a>>,
        start: &Start,
    ) -> Result<Vec<f64>, SimulationError> {
        let timing = timing.into();
        let (model_hz, record_hz) = match self.check_sample_rate(timing.sample_rate_hz()) {
            Err(SimulationError::SampleRate { model_hz, record_hz, .. }) => (model_hz, record_hz),
            _ => return self.simulate(u, timing, start),
        };
        let ratio = record_hz / model_hz;
        let samples = ((u.len().max(1) - 1) as f64 / ratio).ceil() as usize + 1;
        let drive: Vec<f64> = (0..samples).map(|k| between(u, k as f64 * ratio)).collect();
        let start = match *start {
            Start::Settled { period_samples: Some(samples), .. } => {
                Start::settled((samples as f64 / ratio).round() as usize)
            }
            rest => rest,
        };
        let y = self.simulate(&drive, Some(model_hz), &start)?;
        Ok((0..u.len()).map(|k| between(&y, k as f64 / ratio)).collect())
    }

    /// [`Self::simulate`] on time stamps \[s\].
    fn simulate_on_stamps(
        &self,
        u: &[f64],
        times_s: &[f64],
        start: &Start,
    ) -> Result<Vec<f64>, SimulationError> {
        check_length("time stamps", times_s.len(), u.len())?;
        let (extended, prologue, rest_voltage_v) = extend(start, u)?;
        let times_s = with_prologue(even_times(times_s), prologue);
        let scored = times_s.get(prologue..).unwrap_or_default();
        let depends_on = self.hysteresis.form().depends_on();
        let (memory, origin) = self.origin(start, rest_voltage_v)?;
        let rest = self.hysteresis.at_rest(rest_voltage_v, memory);
        let run = |drive_v: &[f64], paces: Option<&[Pace]>| {
            let mut v = vec![0.0; drive_v.len()];
            let grid = DriveGrid { paces, ..DriveGrid::from(1) };
            self.hysteresis.simulate_every(grid, drive_v, origin, &mut v).map(|_| v)
        };
        let knots = || Knots::new(&times_s, &extended, self.inter_sample, depends_on);
        let g = match &self.dynamics {
            Dynamics::None => {
                // Where the drive speeds up, hysteresis that depends on time is not exact over long moves.
                let dense = (depends_on == Dependence::Time).then(knots);
                let (knots_s, drive_v) = dense.as_ref().map_or((&times_s[..], &extended[..]), |knots| {
                    (&knots.times.times_s[..], &knots.drive_v[..])
                });
                let read_s = scored.iter().map(|time| time - self.delay_s);
                let readings = Readings::new(knots_s, drive_v, self.inter_sample, depends_on, read_s);
                let v = run(&readings.drive_v, readings.paces.as_deref())?;
                return Ok(readings.of(&v, rest).map(|v| v + self.offset).collect());
            }
            Dynamics::Arx(_) => return Err(SimulationError::NoSampleRate),
            Dynamics::Integer(g) | Dynamics::Fractional(g) => g,
        };
        if self.scheme.parameters_belong_to_sample_rate() {
            return Err(SimulationError::NoSampleRate);
        }
        let knots = knots();
        let mut v = run(&knots.drive_v, knots.paces.as_deref())?;
        v.iter_mut().for_each(|v| *v -= rest);
        let plan = StampedPlan::new(knots.times, scored.to_vec(), self.inter_sample == InterSample::Hold)?;
        let mut response = plan.empty_response();
        plan.response(g, None, self.delay_s, &mut response)?;
        let mut y = vec![0.0; plan.samples()];
        plan.apply(&response, &v, &mut StampedWorkspace::default(), &mut y)?;
        let level = self.gain_at_rest() * rest + self.offset;
        y.iter_mut().for_each(|y| *y += level);
        Ok(y)
    }

    /// Memory before the first sample in the operator's scale, and the operator's start.
    fn origin(
        &self,
        start: &Start,
        rest_voltage_v: f64,
    ) -> Result<(Option<f64>, Start<f64>), SimulationError> {
        Ok(match *start {
            Start::Remembering { voltage_v, memory } => {
                let memory = self.hysteresis.own_memory(memory)?;
                (Some(memory), Start::Remembering { voltage_v, memory })
            }
            Start::Settled { virgin_at_v: Some(virgin), .. } => {
                let memory = self.hysteresis.own_memory(Memory::VirginAt(virgin))?;
                (Some(memory), Start::Remembering { voltage_v: rest_voltage_v, memory })
            }
            // The extended drive contains the motion before the record.
            _ => (None, Start::Rest { voltage_v: rest_voltage_v }),
        })
    }

    /// Output v of the static block \[µm\], before delay and dynamics. Rate-dependent hysteresis uses
    /// `timing`.
    ///
    /// # Errors
    /// [`SimulationError::Hysteresis`], [`SimulationError::Period`].
    pub fn simulate_hysteresis(
        &self,
        u: &[f64],
        timing: Timing<'_>,
        start: &Start,
    ) -> Result<Vec<f64>, SimulationError> {
        let (mut v, prologue, _) = self.simulate_hysteresis_extended(u, timing, start)?;
        v.drain(..prologue);
        Ok(v)
    }

    fn simulate_hysteresis_extended(
        &self,
        u: &[f64],
        timing: Timing<'_>,
        start: &Start,
    ) -> Result<(Vec<f64>, usize, f64), SimulationError> {
        let grid = |finer, factor| DriveGrid::new(timing.sample_rate_hz(), finer, factor);
        let (extended, prologue, rest_voltage_v) = extend(start, u)?;
        // On time stamps the steps differ in duration.
        let times_s = match timing {
            Timing::Stamps(times_s) => {
                check_length("time stamps", times_s.len(), u.len())?;
                Some(with_prologue(even_times(times_s), prologue))
            }
            Timing::Unknown | Timing::Rate(_) => None,
        };
        let mut v = vec![0.0; extended.len()];
        let operator = &self.hysteresis;
        let (memory, origin) = self.origin(start, rest_voltage_v)?;
        let filtered = matches!(self.dynamics, Dynamics::Integer(_) | Dynamics::Fractional(_));
        if extended.len() > 1 && filtered && joins_means(self.scheme, self.inter_sample) {
            let drive = self.inter_sample.upsample(&extended, 2, RecordEnds::Open)?;
            let mut fine = vec![0.0; drive.len()];
            operator.simulate_every(grid(2, 1), &drive, origin, &mut fine)?;
            polygon_of_means(&fine, &mut v);
        } else if self.inter_sample == InterSample::BandLimited && extended.len() > 1 {
            let fine = self.inter_sample.upsample(&extended, FINER, RecordEnds::Open)?;
            // Time is interpolated linearly between samples.
            let even = |times_s: Vec<f64>| InterSample::Linear.upsample(&times_s, FINER, RecordEnds::Open);
            let paces = times_s.map(even).transpose()?.map(|times_s| paces_on(&times_s, &fine));
            let grid = DriveGrid { paces: paces.as_deref(), ..grid(FINER, FINER) };
            operator.simulate_every(grid, &fine, origin, &mut v)?;
        } else {
            let paces = times_s.map(|times_s| paces_on(&times_s, &extended));
            let grid = DriveGrid { paces: paces.as_deref(), ..grid(1, 1) };
            operator.simulate_every(grid, &extended, origin, &mut v)?;
        }
        Ok((v, prologue, operator.at_rest(rest_voltage_v, memory)))
    }

    #[doc(hidden)]
    pub fn check_sample_rate(&self, record: Option<f64>) -> Result<(), SimulationError> {
        if self.dynamics == Dynamics::None && self.delay_s == 0.0 {
            return Ok(());
        }
        let Some(record_hz) = record else { return Err(SimulationError::NoSampleRate) };
        let tied = match &self.dynamics {
            Dynamics::None => None,
            Dynamics::Arx(_) => Some("ARX"),
            Dynamics::Integer(_) | Dynamics::Fractional(_) => {
                self.scheme.parameters_belong_to_sample_rate().then_some(self.scheme.name())
            }
        };
        match (tied, self.sample_rate_hz) {
            (Some(scheme), Some(model_hz)) if (model_hz - record_hz).abs() > 1e-6 * model_hz => {
                Err(SimulationError::SampleRate { scheme, model_hz, record_hz })
            }
            _ => Ok(()),
        }
    }

    /// Static gain of the dynamics; 1 where G(0) is infinite.
    #[doc(hidden)]
    pub fn gain_at_rest(&self) -> f64 {
        let gain = match &self.dynamics {
            Dynamics::None => 1.0,
            Dynamics::Arx(arx) => arx.dc_gain(),
            Dynamics::Integer(g) | Dynamics::Fractional(g) => g.dc_gain(),
        };
        // Unbounded creep never settles: the creep before the record is in the offset.
        if gain.is_finite() { gain } else { 1.0 }
    }

    /// G ∗ v, the block having rested at `rest` before the first sample.
    fn simulate_dynamics(
        &self,
        v: Vec<f64>,
        rest: f64,
        sample_rate_hz: Option<f64>,
    ) -> Result<Vec<f64>, SimulationError> {
        // The one buffer is input, then output: a long record has few of its length at a time.
        let mut y = v;
        let moved = |y: &mut Vec<f64>| y.iter_mut().for_each(|y| *y -= rest);
        match &self.dynamics {
            Dynamics::None => return Ok(y),
            Dynamics::Arx(arx) => {
                moved(&mut y);
                arx.simulate(&y.clone(), Start::ZERO, &mut y)?;
            }
            Dynamics::Integer(g) | Dynamics::Fractional(g) => {
                let rate = sample_rate_hz.ok_or(SimulationError::NoSampleRate)?;
                let mut plan = SimulationPlan::new(y.len(), rate, self.scheme, Start::ZERO)?;
                let mut response = plan.empty_values();
                let sampling = Sampling { reconstruction: self.inter_sample, ..Sampling::of(self.scheme) };
                plan.response(g, self.delay_s, sampling, &mut response)?;
                plan.forget_tables();
                let (mut workspace, mut spectrum) = (plan.workspace(), plan.empty_spectrum());
                moved(&mut y);
                plan.transform_into(&y, &mut workspace, &mut spectrum)?;
                plan.apply(&response, &spectrum, &mut workspace, &mut y)?;
            }
        }
        let gain = self.gain_at_rest();
        y.iter_mut().for_each(|y| *y += gain * rest);
        Ok(y)
    }
}

/// Time stamps with those of a prologue of `prologue` samples, whole repetitions of the first period.
fn with_prologue(times_s: Vec<f64>, prologue: usize) -> Vec<f64> {
    let period = prologue / SETTLING_PERIODS;
    if period == 0 {
        return times_s;
    }
    times_before(&times_s, period, 0..period).chain(times_s.iter().copied()).collect()
}

/// Times of the samples `rows` of the first `period` samples in every period simulated before the record
/// ([`Start::Settled`]).
#[doc(hidden)]
pub fn times_before(
    times_s: &[f64],
    period: usize,
    rows: impl Iterator<Item = usize> + Clone,
) -> impl Iterator<Item = f64> {
    let first = times_s.first().copied().unwrap_or(0.0);
    let last = times_s.last().copied().unwrap_or(0.0);
    // Where the record ends with its period, the step to the next one is the mean of its steps.
    let period_s = times_s.get(period).map_or_else(
        || (last - first) * period as f64 / (times_s.len().max(2) - 1) as f64,
        |next| next - first,
    );
    (0..SETTLING_PERIODS).flat_map(move |repetition| {
        let back = (SETTLING_PERIODS - repetition) as f64 * period_s;
        rows.clone().filter_map(move |k| Some(times_s.get(k)? - back))
    })
}

/// `x` at the sample position `at`, linear between samples, constant beyond the ends.
fn between(x: &[f64], at: f64) -> f64 {
    let k = (at.floor() as usize).min(x.len().saturating_sub(1));
    let next = (k + 1).min(x.len().saturating_sub(1));
    let fraction = (at - k as f64).clamp(0.0, 1.0);
    (1.0 - fraction) * x.get(k).copied().unwrap_or(0.0) + fraction * x.get(next).copied().unwrap_or(0.0)
}
