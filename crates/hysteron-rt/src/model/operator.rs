//! The hysteresis block of a streaming model.

use super::ModelError;
use super::sections::accumulate;
use crate::bouc_wen::BoucWen;
use crate::play::{PlayBank, play};
use crate::real::Real;

/// z of a Bouc–Wen operator and what rounding has left of its increments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWenMemory<T> {
    z: T,
    carry: T,
    /// Both after the move under way.
    next: (T, T),
}

impl<T: Real> BoucWenMemory<T> {
    /// The memory z \[µm\].
    pub fn new(z: T) -> Self {
        Self { z, carry: T::of(0.0), next: (z, T::of(0.0)) }
    }

    /// z \[µm\].
    pub fn z(&self) -> T {
        self.z
    }
}

/// What adds memory to the polynomial l\[u\].
#[derive(Debug)]
pub enum Operator<'a, T> {
    /// Nothing: v = l\[u\].
    None,
    /// v = l\[u\] − Σ zₖ, Bouc–Wen operators in parallel, usually one.
    BoucWen {
        /// The operators.
        operators: &'a [BoucWen<T>],
        /// Their memory, one each.
        memory: &'a mut [BoucWenMemory<T>],
    },
    /// v = l\[u\] + Σ wᵢ F_rᵢ\[u\].
    Plays {
        /// The plays.
        bank: PlayBank<'a, T>,
        /// Their states, one each.
        states: &'a mut [T],
    },
}

/// v = l\[u\] + memory, l\[u\] = Σ_{i≥1} polynomial\[i−1\] uⁱ.
#[derive(Debug)]
pub struct Hysteresis<'a, T> {
    polynomial: &'a [T],
    operator: Operator<'a, T>,
    voltage: T,
}

impl<'a, T: Real> Hysteresis<'a, T> {
    /// The block, virgin at 0 V.
    ///
    /// # Errors
    /// [`ModelError::Memory`] where operators and memory differ in number, [`ModelError::Coefficient`] for a polynomial that is
    /// not finite.
    pub fn new(polynomial: &'a [T], operator: Operator<'a, T>) -> Result<Self, ModelError<T>> {
        let (expected, found) = match &operator {
            Operator::None => (0, 0),
            Operator::BoucWen { operators, memory } => (operators.len(), memory.len()),
            Operator::Plays { bank, states } => (bank.weights().len(), states.len()),
        };
        if expected != found {
            return Err(ModelError::Memory { expected, found });
        }
        if !polynomial.iter().all(|c| c.is_finite()) {
            return Err(ModelError::Coefficient);
        }
        let mut block = Self { polynomial, operator, voltage: T::of(0.0) };
        block.rest_at(T::of(0.0));
        Ok(block)
    }

    /// Output of the block where it is virgin at `voltage`.
    pub fn output_at_rest(&self, voltage: T) -> T {
        let v = self.polynomial_at(voltage);
        match &self.operator {
            Operator::None | Operator::BoucWen { .. } => v,
            Operator::Plays { bank, .. } => bank.weights().iter().fold(v, |v, weight| v + *weight * voltage),
        }
    }

    /// Makes the block virgin at `voltage` and returns its output there.
    pub fn rest_at(&mut self, voltage: T) -> T {
        self.voltage = voltage;
        match &mut self.operator {
            Operator::None => {}
            Operator::BoucWen { memory, .. } => memory.fill(BoucWenMemory::new(T::of(0.0))),
            Operator::Plays { states, .. } => states.fill(voltage),
        }
        self.output_at_rest(voltage)
    }

    /// Makes the block virgin at `virgin`, moves it monotonically to `voltage` and returns its output there.
    ///
    /// # Errors
    /// As [`Self::step`]; as it was where the output at `virgin` is out of range, virgin there where that at `voltage` is.
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
    /// [`ModelError::NotFinite`] for the voltage; [`ModelError::Overflow`] where |v| exceeds [`Real::LARGEST`] (inadmissible
    /// parameters, a voltage out of all reason). The memory is then as it was, but for plays, which stand at the voltage.
    #[inline]
    pub fn step(&mut self, voltage: T) -> Result<T, ModelError<T>> {
        if !voltage.is_finite() {
            return Err(ModelError::NotFinite);
        }
        let mut v = self.polynomial_at(voltage);
        let du = voltage - self.voltage;
        match &mut self.operator {
            Operator::None => {}
            Operator::BoucWen { operators, memory } => {
                for (operator, memory) in operators.iter().zip(memory.iter_mut()) {
                    memory.next = (memory.z, memory.carry);
                    let (z, carry) = (&mut memory.next.0, &mut memory.next.1);
                    accumulate(z, carry, operator.increment(memory.z, du));
                    v = v - *z;
                }
                if !in_range(v) {
                    return Err(ModelError::Overflow);
                }
                for memory in memory.iter_mut() {
                    (memory.z, memory.carry) = memory.next;
                }
            }
            Operator::Plays { bank, states } => {
                v = v + bank.step(states, voltage).map_err(|_| ModelError::Overflow)?;
            }
        }
        if !in_range(v) {
            return Err(ModelError::Overflow);
        }
        self.voltage = voltage;
        Ok(v)
    }

    /// As [`Self::step`], with v half-way to `voltage` before it.
    ///
    /// # Errors
    /// As [`Self::step`].
    #[inline]
    pub fn step_with_middle(&mut self, voltage: T) -> Result<(T, T), ModelError<T>> {
        let half = T::of(0.5);
        // From the start of the move, as its end is: neither waits for the other.
        let middle = self.look(half * self.voltage + half * voltage);
        if !voltage.is_finite() {
            return Err(ModelError::NotFinite);
        }
        if !in_range(middle) {
            return Err(ModelError::Overflow);
        }
        Ok((middle, self.step(voltage)?))
    }

    /// What a monotone move to `voltage` would put out; nothing is moved. Not finite where [`Self::step`] would fail.
    #[inline]
    pub fn look(&self, voltage: T) -> T {
        let mut v = self.polynomial_at(voltage);
        match &self.operator {
            Operator::None => {}
            Operator::BoucWen { operators, memory } => {
                let du = voltage - self.voltage;
                for (operator, memory) in operators.iter().zip(memory.iter()) {
                    v = v - (memory.z + operator.increment(memory.z, du));
                }
            }
            Operator::Plays { bank, states } => {
                let plays = bank.thresholds().iter().zip(bank.weights()).zip(states.iter());
                v = plays.fold(v, |v, ((threshold, weight), state)| {
                    v + *weight * play(*threshold, *state, voltage)
                });
            }
        }
        v
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

/// Whether dynamics can be fed with `v`; not so for a number that is not one.
#[inline(always)]
pub(super) fn in_range<T: Real>(v: T) -> bool {
    v.abs() <= T::LARGEST
}
