//! Exponential relaxation over many moves at once: the coefficients of a move of hysteresis with n = 1 that
//! do not depend on its start.

use super::InstructionSet;
use super::dispatch::{relaxations, relaxations_with_slopes};
use super::elementary::exp;

/// A row of moves Δu and, with d = |Δu| and κ ≥ 0 the rate in the direction of each, their relaxation
/// coefficients.
#[derive(Clone, Debug)]
pub struct Relaxations {
    /// Δu.
    pub moves: [f64; Self::MOST],
    /// e^(−κd).
    pub decay: [f64; Self::MOST],
    /// sign Δu · (1 − e^(−κd))/κ, Δu where κ = 0.
    pub reach: [f64; Self::MOST],
    /// Derivative of `reach` with respect to κ.
    pub slope: [f64; Self::MOST],
}

impl Relaxations {
    /// Moves a row can hold.
    pub const MOST: usize = 64;

    /// Moves computed together, whether needed or not.
    const LANES: usize = 8;

    /// A row of no moves.
    pub fn new() -> Self {
        let none = [0.0; Self::MOST];
        Self { moves: none, decay: none, reach: none, slope: none }
    }

    /// Computes `decay` and `reach` of the first `count` moves at the rates `up` and `down` ≥ 0, and `slope`
    /// where requested; entries beyond them are invalid. The first two are within 3, the slope within 30
    /// units in the last place.
    pub fn compute(&mut self, set: InstructionSet, (up, down): (f64, f64), count: usize, slopes: bool) {
        let count = count.next_multiple_of(Self::LANES).min(Self::MOST);
        if slopes {
            relaxations_with_slopes(set, up, down, count, self);
        } else {
            relaxations(set, up, down, count, self);
        }
    }
}

impl Default for Relaxations {
    fn default() -> Self {
        Self::new()
    }
}

/// 1/2!, −1/3!, 1/4!, … : coefficients of G(x) = (e⁻ˣ − 1 + x)/x².
const G: [f64; 13] = [
    1.0 / 2.0,
    -1.0 / 6.0,
    1.0 / 24.0,
    -1.0 / 120.0,
    1.0 / 720.0,
    -1.0 / 5040.0,
    1.0 / 40320.0,
    -1.0 / 362880.0,
    1.0 / 3628800.0,
    -1.0 / 39916800.0,
    1.0 / 479001600.0,
    -1.0 / 6227020800.0,
    1.0 / 87178291200.0,
];

/// Up to this x degree 5 is enough for G, and up to the other one degree 12.
const SMALL: f64 = 0.015_625;
const MEDIUM: f64 = 0.5;

/// Without slopes.
#[inline(always)]
pub(super) fn relaxations_kernel(up: f64, down: f64, count: usize, row: &mut Relaxations) {
    kernel::<false>(up, down, count, row);
}

/// With slopes.
#[inline(always)]
pub(super) fn relaxations_with_slopes_kernel(up: f64, down: f64, count: usize, row: &mut Relaxations) {
    kernel::<true>(up, down, count, row);
}

/// The whole row uses the formula that its longest move needs, so that the loops do not branch.
#[inline(always)]
fn kernel<const SLOPES: bool>(up: f64, down: f64, count: usize, row: &mut Relaxations) {
    let rate = |du: f64| if du < 0.0 { down } else { up };
    let (mut above_small, mut above_medium) = (0_u64, 0_u64);
    for &du in row.moves.iter().take(count) {
        let x = rate(du) * du.abs();
        above_small += u64::from(x > SMALL);
        above_medium += u64::from(x > MEDIUM);
    }
    if above_small == 0 {
        fill::<SLOPES>(count, row, |du| {
            let (x, d) = (rate(du) * du.abs(), du.abs());
            near(x, d, small_remainder(x))
        });
    } else if above_medium == 0 {
        fill::<SLOPES>(count, row, |du| {
            let (x, d) = (rate(du) * du.abs(), du.abs());
            near(x, d, medium_remainder(x))
        });
    } else {
        let (per_up, per_down) = (1.0 / up, 1.0 / down);
        fill::<SLOPES>(count, row, |du| {
            let (x, d) = (rate(du) * du.abs(), du.abs());
            let near = near(x, d, medium_remainder(x));
            let e = exp(-x);
            let reach = (1.0 - e) * if du < 0.0 { per_down } else { per_up };
            let slope = (d * e - reach) * if du < 0.0 { per_down } else { per_up };
            let take = |near, far| if x > MEDIUM { far } else { near };
            (take(near.0, e), take(near.1, reach), take(near.2, slope))
        });
    }
}

/// Writes (decay, reach, slope) of each move, as `of` gives them for its direction.
#[inline(always)]
fn fill<const SLOPES: bool>(count: usize, row: &mut Relaxations, of: impl Fn(f64) -> (f64, f64, f64)) {
    let slots = row.decay.iter_mut().zip(&mut row.reach).zip(&mut row.slope);
    for (&du, ((decay, reach), slope)) in row.moves.iter().zip(slots).take(count) {
        let (e, r, s) = of(du);
        *decay = e;
        *reach = if du < 0.0 { -r } else { r };
        if SLOPES {
            *slope = if du < 0.0 { -s } else { s };
        }
    }
}

