//! Golden vectors of a controller: the library's own simulation on a stage that is not the model; in single
//! precision, what the library puts out in double precision for the rounded readings of that simulation.

use hysteron_model::control::{ControllerParts, Plant, play};
use hysteron_model::realise::Section;
use hysteron_rt::{Controller, Real};

use super::ClosedLoop;
use super::stage::OtherStage;
use crate::dry_run::{DryRun, still, throw};
use crate::error::ExportError;
use crate::inverse::{DOUBLE, SINGLE};
use crate::number::Precision;

/// Samples of the vectors from where the reference moves; the last third are steps.
const SAMPLES: usize = 600;
/// Share of the range of the displacement that the reference swings and steps by.
const SWING: f64 = 0.25;

/// References, and the voltages and readings of a simulation; numbers that go in are exact in the number type
/// of the export.
#[derive(Clone, Debug, PartialEq)]
pub struct GoldenLoop {
    /// Voltage at rest before the first.
    pub rest_v: f64,
    /// Reading there.
    pub measured: f64,
    /// References: the first ones, as many as the preview and one more, are those of the rest.
    pub references: Vec<f64>,
    /// Voltage of every period.
    pub voltages: Vec<f64>,
    /// Reading at the beginning of it.
    pub readings: Vec<f64>,
    /// Largest difference that the exported source may show.
    pub tolerance: f64,
}

impl GoldenLoop {
    /// The vectors: a sine through half of the range, then steps.
    ///
    /// # Errors
    /// [`ExportError::Control`] where the library has no result along them, [`ExportError::Still`] where the
    /// voltage does not move.
    pub fn new(closed: &ClosedLoop) -> Result<Self, ExportError> {
        let precision = closed.inverse.subject.precision;
        let line = &closed.made.line;
        let [low, high] = closed.made.settings.range_v;
        let (middle, stroke) = (line.offset + 0.5 * line.slope * (low + high), line.slope * (high - low));
        let rested = closed.preview() + 1;
        let references: Vec<f64> = (0..rested + SAMPLES)
            .map(|k| {
                let k = k.saturating_sub(rested);
                let phase = 5.0 * std::f64::consts::TAU * k as f64 / SAMPLES as f64;
                let swing = if k < 2 * SAMPLES / 3 { phase.sin() } else { 0.5 * phase.sin().signum() };
                precision.round(middle + SWING * stroke * swing)
            })
            .collect();
        let stage = OtherStage::new(closed);
        let played = play(&closed.made, &references, Plant::Stage(&stage), None)?;
        let moves = played.drive.iter().any(|u| (u - played.rest_v).abs() > 0.01 * (high - low));
        if !moves {
            return Err(ExportError::Still { what: "voltage of the controller" });
        }
        let tolerance = DOUBLE * (high - low);
        let mut golden = Self {
            rest_v: precision.round(played.rest_v),
            measured: precision.round(middle),
            references,
            voltages: played.drive,
            readings: played.reading.iter().map(|y| precision.round(*y)).collect(),
            tolerance,
        };
        if precision == Precision::F32 {
            golden.voltages = golden.replayed::<f64>(closed)?;
            golden.tolerance = if closed.dry_run.drifts() {
                closed.dry_run.stated()
            } else {
                SINGLE * precision.epsilon() * golden.magnitudes(closed)?
            };
        }
        Ok(golden)
    }

