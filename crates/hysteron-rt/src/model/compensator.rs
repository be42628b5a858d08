//! Feedforward sample by sample: the voltage that makes a model's displacement follow a reference.

use super::{Hysteresis, LANES, Linear, MOST_TAPS, ModelError};
use crate::real::Real;
use crate::saved::{Tape, saves};

/// The linear part of a compensator: the hysteresis output v with which the dynamics follow the reference,
/// from their state and the known samples of the reference,
///
/// v = v₁ + Σ recentₗ (v₁₊ₗ − v₁) + Σ kₙ (xₙ − v₁) + Σ fⱼ (rⱼ − y₁),
///
/// v₁, v₂, … the last outputs, xₙ the states of the [`Sections`](super::Sections), rⱼ the reference, the
/// newest first, y₁ the steady-state displacement for v₁. All terms vanish at rest, so that a constant
/// reference is reached exactly whatever the rounding of the gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<'a, T> {
    /// Gains on v₂ − v₁, v₃ − v₁, …: at most [`MOST_TAPS`].
    pub recent: &'a [T],
    /// Gains on the real poles, a group each.
    pub real: &'a [[T; LANES]],
    /// Gains on the pairs: real part (counted from v₁), imaginary part.
    pub pairs: &'a [[T; 2]],
    /// Gains fⱼ on the reference, at least one, the newest first.
    pub reference: &'a [T],
}

/// Limits of the drive voltage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits<T> {
    /// Least voltage.
    pub low: T,
    /// Largest voltage.
    pub high: T,
    /// Largest change from one sample to the next, to the rounding of the voltage; infinite for none, at
    /// least four units in the last place of the voltages.
    pub step: T,
}

impl<T: Real> Limits<T> {
    /// Whether the range is not empty and its voltages resolve the step.
    pub(super) fn are_sound(&self) -> bool {
        let width = self.high - self.low;
        let largest = if self.high.abs() > self.low.abs() { self.high.abs() } else { self.low.abs() };
        width > T::of(0.0) && width.is_finite() && self.step >= T::of(4.0) * T::EPSILON * largest
    }
}

/// Reason why a drive was held back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limited {
    /// Nothing: the model follows.
    No,
    /// The range of voltages.
    Range,
    /// The largest change from one sample to the next.
    Step,
    /// The reference was infinite or not a number (its last finite value was followed), or so large that no
    /// voltage follows (the stage was held).
    Reference,
    /// The hysteresis has left the range of the number type (inadmissible parameters): the voltage stays as
    /// it was.
    Overflow,
}

/// A sample of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive<T> {
    /// The voltage: within the limits, always.
    pub voltage: T,
    /// Reason why it was held back.
    pub limited: Limited,
}

/// The inverse of a model, sample by sample: reference in, voltage out.
///
/// The reference enters ([`Law::reference`]) as far ahead as it is previewed; beyond that the gains predict
/// it. The voltage is the one at which one monotone move reaches the desired hysteresis output
/// ([`Hysteresis::reach`]); at a limit the states follow the voltage really applied (anti-windup).
///
/// Coefficients and memory are borrowed; no allocation, no panic, bounded cost of a step.
#[derive(Debug)]
pub struct Compensator<'a, T> {
    hysteresis: Hysteresis<'a, T>,
    dynamics: Linear<'a, T>,
    law: Law<'a, T>,
    /// Ring buffer of the reference; `at` is its next write position.
    ring: &'a mut [T],
    at: usize,
    /// Its newest value.
    reference: T,
    limits: Limits<T>,
    /// Trims of the displacement.
    trim: T,
    offset: T,
    /// DC gain of taps and sections.
    gain: T,
    /// Output of the hysteresis, and an estimate of its slope.
    output: T,
    slope: T,
    displacement: T,
}

