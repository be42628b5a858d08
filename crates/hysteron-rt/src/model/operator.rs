//! The hysteresis block of a streaming model.

use super::ModelError;
use crate::StateLaw;
use crate::branch::Branch;
use crate::increment::IncrementMemory;
use crate::plane::{LEAST_TURNS, Plane, Turns};
use crate::play::{PlayBank, RelaxingPlays, SidedPlays};
use crate::real::Real;
use crate::saved::Tape;

/// Hysteresis operator beside the polynomial l\[u\].
#[derive(Debug)]
pub enum Operator<'a, T> {
    /// Nothing: v = l\[u\].
    None,
    /// v = l\[u\] − Σ zₖ, states in parallel with parameters each, usually one.
    States {
        /// Their laws.
        laws: &'a [StateLaw<T>],
        /// Their memory, one each.
        memory: &'a mut [IncrementMemory<T>],
    },
    /// v = l\[u\] + Σ wⱼ yⱼ, yⱼ by one law on each branch.
    Branch {
        /// The law.
        law: Branch<T>,
        /// Weights of its states.
        weights: &'a [T],
        /// Their memory, one each.
        memory: &'a mut [IncrementMemory<T>],
    },
    /// v = l\[u\] + Σ wᵢ F_rᵢ\[u\].
    Plays {
        /// The plays.
        bank: PlayBank<'a, T>,
        /// Their states, one each.
        states: &'a mut [T],
    },
    /// v = l\[u\] + plays between other sides.
    SidedPlays {
        /// The plays.
        plays: SidedPlays<'a, T>,
        /// Their states, one each.
        states: &'a mut [T],
    },
    /// v = l\[u\] + plays with thermally activated edges.
    RelaxingPlays {
        /// The plays.
        plays: RelaxingPlays<'a, T>,
        /// Their distances behind the drive, one each.
        states: &'a mut [T],
    },
    /// v = l\[u\] + a plane of relays.
    Plane {
        /// The relays.
        plane: Plane<'a, T>,
        /// The turning points that still count.
        turns: Turns<'a, T>,
    },
}

/// v = l\[u\] + memory, l\[u\] = Σ_{i≥1} polynomial\[i−1\] uⁱ.
#[derive(Debug)]
pub struct Hysteresis<'a, T> {
    polynomial: &'a [T],
    operator: Operator<'a, T>,
    voltage: T,
    /// Virgin still: the rate of the first move is unknown.
    rested: bool,
}

impl<'a, T: Real> Hysteresis<'a, T> {
    /// The block, virgin at 0 V.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where operators and memory differ in number, [`ModelError::Coefficient`] for a
    /// polynomial that is not finite, or numbers of a branch that are out of order.
    pub fn new(polynomial: &'a [T], operator: Operator<'a, T>) -> Result<Self, ModelError<T>> {
        let (expected, found) = match &operator {
            Operator::None => (0, 0),
            Operator::States { laws, memory } => (laws.len(), memory.len()),
            Operator::Branch { weights, memory, .. } => (weights.len(), memory.len()),
            Operator::Plays { bank, states } => (bank.weights().len(), states.len()),
            Operator::SidedPlays { plays, states } => (plays.count(), states.len()),
            Operator::RelaxingPlays { plays, states } => (plays.count(), states.len()),
            Operator::Plane { turns, .. } => (turns.room().max(LEAST_TURNS), turns.room()),
        };
        if expected != found {
            return Err(ModelError::Memory { expected, found });
        }
        let sound = match &operator {
            Operator::Branch { law, weights, .. } => {
                law.is_sound(weights.len()) && weights.iter().all(|w| w.is_finite())
            }
            _ => true,
        };
        if !sound || !polynomial.iter().all(|c| c.is_finite()) {
            return Err(ModelError::Coefficient);
        }
        let mut block = Self { polynomial, operator, voltage: T::of(0.0), rested: true };
        block.rest_at(T::of(0.0));
        Ok(block)
    }

