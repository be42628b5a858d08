//! Coordinates of the search: small-signal parameters, and the loop shape normalised by the size of the
//! motion.

use nalgebra::{DMatrix, SMatrix};

use hysteron_model::oscillator::Oscillator;
use hysteron_optimize::Range;

/// Number of coordinates: m, c, K, ρ, b, g, n.
pub(super) const COUNT: usize = 7;
/// Names in the search box.
const NAMES: [&str; COUNT] = [
    "mass",
    "damping",
    "small-motion stiffness",
    "hysteretic share",
    "beta over size",
    "gamma over size",
    "n",
];
/// Index of n.
pub(super) const N: usize = 6;

/// Factor either way of the mass and the stiffness of the best linear oscillator.
const MASS_FACTOR: f64 = 8.0;
/// Factor either way of its damping.
const DAMPING_FACTOR: f64 = 300.0;
/// Largest |b| and |g|: a loop that saturates within a fiftieth of the rms motion.
pub(super) const SHARPEST: f64 = 50.0;
/// Least share of the hysteretic spring.
const LEAST_SHARE: f64 = 1e-3;
/// Its largest share: k may be a little negative.
const LARGEST_SHARE: f64 = 1.5;
/// Largest exponent.
pub(super) const LARGEST_N: f64 = 5.0;

/// m, c, K = k + α, ρ = α/K, b = β'Yⁿ, g = γ'Yⁿ, n; Y is the size of the motion. k and α are strongly
/// correlated where the loop is thin, K and ρ are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates(pub [f64; COUNT]);

impl Coordinates {
    pub(super) fn of(oscillator: &Oscillator, size: f64) -> Self {
        let stiffness = oscillator.stiffness + oscillator.alpha;
        let shape = oscillator.unit_shape();
        let scale = size.powf(shape.n);
        Self([
            oscillator.mass,
            oscillator.damping,
            stiffness,
            oscillator.alpha / stiffness,
            shape.beta * scale,
            shape.gamma * scale,
            shape.n,
        ])
    }

    /// The oscillator: k = (1 − ρ)K, α = ρK, β = b|α|¹⁻ⁿY⁻ⁿ, γ = sign(α) g|α|¹⁻ⁿY⁻ⁿ.
    pub(super) fn oscillator(&self, size: f64) -> Oscillator {
        let [mass, damping, stiffness, share, b, g, n] = self.0;
        let alpha = share * stiffness;
        let scale = alpha.abs().powf(1.0 - n) * size.powf(-n);
        Oscillator {
            mass,
            damping,
            stiffness: (1.0 - share) * stiffness,
            alpha,
            beta: b * scale,
            gamma: if alpha < 0.0 { -g } else { g } * scale,
            n,
        }
    }

    /// ∂ parameters (rows, in the order of [`Oscillator::NAMES`]) / ∂ coordinates.
    pub(super) fn derivatives(&self, size: f64) -> SMatrix<f64, COUNT, COUNT> {
        let [_, _, stiffness, share, _, _, n] = self.0;
        let p = self.oscillator(size);
        let alpha = p.alpha;
        let scale = alpha.abs().powf(1.0 - n) * size.powf(-n);
        let mut d = SMatrix::zeros();
        d[(0, 0)] = 1.0;
        d[(1, 1)] = 1.0;
        d[(2, 2)] = 1.0 - share;
        d[(2, 3)] = -stiffness;
        d[(3, 2)] = share;
        d[(3, 3)] = stiffness;
        // |α|¹⁻ⁿ and Y⁻ⁿ with respect to K, ρ and n.
        for (row, value) in [(4, p.beta), (5, p.gamma)] {
            d[(row, 2)] = (1.0 - n) * value / stiffness;
            d[(row, 3)] = (1.0 - n) * value / share;
            d[(row, 6)] = -value * (alpha.abs() * size).ln();
        }
        d[(4, 4)] = scale;
        d[(5, 5)] = if alpha < 0.0 { -scale } else { scale };
        d[(6, 6)] = 1.0;
        d
    }
}

/// Search ranges around the linear oscillator (m, c, K).
pub(super) fn ranges([mass, damping, stiffness]: [f64; 3]) -> [Range; COUNT] {
    let around =
        |i: usize, value: f64, factor: f64| Range::logarithmic(NAMES[i], value / factor, value * factor);
    [
        around(0, mass, MASS_FACTOR),
        around(1, damping, DAMPING_FACTOR),
        around(2, stiffness, MASS_FACTOR),
        Range::linear(NAMES[3], LEAST_SHARE, LARGEST_SHARE),
        Range::linear(NAMES[4], -SHARPEST, SHARPEST),
        Range::linear(NAMES[5], -SHARPEST, SHARPEST),
        Range::linear(NAMES[6], 1.0, LARGEST_N),
    ]
}

/// Covariance of the parameters from that of some coordinates.
pub(super) fn covariance(
    at: &Coordinates,
    size: f64,
    searched: &[usize],
    of_searched: &DMatrix<f64>,
) -> DMatrix<f64> {
    let all = at.derivatives(size);
    let d = DMatrix::from_fn(COUNT, searched.len(), |i, j| all[(i, searched[j])]);
    &d * of_searched * d.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: f64 = 3.0;
    const POINTS: [[f64; COUNT]; 3] = [
        [2.0, 10.0, 90.0, 0.4, 0.5, -0.7, 1.0],
        [1.0, 3.0, 20.0, 1.2, 2.0, 0.4, 1.6],
        [4.0, 1.0, 7.0, 0.1, -0.3, 1.0, 3.0],
    ];

    #[test]
    fn coordinates_and_parameters_are_inverse_to_each_other() {
        for point in POINTS {
            let back = Coordinates::of(&Coordinates(point).oscillator(SIZE), SIZE).0;
            assert!(
                back.iter().zip(point).all(|(a, b)| (a - b).abs() < 1e-13 * b.abs().max(1.0)),
                "{back:?}"
            );
        }
    }

    #[test]
    fn derivatives_are_those_of_the_parameters() {
        for point in POINTS {
            let found = Coordinates(point).derivatives(SIZE);
            for j in 0..COUNT {
                let h = 1e-6;
                let side = |h: f64| {
                    let mut moved = point;
                    moved[j] += h;
                    Coordinates(moved).oscillator(SIZE).values()
                };
                for (i, (up, down)) in side(h).iter().zip(side(-h)).enumerate() {
                    let difference = (up - down) / (2.0 * h);
                    let bound = 1e-7 * (1.0 + difference.abs());
                    assert!(
                        (found[(i, j)] - difference).abs() < bound,
                        "{i} {j}: {} {difference}",
                        found[(i, j)]
                    );
                }
            }
        }
    }
}
