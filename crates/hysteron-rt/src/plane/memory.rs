//! Memory of a Preisach plane: the turning points not yet wiped out.

use super::Plane;
use crate::real::{Real, Scalar};
use crate::saved::Tape;

/// Wiping-out: number of the `turns` turns left after a monotone move to `u`.
///
/// A loop closes at the turn before its last one; the widest, which has one turn, at the opposite turn of the
/// virgin curve from `rest`, 2 `rest` − turn. `voltage` gives the voltage of a turn; `closes` receives the
/// number of turns before a loop closes, and the voltage at which it does.
#[inline(always)]
pub fn wipe_out<S: Scalar>(
    (rest, mut turns): (S, usize),
    voltage: impl Fn(usize) -> S,
    (rising, u): (bool, S::Real),
    mut closes: impl FnMut(usize, S),
) -> usize {
    while let Some(last) = turns.checked_sub(1) {
        let limit = match last.checked_sub(1) {
            Some(before) => voltage(before),
            None => rest.scale(S::Real::of(2.0)) - voltage(last),
        };
        let passes = if rising { u >= limit.value() } else { u <= limit.value() };
        if !passes {
            break;
        }
        closes(turns, limit);
        turns = last.saturating_sub(1);
    }
    turns
}

/// A turning point: voltage and output of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn<T> {
    voltage: T,
    output: T,
}

impl<T: Real> Turn<T> {
    /// Unused memory.
    pub fn none() -> Self {
        Self { voltage: T::of(0.0), output: T::of(0.0) }
    }
}

/// Minimum capacity for turns.
pub const LEAST_TURNS: usize = 4;

/// The turning points of a plane, the widest loop first, in borrowed memory.
///
/// A closed loop is wiped out with its two turns, and the output returns to that before the loop: errors do
/// not accumulate. Where open loops have more turns than the capacity, the two neighbouring turns that span
/// the smallest area of the plane are dropped: later outputs are wrong by at most twice the weight of the
/// relays in it, until a wider loop wipes them out.
#[derive(Debug)]
pub struct Turns<'a, T> {
    turns: &'a mut [Turn<T>],
    kept: usize,
    /// Virgin state.
    rest: Turn<T>,
    now: Turn<T>,
    /// Whether the last move went up; `None` before the first.
    rising: Option<bool>,
}

/// Outcome of a move that is not made yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Move<T> {
    /// Turns left at its end, including the present voltage where the move reverses.
    left: usize,
    turned: bool,
    end: Turn<T>,
}

impl<T: Copy> Move<T> {
    /// Output of the plane at the end of the move.
    #[inline(always)]
    pub(crate) fn output(&self) -> T {
        self.end.output
    }
}

impl<'a, T: Real> Turns<'a, T> {
    /// Memory with capacity for the turns of loops open at once, at least [`LEAST_TURNS`].
    pub fn new(turns: &'a mut [Turn<T>]) -> Self {
        let none = Turn::none();
        Self { turns, kept: 0, rest: none, now: none, rising: None }
    }

    /// Capacity for turns.
    pub fn room(&self) -> usize {
        self.turns.len()
    }

    /// Its members.
    pub(crate) fn each_member(&mut self, tape: &mut Tape<'_>) {
        let room = self.turns.len();
        tape.index(&mut self.kept, room.saturating_add(1));
        for turn in self.turns.iter_mut().chain([&mut self.rest, &mut self.now]) {
            tape.number(&mut turn.voltage);
            tape.number(&mut turn.output);
        }
        let (mut moved, mut rising) = (self.rising.is_some(), self.rising == Some(true));
        tape.flag(&mut moved);
        tape.flag(&mut rising);
        self.rising = moved.then_some(rising);
    }

    /// Virgin at `u`.
    pub(crate) fn rest_at(&mut self, plane: &Plane<'_, T>, u: T) {
        self.kept = 0;
        self.rest = Turn { voltage: u, output: plane.output_at_rest(u) };
        self.now = self.rest;
        self.rising = None;
    }

    /// Outcome of a monotone move to `u`; no state changes.
    #[inline]
    pub(crate) fn look(&self, plane: &Plane<'_, T>, u: T) -> Move<T> {
        if u == self.now.voltage {
            return Move { left: self.kept, turned: false, end: self.now };
        }
        let rising = u > self.now.voltage;
        let turned = self.rising.is_some_and(|before| before != rising);
        let turn = |index: usize| {
            if index < self.kept { self.turns.get(index).copied().unwrap_or(self.now) } else { self.now }
        };
        let open = (self.rest.voltage, self.kept + usize::from(turned));
        let left = wipe_out(open, |index| turn(index).voltage, (rising, u), |_, _| {});
        let output = if left == 0 {
            self.rest.output + plane.virgin_change(self.rest.voltage, u)
        } else {
            let turn = turn(left - 1);
            turn.output + plane.change(turn.voltage, u)
        };
        Move { left, turned, end: Turn { voltage: u, output } }
    }

    /// Makes a move computed by [`Self::look`].
    #[inline]
    pub(crate) fn make(&mut self, to: Move<T>) {
        if to.end.voltage == self.now.voltage {
            return;
        }
        if to.left > self.kept {
            // The move reverses here and opens a loop.
            if self.kept >= self.turns.len() {
                self.forget();
            }
            if let Some(slot) = self.turns.get_mut(self.kept) {
                *slot = self.now;
                self.kept += 1;
            }
        } else {
            self.kept = to.left;
        }
        self.rising = Some(to.end.voltage > self.now.voltage);
        self.now = to.end;
    }

    /// Drops the pair of neighbouring turns, between two others, that spans the smallest area of the plane.
    fn forget(&mut self) {
        let voltages = self.turns.iter().map(|turn| turn.voltage);
        let next = voltages.clone().skip(1).chain(core::iter::once(self.now.voltage));
        let (mut least, mut at) = (T::of(f64::INFINITY), 1);
        let quadruples = voltages.clone().zip(next.clone()).zip(next.clone().skip(1).zip(next.skip(2)));
        for (index, ((before, first), (second, after))) in quadruples.enumerate() {
            let between = (before - second).abs() * (after - first).abs();
            if between < least {
                (least, at) = (between, index + 1);
            }
        }
        for index in at..self.kept.saturating_sub(2) {
            if let Some(&later) = self.turns.get(index + 2)
                && let Some(slot) = self.turns.get_mut(index)
            {
                *slot = later;
            }
        }
        self.kept = self.kept.saturating_sub(2);
    }
}
