//! Feedforward: the drive that makes a model's output follow a reference known ahead.
//!
//! The DAC of a controller is a zero-order hold. The output v of rate-independent hysteresis, the input of
//! the linear part, is then held as well; of families that depend on rate or time, each step of the voltage
//! counts as one move over a period, after which v is held. The reference passes the inverse model: the
//! regularised inverse of the dynamics under a zero-order hold ([`crate::dynamics::Inverse`]: delay, hold
//! and creep included, non-causal), then the inverse hysteresis, exact in one step ([`Hysteresis::follow`]).
//!
//! [`Hysteresis::follow`]: crate::hysteresis::Hysteresis::follow

mod error;

pub use error::InversionError;

use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

use hysteron_numeric::Listener;
use hysteron_rt::Limited;

use crate::compensator::{Compensation, CompensatorParts};
use crate::dynamics::{
    Dynamics, DynamicsError, InterSample, Inverse, InverseAim, Response, Sampling, Scheme, SimulationPlan,
    Term, TransferFunction,
};
use crate::hammerstein::{Model, SETTLING_PERIODS};
use crate::hysteresis::{DriveGrid, DriveLimits, Followed, HysteresisError};
use crate::realise::RealiseError;
use crate::start::{Memory, Start};

/// Default relative error at the bandwidth.
pub const ERROR_AT_BANDWIDTH: f64 = 1e-3;
/// Default bandwidth, as a share of the sample rate.
pub const BANDWIDTH_SHARE: f64 = 0.05;

/// Relative error that defines the bandwidth of a law that works sample by sample.
const ERROR_OF_A_LAW: f64 = 0.01;
/// Cycles of the bandwidth over which learning fades in at the beginning of a record.
const FIRST_CYCLES: f64 = 2.0;
/// Stages of an inversion, and the shares of its time that the first and, of the rest, the second take.
const OF_DYNAMICS: &str = "inverse of the dynamics";
const OF_HYSTERESIS: &str = "inverse of the hysteresis";
const OF_MODEL: &str = "predicted output";
const SHARE_OF_DYNAMICS: f64 = 0.4;
const SHARE_OF_DRIVE: f64 = 0.8;
/// Intervals of the range searched for a falling output.
const LOOKED_AT: usize = 256;

/// Options of an inverse drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InverseOptions {
    /// Tracking bandwidth \[Hz\]; `None`: [`BANDWIDTH_SHARE`] of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Relative error there.
    pub error_at_bandwidth: f64,
    /// Least and largest voltage \[V\].
    pub range_v: [f64; 2],
    /// Largest rate of the drive \[V/s\]; infinite for none.
    #[serde(with = "crate::unlimited")]
    pub slew_v_per_s: f64,
    /// State of the device before the reference. [`Start::AsIdentified`]: at rest at the first value of the
    /// reference; [`Start::Settled`]: in the periodic steady state of the reference, a whole number of
    /// periods.
    pub start: Start,
    /// Voltage \[V\] at which it was demagnetised and from which it was driven monotonically to rest; `None`:
    /// demagnetised at rest.
    pub virgin_v: Option<f64>,
}

impl InverseOptions {
    /// Default voltage at which the device was demagnetised: 0 V at switch-on, if within the range.
    pub fn switched_on([low, high]: [f64; 2]) -> Option<f64> {
        (low..=high).contains(&0.0).then_some(0.0)
    }

    /// Default options within these voltages \[V\].
    pub fn within(range_v: [f64; 2]) -> Self {
        Self {
            bandwidth_hz: None,
            error_at_bandwidth: ERROR_AT_BANDWIDTH,
            range_v,
            slew_v_per_s: f64::INFINITY,
            start: Start::AsIdentified,
            virgin_v: None,
        }
    }
}

