//! Hysteresis in feedback: a mass on a hysteretic spring, driven by a force.
//!
//! m ÿ + c ẏ + k y + z = u,  ż = α ẏ − β |ẏ| z |z|ⁿ⁻¹ − γ ẏ |z|ⁿ,  n ≥ 1.
//!
//! In a Hammerstein model ([`crate::hammerstein`]) hysteresis is ahead of linear dynamics; here it is a
//! restoring force within them, so that resonances move with the amplitude. At small motion z ≈ α y: the
//! stiffness is k + α.
//!
//! * [`Oscillator`]: the parameters; [`Oscillator::simulate`], and with exact derivatives
//!   [`Oscillator::simulate_with_sensitivities`].
//! * [`Drive`]: the force and its inter-sample behaviour.
//! * [`Oscillator::simulate_record`]: a whole record at once, from a [`Start`](crate::Start).
//!
//! Identified by `hysteron_identify::oscillator`.
//!
//! Sources: R. Bouc 1967; Y.-K. Wen, *J. Eng. Mech. Div. ASCE* 102 (1976) 249–263; F. Ikhouane, J. Rodellar,
//! *Systems with Hysteresis*, Wiley 2007, doi:10.1002/9780470513200; J. P. Noël, M. Schoukens, *Hysteretic
//! benchmark with a dynamic nonlinearity*, Workshop on Nonlinear System Identification Benchmarks, Brussels
//! 2016, which writes βγ for β and βδ for γ.

mod drive;
mod record;
mod sensitivities;
mod simulate;
mod step;

pub use crate::simulation_error::SimulationError;
pub use drive::Drive;
pub use sensitivities::{PARTIALS, Response};

use crate::hysteresis::{Admissibility, UnitShape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of the oscillator m ÿ + c ẏ + k y + z = u, ż = α ẏ − β |ẏ| z |z|ⁿ⁻¹ − γ ẏ |z|ⁿ.
///
/// Units: those of the record, u in N and y in µm, say; then m in N s²/µm, and so on. Any other pair is
/// possible.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Oscillator {
    /// Mass m > 0 \[N s²/µm\].
    pub mass: f64,
    /// Viscous damping c \[N s/µm\].
    pub damping: f64,
    /// Elastic stiffness k, of the spring beside the hysteretic one \[N/µm\].
    pub stiffness: f64,
    /// Stiffness α of the hysteretic spring at small motion \[N/µm\].
    pub alpha: f64,
    /// Shape of the loop \[N^(1−n)/µm\], factor of |ẏ| z |z|ⁿ⁻¹.
    pub beta: f64,
    /// Shape of the loop, factor of ẏ |z|ⁿ; same unit as `beta`.
    pub gamma: f64,
    /// Smoothness of the transition, ≥ 1.
    pub n: f64,
}

/// State of the oscillator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OscillatorState {
    /// Displacement \[µm\].
    pub y: f64,
    /// Velocity \[µm/s\].
    pub velocity: f64,
    /// Hysteretic force \[N\].
    pub z: f64,
}

/// Most steps taken from one sample to the next.
const MOST_STEPS: f64 = 1000.0;
/// Fewest steps taken from one sample to the next: a band-limited force is followed between its samples.
const FEWEST_STEPS: f64 = 4.0;
/// Longest step, times the natural frequency at small motion \[rad\].
const LONGEST_STEP: f64 = 0.03;

impl Oscillator {
    /// Names of the parameters, in the order of [`Self::values`].
    pub const NAMES: [&str; 7] = ["mass", "damping", "stiffness", "alpha", "beta", "gamma", "n"];

    /// The parameters in the order of [`Self::NAMES`].
    pub fn values(&self) -> [f64; 7] {
        [self.mass, self.damping, self.stiffness, self.alpha, self.beta, self.gamma, self.n]
    }

    /// The oscillator with these parameters, in the order of [`Self::NAMES`]; not checked.
    pub fn from_values([mass, damping, stiffness, alpha, beta, gamma, n]: [f64; 7]) -> Self {
        Self { mass, damping, stiffness, alpha, beta, gamma, n }
    }

    /// Checks that every parameter is finite, m > 0 and n ≥ 1. Nothing else: parameters that allow unbounded
    /// motion are simulated until it occurs.
    ///
    /// # Errors
    /// [`SimulationError::Parameter`], the first found.
    pub fn validate(&self) -> Result<(), SimulationError> {
        for (name, value) in Self::NAMES.into_iter().zip(self.values()) {
            let (allowed, expected) = match name {
                "mass" => (value > 0.0, "a finite number above 0"),
                "n" => (value >= 1.0, "a finite number of at least 1"),
                _ => (true, "a finite number"),
            };
            if !(allowed && value.is_finite()) {
                return Err(SimulationError::Parameter { name, value, expected });
            }
        }
        Ok(())
    }

    /// Natural frequency at small motion, √((k + α)/m)/2π \[Hz\]; 0 where k + α ≤ 0.
    pub fn natural_frequency_hz(&self) -> f64 {
        ((self.stiffness + self.alpha).max(0.0) / self.mass).sqrt() / std::f64::consts::TAU
    }

    /// Viscous damping ratio at small motion, c/(2√((k + α) m)); infinite where k + α ≤ 0.
    pub fn damping_ratio(&self) -> f64 {
        0.5 * self.damping / ((self.stiffness + self.alpha).max(0.0) * self.mass).sqrt()
    }

    /// Steps from one sample to the next with which simulations are made: none longer than 0.03 rad of the
    /// natural frequency at small motion, at least four.
    ///
    /// The error of a step is that of the corners of ż, where ẏ or z change sign: second order, measured on
    /// the public benchmark 5e-5 of the rms displacement at ten steps per sample (0.030 rad).
    pub fn steps(&self, sample_rate_hz: f64) -> usize {
        let angle = std::f64::consts::TAU * self.natural_frequency_hz() / sample_rate_hz;
        (angle / LONGEST_STEP).ceil().clamp(FEWEST_STEPS, MOST_STEPS) as usize
    }

    /// The shape of the unit-α form, z = α ζ, ζ in the unit of y: β' = β|α|ⁿ⁻¹, γ' = sign(α) γ |α|ⁿ⁻¹.
    pub fn unit_shape(&self) -> UnitShape {
        let size = self.alpha.abs().powf(self.n - 1.0);
        UnitShape {
            beta: self.beta * size,
            gamma: if self.alpha < 0.0 { -self.gamma } else { self.gamma } * size,
            n: self.n,
        }
    }

    /// That the motion leaves the range of numbers before sample `index`, and why.
    fn overflow(&self, index: usize) -> SimulationError {
        let bounded = self.admissibility().is_bounded() && self.stiffness > 0.0 && self.damping > 0.0;
        if bounded { SimulationError::TooFast { index } } else { SimulationError::RunsAway { index } }
    }

    /// Boundedness of z for every motion; the displacement is then bounded where k > 0 and c > 0.
    pub fn admissibility(&self) -> Admissibility {
        self.unit_shape().admissibility()
    }
}
