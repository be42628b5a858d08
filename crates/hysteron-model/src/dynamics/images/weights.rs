//! Weights of the images: Σ q^k f(k) over all k ≥ 1, |q| = 1, from f at a few dozen places.
//!
//! The first images are summed one by one, the others in blocks that double in length. Over a block f is a
//! polynomial through its values at Chebyshev nodes; the sum of q^k times that polynomial over a block of
//! twice the length follows from the sum over the block itself. Behind the last block f is a power of k + c,
//! c the same small number for all k, taken to first order.

use std::f64::consts::{PI, TAU};

use hysteron_numeric::Complex64;

/// Images below this are summed one by one; length of the first block.
pub(super) const SINGLE: usize = 16;
const BLOCKS: usize = 6;
/// Nodes of a block: singularities lie at |k| ≤ 1, so that 5.6^−NODES of a block is lost.
const NODES: usize = 12;
/// Places k: those of single images, of the blocks, and twice where the power law begins.
pub(super) const PLACES: usize = SINGLE + BLOCKS * NODES + 1;
/// Images below where the power law begins.
pub(super) const POWER_LAW: f64 = (SINGLE << BLOCKS) as f64;
/// Turns per image below which all images are in phase.
const IN_PHASE: f64 = 1e-12;
/// Turns over a block beyond which a sum of a power of k is given by its first terms at the lower end.
const MANY_TURNS: f64 = 300.0;

/// Interpolation tables of the block sums, independent of q.
#[derive(Debug)]
pub(super) struct BlockRule {
    nodes: [f64; NODES],
    /// Interpolation at the places of the first block.
    first: [[f64; NODES]; SINGLE],
    /// Interpolation from the nodes of a block of twice the length at those of its two halves.
    halves: [[[f64; NODES]; NODES]; 2],
}

/// Weights of the places.
pub(super) struct Weights {
    pub(super) at_places: [Complex64; PLACES],
    /// Sums over a block as long as the first behind the last.
    block: [Complex64; NODES],
    turns: f64,
    fall: f64,
}

/// Cardinal polynomial `j` of the `count` Chebyshev nodes, at y.
pub(super) fn cardinal(count: usize, j: usize, y: f64) -> f64 {
    let (x, mut before, mut now, mut at_node, mut node_now) = (node(count, j), 1.0, y, 1.0, node(count, j));
    let mut sum = 0.5;
    for _ in 1..count {
        sum += node_now * now;
        (before, now) = (now, 2.0 * y * now - before);
        (at_node, node_now) = (node_now, 2.0 * x * node_now - at_node);
    }
    2.0 * sum / count as f64
}

/// Chebyshev node `j` of `count` in (−1, 1).
pub(super) fn node(count: usize, j: usize) -> f64 {
    -(PI * (j as f64 + 0.5) / count as f64).cos()
}

/// e^(−2πi·turns).
pub(super) fn turn(turns: f64) -> Complex64 {
    let (sin, cos) = (TAU * (turns - turns.round())).sin_cos();
    Complex64::new(cos, -sin)
}

impl BlockRule {
    pub(super) fn new() -> Self {
        let nodes = std::array::from_fn(|j| node(NODES, j));
        let row = |y: f64| std::array::from_fn(|j| cardinal(NODES, j, y));
        let middle = 0.5 * (SINGLE - 1) as f64;
        Self {
            nodes,
            first: std::array::from_fn(|i| row((i as f64 - middle) / (0.5 * SINGLE as f64))),
            halves: [-1.0, 1.0].map(|side| nodes.map(|x| row(0.5 * (x + side)))),
        }
    }

    /// The places k, ascending.
    pub(super) fn places(&self) -> [f64; PLACES] {
        let mut places = [0.0; PLACES];
        let mut start = SINGLE as f64;
        for (k, place) in places[..SINGLE - 1].iter_mut().enumerate() {
            *place = (k + 1) as f64;
        }
        for block in places[SINGLE - 1..PLACES - 2].chunks_exact_mut(NODES) {
            for (place, x) in block.iter_mut().zip(self.nodes) {
                *place = Self::place(start, x);
            }
            start *= 2.0;
        }
        places[PLACES - 2..].fill(POWER_LAW);
        places
    }

    /// Place of node x in the block of as many images as its first one's number.
    fn place(start: f64, x: f64) -> f64 {
        1.5 * start - 0.5 + 0.5 * start * x
    }

