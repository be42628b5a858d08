//! The memory of a Preisach plane: the turning points not wiped out.

use hysteron_rt::{Dual, Scalar, wipe_out};

use super::super::columns::is_plain;

/// Share of the largest amplitude by which a repeated one may be above it.
const ROUNDING: f64 = 1e-12;

/// The staircase between relays that are up and relays that are down, as the voltages at which it turns;
/// beyond the largest of them it is the antidiagonal α + β = 2 · rest of a virgin device.
///
/// A move is processed in pieces. On each, going up from `from` to `to`, the relays with α between these and
/// β from an edge up to α are switched; a loop that closes ends its piece, and its two turning points are
/// wiped out. So the cost of a move is proportional to the change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Staircase<S> {
    rest: S,
    u: S,
    rising: Option<bool>,
    /// Turning points, the widest loop first; after the last one the voltage has moved towards `u`.
    turns: Vec<S>,
}

/// Where the switched relays of a piece begin, away from the diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Edge<S> {
    /// At the turning point where the branch began.
    Turn(S),
    /// At the virgin antidiagonal of this rest voltage.
    Virgin(S),
}

/// A monotone part of a move between two events of memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MovePiece<S> {
    pub(super) from: S,
    pub(super) to: S,
    pub(super) edge: Edge<S>,
}

impl<S: Scalar<Real = f64>> MovePiece<S> {
    /// The piece in the plane mirrored at the antidiagonal through 0, where a fall is a rise.
    pub(super) fn mirrored(self) -> Self {
        let edge = match self.edge {
            Edge::Turn(turn) => Edge::Turn(-turn),
            Edge::Virgin(rest) => Edge::Virgin(-rest),
        };
        MovePiece { from: -self.from, to: -self.to, edge }
    }
}

impl<S: Scalar<Real = f64>> Staircase<S> {
    pub(super) fn virgin(rest: S) -> Self {
        Self { rest, u: rest, rising: None, turns: Vec::new() }
    }

    /// The present voltage.
    pub(super) fn voltage(&self) -> S {
        self.u
    }

    /// Moves monotonically to `u`; `switch` receives each piece and whether it rises.
    pub(super) fn advance(&mut self, u: f64, mut switch: impl FnMut(bool, MovePiece<S>)) {
        if u == self.u.value() {
            // Derivatives of the start end here, as in any other move.
            self.u = S::constant(u);
            return;
        }
        let rising = u > self.u.value();
        if self.rising.is_some_and(|before| before != rising) {
            self.turns.push(self.u);
        }
        self.rising = Some(rising);
        let Self { rest, u: now, turns, .. } = self;
        let target = S::constant(u);
        let (rest, mut from) = (*rest, *now);
        let last = |left: usize| left.checked_sub(1).and_then(|last| turns.get(last).copied());
        let edge = |left: usize| last(left).map_or(Edge::Virgin(rest), Edge::Turn);
        let turn = |index: usize| last(index + 1).unwrap_or(rest);
        let left = wipe_out((rest, turns.len()), turn, (rising, u), |left, limit| {
            switch(rising, MovePiece { from, to: limit, edge: edge(left) });
            from = limit;
        });
        switch(rising, MovePiece { from, to: target, edge: edge(left) });
        turns.truncate(left);
        *now = target;
    }
}

impl<const P: usize> Staircase<Dual<f64, P>> {
    /// These turning points in plain numbers, where no drive between the voltages `reach` comes to the virgin
    /// antidiagonal again, whose derivative stays.
    pub(super) fn settled(&self, [low, high]: [f64; 2]) -> Option<Staircase<f64>> {
        let (rest, widest) = (self.rest.value, self.turns.first()?.value);
        let amplitude = (1.0 + ROUNDING) * (widest - rest).abs();
        let is_within = rest - amplitude <= low && high <= rest + amplitude;
        if !is_within || !self.turns.iter().chain([&self.u]).all(is_plain) {
            return None;
        }
        let turns = self.turns.iter().map(|turn| turn.value).collect();
        Some(Staircase { rest, u: self.u.value, rising: self.rising, turns })
    }
}