impl<'a, T: Real> Compensator<'a, T> {
    /// The compensator, at rest and virgin at the voltage of the range closest to 0. `ring` holds as many
    /// numbers as the law has gains on the reference. The dynamics are those of the model under zero-order
    /// hold, without the whole samples of its delay (no [`SectionsMemory::delay`]).
    ///
    /// [`SectionsMemory::delay`]: super::SectionsMemory::delay
    ///
    /// # Errors
    /// [`ModelError::Memory`] where ring, law and sections do not fit each other, [`ModelError::Taps`],
    /// [`ModelError::Coefficient`] for a gain or offset that is not finite, [`ModelError::Limits`].
    pub fn new(
        hysteresis: Hysteresis<'a, T>,
        dynamics: Linear<'a, T>,
        law: Law<'a, T>,
        ring: &'a mut [T],
        limits: Limits<T>,
        offset: T,
    ) -> Result<Self, ModelError<T>> {
        let zero = T::of(0.0);
        if law.recent.len() > MOST_TAPS {
            return Err(ModelError::Taps { found: law.recent.len() });
        }
        let sections = *dynamics.sections();
        for (expected, found) in [
            (law.reference.len().max(1), ring.len()),
            (sections.real.len(), law.real.len()),
            (sections.pairs.len(), law.pairs.len()),
            (0, dynamics.memory().delay.len()),
        ] {
            if expected != found {
                return Err(ModelError::Memory { expected, found });
            }
        }
        let finite = |numbers: &[T]| numbers.iter().all(|x| x.is_finite());
        let sound = offset.is_finite()
            && finite(law.recent)
            && law.real.iter().all(|k| finite(k))
            && law.pairs.iter().all(|k| finite(k))
            && finite(law.reference);
        if !sound {
            return Err(ModelError::Coefficient);
        }
        if !limits.are_sound() {
            return Err(ModelError::Limits);
        }
        let sum = |numbers: &[T]| numbers.iter().fold(zero, |sum, &x| sum + x);
        let mut gain = sum(sections.taps);
        for poles in sections.real {
            gain = gain + sum(&poles.weight);
        }
        for pair in sections.pairs {
            let [re, _] = pair.weight;
            gain = gain + re;
        }
        let mut compensator = Self {
            hysteresis,
            dynamics,
            law,
            ring,
            at: 0,
            reference: zero,
            limits,
            trim: T::of(1.0),
            offset,
            gain,
            output: zero,
            slope: T::of(1.0),
            displacement: zero,
        };
        compensator.rest_at(zero)?;
        Ok(compensator)
    }

    /// Resets to steady state, hysteresis virgin, at `voltage` (clamped to the range), with the reference at
    /// the displacement there, which is returned.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`]; the compensator is then as it was.
    pub fn rest_at(&mut self, voltage: T) -> Result<T, ModelError<T>> {
        self.rest_after(voltage, voltage)
    }

    /// [`Self::rest_at`] after a monotone move from the voltage `virgin`, where the hysteresis was virgin.
    ///
    /// # Errors
    /// Those of [`Self::rest_at`]; [`ModelError::Overflow`] leaves it at rest and virgin at its voltage
    /// before the call.
    pub fn rest_after(&mut self, virgin: T, voltage: T) -> Result<T, ModelError<T>> {
        if !(voltage.is_finite() && virgin.is_finite()) {
            return Err(ModelError::NotFinite);
        }
        let [voltage, stood] =
            [voltage, self.hysteresis.voltage()].map(|u| within(u, self.limits.low, self.limits.high));
        let outcome = self.hysteresis.rest_after(virgin, voltage);
        let (voltage, output) = match outcome {
            Ok(output) => (voltage, output),
            Err(_) => (stood, self.hysteresis.rest_at(stood)),
        };
        self.output = output;
        self.dynamics.rest_at(self.output);
        self.displacement = self.offset + self.trim * self.dynamics.output_at_rest();
        self.stand_at(self.displacement);
        // Slope at rest, the first estimate.
        let away = T::of(1e-3) * (self.limits.high - self.limits.low);
        let rise = (self.hysteresis.look(voltage + away) - self.output) / away;
        self.slope = if rise > T::of(0.0) && rise.is_finite() { rise } else { T::of(1.0) };
        outcome.map(|_| self.displacement)
    }

    /// Sets all past references to `displacement`.
    fn stand_at(&mut self, displacement: T) {
        self.ring.fill(displacement);
        self.reference = displacement;
        self.at = 0;
    }

    /// Chooses the offset so that the steady-state displacement is the measured `displacement`: bumpless
    /// start, in mid-stroke too. To be called after [`Self::rest_at`] or [`Self::rest_after`].
    ///
    /// # Errors
    /// [`ModelError::Start`]; the compensator is then as it was.
    pub fn measured_at_rest(&mut self, displacement: T) -> Result<(), ModelError<T>> {
        let offset = displacement - self.trim * self.dynamics.output_at_rest();
        if !offset.is_finite() {
            return Err(ModelError::Start { displacement });
        }
        self.offset = offset;
        self.displacement = displacement;
        self.stand_at(displacement);
        Ok(())
    }

    /// Sets gain and offset of the displacement, from the next step on:
    /// [`Model::trim`](super::Model::trim).
    ///
    /// # Errors
    /// [`ModelError::Coefficient`]; both are then as they were.
    pub fn trim(&mut self, gain: T, offset: T) -> Result<(), ModelError<T>> {
        super::trims_are_sound(gain, offset)?;
        (self.trim, self.offset) = (gain, offset);
        Ok(())
    }