    /// Output of the block where it is virgin at `voltage`.
    pub fn output_at_rest(&self, voltage: T) -> T {
        let v = self.polynomial_at(voltage);
        match &self.operator {
            Operator::None | Operator::States { .. } => v,
            Operator::Plays { bank, .. } => bank.weights().iter().fold(v, |v, weight| v + *weight * voltage),
            Operator::Branch { law, weights, .. } => v + law.output_at_rest(weights, voltage),
            Operator::SidedPlays { plays, .. } => v + plays.output_at_rest(voltage),
            Operator::RelaxingPlays { plays, .. } => v + plays.output_at_rest(voltage),
            Operator::Plane { plane, .. } => v + plane.output_at_rest(voltage),
        }
    }

    /// Makes the block virgin at `voltage` and returns its output there.
    pub fn rest_at(&mut self, voltage: T) -> T {
        self.voltage = voltage;
        self.rested = true;
        match &mut self.operator {
            Operator::None => {}
            Operator::States { memory, .. } => memory.fill(IncrementMemory::new(T::of(0.0))),
            Operator::Branch { law, memory, .. } => memory.fill(IncrementMemory::new(law.virgin(voltage))),
            Operator::Plays { states, .. } => states.fill(voltage),
            Operator::SidedPlays { plays, states } => plays.rest_at(states, voltage),
            Operator::RelaxingPlays { states, .. } => states.fill(T::of(0.0)),
            Operator::Plane { plane, turns } => turns.rest_at(plane, voltage),
        }
        self.output_at_rest(voltage)
    }

    /// Its members.
    pub(super) fn each_member(&mut self, tape: &mut Tape<'_>) {
        match &mut self.operator {
            Operator::None => {}
            Operator::States { memory, .. } | Operator::Branch { memory, .. } => {
                memory.iter_mut().for_each(|state| state.each_member(tape));
            }
            Operator::Plays { states, .. }
            | Operator::SidedPlays { states, .. }
            | Operator::RelaxingPlays { states, .. } => tape.numbers(states),
            Operator::Plane { turns, .. } => turns.each_member(tape),
        }
        tape.number(&mut self.voltage);
        tape.flag(&mut self.rested);
    }

    /// Makes the block virgin at `virgin`, moves it monotonically to `voltage` and returns its output there.
    ///
    /// # Errors
    /// Those of [`Self::step`]. Unchanged where the output at `virgin` is out of range; virgin there where
    /// that at `voltage` is.
    pub fn rest_after(&mut self, virgin: T, voltage: T) -> Result<T, ModelError<T>> {
        if !virgin.is_finite() {
            return Err(ModelError::NotFinite);
        }
        if !in_range(self.output_at_rest(virgin)) {
            return Err(ModelError::Overflow);
        }
        let there = self.rest_at(virgin);
        if voltage == virgin { Ok(there) } else { self.step(voltage) }
    }

    /// Moves monotonically to `voltage` and returns v.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] for the voltage; [`ModelError::Overflow`] where |v| exceeds
    /// [`Real::LARGEST`] (inadmissible parameters, an excessive voltage) or the sides of a play cross. The
    /// memory is then unchanged.
    #[inline]
    pub fn step(&mut self, voltage: T) -> Result<T, ModelError<T>> {
        self.step_through(voltage, voltage)
    }

    /// [`Self::step`]; plays that depend on the rate are moved at `middle` too.
    #[inline(always)]
    fn step_through(&mut self, middle: T, voltage: T) -> Result<T, ModelError<T>> {
        if !voltage.is_finite() {
            return Err(ModelError::NotFinite);
        }
        let mut v = self.polynomial_at(voltage);
        let du = voltage - self.voltage;
        match &mut self.operator {
            Operator::None => in_range_or_overflow(v)?,
            Operator::States { laws, memory } => {
                for (law, memory) in laws.iter().zip(memory.iter_mut()) {
                    v = v - memory.advance(law.increment(memory.z(), du));
                }
                in_range_or_taken_back(v, memory)?;
            }
            Operator::Branch { law, weights, memory } => {
                v = v + law.advance(weights, memory, self.voltage, voltage);
                in_range_or_taken_back(v, memory)?;
            }
            Operator::Plays { bank, states } => {
                v = v + bank.look(states, voltage);
                in_range_or_overflow(v)?;
                bank.advance(states, voltage);
            }
            Operator::SidedPlays { plays, states } => {
                let du = if self.rested { T::of(0.0) } else { du };
                v = v + plays.look(states, [middle, voltage], du);
                in_range_or_overflow(v)?;
                plays.advance(states, [middle, voltage], du);
            }
            Operator::RelaxingPlays { plays, states } => {
                v = v + plays.look(states, voltage, (du, T::of(1.0)), self.rested);
                in_range_or_overflow(v)?;
                plays.advance(states, du, self.rested);
            }
            Operator::Plane { plane, turns } => {
                let to = turns.look(plane, voltage);
                v = v + to.output();
                in_range_or_overflow(v)?;
                turns.make(to);
            }
        }
        self.voltage = voltage;
        self.rested = false;
        Ok(v)
    }

