//! A controller: the inverse, with feedback on the reading and an observer of the disturbance around it.

use super::{Compensator, Drive, Feedback, HeldBack, Limits, ModelError, Observer};
use crate::real::Real;
use crate::saved::{Tape, saves};

/// voltage = inverse\[reference + c, d\]: c the correction of a [`Feedback`] by the error of the last reading, d
/// the disturbance of an [`Observer`]; either may be absent.
///
/// A period is [`Self::step`], then [`Self::measured`] with the reading taken when the voltage has gone out:
/// the reading of one period determines the voltage of the next. Coefficients and memory are borrowed; no
/// allocation, no panic, bounded cost of a period.
#[derive(Debug)]
pub struct Controller<'a, T> {
    inverse: Compensator<'a, T>,
    feedback: Option<Feedback<'a, T>>,
    observer: Option<Observer<'a, T>>,
    /// References from the present one on; `due_at` is where the next is written.
    due: &'a mut [T],
    due_at: usize,
    error: T,
    held: HeldBack,
}

impl<'a, T: Real> Controller<'a, T> {
    /// The controller, its stage at rest and virgin at the voltage of the range closest to 0. `due` holds as
    /// many numbers as the law's preview, and one more.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where `due` is empty; those of [`Self::rest_after`].
    pub fn new(
        inverse: Compensator<'a, T>,
        feedback: Option<Feedback<'a, T>>,
        observer: Option<Observer<'a, T>>,
        due: &'a mut [T],
    ) -> Result<Self, ModelError<T>> {
        if due.is_empty() {
            return Err(ModelError::Memory { expected: 1, found: 0 });
        }
        let (voltage, displacement) = (inverse.voltage(), inverse.displacement());
        let (due_at, error, held) = (0, T::of(0.0), HeldBack::No);
        let mut controller = Self { inverse, feedback, observer, due, due_at, error, held };
        controller.rest_after(voltage, voltage, displacement)?;
        Ok(controller)
    }

    /// Resets to steady state at `voltage` (clamped to the range), reached monotonically from `virgin`, where
    /// the sensor reads `measured`: the disturbance is what it lies above the model. Returns the displacement
    /// of the model, at which the reference stands.
    ///
    /// # Errors
    /// [`ModelError::Start`] for a reading that is not finite; those of [`Compensator::rest_after`] and
    /// [`Observer::rest_after`].
    pub fn rest_after(&mut self, virgin: T, voltage: T, measured: T) -> Result<T, ModelError<T>> {
        if !measured.is_finite() {
            return Err(ModelError::Start { displacement: measured });
        }
        let displacement = self.inverse.rest_after(virgin, voltage)?;
        if let Some(observer) = &mut self.observer {
            observer.rest_after(virgin, self.inverse.voltage(), measured)?;
        }
        if let Some(feedback) = &mut self.feedback {
            feedback.rest();
        }
        self.due.fill(displacement);
        (self.due_at, self.error, self.held) = (0, T::of(0.0), HeldBack::No);
        Ok(displacement)
    }

    /// Appends a reference sample without a step, to fill the preview before the first one.
    /// [`Compensator::know`].
    #[inline]
    pub fn know(&mut self, reference: T) -> bool {
        let sound = self.inverse.know(reference);
        self.take_reference();
        sound
    }

    /// The newest reference, as the inverse has taken it.
    fn take_reference(&mut self) {
        if let Some(slot) = self.due.get_mut(self.due_at) {
            *slot = self.inverse.reference();
        }
        self.due_at += 1;
        if self.due_at >= self.due.len() {
            self.due_at = 0;
        }
    }

    /// The voltage for the next period. `reference` is the newest known sample, ahead by the preview.
    #[inline]
    pub fn step(&mut self, reference: T) -> Drive<T> {
        let zero = T::of(0.0);
        let correction = self.feedback.as_mut().map_or(zero, |f| f.step(self.error, self.held));
        let disturbance = self.observer.as_ref().map_or(zero, Observer::disturbance);
        let before = self.inverse.voltage();
        let drive = self.inverse.step_against(reference, disturbance - correction);
        self.take_reference();
        self.held = HeldBack::of(drive, before, self.inverse.limits());
        drive
    }

    /// The displacement read when the voltage of the last step has gone out. Returns whether it is finite; one
    /// that is not, where there is no reading, changes neither correction nor disturbance.
    #[inline]
    pub fn measured(&mut self, reading: T) -> bool {
        let due = self.due.get(self.due_at).copied().unwrap_or(reading);
        self.error = due - reading;
        if let Some(observer) = &mut self.observer {
            // A voltage that the model refuses leaves the disturbance as it was.
            let _ = observer.step(self.inverse.voltage(), reading);
        }
        self.error.is_finite()
    }

    /// Sets gain and offset of the displacement, for inverse and observer, from the next step on:
    /// [`Model::trim`](super::Model::trim). The disturbance stays, and follows the next readings.
    ///
    /// # Errors
    /// [`ModelError::Coefficient`]; all are then as they were.
    pub fn trim(&mut self, gain: T, offset: T) -> Result<(), ModelError<T>> {
        self.inverse.trim(gain, offset)?;
        match &mut self.observer {
            Some(observer) => observer.trim(gain, offset),
            None => Ok(()),
        }
    }

    /// Everything that it remembers.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        self.inverse.each_member(tape);
        if let Some(feedback) = &mut self.feedback {
            feedback.each_member(tape);
        }
        if let Some(observer) = &mut self.observer {
            observer.each_member(tape);
        }
        tape.numbers(self.due);
        tape.index(&mut self.due_at, self.due.len());
        tape.number(&mut self.error);
        let (mut above, mut below) = self.held.directions();
        tape.flag(&mut above);
        tape.flag(&mut below);
        self.held = HeldBack::in_directions(above, below);
    }

    /// The last voltage.
    pub fn voltage(&self) -> T {
        self.inverse.voltage()
    }

    /// Displacement of the model now: [`Compensator::displacement`].
    pub fn displacement(&self) -> T {
        self.inverse.displacement()
    }

    /// The limits of the voltage.
    pub fn limits(&self) -> Limits<T> {
        self.inverse.limits()
    }
}

saves!(Controller);
