//! Running a loop on a stage.

use hysteron_numeric::Meter;
use hysteron_rt::{Compensator, HeldBack, Limited, Limits, Line, Model as RuntimeModel, Observer};

use super::{AdaptiveParts, ControlError, FeedbackParts, Loop, StageError};
use crate::compensator::CompensatorParts;
use crate::realise::{Realisation, RuntimeParts};

/// Samples at rest before the reference begins, on whose mean the sensor is zeroed.
const RESTED: usize = 1000;

/// Reading and displacement of a stage at the beginning of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageSample {
    /// The sensor's reading \[µm\].
    pub reading_um: f64,
    /// True displacement \[µm\].
    pub true_um: f64,
}

/// A stage with its amplifier and sensor; a loop begins with it at rest.
pub trait Stage: Sync {
    /// The stage in steady state at the voltage `rest_v`, driven through a zero-order hold.
    ///
    /// # Errors
    /// [`StageError`]: a sample rate or voltage that the stage cannot take.
    fn at_rest(&self, sample_rate_hz: f64, rest_v: f64) -> Result<Box<dyn StageRun + '_>, StageError>;
}

/// One run of a [`Stage`], a period at a time.
pub trait StageRun {
    /// Holds `drive_v` for one period; the sample is taken at its beginning.
    ///
    /// # Errors
    /// [`StageError`]: a voltage that the stage cannot take.
    fn step(&mut self, drive_v: f64) -> Result<StageSample, StageError>;
}

/// Plant of a loop.
#[derive(Clone, Copy)]
pub enum Plant<'a> {
    /// A stage, e.g. the simulated bench.
    Stage(&'a dyn Stage),
    /// The model itself, without noise.
    Model,
}

/// Result of playing a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// Voltage at rest before it \[V\].
    pub rest_v: f64,
    /// The drive \[V\].
    pub drive: Vec<f64>,
    /// The sensor's reading, zeroed so that it is the reference's first value at rest \[µm\].
    pub reading: Vec<f64>,
    /// The displacement, counted from the same zero \[µm\].
    pub displacement: Vec<f64>,
    /// Samples limited by the range.
    pub at_range: usize,
    /// Samples limited by the slew rate.
    pub at_slew: usize,
}

enum Running<'a> {
    Stage(Box<dyn StageRun + 'a>),
    Model(Box<RuntimeModel<'a, f64>>),
}

impl Running<'_> {
    /// Reading and displacement at the beginning of a period.
    fn step(&mut self, voltage: f64) -> Result<(f64, f64), ControlError> {
        match self {
            Running::Stage(stage) => {
                let sample = stage.step(voltage)?;
                Ok((sample.reading_um, sample.true_um))
            }
            Running::Model(model) => {
                let y = model.step(voltage)?;
                Ok((y, y))
            }
        }
    }
}

enum Driver<'a> {
    Line(Line<f64>),
    Inverse(Box<Compensator<'a, f64>>),
}

/// Plays a reference from rest at its first value, the hysteresis having been driven there from `virgin_v`
/// (`None`: virgin there). Beyond its end the reference stays constant. The reading at the beginning of one
/// period determines the drive of the next.
///
/// # Errors
/// [`ControlError`].
pub fn play(
    made: &Loop,
    reference: &[f64],
    plant: Plant<'_>,
    virgin_v: Option<f64>,
) -> Result<Played, ControlError> {
    play_metered(made, reference, plant, virgin_v, &Meter::silent())
}

