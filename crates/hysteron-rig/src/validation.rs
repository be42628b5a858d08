//! Validation of a truth.

use super::truth::{BoucWenFractional, Plant, PlayStack, Sensor, Truth};
use super::{PowerTerm, RigError};

impl Truth {
    /// Checks every number.
    ///
    /// # Errors
    /// [`RigError::Parameter`] or [`RigError::EmptyList`] naming the first invalid field,
    /// [`RigError::Improper`].
    pub fn validate(&self) -> Result<(), RigError> {
        if !(20..=10_000).contains(&self.oversampling) {
            return Err(wrong(
                "oversampling",
                f64::from(self.oversampling),
                "a whole number from 20 to 10000",
            ));
        }
        self.sensor.validate()?;
        match &self.plant {
            Plant::PlayStack(p) => p.validate(),
            Plant::BoucWenFractional(p) => p.validate(),
        }
    }
}

pub(super) fn wrong(parameter: impl Into<String>, value: f64, expected: &'static str) -> RigError {
    RigError::Parameter { parameter: parameter.into(), value, expected }
}

/// Largest magnitude of a number of the truth: far above any device, far below where products overflow.
const LARGEST: f64 = 1e12;
/// Largest frequency \[Hz\].
const FASTEST_HZ: f64 = 1e9;
/// Smallest frequency \[Hz\].
const SLOWEST_HZ: f64 = 1e-9;
/// Most modes, whose partial fractions are still told apart in double precision.
pub(super) const MOST_MODES: usize = 100;
/// Most plays.
pub(super) const MOST_PLAYS: usize = 10_000;
/// Most terms of a polynomial or a transfer function.
const MOST_TERMS: usize = 30;

pub(super) fn finite(parameter: &str, value: f64) -> Result<(), RigError> {
    if value.abs() <= LARGEST {
        Ok(())
    } else {
        Err(wrong(parameter, value, "a number of at most 1e12 in magnitude"))
    }
}

pub(super) fn at_most(parameter: &'static str, count: usize, most: usize) -> Result<(), RigError> {
    if count <= most { Ok(()) } else { Err(RigError::TooMany { parameter, count, most }) }
}

pub(super) fn frequency(parameter: String, value: f64) -> Result<(), RigError> {
    if (SLOWEST_HZ..=FASTEST_HZ).contains(&value) {
        Ok(())
    } else {
        Err(wrong(parameter, value, "a frequency from 1e-9 to 1e9 Hz"))
    }
}

pub(super) fn not_negative(parameter: impl Into<String>, value: f64) -> Result<(), RigError> {
    if (0.0..=LARGEST).contains(&value) {
        Ok(())
    } else {
        Err(wrong(parameter, value, "a number from 0 to 1e12"))
    }
}

pub(super) fn positive(parameter: impl Into<String>, value: f64) -> Result<(), RigError> {
    if value > 0.0 && value <= LARGEST {
        Ok(())
    } else {
        Err(wrong(parameter, value, "a number above 0, at most 1e12"))
    }
}

fn delay(value: f64) -> Result<(), RigError> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(wrong("plant.delay_s", value, "a time from 0 s to 1 s"))
    }
}

impl Sensor {
    pub(super) fn validate(&self) -> Result<(), RigError> {
        not_negative("sensor.noise_um", self.noise_um)?;
        finite("sensor.offset_um", self.offset_um)?;
        finite("sensor.drift_um_per_s", self.drift_um_per_s)?;
        not_negative("sensor.random_walk_um_per_sqrt_s", self.random_walk_um_per_sqrt_s)?;
        if let Some(adc) = &self.adc {
            if !(1..=32).contains(&adc.bits) {
                return Err(wrong("sensor.adc.bits", f64::from(adc.bits), "1 to 32"));
            }
            finite("sensor.adc.low_um", adc.low_um)?;
            if !(adc.high_um.is_finite() && adc.high_um > adc.low_um) {
                return Err(wrong("sensor.adc.high_um", adc.high_um, "a finite displacement above low_um"));
            }
        }
        Ok(())
    }
}

impl PlayStack {
    fn validate(&self) -> Result<(), RigError> {
        if let Some(f) = self.amplifier_corner_hz {
            frequency("plant.amplifier_corner_hz".to_owned(), f)?;
        }
        finite("plant.linear_um_per_v", self.linear_um_per_v)?;
        finite("plant.quadratic_per_um", self.quadratic_per_um)?;
        finite("plant.cubic_per_um2", self.cubic_per_um2)?;
        at_most("plant.plays", self.plays.len(), MOST_PLAYS)?;
        at_most("plant.modes", self.modes.len(), MOST_MODES)?;
        for (i, play) in self.plays.iter().enumerate() {
            not_negative(format!("plant.plays[{i}].rising_v"), play.rising_v)?;
            not_negative(format!("plant.plays[{i}].falling_v"), play.falling_v)?;
            finite(&format!("plant.plays[{i}].weight_um_per_v"), play.weight_um_per_v)?;
        }
        if self.modes.is_empty() {
            return Err(RigError::EmptyList { parameter: "plant.modes" });
        }
        for (i, mode) in self.modes.iter().enumerate() {
            frequency(format!("plant.modes[{i}].frequency_hz"), mode.frequency_hz)?;
            positive(format!("plant.modes[{i}].share"), mode.share)?;
            if !(mode.damping > 0.0 && mode.damping < 1.0) {
                return Err(wrong(format!("plant.modes[{i}].damping"), mode.damping, "above 0 and below 1"));
            }
        }
        if let Some(creep) = &self.creep {
            not_negative("plant.creep.strength", creep.strength)?;
            not_negative("plant.creep.corner_hz", creep.corner_hz)?;
            if !(creep.order > 0.0 && creep.order < 1.0) {
                return Err(wrong("plant.creep.order", creep.order, "above 0 and below 1"));
            }
        }
        delay(self.delay_s)
    }
}

impl BoucWenFractional {
    fn validate(&self) -> Result<(), RigError> {
        if self.polynomial.is_empty() {
            return Err(RigError::EmptyList { parameter: "plant.polynomial" });
        }
        at_most("plant.polynomial", self.polynomial.len(), MOST_TERMS)?;
        for (i, &c) in self.polynomial.iter().enumerate() {
            finite(&format!("plant.polynomial[{i}]"), c)?;
        }
        finite("plant.alpha", self.alpha)?;
        finite("plant.beta", self.beta)?;
        finite("plant.gamma", self.gamma)?;
        if !(self.n.is_finite() && self.n >= 1.0) {
            return Err(wrong("plant.n", self.n, "a finite number, at least 1"));
        }
        let numerator_order = highest_order("plant.numerator", &self.numerator)?;
        let denominator_order = highest_order("plant.denominator", &self.denominator)?;
        if numerator_order > denominator_order {
            return Err(RigError::Improper { numerator_order, denominator_order });
        }
        delay(self.delay_s)
    }
}

fn highest_order(list: &'static str, terms: &[PowerTerm]) -> Result<f64, RigError> {
    at_most(list, terms.len(), MOST_TERMS)?;
    for (i, term) in terms.iter().enumerate() {
        finite(&format!("{list}[{i}].coefficient"), term.coefficient)?;
        if !(0.0..=20.0).contains(&term.order) {
            return Err(wrong(format!("{list}[{i}].order"), term.order, "from 0 to 20"));
        }
    }
    terms
        .iter()
        .filter(|t| t.coefficient != 0.0)
        .map(|t| t.order)
        .max_by(f64::total_cmp)
        .ok_or(RigError::EmptyList { parameter: list })
}
