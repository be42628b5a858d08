//! The bench of several axes, one sample period at a time.

use std::f64::consts::TAU;

use rustfft::num_complex::Complex64;

use hysteron_model::control::StageError;
use hysteron_model::decoupling::{AxesStage, AxesStageRun};
use hysteron_model::record::{Channel, Record, TimeBase};

use super::AxesTruth;
use crate::RigError;
use crate::partial_fractions::{PartialFractions, PolePair, RealPole};
use crate::plays::PlayStates;
use crate::propagation::Propagator;
use crate::sensor::SensorState;
use crate::truth::Dac;

/// The bench with its states.
pub struct AxesRig<'a> {
    truth: &'a AxesTruth,
    amplifiers: Vec<Propagator>,
    hystereses: Vec<PlayStates<'a>>,
    modes: Vec<Propagator>,
    /// Present strokes of the actuators, and inputs of the modes \[µm\].
    strokes: Vec<f64>,
    forces: Vec<f64>,
    sensors: Vec<SensorState>,
    true_um: Vec<f64>,
    readings: Vec<f64>,
}

impl<'a> AxesRig<'a> {
    /// In equilibrium at the voltages `rest_v`, driven to them from 0 V. `stream` numbers the record: with
    /// the same seed, different streams have independent noise.
    ///
    /// # Errors
    /// [`RigError::Parameter`], [`RigError::Drive`].
    pub fn at_rest(
        truth: &'a AxesTruth,
        sample_rate_hz: f64,
        rest_v: &[f64],
        seed: u64,
        stream: usize,
    ) -> Result<Self, RigError> {
        truth.validate()?;
        finite(rest_v, truth.actuators.len())?;
        if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
            let (what, expected) = ("sample_rate_hz", "a finite rate above 0");
            return Err(RigError::Drive { what, value: sample_rate_hz, expected });
        }
        let step_s = 1.0 / (sample_rate_hz * f64::from(truth.oversampling));
        let amplifier = |(corner_hz, rest): (f64, f64)| {
            let rate = TAU * corner_hz;
            let lag = PartialFractions {
                feedthrough: 0.0,
                real: vec![RealPole { rate, weight: rate }],
                pairs: Vec::new(),
                static_gain: 1.0,
            };
            Propagator::at_rest(&lag, step_s, 0.0, rest)
        };
        let corners = truth.actuators.iter().map(|a| a.amplifier_corner_hz);
        let amplifiers: Vec<Propagator> = corners.zip(rest_v.iter().copied()).map(amplifier).collect();
        let mut hystereses: Vec<PlayStates<'a>> = truth
            .actuators
            .iter()
            .map(|a| PlayStates::new(&a.plays, a.linear_um_per_v, a.quadratic_per_um, a.cubic_per_um2))
            .collect();
        let strokes: Vec<f64> = hystereses.iter_mut().zip(rest_v).map(|(h, rest)| h.step(*rest)).collect();
        let mut modes = Vec::with_capacity(truth.modes.len());
        let mut forces = Vec::with_capacity(truth.modes.len());
        for mode in &truth.modes {
            let w = TAU * mode.frequency_hz;
            let damped = w * (1.0 - mode.damping * mode.damping).sqrt();
            let pair = PolePair {
                pole: Complex64::new(-mode.damping * w, damped),
                residue: Complex64::new(0.0, -w * w / (2.0 * damped)),
            };
            let plant =
                PartialFractions { feedthrough: 0.0, real: Vec::new(), pairs: vec![pair], static_gain: 1.0 };
            let force = dot(&mode.drive, &strokes);
            modes.push(Propagator::at_rest(&plant, step_s, 0.0, force));
            forces.push(force);
        }
        let axes = truth.axes();
        let sensors = (0..axes)
            .map(|m| SensorState::new(&truth.sensor, sample_rate_hz, seed, stream * axes + m))
            .collect();
        let (true_um, readings) = (vec![0.0; axes], vec![0.0; axes]);
        Ok(Self { truth, amplifiers, hystereses, modes, strokes, forces, sensors, true_um, readings })
    }

    /// One sample period: the sample is taken at its beginning, the drives go from `start_v` to `end_v`.
    ///
    /// # Errors
    /// [`RigError::Drive`] for voltages that are not finite or not one per actuator.
    pub fn next(&mut self, start_v: &[f64], end_v: &[f64]) -> Result<(), RigError> {
        finite(start_v, self.truth.actuators.len())?;
        finite(end_v, self.truth.actuators.len())?;
        for (m, y) in self.true_um.iter_mut().enumerate() {
            let parts = self.truth.modes.iter().zip(&self.modes).zip(&self.forces);
            *y = parts.map(|((mode, state), force)| mode.motion[m] * state.output(*force, *force)).sum();
        }
        for ((reading, y), sensor) in self.readings.iter_mut().zip(&self.true_um).zip(&mut self.sensors) {
            *reading = sensor.read(*y);
        }
        let steps = self.truth.oversampling;
        for step in 0..steps {
            for (i, amplifier) in self.amplifiers.iter_mut().enumerate() {
                let at = |k: u32| start_v[i] + (end_v[i] - start_v[i]) * f64::from(k) / f64::from(steps);
                amplifier.advance(at(step), at(step + 1));
                self.strokes[i] = self.hystereses[i].step(amplifier.output(0.0, 0.0));
            }
            for ((mode, state), force) in self.truth.modes.iter().zip(&mut self.modes).zip(&mut self.forces) {
                let next = dot(&mode.drive, &self.strokes);
                state.advance(*force, next);
                *force = next;
            }
        }
        Ok(())
    }

    /// True displacements at the last sample \[µm\].
    pub fn true_um(&self) -> &[f64] {
        &self.true_um
    }

    /// Readings at the last sample \[µm\].
    pub fn readings_um(&self) -> &[f64] {
        &self.readings
    }

    /// Readings so far at the ends of a converter's range.
    pub fn clipped(&self) -> usize {
        self.sensors.iter().map(SensorState::clipped).sum()
    }
}