    /// [`Self::step`] that also returns v half-way to `voltage`, before v at its end.
    ///
    /// # Errors
    /// Those of [`Self::step`].
    #[inline]
    pub fn step_with_middle(&mut self, voltage: T) -> Result<(T, T), ModelError<T>> {
        let half = T::of(0.5);
        // From the start of the move, as its end is: the two are independent.
        let place = half * self.voltage + half * voltage;
        let middle = self.look_during(place, voltage - self.voltage, half);
        if !voltage.is_finite() {
            return Err(ModelError::NotFinite);
        }
        in_range_or_overflow(middle)?;
        Ok((middle, self.step_through(place, voltage)?))
    }

    /// Output after a monotone move to `voltage`; no state changes. It is out of range or NaN where
    /// [`Self::step`] would fail.
    #[inline]
    pub fn look(&self, voltage: T) -> T {
        self.look_during(voltage, voltage - self.voltage, T::of(1.0))
    }

    /// Output at `voltage`, after the fraction `share` of a sample whose whole move is `whole`; no state
    /// changes.
    #[inline]
    fn look_during(&self, voltage: T, whole: T, share: T) -> T {
        let v = self.polynomial_at(voltage);
        match &self.operator {
            Operator::None => v,
            Operator::States { laws, memory } => {
                let du = voltage - self.voltage;
                let states = laws.iter().zip(memory.iter());
                states.fold(v, |v, (law, memory)| v - (memory.z() + law.increment(memory.z(), du)))
            }
            Operator::Branch { law, weights, memory } => v + law.look(weights, memory, self.voltage, voltage),
            Operator::Plays { bank, states } => v + bank.look(states, voltage),
            Operator::SidedPlays { plays, states } => {
                let du = if self.rested { T::of(0.0) } else { whole };
                v + plays.look(states, [voltage, voltage], du)
            }
            Operator::RelaxingPlays { plays, states } => {
                v + plays.look(states, voltage, (voltage - self.voltage, share), self.rested)
            }
            Operator::Plane { plane, turns } => v + turns.look(plane, voltage).output(),
        }
    }

    /// Whether plays move at constant voltage: they depend on the rate, or creep.
    #[inline(always)]
    pub(super) fn moves_at_rest(&self) -> bool {
        match &self.operator {
            Operator::SidedPlays { plays, .. } => plays.sees_rate(),
            Operator::RelaxingPlays { .. } => true,
            _ => false,
        }
    }

    /// The polynomial l\[u\] at `u`.
    #[inline(always)]
    fn polynomial_at(&self, u: T) -> T {
        self.polynomial.iter().rev().fold(T::of(0.0), |sum, &c| (sum + c) * u)
    }

    /// Present voltage.
    pub fn voltage(&self) -> T {
        self.voltage
    }
}

/// Whether `v` is within the input range of the dynamics; false for NaN.
#[inline(always)]
pub(super) fn in_range<T: Real>(v: T) -> bool {
    v.abs() <= T::LARGEST
}

#[inline(always)]
fn in_range_or_overflow<T: Real>(v: T) -> Result<(), ModelError<T>> {
    if in_range(v) { Ok(()) } else { Err(ModelError::Overflow) }
}

#[inline(always)]
fn in_range_or_taken_back<T: Real>(v: T, memory: &mut [IncrementMemory<T>]) -> Result<(), ModelError<T>> {
    let checked = in_range_or_overflow(v);
    if checked.is_err() {
        memory.iter_mut().for_each(IncrementMemory::take_back);
    }
    checked
}