/// An inverse drive and the model's response to it.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseDrive {
    /// Held drive \[V\], one value per sample of the reference.
    pub drive: Vec<f64>,
    /// Output of the model for it \[µm\].
    pub predicted: Vec<f64>,
    /// State before the first sample; `None` where the reference repeats.
    pub rest: Option<Start>,
    /// Samples limited by the range.
    pub at_range: usize,
    /// Samples limited by the slew rate.
    pub at_slew: usize,
    /// Figures of the inverse of the dynamics; `None` for a static model, whose inverse is exact at every
    /// frequency.
    pub dynamics: Option<InverseOfDynamics>,
}

/// A run of the device with a drive made for the same reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastRun<'a> {
    /// Its drive \[V\].
    pub drive: &'a [f64],
    /// Measured output \[µm\].
    pub measured: &'a [f64],
}

/// Figures of the inverse of the dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseOfDynamics {
    /// Tracking bandwidth \[Hz\].
    pub bandwidth_hz: f64,
    /// Relative error there.
    pub error_at_bandwidth: f64,
    /// Largest gain.
    pub peak: f64,
    /// Gain from white noise on the reference to noise on the hysteresis output, both rms.
    pub noise_gain: f64,
}

impl Model {
    /// The drive whose output tracks `reference` \[µm\] at `sample_rate_hz`, the rate of the controller.
    ///
    /// # Errors
    /// [`InversionError`].
    pub fn invert(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
        options: &InverseOptions,
    ) -> Result<InverseDrive, InversionError> {
        self.invert_told(reference, sample_rate_hz, options, Listener::silent())
    }

    /// [`Self::invert`], with its progress told to `listener`.
    ///
    /// # Errors
    /// [`InversionError`]; [`InversionError::Stopped`] where the listener ends it.
    pub fn invert_told(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
        options: &InverseOptions,
        listener: Listener<'_>,
    ) -> Result<InverseDrive, InversionError> {
        listener.tell(OF_DYNAMICS, 0.0)?;
        let task = Task::new(self, reference, sample_rate_hz, options)?;
        let moved: Vec<f64> = reference.iter().map(|r| r - task.output_at_rest).collect();
        let mut wanted = vec![0.0; moved.len()];
        task.linear.backwards(&moved, &mut wanted)?;
        wanted.iter_mut().for_each(|v| *v += task.level);
        task.drive(&wanted, listener.part(SHARE_OF_DYNAMICS, 1.0))
    }

    /// Iterative learning control: the drive of the next run from the tracking error of the `last` (S.
    /// Arimoto, S. Kawamura, F. Miyazaki, *J. Robot. Syst.* 1 (1984) 123–140, doi:10.1002/rob.4620010203): v
    /// ← v + W (r − y), v the output of the hysteresis, W the inverse of the dynamics. One run removes the
    /// error that model and device share; the residual shrinks by |1 − W P'| per run, P' the device's
    /// response, so it falls wherever the model is within 100 % of it. The mean error is attributed to the
    /// sensor's zero and not learned: it would become a jump from rest. Errors that do not repeat (noise,
    /// drift) are not removed but passed on.
    ///
    /// # Errors
    /// [`InversionError`].
    pub fn learn(
        &self,
        reference: &[f64],
        last: LastRun<'_>,
        sample_rate_hz: f64,
        options: &InverseOptions,
    ) -> Result<InverseDrive, InversionError> {
        let task = Task::new(self, reference, sample_rate_hz, options)?;
        let samples = reference.len();
        let within = |u: &f64| options.range_v[0] <= *u && *u <= options.range_v[1];
        if last.drive.len() != samples || last.measured.len() != samples || !last.drive.iter().all(within) {
            let (drive, measured) = (last.drive.len(), last.measured.len());
            return Err(InversionError::LastRun { drive, measured, samples });
        }
        if let Some(index) = last.measured.iter().position(|y| !y.is_finite()) {
            return Err(InversionError::NotFinite { index });
        }
        let mut wanted = vec![0.0; samples];
        let rest = task.rest_v;
        let origin = match task.memory {
            _ if task.periodic => Start::PERIODIC,
            Some(memory) => Start::Remembering { voltage_v: rest, memory },
            None => Start::Rest { voltage_v: rest },
        };
        let grid = DriveGrid::new(Some(sample_rate_hz), 1, 1);
        self.hysteresis.simulate_every(grid, last.drive, origin, &mut wanted)?;
        let left = || reference.iter().zip(last.measured).map(|(r, y)| r - y);
        let zero = left().sum::<f64>() / samples as f64;
        let mut left: Vec<f64> = left().map(|e| e - zero).collect();
        if let (false, Some(figures)) = (task.periodic, task.linear.figures()) {
            // The drive cannot begin before the record: without this window the residual at its beginning
            // would be learned again in every run.
            let first = (FIRST_CYCLES * sample_rate_hz / figures.bandwidth_hz).ceil();
            for (k, e) in left.iter_mut().enumerate().take(first as usize) {
                *e *= (FRAC_PI_2 * k as f64 / first).sin().powi(2);
            }
        }
        let mut correction = vec![0.0; samples];
        task.linear.backwards(&left, &mut correction)?;
        wanted.iter_mut().zip(&correction).for_each(|(v, c)| *v += c);
        task.drive(&wanted, Listener::silent())
    }