/// (e⁻ˣ, d E(x), d² E'(x)) from `g` = G(x): E = 1 − x G, e⁻ˣ = 1 − x E, E' = (1 + x) G − 1.
#[inline(always)]
fn near(x: f64, d: f64, g: f64) -> (f64, f64, f64) {
    let ratio = 1.0 - x * g;
    (1.0 - x * ratio, d * ratio, d * d * (g + x * g - 1.0))
}

#[inline(always)]
fn small_remainder(x: f64) -> f64 {
    let x2 = x * x;
    (G[0] + G[1] * x) + (G[2] + G[3] * x) * x2 + (G[4] + G[5] * x) * (x2 * x2)
}

#[inline(always)]
fn medium_remainder(x: f64) -> f64 {
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = (G[0] + G[1] * x) + (G[2] + G[3] * x) * x2;
    let middle = (G[4] + G[5] * x) + (G[6] + G[7] * x) * x2;
    let high = (G[8] + G[9] * x) + (G[10] + G[11] * x) * x2 + G[12] * x4;
    low + (middle + high * x4) * x4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance in units in the last place of the wanted value.
    fn units(got: f64, want: f64) -> f64 {
        if got == want { 0.0 } else { ((got - want) / (want * f64::EPSILON)).abs() }
    }

    /// d² E'(x) = −d² Σ k (−x)^(k−1)/(k+1)!, alternating: from x = 1 on from the exponential function.
    fn slope(x: f64, d: f64) -> f64 {
        if x > 1.0 {
            return d * d * ((-x).exp() * (1.0 + x) - 1.0) / (x * x);
        }
        let (mut term, mut sum) = (1.0, 0.0);
        for k in 1..30_i32 {
            term *= -1.0 / f64::from(k + 1);
            sum += f64::from(k) * term * x.powi(k - 1);
        }
        d * d * sum
    }

    #[test]
    fn every_tier_and_instruction_set_meets_the_library_functions() {
        let (up, down) = (0.8, 0.3);
        for longest in [0.01, 0.3, 3.0, 60.0, 2000.0] {
            let mut want: Option<Relaxations> = None;
            for set in InstructionSet::available() {
                let mut row = Relaxations::new();
                for (k, du) in row.moves.iter_mut().enumerate() {
                    *du = longest * (k as f64 * 0.7).sin().powi(3);
                }
                row.compute(set, (up, down), Relaxations::MOST, true);
                for (k, &du) in row.moves.iter().enumerate() {
                    let kappa = if du < 0.0 { down } else { up };
                    let (d, x) = (du.abs(), kappa * du.abs());
                    if x < 700.0 {
                        assert!(units(row.decay[k], (-x).exp()) <= 3.0, "x {x:e}: {:e}", row.decay[k]);
                    }
                    assert!(units(row.reach[k], -du.signum() * (-x).exp_m1() / kappa) <= 3.0, "x {x:e}");
                    assert!(units(row.slope[k], du.signum() * slope(x, d)) <= 30.0, "x {x:e}");
                }
                let same = |a: &Relaxations| (a.decay, a.reach, a.slope) == (row.decay, row.reach, row.slope);
                assert!(want.as_ref().is_none_or(same), "{set:?} rounds differently");
                want = Some(row);
            }
        }
    }

    #[test]
    fn without_a_rate_the_reach_is_the_move() {
        let mut row = Relaxations::new();
        row.moves[..3].copy_from_slice(&[2.0, -3.0, 0.0]);
        row.compute(InstructionSet::detected(), (0.0, 0.0), 3, true);
        assert_eq!((&row.decay[..3], &row.reach[..3]), ([1.0; 3].as_slice(), [2.0, -3.0, 0.0].as_slice()));
        assert_eq!(&row.slope[..3], [-2.0, 4.5, 0.0]);
        // One rate 0 beside a long move at the other.
        row.moves[..3].copy_from_slice(&[2.0, -3.0, 0.0]);
        row.compute(InstructionSet::detected(), (0.0, 1.0), 3, true);
        assert_eq!((row.decay[0], row.reach[0], row.slope[0]), (1.0, 2.0, -2.0));
        assert_eq!((row.decay[2], row.reach[2], row.slope[2]), (1.0, 0.0, 0.0));
    }

    #[test]
    fn the_slope_is_there_only_where_asked_for() {
        let mut row = Relaxations::new();
        row.moves[0] = 1.0;
        row.compute(InstructionSet::detected(), (1.0, 1.0), 1, false);
        assert_eq!(row.slope, [0.0; Relaxations::MOST]);
        assert!((row.decay[0] - (-1.0_f64).exp()).abs() < 1e-15);
    }
}