/// [`play`], whose samples `meter` counts.
///
/// # Errors
/// Those of [`play`]; [`ControlError::Stopped`].
pub(crate) fn play_metered(
    made: &Loop,
    reference: &[f64],
    plant: Plant<'_>,
    virgin_v: Option<f64>,
    meter: &Meter<'_>,
) -> Result<Played, ControlError> {
    let (Some(&first), Some(&last)) = (reference.first(), reference.last()) else {
        return Err(ControlError::Reference);
    };
    if reference.len() < 2 || !reference.iter().all(|r| r.is_finite()) {
        return Err(ControlError::Reference);
    }
    let settings = &made.settings;
    let [low, high] = settings.range_v;
    let limits = Limits { low, high, step: settings.slew_v_per_s / settings.sample_rate_hz };
    let rest_v = match made.inverse {
        Some(_) => made.model.rest_for(first, virgin_v, settings.range_v)?,
        None => ((first - made.line.offset) / made.line.slope).clamp(low, high),
    };
    let virgin = virgin_v.unwrap_or(rest_v);
    let realisation = || Realisation {
        model: made.model.clone(),
        dynamics: made.dynamics.clone(),
        sample_rate_hz: settings.sample_rate_hz,
        joins_means: false,
    };

    let mut compensator_parts = match &made.inverse {
        Some(inverse) => Some(CompensatorParts::new(inverse, settings.range_v, settings.slew_v_per_s)?),
        None => None,
    };
    let preview = made.inverse.as_ref().map_or(0, |inverse| inverse.preview);
    let ahead = |k: usize| reference.get(k).copied().unwrap_or(last);
    let mut driver = match &mut compensator_parts {
        Some(parts) => {
            let mut compensator = parts.compensator()?;
            compensator.rest_after(virgin, rest_v)?;
            (0..preview).for_each(|k| {
                compensator.know(ahead(k));
            });
            Driver::Inverse(Box::new(compensator))
        }
        None => Driver::Line(Line::new(made.line.offset, made.line.slope, limits, rest_v)?),
    };
    let mut feedback_parts = made.feedback.as_ref().map(|tuned| FeedbackParts::<f64>::new(&tuned.law));
    let mut feedback = match &mut feedback_parts {
        Some(parts) => Some(parts.feedback()?),
        None => None,
    };
    let mut observer_parts = match made.observer {
        Some((gain, _)) => Some((RuntimeParts::<f64>::new(&realisation())?, gain)),
        None => None,
    };
    let mut observer = match &mut observer_parts {
        Some((parts, gain)) => Some(Observer::new(parts.model()?, *gain)?),
        None => None,
    };
    let mut model_parts = match plant {
        Plant::Model => Some(RuntimeParts::<f64>::new(&realisation())?),
        Plant::Stage(_) => None,
    };
    let mut running = match (plant, &mut model_parts) {
        (Plant::Stage(stage), _) => Running::Stage(stage.at_rest(settings.sample_rate_hz, rest_v)?),
        (Plant::Model, Some(parts)) => {
            let mut model = parts.model()?;
            model.rest_after(virgin, rest_v)?;
            Running::Model(Box::new(model))
        }
        (Plant::Model, None) => return Err(ControlError::Reference),
    };
    let swing = reference.iter().map(|r| (r - first).powi(2)).sum::<f64>() / reference.len() as f64;
    let mut adaptive_parts = made.adaptive.as_ref().map(|adaptive| AdaptiveParts::new(adaptive, swing));
    let mut lms = match &mut adaptive_parts {
        Some(parts) => Some(parts.lms()?),
        None => None,
    };

    // The reading at rest is zeroed to the reference's first value.
    let mut sums = (0.0, 0.0);
    for _ in 0..RESTED {
        let (reading, displacement) = running.step(rest_v)?;
        sums = (sums.0 + reading, sums.1 + displacement);
    }
    let zero = (sums.0 / RESTED as f64 - first, sums.1 / RESTED as f64 - first);
    if let Some(observer) = &mut observer {
        observer.rest_after(virgin, rest_v, first)?;
    }

    let mut played = Played {
        rest_v,
        drive: Vec::with_capacity(reference.len()),
        reading: Vec::with_capacity(reference.len()),
        displacement: Vec::with_capacity(reference.len()),
        at_range: 0,
        at_slew: 0,
    };
    let (mut error, mut disturbance, mut held, mut voltage) = (0.0, 0.0, HeldBack::No, rest_v);
    for (k, r) in reference.iter().enumerate() {
        meter.at_sample(k)?;
        let mut correction = feedback.as_mut().map_or(0.0, |f| f.step(error, held));
        if let Some(lms) = &mut lms {
            correction += lms.step(ahead(k + preview) - first, error);
        }
        let drive = match &mut driver {
            Driver::Line(line) => line.step(r + correction),
            Driver::Inverse(inverse) => inverse.step_against(ahead(k + preview), disturbance - correction),
        };
        held = HeldBack::of(drive, voltage, limits);
        voltage = drive.voltage;
        match drive.limited {
            Limited::Range => played.at_range += 1,
            Limited::Step => played.at_slew += 1,
            Limited::No | Limited::Reference | Limited::Overflow => {}
        }
        let (reading, displacement) = running.step(voltage)?;
        let (reading, displacement) = (reading - zero.0, displacement - zero.1);
        error = r - reading;
        if let Some(observer) = &mut observer {
            disturbance = observer.step(voltage, reading)?.disturbance;
        }
        played.drive.push(voltage);
        played.reading.push(reading);
        played.displacement.push(displacement);
    }
    Ok(played)
}