    /// Rest voltage for this output, reached monotonically from the virgin state.
    pub(crate) fn rest_for(
        &self,
        output: f64,
        virgin_v: Option<f64>,
        [low, high]: [f64; 2],
    ) -> Result<f64, InversionError> {
        let gain = self.gain_at_rest();
        let at = |u: f64| -> Result<f64, HysteresisError> {
            let memory = virgin_v.map(|virgin| self.hysteresis.memory_of_move(virgin, u)).transpose()?;
            Ok(self.offset + gain * self.hysteresis.at_rest(u, memory))
        };
        let (from, to) = (at(low)?, at(high)?);
        if !(from.min(to) <= output && output <= from.max(to)) {
            let voltage = |k: usize| low + (high - low) * k as f64 / LOOKED_AT as f64;
            for k in 1..=LOOKED_AT {
                if at(voltage(k))? < at(voltage(k - 1))? {
                    return Err(InversionError::Falls { low, high, near: voltage(k) });
                }
            }
            return Err(InversionError::Begins { reference: output, low, high, from, to });
        }
        let (mut below, mut above) = if from <= to { (low, high) } else { (high, low) };
        // 60 bisections leave 1e-18 of the range.
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            if at(middle)? <= output { below = middle } else { above = middle }
        }
        Ok(below)
    }
}

impl Compensation {
    /// The drive along `reference` \[µm\], computed sample by sample: the law uses the reference only within
    /// its preview; after its end the reference stays constant. Of `options` only the limits and the start
    /// are used; bandwidth and error are the law's.
    ///
    /// # Errors
    /// [`InversionError`]; a periodic reference is refused, since its steady state depends on the whole
    /// period.
    pub fn follow(
        &self,
        reference: &[f64],
        options: &InverseOptions,
    ) -> Result<InverseDrive, InversionError> {
        let virgin_v = match options.start {
            Start::Settled { .. } => return Err(InversionError::Repeats),
            Start::Remembering { memory: Memory::VirginAt(virgin_v), .. } => Some(virgin_v),
            Start::Remembering { .. } => return Err(InversionError::Displacement),
            Start::AsIdentified | Start::Rest { .. } => options.virgin_v,
        };
        let task = Task::new(&self.model, reference, self.sample_rate_hz, options)?;
        let mut parts = CompensatorParts::<f64>::new(self, options.range_v, options.slew_v_per_s)?;
        let mut compensator = parts.compensator()?;
        let rest_v = task.rest_v;
        compensator.rest_after(virgin_v.unwrap_or(rest_v), rest_v).map_err(RealiseError::from)?;
        let last = reference.last().copied().unwrap_or(task.output_at_rest);
        let ahead = |k: usize| reference.get(k).copied().unwrap_or(last);
        for k in 0..self.preview {
            compensator.know(ahead(k));
        }
        let mut followed = Followed { drive: Vec::new(), output: Vec::new(), limited: Vec::new() };
        for k in 0..reference.len() {
            let sample = compensator.step(ahead(k + self.preview));
            if matches!(sample.limited, Limited::Reference | Limited::Overflow) {
                return Err(HysteresisError::Overflow { index: k }.into());
            }
            followed.limited.push(sample.limited);
            followed.drive.push(sample.voltage);
            followed.output.push(compensator.output());
        }
        let figures = self.bandwidth_hz.is_finite().then(|| InverseOfDynamics {
            bandwidth_hz: self.follows_to(ERROR_OF_A_LAW),
            error_at_bandwidth: ERROR_OF_A_LAW,
            peak: self.peak,
            noise_gain: self.noise_gain,
        });
        Ok(InverseDrive { dynamics: figures, ..task.answer(followed)? })
    }
}