impl AxesStageRun for AxesRig<'_> {
    fn step(&mut self, drive_v: &[f64]) -> Result<(), StageError> {
        Ok(self.next(drive_v, drive_v)?)
    }

    fn reading_um(&self) -> &[f64] {
        &self.readings
    }

    fn true_um(&self) -> &[f64] {
        &self.true_um
    }
}

/// The bench of several axes as the stage of a controller, its drives held.
#[derive(Clone, Copy, Debug)]
pub struct AxesRigStage<'a> {
    /// The device.
    pub truth: &'a AxesTruth,
    /// Seed of its noise.
    pub seed: u64,
}

impl AxesStage for AxesRigStage<'_> {
    fn at_rest(&self, sample_rate_hz: f64, rest_v: &[f64]) -> Result<Box<dyn AxesStageRun + '_>, StageError> {
        Ok(Box::new(AxesRig::at_rest(self.truth, sample_rate_hz, rest_v, self.seed, 0)?))
    }
}

/// Measures one record: the `drives` \[V\], one list per actuator, from rest at their first voltages.
///
/// Channels: `u1` … \[V\], `y1` … \[µm\], the readings.
///
/// # Errors
/// Those of [`AxesRig::at_rest`] and [`AxesRig::next`].
pub fn measure_axes(
    truth: &AxesTruth,
    name: &str,
    drives: &[Vec<f64>],
    sample_rate_hz: f64,
    (seed, stream): (u64, usize),
) -> Result<(Record, usize), RigError> {
    let at = |k: usize| -> Vec<f64> { drives.iter().map(|u| u.get(k).copied().unwrap_or(0.0)).collect() };
    let samples = drives.first().map_or(0, Vec::len);
    if samples == 0 || drives.iter().any(|u| u.len() != samples) {
        let expected = "as many samples, at least 1, of every drive";
        return Err(RigError::Drive { what: "number of samples", value: samples as f64, expected });
    }
    let mut rig = AxesRig::at_rest(truth, sample_rate_hz, &at(0), seed, stream)?;
    let mut y = vec![Vec::with_capacity(samples); truth.axes()];
    for k in 0..samples {
        let start = at(k);
        let end = match truth.dac {
            Dac::Linear if k + 1 < samples => at(k + 1),
            Dac::Linear | Dac::Hold => start.clone(),
        };
        rig.next(&start, &end)?;
        for (list, reading) in y.iter_mut().zip(rig.readings_um()) {
            list.push(*reading);
        }
        if let Some(value) = rig.true_um().iter().find(|y| !y.is_finite()) {
            return Err(RigError::NotFinite { time_s: k as f64 / sample_rate_hz, value: *value });
        }
    }
    let inputs = drives.iter().enumerate().map(|(i, u)| Channel::new(&format!("u{}", i + 1), "V", u.clone()));
    let outputs = y.into_iter().enumerate().map(|(m, y)| Channel::new(&format!("y{}", m + 1), "um", y));
    let record = Record {
        name: format!("simulated_{name}"),
        time: TimeBase::uniform(sample_rate_hz),
        channels: inputs.chain(outputs).collect(),
        valid: None,
        source: None,
    };
    Ok((record, rig.clipped()))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn finite(volts: &[f64], actuators: usize) -> Result<(), RigError> {
    if volts.len() != actuators {
        let (what, expected) = ("number of drives", "one per actuator");
        return Err(RigError::Drive { what, value: volts.len() as f64, expected });
    }
    match volts.iter().find(|u| !u.is_finite()) {
        None => Ok(()),
        Some(value) => Err(RigError::Drive { what: "a sample", value: *value, expected: "finite voltages" }),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn at_rest_it_stays_at_the_strokes_of_its_actuators_through_its_modes() {
        let truth = AxesTruth::with_axes(3).unwrap();
        let rest = [2.0, -1.0, 3.0];
        let mut rig = AxesRig::at_rest(&truth, 5000.0, &rest, 1, 0).unwrap();
        let strokes: Vec<f64> = rig.strokes.clone();
        for _ in 0..50 {
            rig.next(&rest, &rest).unwrap();
        }
        for m in 0..3 {
            let modes = truth.modes.iter();
            let expected: f64 = modes.map(|mode| mode.motion[m] * dot(&mode.drive, &strokes)).sum();
            assert!((rig.true_um()[m] - expected).abs() < 1e-9, "{m}");
        }
    }

    /// One actuator without plays, one mode without neighbours: the textbook response to a step, behind a lag
    /// that is much faster.
    #[test]
    fn a_single_mode_has_the_textbook_step_response() {
        let mut truth = AxesTruth::with_axes(2).unwrap();
        for actuator in &mut truth.actuators {
            actuator.plays.clear();
            actuator.amplifier_corner_hz = 1e6;
            (actuator.quadratic_per_um, actuator.cubic_per_um2) = (0.0, 0.0);
            actuator.linear_um_per_v = 2.0;
        }
        truth.modes.truncate(1);
        (truth.modes[0].drive, truth.modes[0].motion) = (vec![1.0, 0.5], vec![1.0, -0.25]);
        let mut rig = AxesRig::at_rest(&truth, 5000.0, &[0.0, 0.0], 1, 0).unwrap();
        let (w, z) = (TAU * 310.0, 0.03_f64);
        let wd = w * (1.0 - z * z).sqrt();
        for k in 0..60 {
            rig.next(&[1.0, 2.0], &[1.0, 2.0]).unwrap();
            let t = f64::from(k) / 5000.0;
            let step = 1.0 - (-z * w * t).exp() * ((wd * t).cos() + z * w / wd * (wd * t).sin());
            // (1 + 0.5 · 2) · 2 µm; the first step of the grid is a ramp.
            let expected = 4.0 * step;
            assert!((rig.true_um()[0] - expected).abs() < 0.05, "{k}: {} {expected}", rig.true_um()[0]);
            assert!((rig.true_um()[1] + 0.25 * rig.true_um()[0]).abs() < 1e-12);
        }
    }

    #[test]
    fn what_is_not_possible_is_refused() {
        assert!(AxesTruth::with_axes(1).is_err() && AxesTruth::with_axes(7).is_err());
        let truth = AxesTruth::with_axes(2).unwrap();
        assert!(AxesRig::at_rest(&truth, 5000.0, &[0.0], 1, 0).is_err());
        assert!(AxesRig::at_rest(&truth, f64::NAN, &[0.0; 2], 1, 0).is_err());
        let mut odd = truth.clone();
        odd.modes[1].drive.pop();
        assert!(matches!(odd.validate(), Err(RigError::Parameter { .. })));
        let text = serde_json::to_string(&truth).unwrap();
        assert_eq!(serde_json::from_str::<AxesTruth>(&text).unwrap(), truth);
    }
}