    /// Sum of magnitudes for a voltage: those of the inverse, and of correction and disturbance before it.
    fn magnitudes(&self, closed: &ClosedLoop) -> Result<f64, ExportError> {
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0_f64, |most, x| most.max(x.abs()));
        let [bottom, top, _] = closed.inverse.displacements()?;
        let span = largest(&mut self.references.iter().copied()) + (top - bottom).abs();
        let errors = || self.references.iter().zip(&self.readings).map(|(r, y)| (r - y).abs());
        let (most, sum) = (largest(&mut errors()), errors().sum::<f64>());
        let correction = closed.made.feedback.as_ref().map_or(0.0, |tuned| {
            let law = &tuned.law;
            let taps: f64 = law.dynamics.taps.iter().map(|tap| tap.abs()).sum();
            // A slow state has not come far.
            let state = |s: &Section| s.weight.norm() * most.min(s.gain.norm() * sum);
            (law.proportional.abs() + taps) * most
                + (law.integral_per_s / law.sample_rate_hz).abs() * sum
                + law.dynamics.sections.iter().map(state).sum::<f64>()
        });
        // Its bound is [`SINGLE`] roundings of the model's own sum.
        let observed = closed.observed.as_ref().map_or(0.0, |observed| {
            observed.rounding.bound / (SINGLE * observed.precision.epsilon())
                + largest(&mut self.readings.iter().copied())
        });
        Ok(closed.inverse.sensitivity()? * (span + correction + observed))
    }

    /// Voltages of the library in a number type for the references and readings.
    fn replayed<T: Real + Into<f64>>(&self, closed: &ClosedLoop) -> Result<Vec<f64>, ExportError> {
        let mut parts = parts::<T>(closed)?;
        let mut controller = self.at_rest(&mut parts)?;
        let preview = closed.preview();
        let last = self.references.last().copied().unwrap_or(self.measured);
        let ahead = |k: usize| T::of(self.references.get(k).copied().unwrap_or(last));
        (0..preview).for_each(|k| {
            controller.know(ahead(k));
        });
        let period = |(k, reading): (usize, &f64)| {
            let voltage = controller.step(ahead(k + preview)).voltage;
            controller.measured(T::of(*reading));
            voltage.into()
        };
        Ok(self.readings.iter().enumerate().map(period).collect())
    }

    /// The controller, where the vectors begin.
    fn at_rest<'a, T: Real>(
        &self,
        parts: &'a mut ControllerParts<T>,
    ) -> Result<Controller<'a, T>, ExportError> {
        let mut controller = parts.controller()?;
        let (rest, measured) = (T::of(self.rest_v), T::of(self.measured));
        controller.rest_after(rest, rest, measured).map_err(|_| still())?;
        Ok(controller)
    }

    /// The dry run in single precision: along the vectors, and with references from end to end, on the stage
    /// that the controller in double precision drives.
    ///
    /// # Errors
    /// [`ExportError::Departs`] where it departs along its vectors.
    pub(super) fn dry_run(&self, closed: &ClosedLoop) -> Result<DryRun, ExportError> {
        let own = self.replayed::<f32>(closed)?;
        let along = own
            .iter()
            .zip(&self.voltages)
            .fold(0.0_f64, |worst, (own, wanted)| worst.max((own - wanted).abs()));
        DryRun::judged(&closed.compared(), along, self.tolerance, || self.thrown(closed))
    }

    fn thrown(&self, closed: &ClosedLoop) -> Result<f64, ExportError> {
        let (mut own, mut double) = (parts::<f32>(closed)?, parts::<f64>(closed)?);
        let (mut own, mut double) = (self.at_rest(&mut own)?, self.at_rest(&mut double)?);
        let stage = OtherStage::new(closed);
        let mut run = stage.run(self.rest_v);
        let zero = self.measured - run.moved(self.rest_v);
        let mut worst = 0.0_f64;
        throw(&self.references, |end| {
            let voltage = double.step(end).voltage;
            let single = f64::from(own.step(f32::of(end)).voltage);
            worst = worst.max((single - voltage).abs());
            let reading = f32::of(run.moved(voltage) + zero);
            own.measured(reading);
            double.measured(f64::from(reading));
        });
        Ok(worst)
    }
}

fn parts<T: Real>(closed: &ClosedLoop) -> Result<ControllerParts<T>, ExportError> {
    let name = closed.controller.name();
    ControllerParts::new(&closed.made)?.ok_or(ExportError::Controller { controller: name })
}