    /// Weights of f at the places, of which the last is for f times c/[`POWER_LAW`]; q = e^(−2πi·turns), and
    /// in the end f falls as (k + c)^−fall.
    pub(super) fn weights(&self, turns: f64, fall: f64) -> Weights {
        let turns = turns - turns.round();
        let mut weights = [Complex64::ZERO; PLACES];
        for (k, weight) in weights[..SINGLE - 1].iter_mut().enumerate() {
            *weight = turn(turns * (k + 1) as f64);
        }
        let mut block = [Complex64::ZERO; NODES];
        for (i, row) in self.first.iter().enumerate() {
            let phase = turn(turns * i as f64);
            block.iter_mut().zip(row).for_each(|(sum, weight)| *sum += phase * weight);
        }
        let mut start = SINGLE as f64;
        for octave in weights[SINGLE - 1..PLACES - 2].chunks_exact_mut(NODES) {
            let phase = turn(turns * start);
            octave.iter_mut().zip(block).for_each(|(weight, sum)| *weight = phase * sum);
            block = self.doubled(phase, &block);
            start *= 2.0;
        }
        let ends = self.ends(turns, fall, &block);
        weights[PLACES - 2..].copy_from_slice(&ends);
        Weights { at_places: weights, block, turns, fall }
    }

    /// Weights at the last two places.
    fn ends(&self, turns: f64, fall: f64, block: &[Complex64; NODES]) -> [Complex64; 2] {
        let phase = turn(turns * POWER_LAW);
        let [own, steeper] = [fall, fall + 1.0].map(|fall| self.rest(turns, POWER_LAW, fall, *block));
        [phase * own, phase * (own - steeper) * fall]
    }

    /// Derivative of the weights at the last two places in `fall`.
    pub(super) fn slopes(&self, weights: &Weights) -> [Complex64; 2] {
        const STEP: f64 = 1e-4;
        let at = |fall: f64| self.ends(weights.turns, fall, &weights.block);
        let (up, down) = (at(weights.fall + STEP), at(weights.fall - STEP));
        std::array::from_fn(|end| (up[end] - down[end]) / (2.0 * STEP))
    }

    /// Sums over a block of twice the length; `phase`: q to the power of the length.
    fn doubled(&self, phase: Complex64, block: &[Complex64; NODES]) -> [Complex64; NODES] {
        let mut sums = [Complex64::ZERO; NODES];
        for (rows, turned) in self.halves.iter().zip([Complex64::ONE, phase]) {
            for (row, weight) in rows.iter().zip(block) {
                let weight = weight * turned;
                sums.iter_mut().zip(row).for_each(|(sum, x)| *sum += weight * x);
            }
        }
        sums
    }

    /// Σ q^(k − start) (k/start)^−fall over k ≥ `start`; `block`: sums over a block of that length.
    fn rest(&self, turns: f64, start: f64, fall: f64, mut block: [Complex64; NODES]) -> Complex64 {
        if turns.abs() < IN_PHASE {
            // The divergent part cancels that of the images on the other side.
            let integral = if fall > 1.0 { start / (fall - 1.0) } else { 0.0 };
            return Complex64::from(integral + 0.5 + fall / (12.0 * start));
        }
        let (mut sum, mut from) = (Complex64::ZERO, start);
        while from * turns.abs() < MANY_TURNS {
            let phase = turn(turns * (from - start));
            for (weight, x) in block.iter().zip(self.nodes) {
                sum += phase * weight * (Self::place(from, x) / start).powf(-fall);
            }
            block = self.doubled(turn(turns * from), &block);
            from *= 2.0;
        }
        // 1 − q without cancellation, then the sum by parts.
        let less = Complex64::new(0.0, 2.0 * (PI * turns).sin()) * turn(0.5 * turns);
        let value = (from / start).powf(-fall);
        sum + turn(turns * (from - start)) * (value - turn(turns) / less * (fall * value / from)) / less
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ q^k/(k + c)^fall over k ≥ 1, from the weights.
    fn sum(turns: f64, fall: i32, c: Complex64) -> Complex64 {
        let rule = BlockRule::new();
        let mut weights = rule.weights(turns, f64::from(fall)).at_places;
        weights[PLACES - 1] *= c / POWER_LAW;
        weights.iter().zip(rule.places()).map(|(w, k)| w / (c + k).powi(fall)).sum()
    }

    #[test]
    fn sums_in_phase_are_those_of_the_sine() {
        // Σ over all k of 1/(k + c)² = (π/sin πc)².
        let c = Complex64::new(0.31, -0.02);
        let exact = (Complex64::from(PI) / (c * PI).sin()).powi(2);
        let found = sum(0.0, 2, c) + sum(0.0, 2, -c) + c.powi(-2);
        assert!((found - exact).norm() < 1e-9 * exact.norm(), "{found} {exact}");
    }

    #[test]
    fn sums_are_those_of_a_sawtooth_at_any_phase() {
        let c = Complex64::new(0.31, -0.02);
        for turns in [1e-9, 1e-6, 1e-3, 0.02, 0.3, 0.5, 0.77, 0.9999] {
            // Σ over all k of e^(−2πik·turns)/(k + c) = 2πi e^(2πic·turns)/(e^(2πic) − 1).
            let whole = Complex64::new(0.0, TAU);
            let exact = whole * (whole * c * turns).exp() / ((whole * c).exp() - 1.0);
            let found = sum(turns, 1, c) - sum(-turns, 1, -c) + c.inv();
            assert!((found - exact).norm() < 1e-8 * exact.norm(), "{turns}: {found} {exact}");
        }
    }
}
