//! Truth of a bench of several axes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::RigError;
use crate::plays::Play;
use crate::truth::{Adc, Dac, Sensor};
use crate::validation::{MOST_MODES, MOST_PLAYS, at_most, finite, frequency, not_negative, positive, wrong};

/// Most actuators and axes.
const MOST: usize = 16;

/// The whole bench of several axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxesTruth {
    /// One actuator per input.
    pub actuators: Vec<HystereticActuator>,
    /// Vibration modes that couple them.
    pub modes: Vec<CoupledMode>,
    /// Interpolation of the drives between two samples of the command.
    #[serde(default)]
    pub dac: Dac,
    /// The sensor of every axis; each has its own noise.
    pub sensor: Sensor,
    /// Steps of the computation in one sample period, ≥ 20.
    pub oversampling: u32,
}

/// Amplifier and hysteresis of one actuator: s = linear·u + Σ plays, v = s + quadratic·s² + cubic·s³.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HystereticActuator {
    /// Corner of the amplifier's first-order lag \[Hz\].
    pub amplifier_corner_hz: f64,
    /// Reversible part \[µm/V\].
    pub linear_um_per_v: f64,
    /// Irreversible part.
    pub plays: Vec<Play>,
    /// Coefficient of s² \[1/µm\].
    pub quadratic_per_um: f64,
    /// Coefficient of s³ \[1/µm²\].
    pub cubic_per_um2: f64,
}

/// A mode q'' + 2 ζ ω q' + ω² q = ω² Σ drive_i v_i, which moves axis m by motion_m q.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledMode {
    /// Natural frequency \[Hz\].
    pub frequency_hz: f64,
    /// Damping ratio, between 0 and 1.
    pub damping: f64,
    /// Share of the stroke of every actuator.
    pub drive: Vec<f64>,
    /// Motion of every axis.
    pub motion: Vec<f64>,
}

impl AxesTruth {
    /// The default bench of this number of actuators and axes, 2 to 6: strokes of about ±12 µm at ±6 V, loops
    /// that open by about a tenth, a mode near 310 Hz for the first axis and higher for the others, each with
    /// a few per cent of its neighbours, and one at 1200 Hz shared by all.
    ///
    /// # Errors
    /// [`RigError::Parameter`] for another number.
    pub fn with_axes(axes: usize) -> Result<Self, RigError> {
        if !(2..=6).contains(&axes) {
            return Err(wrong("axes", axes as f64, "a whole number from 2 to 6"));
        }
        let actuator = |i: usize| {
            let share = 1.0 + 0.1 * i as f64;
            let plays = (0..12)
                .map(|j| {
                    let r = 3.0 * (f64::from(j) + 0.5) / 12.0;
                    Play {
                        rising_v: (1.05 + 0.02 * i as f64) * r,
                        falling_v: (0.95 - 0.02 * i as f64) * r,
                        weight_um_per_v: 0.04 * share * (-r / 2.0).exp(),
                    }
                })
                .collect();
            HystereticActuator {
                amplifier_corner_hz: 2500.0 - 150.0 * i as f64,
                linear_um_per_v: 1.7 + 0.12 * i as f64,
                plays,
                quadratic_per_um: 6e-4 * (1.0 - 0.5 * i as f64),
                cubic_per_um2: -2e-5,
            }
        };
        // Coupling of axis and actuator, a few per cent, of either sign.
        let coupling = |a: usize, b: usize| {
            if a == b { 1.0 } else { [0.025, -0.018, 0.012][(2 * a + b) % 3] }
        };
        let axis = |k: usize| CoupledMode {
            frequency_hz: 310.0 + 95.0 * k as f64,
            damping: 0.03,
            drive: (0..axes).map(|i| coupling(k, i)).collect(),
            motion: (0..axes).map(|m| coupling(m, k)).collect(),
        };
        let mut modes: Vec<CoupledMode> = (0..axes).map(axis).collect();
        modes.push(CoupledMode {
            frequency_hz: 1200.0,
            damping: 0.02,
            drive: (0..axes).map(|i| if i % 2 == 0 { 0.03 } else { -0.02 }).collect(),
            motion: (0..axes).map(|m| 0.5 + 0.2 * m as f64).collect(),
        });
        Ok(Self {
            actuators: (0..axes).map(actuator).collect(),
            modes,
            dac: Dac::Linear,
            sensor: Sensor {
                noise_um: 0.002,
                offset_um: 0.0,
                drift_um_per_s: 0.0,
                random_walk_um_per_sqrt_s: 0.0,
                adc: Some(Adc { bits: 16, low_um: -40.0, high_um: 40.0 }),
            },
            oversampling: 20,
        })
    }

    /// Number of axes: that of the motions of a mode.
    pub fn axes(&self) -> usize {
        self.modes.first().map_or(0, |mode| mode.motion.len())
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`RigError::Parameter`], [`RigError::EmptyList`] or [`RigError::TooMany`] naming the first invalid
    /// field.
    pub fn validate(&self) -> Result<(), RigError> {
        if !(20..=10_000).contains(&self.oversampling) {
            let expected = "a whole number from 20 to 10000";
            return Err(wrong("oversampling", f64::from(self.oversampling), expected));
        }
        self.sensor.validate()?;
        let (actuators, axes) = (self.actuators.len(), self.axes());
        for (parameter, count) in
            [("actuators", actuators), ("modes", self.modes.len()), ("modes[0].motion", axes)]
        {
            if count == 0 {
                return Err(RigError::EmptyList { parameter });
            }
        }
        at_most("actuators", actuators, MOST)?;
        at_most("modes", self.modes.len(), MOST_MODES)?;
        at_most("modes[0].motion", axes, MOST)?;
        for (i, actuator) in self.actuators.iter().enumerate() {
            let field = |name: &str| format!("actuators[{i}].{name}");
            frequency(field("amplifier_corner_hz"), actuator.amplifier_corner_hz)?;
            finite(&field("linear_um_per_v"), actuator.linear_um_per_v)?;
            finite(&field("quadratic_per_um"), actuator.quadratic_per_um)?;
            finite(&field("cubic_per_um2"), actuator.cubic_per_um2)?;
            at_most("actuators[].plays", actuator.plays.len(), MOST_PLAYS)?;
            for (j, play) in actuator.plays.iter().enumerate() {
                not_negative(field(&format!("plays[{j}].rising_v")), play.rising_v)?;
                not_negative(field(&format!("plays[{j}].falling_v")), play.falling_v)?;
                finite(&field(&format!("plays[{j}].weight_um_per_v")), play.weight_um_per_v)?;
            }
        }
        for (k, mode) in self.modes.iter().enumerate() {
            let field = |name: &str| format!("modes[{k}].{name}");
            frequency(field("frequency_hz"), mode.frequency_hz)?;
            positive(field("damping"), mode.damping)?;
            if mode.damping >= 1.0 {
                return Err(wrong(field("damping"), mode.damping, "above 0 and below 1"));
            }
            for (name, list, count) in [("drive", &mode.drive, actuators), ("motion", &mode.motion, axes)] {
                if list.len() != count {
                    let expected = "one number per actuator in drive, one per axis in motion, in every mode";
                    return Err(wrong(field(name), list.len() as f64, expected));
                }
                list.iter().try_for_each(|x| finite(&field(name), *x))?;
            }
        }
        Ok(())
    }

    /// One-line description of the true plant.
    pub fn describe(&self) -> String {
        format!(
            "{} actuators with asymmetric plays and a bend each, {} axes, {} coupled modes, amplifier lags",
            self.actuators.len(),
            self.axes(),
            self.modes.len()
        )
    }
}