/// Inversion of one reference.
struct Task<'a> {
    model: &'a Model,
    options: &'a InverseOptions,
    sample_rate_hz: f64,
    linear: Linear,
    periodic: bool,
    /// Voltage before the first sample; for a periodic reference, at the start of its first period.
    rest_v: f64,
    /// Hysteresis memory there, in the operator's scale.
    memory: Option<f64>,
    /// Operating point: output of the hysteresis and of the model at rest.
    level: f64,
    output_at_rest: f64,
}

impl<'a> Task<'a> {
    fn new(
        model: &'a Model,
        reference: &[f64],
        sample_rate_hz: f64,
        options: &'a InverseOptions,
    ) -> Result<Self, InversionError> {
        if reference.len() < 2 {
            return Err(InversionError::TooShort { samples: reference.len() });
        }
        if let Some(index) = reference.iter().position(|r| !r.is_finite()) {
            return Err(InversionError::NotFinite { index });
        }
        model.check_sample_rate(Some(sample_rate_hz))?;
        let [low, high] = options.range_v;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high }.into());
        }
        let periodic = matches!(options.start, Start::Settled { .. });
        let rest_v = match options.start {
            Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => voltage_v,
            Start::AsIdentified => model.rest_for(reference[0], options.virgin_v, options.range_v)?,
            Start::Settled { period_samples: Some(period_samples), .. }
                if period_samples == 0 || !reference.len().is_multiple_of(period_samples) =>
            {
                return Err(InversionError::Period { samples: reference.len(), period_samples });
            }
            Start::Settled { .. } => 0.5 * low + 0.5 * high,
        };
        let memory = match (options.start, options.virgin_v) {
            (Start::Remembering { memory, .. }, _) => Some(model.hysteresis.own_memory(memory)?),
            (Start::AsIdentified | Start::Rest { .. }, Some(virgin_v)) => {
                Some(model.hysteresis.memory_of_move(virgin_v, rest_v)?)
            }
            _ => None,
        };
        let level = if periodic { 0.0 } else { model.hysteresis.at_rest(rest_v, memory) };
        Ok(Self {
            model,
            options,
            sample_rate_hz,
            linear: Linear::new(model, reference.len(), sample_rate_hz, options)?,
            periodic,
            rest_v,
            memory,
            level,
            output_at_rest: model.offset + model.gain_at_rest() * level,
        })
    }

    /// The drive for the hysteresis output `wanted`, and the model's response to it.
    fn drive(&self, wanted: &[f64], listener: Listener<'_>) -> Result<InverseDrive, InversionError> {
        let Self { options, rest_v, .. } = *self;
        let limits = DriveLimits {
            range: options.range_v,
            step: options.slew_v_per_s / self.sample_rate_hz,
            interval_s: Some(1.0 / self.sample_rate_hz),
        };
        let hysteresis = &self.model.hysteresis;
        let periods = if self.periodic { SETTLING_PERIODS + 1 } else { 1 };
        let meter = listener.part(0.0, SHARE_OF_DRIVE).meter(OF_HYSTERESIS, periods * wanted.len());
        let followed = if self.periodic {
            let settled = SETTLING_PERIODS * wanted.len();
            let wanted = wanted.repeat(periods);
            let mut followed = hysteresis.follow_metered(&wanted, rest_v, None, &limits, &meter)?;
            followed.drive.drain(..settled);
            followed.output.drain(..settled);
            followed.limited.drain(..settled);
            followed
        } else {
            hysteresis.follow_metered(wanted, rest_v, self.memory, &limits, &meter)?
        };
        listener.tell(OF_MODEL, SHARE_OF_DRIVE)?;
        self.answer(followed)
    }

    /// The drive with its predicted output and its limited samples counted.
    fn answer(&self, followed: Followed) -> Result<InverseDrive, InversionError> {
        let (at_range, at_slew) = (followed.count(Limited::Range), followed.count(Limited::Step));
        let Followed { drive, output, .. } = followed;
        let held: Vec<f64> = output.iter().map(|v| v - self.level).collect();
        let mut predicted = vec![0.0; held.len()];
        self.linear.forwards(&held, &mut predicted)?;
        predicted.iter_mut().for_each(|y| *y += self.output_at_rest);
        Ok(InverseDrive {
            drive,
            predicted,
            rest: (!self.periodic).then(|| self.model.hysteresis.start_at_rest(self.rest_v, self.memory)),
            at_range,
            at_slew,
            dynamics: self.linear.figures(),
        })
    }
}

