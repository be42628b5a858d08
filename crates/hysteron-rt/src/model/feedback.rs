//! Feedback beside feedforward: correction of the reference by the measured error.

use super::operator::in_range;
use super::{Limited, Limits, Linear, ModelError};
use crate::increment::accumulate;
use crate::model::Drive;
use crate::real::Real;
use crate::saved::{Tape, saves};

/// c = k e + i Σ e + H e: proportional, integral and linear dynamics in parallel, which covers PI, PI^λ (the
/// fractional integral as real poles) and an integral with a notch (its partial fractions: integral and pair
/// of poles).
///
/// While the drive is limited, integral and dynamics accept only errors that lead away from the limit
/// (anti-windup). An error that is infinite, above [`Real::LARGEST`] or not a number is ignored.
#[derive(Debug)]
pub struct Feedback<'a, T> {
    proportional: T,
    integral: T,
    dynamics: Linear<'a, T>,
    sum: T,
    carry: T,
    /// Last output of the parts with memory, Σ and H.
    remembered: T,
    correction: T,
}

/// Direction in which a drive was limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeldBack {
    /// It was not.
    No,
    /// It would have gone higher.
    Above,
    /// It would have gone lower.
    Below,
    /// It could not move.
    Both,
}

impl HeldBack {
    /// Direction for a sample of the drive and the voltage before it.
    pub fn of<T: Real>(drive: Drive<T>, before: T, limits: Limits<T>) -> Self {
        match drive.limited {
            Limited::No | Limited::Reference => Self::No,
            Limited::Overflow => Self::Both,
            Limited::Range | Limited::Step => {
                if drive.voltage > before || drive.voltage >= limits.high {
                    Self::Above
                } else {
                    Self::Below
                }
            }
        }
    }

    /// Whether it would have gone higher, and lower.
    pub(super) fn directions(self) -> (bool, bool) {
        (matches!(self, Self::Above | Self::Both), matches!(self, Self::Below | Self::Both))
    }

    /// The reverse of [`Self::directions`].
    pub(super) fn in_directions(above: bool, below: bool) -> Self {
        match (above, below) {
            (false, false) => Self::No,
            (true, false) => Self::Above,
            (false, true) => Self::Below,
            (true, true) => Self::Both,
        }
    }
}

impl<'a, T: Real> Feedback<'a, T> {
    /// The controller at rest; `integral` is the gain per sample.
    ///
    /// # Errors
    /// [`ModelError::Coefficient`] for a gain that is not finite.
    pub fn new(proportional: T, integral: T, dynamics: Linear<'a, T>) -> Result<Self, ModelError<T>> {
        if !(proportional.is_finite() && integral.is_finite()) {
            return Err(ModelError::Coefficient);
        }
        let zero = T::of(0.0);
        Ok(Self {
            proportional,
            integral,
            dynamics,
            sum: zero,
            carry: zero,
            remembered: zero,
            correction: zero,
        })
    }

    /// Resets all states to 0.
    pub fn rest(&mut self) {
        let zero = T::of(0.0);
        self.dynamics.rest_at(zero);
        (self.sum, self.carry, self.remembered, self.correction) = (zero, zero, zero, zero);
    }

    /// Everything that it remembers.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        self.dynamics.each_member(tape);
        for number in [&mut self.sum, &mut self.carry, &mut self.remembered, &mut self.correction] {
            tape.number(number);
        }
    }

    /// Correction to add to the reference, from the newest error and the direction in which the drive was
    /// limited since the last one.
    #[inline]
    pub fn step(&mut self, error: T, held: HeldBack) -> T {
        if !in_range(error) {
            return self.correction;
        }
        let zero = T::of(0.0);
        let outwards = match held {
            HeldBack::No => false,
            HeldBack::Above => error > zero,
            HeldBack::Below => error < zero,
            HeldBack::Both => true,
        };
        if !outwards {
            accumulate(&mut self.sum, &mut self.carry, self.integral * error);
            self.remembered = self.sum + self.dynamics.step(error);
        }
        self.correction = self.proportional * error + self.remembered;
        self.correction
    }
}

saves!(Feedback);

/// Uncompensated stage: reference to voltage by displacement = offset + slope · voltage, within limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<T> {
    offset: T,
    slope: T,
    limits: Limits<T>,
    voltage: T,
}

impl<T: Real> Line<T> {
    /// The line, standing at `voltage` (moved into the range).
    ///
    /// # Errors
    /// [`ModelError::Coefficient`] for a slope of 0 or numbers that are not finite, [`ModelError::Limits`].
    pub fn new(offset: T, slope: T, limits: Limits<T>, voltage: T) -> Result<Self, ModelError<T>> {
        let zero = T::of(0.0);
        if !(offset.is_finite() && slope.is_finite() && voltage.is_finite()) || slope == zero {
            return Err(ModelError::Coefficient);
        }
        if !limits.are_sound() {
            return Err(ModelError::Limits);
        }
        Ok(Self {
            offset,
            slope,
            limits,
            voltage: super::compensator::within(voltage, limits.low, limits.high),
        })
    }

    /// The voltage for the next period.
    #[inline]
    pub fn step(&mut self, reference: T) -> Drive<T> {
        let wanted = (reference - self.offset) / self.slope;
        if !wanted.is_finite() {
            return Drive { voltage: self.voltage, limited: Limited::Reference };
        }
        let Limits { low, high, step } = self.limits;
        let ranged = super::compensator::within(wanted, low, high);
        let voltage = super::compensator::within(ranged, self.voltage - step, self.voltage + step);
        self.voltage = voltage;
        let limited = if voltage != ranged {
            Limited::Step
        } else if ranged != wanted {
            Limited::Range
        } else {
            Limited::No
        };
        Drive { voltage, limited }
    }

    /// The limits of the voltage.
    pub fn limits(&self) -> Limits<T> {
        self.limits
    }

    /// The last voltage.
    pub fn voltage(&self) -> T {
        self.voltage
    }
}