    /// Everything that it remembers.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        self.hysteresis.each_member(tape);
        self.dynamics.each_member(tape);
        tape.numbers(self.ring);
        tape.index(&mut self.at, self.ring.len());
        for number in [
            &mut self.reference,
            &mut self.trim,
            &mut self.offset,
            &mut self.output,
            &mut self.slope,
            &mut self.displacement,
        ] {
            tape.number(number);
        }
    }

    /// Appends a reference sample without a step, to fill the preview before the first one. Returns whether
    /// it is finite; if not, the previous sample is repeated.
    #[inline]
    pub fn know(&mut self, reference: T) -> bool {
        let sound = reference.is_finite();
        self.reference = if sound { reference } else { self.reference };
        if let Some(slot) = self.ring.get_mut(self.at) {
            *slot = self.reference;
        }
        self.at += 1;
        if self.at >= self.ring.len() {
            self.at = 0;
        }
        sound
    }

    /// The voltage for the next period. `reference` is the newest known sample, ahead by the preview of the
    /// law.
    #[inline]
    pub fn step(&mut self, reference: T) -> Drive<T> {
        self.step_against(reference, T::of(0.0))
    }

    /// [`Self::step`] with compensation of a `disturbance` estimated by an [`Observer`](super::Observer): the
    /// displacement of the stage less that of the model. It is subtracted from the whole reference at once.
    /// One that is not finite counts as 0.
    #[inline]
    pub fn step_against(&mut self, reference: T, disturbance: T) -> Drive<T> {
        let sound = self.know(reference);
        let disturbance = if disturbance.is_finite() { disturbance } else { T::of(0.0) };
        let wanted = self.wanted(disturbance);
        // A reference near the largest number overflows the law to infinity or NaN.
        let sound = sound && wanted.is_finite();
        let wanted = if wanted.is_finite() { wanted } else { self.output };
        let (limits, voltage) = (self.limits, self.hysteresis.voltage());
        let low = within(voltage - limits.step, limits.low, limits.high);
        let high = within(voltage + limits.step, limits.low, limits.high);
        let reached = self.hysteresis.reach(self.output, wanted, [low, high], self.slope);
        let Ok(output) = self.hysteresis.step(reached.voltage) else {
            self.displacement = self.offset + self.trim * self.dynamics.step(self.output);
            return Drive { voltage, limited: Limited::Overflow };
        };
        let slope = (output - self.output) / (reached.voltage - voltage);
        if slope > T::of(0.0) && slope.is_finite() {
            self.slope = slope;
        }
        self.output = output;
        self.displacement = self.offset + self.trim * self.dynamics.step(output);
        let limited = if !sound {
            Limited::Reference
        } else if !reached.missed {
            Limited::No
        } else if reached.voltage == limits.low || reached.voltage == limits.high {
            Limited::Range
        } else {
            Limited::Step
        };
        Drive { voltage: reached.voltage, limited }
    }

    /// The law.
    #[inline(always)]
    fn wanted(&self, disturbance: T) -> T {
        let (rest, recent) = self.dynamics.inputs();
        let newest = recent.before(0);
        let states = self.dynamics.memory();
        let mut sum = T::of(0.0);
        for (older, gain) in self.law.recent.iter().enumerate() {
            sum = sum + *gain * (recent.before(older + 1) - newest);
        }
        for (gains, state) in self.law.real.iter().zip(states.real.iter()) {
            for (gain, x) in gains.iter().zip(&state.value) {
                sum = sum + *gain * (*x - newest);
            }
        }
        for ([on_re, on_im], state) in self.law.pairs.iter().zip(states.pairs.iter()) {
            let [re, im] = state.value;
            sum = sum + *on_re * (re - newest) + *on_im * im;
        }
        let (trim, per_trim) = (self.trim, T::of(1.0) / self.trim);
        let settles =
            self.offset + trim * self.dynamics.output_at_rest() + trim * (self.gain * newest) + disturbance;
        let (older, newer) = self.ring.split_at_checked(self.at).unwrap_or((&[], self.ring));
        let newest_first = older.iter().rev().chain(newer.iter().rev());
        for (gain, r) in self.law.reference.iter().zip(newest_first) {
            sum = sum + *gain * ((*r - settles) * per_trim);
        }
        rest + (newest + sum)
    }

    /// Displacement of the model now; of a model with whole samples of delay, that many samples from now.
    pub fn displacement(&self) -> T {
        self.displacement
    }

    /// The newest reference that was finite.
    pub fn reference(&self) -> T {
        self.reference
    }

    /// Output of the hysteresis at the last voltage.
    pub fn output(&self) -> T {
        self.output
    }

    /// The last voltage.
    pub fn voltage(&self) -> T {
        self.hysteresis.voltage()
    }

    /// The limits of the voltage.
    pub fn limits(&self) -> Limits<T> {
        self.limits
    }
}

saves!(Compensator);

#[inline(always)]
pub(super) fn within<T: Real>(x: T, low: T, high: T) -> T {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}