/// The linear part over a record, forward and inverse. Inputs and outputs are deviations from rest, or
/// periodic.
struct Linear(Option<Both>);

struct Both {
    plan: SimulationPlan,
    plant: Response,
    inverse: Inverse,
    aim: InverseAim,
}

impl Linear {
    fn new(
        model: &Model,
        samples: usize,
        sample_rate_hz: f64,
        options: &InverseOptions,
    ) -> Result<Self, DynamicsError> {
        if model.dynamics == Dynamics::None && model.delay_s == 0.0 {
            return Ok(Self(None));
        }
        let initial = match options.start {
            Start::Settled { .. } => Start::PERIODIC,
            _ => Start::ZERO,
        };
        let plan = SimulationPlan::new(samples, sample_rate_hz, Scheme::BandLimited, initial)?;
        let mut plant = plan.empty_response(0);
        let sampling = Sampling { delay: InterSample::BandLimited, reconstruction: InterSample::Hold };
        match &model.dynamics {
            Dynamics::Arx(arx) => plan.arx_response(arx, model.delay_s, &mut plant)?,
            Dynamics::Integer(g) | Dynamics::Fractional(g) => {
                plan.response(g, model.delay_s, sampling, &mut plant)?;
            }
            Dynamics::None => {
                let one = || vec![Term { coefficient: 1.0, order: 0.0 }];
                let unit = TransferFunction::new(one(), one())?;
                plan.response(&unit, model.delay_s, sampling, &mut plant)?;
            }
        }
        let bandwidth_hz = options.bandwidth_hz.unwrap_or(BANDWIDTH_SHARE * sample_rate_hz);
        let aim = InverseAim { bandwidth_hz, error: options.error_at_bandwidth };
        let inverse = plan.inverse(&plant, aim)?;
        Ok(Self(Some(Both { plan, plant, inverse, aim })))
    }

    fn backwards(&self, moved: &[f64], out: &mut [f64]) -> Result<(), DynamicsError> {
        self.run(|both| &both.inverse.response, moved, out)
    }

    fn forwards(&self, held: &[f64], out: &mut [f64]) -> Result<(), DynamicsError> {
        self.run(|both| &both.plant, held, out)
    }

    fn run(
        &self,
        response: impl Fn(&Both) -> &Response,
        x: &[f64],
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        match &self.0 {
            None => out.copy_from_slice(x),
            Some(both) => {
                let spectrum = both.plan.transform(x)?;
                both.plan.apply(response(both), &spectrum, &mut both.plan.workspace(), out)?;
            }
        }
        Ok(())
    }

    fn figures(&self) -> Option<InverseOfDynamics> {
        self.0.as_ref().map(|both| InverseOfDynamics {
            bandwidth_hz: both.aim.bandwidth_hz,
            error_at_bandwidth: both.aim.error,
            peak: both.inverse.peak,
            noise_gain: both.inverse.noise_gain,
        })
    }
}
