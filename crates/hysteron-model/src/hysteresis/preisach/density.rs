//! A Preisach plane with a density of a few parameters.

use hysteron_rt::{Scalar, between};

use super::super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, GRID_ENDS, NumberUnit, RuntimeOperator, Search, ShapeNumber,
    ends,
};
use super::{HysteresisError, Preisach, PreisachState};

/// Form of a factor of the density over its standardised variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityLaw {
    /// exp(−x²/2).
    Gaussian,
    /// 1/(1 + x²).
    Lorentzian,
}

impl DensityLaw {
    fn at<S: Scalar<Real = f64>>(self, x: S) -> S {
        match self {
            Self::Gaussian => (x * x).scale(-0.5).exp(),
            Self::Lorentzian => S::constant(1.0) / (x * x).shift(1.0),
        }
    }
}

/// One column: a Preisach plane whose density is a product over half-width h = (α − β)/2 and bias m = (α +
/// β)/2,
///
/// μ ∝ f((h − h₀)/σ_h) f((m − m₀)/σ_m),
///
/// integrated over each cell between `levels` (4 × 4 Gauss points) and normalised so that the column runs
/// from −1 to 1. Shape: `half_width` h₀ ≥ 0, `half_width_spread` σ_h, `bias` m₀, `bias_spread` σ_m \[V\]; the
/// weight is half the height of the limiting loop \[µm\].
#[derive(Clone, Debug, PartialEq)]
pub struct PreisachDensity {
    /// The plane; relays beyond its levels are left out.
    pub plane: Preisach,
    /// Form of both factors.
    pub law: DensityLaw,
}

/// Moves after which the sum of the relays is recomputed, so that rounding does not accumulate.
const RECOUNT: usize = 256;

/// The relays, and the weights of their cells.
#[derive(Clone, Debug, PartialEq)]
pub struct PreisachDensityState<S> {
    relays: PreisachState<S>,
    weights: Vec<S>,
    /// Weights of the diagonal below each level.
    below: Vec<S>,
    /// Weighted sum of the relays away from the diagonal.
    sum: S,
    /// Moves since it was added up.
    moves: usize,
}

impl<S: Scalar<Real = f64>> PreisachDensityState<S> {
    fn recount(&mut self) {
        let cells = self.relays.cells.iter().zip(&self.weights).enumerate();
        let mut diagonal = (0, 0);
        self.sum = cells.fold(S::constant(0.0), |sum, (at, (cell, weight))| {
            if at == diagonal.0 {
                // i (i + 3)/2 of row i.
                diagonal = (at + diagonal.1 + 2, diagonal.1 + 1);
                sum
            } else {
                sum + *weight * *cell
            }
        });
        self.moves = 0;
    }
}

/// Gauss–Legendre points on \[0, 1\] with their weights.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

impl PreisachDensity {
    /// Weights of the cells, Σ = 1.
    pub fn weights<S: Scalar<Real = f64>>(&self, shape: &[S]) -> Vec<S> {
        let [h_0, h_spread, m_0, m_spread] = [0, 1, 2, 3].map(|index| parameter(shape, index));
        let density = |alpha: f64, beta: f64| {
            let h = (-h_0).shift(0.5 * (alpha - beta)) / h_spread;
            let m = (-m_0).shift(0.5 * (alpha + beta)) / m_spread;
            self.law.at(h) * self.law.at(m)
        };
        let intervals = self.plane.intervals();
        let pairs = (0..intervals).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mut weights: Vec<S> = pairs
            .map(|(i, j)| {
                let ([a, b], [c, d]) = (self.plane.interval(i), self.plane.interval(j));
                let mut sum = S::constant(0.0);
                for (x, w_x) in GAUSS {
                    for (y, w_y) in GAUSS {
                        let (alpha, beta, area) = if i == j {
                            // The triangle below the diagonal, over half-width and bias, where it is its own
                            // mirror image.
                            let h = 0.5 * (b - a) * x;
                            let m = a + h + (b - a - 2.0 * h) * y;
                            (m + h, m - h, (b - a) * (b - a - 2.0 * h))
                        } else {
                            (a + (b - a) * x, c + (d - c) * y, (b - a) * (d - c))
                        };
                        sum = sum + density(alpha, beta).scale(w_x * w_y * area);
                    }
                }
                sum
            })
            .collect();
        let total = weights.iter().fold(S::constant(0.0), |sum, w| sum + *w);
        weights.iter_mut().for_each(|w| *w = *w / total);
        weights
    }
}

impl ColumnKernel for PreisachDensity {
    type State<S: Scalar<Real = f64>> = PreisachDensityState<S>;

    simulate_with_sensitivities!(4);

    fn shape_names(&self) -> &'static [&'static str] {
        &["half_width", "half_width_spread", "bias", "bias_spread"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        self.plane.check_levels()?;
        let [h_0, h_spread, m_0, m_spread] = [0, 1, 2, 3].map(|index| parameter::<f64>(shape, index));
        positive("spread of the half-width", h_spread)?;
        positive("spread of the bias", m_spread)?;
        for (name, value) in [("mean half-width", h_0), ("mean bias", m_0)] {
            if !value.is_finite() {
                return Err(HysteresisError::ShapeParameter { name, value, must: "finite" });
            }
        }
        // A density that vanishes on all levels has no weights.
        match self.weights(shape).iter().find(|w| !w.is_finite()) {
            None => Ok(()),
            Some(_) => {
                let (name, must) =
                    ("mean half-width", "so near the levels that the density does not vanish on them");
                Err(HysteresisError::ShapeParameter { name, value: h_0, must })
            }
        }
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> PreisachDensityState<S> {
        let weights = self.weights(shape);
        let mut total = S::constant(0.0);
        let diagonal = (0..self.plane.intervals()).map(|i| {
            total = total + weights.get(i * (i + 3) / 2).copied().unwrap_or(S::constant(0.0));
            total
        });
        let below = std::iter::once(S::constant(0.0)).chain(diagonal).collect();
        let relays = self.plane.virgin_state(u);
        let mut state = PreisachDensityState { relays, weights, below, sum: S::constant(0.0), moves: 0 };
        state.recount();
        state
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut PreisachDensityState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let PreisachDensityState { relays, weights, sum, moves, .. } = state;
        self.plane.move_to(relays, u, |at, change| {
            if let Some(weight) = weights.get(at) {
                *sum = *sum + *weight * change;
            }
        });
        *moves += 1;
        if *moves == RECOUNT {
            state.recount();
        }
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PreisachDensityState<S>, out: &mut [S]) {
        let u = state.relays.stairs.voltage();
        let last = self.plane.intervals() - 1;
        let here = self.plane.levels.partition_point(|x| *x <= u.value()).saturating_sub(1).min(last);
        // Ramps below stand at 1, those above at −1.
        let zero = S::constant(0.0);
        let [below, with, all] =
            [here, here + 1, last + 1].map(|k| state.below.get(k).copied().unwrap_or(zero));
        let [low, high] = self.plane.interval(here);
        let share = u.shift(-low).scale(2.0 / (high - low)).shift(-1.0);
        let ramp = between([-1.0, 1.0].map(S::constant), share);
        if let Some(slot) = out.first_mut() {
            *slot = state.sum + below - (all - with) + (with - below) * ramp;
        }
    }
}

/// Intervals of the plane of the family.
const INTERVALS: usize = 40;

/// The family, Lorentzian, on a plane from `low` to `high`.
#[derive(Debug)]
pub(in crate::hysteresis) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "preisach-density"
    }

    fn summary(&self) -> &'static str {
        "Preisach relays with a density of four parameters"
    }

    fn equation(&self) -> &'static str {
        "weight_1 times relays on a plane from low to high, their density Lorentzian in half-width and bias"
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let unit = NumberUnit::INPUT;
        let spread = span.strokes(0.02, 10.0);
        let own = [
            ShapeNumber::new(
                "half_width",
                unit,
                "mean half-width of the relays",
                Search::Linear(0.0, span.stroke),
            ),
            ShapeNumber::new("half_width_spread", unit, "spread of the half-widths", spread),
            ShapeNumber::new("bias", unit, "mean bias of the relays", span.around()),
            ShapeNumber::new("bias_spread", unit, "spread of the biases", spread),
        ];
        ShapeNumber::of_ends(span).into_iter().chain(own).collect()
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let ([low, high], middle) = (span.grid, span.middle());
        let of = |width: f64| {
            [0.3, 1.0].map(|spread| vec![low, high, 0.0, width * span.stroke, middle, spread * span.stroke])
        };
        [0.1, 0.3].into_iter().flat_map(of).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        let ([low, high], stroke) = (span.grid, span.stroke);
        vec![low, high, 0.04 * stroke, 0.13 * stroke, span.middle() + 0.01 * stroke, 0.33 * stroke]
    }

    fn is_plane(&self) -> bool {
        true
    }

    fn runtime(
        &self,
        elements: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        let range = ends(shape);
        let weight: f64 = parameter(weights, 0);
        let cells = self.kernel(elements, shape, 1.0).weights(shape.get(2..).unwrap_or_default());
        let cells: Vec<f64> = cells.into_iter().map(|cell: f64| weight * cell).collect();
        RuntimeOperator::plane(range, INTERVALS, &cells)
    }
}

impl ColumnFamily for Entry {
    type Kernel = PreisachDensity;

    const FIXED: usize = GRID_ENDS;

    fn kernel(&self, _: usize, shape: &[f64], _: f64) -> PreisachDensity {
        let plane = Preisach::regular(ends(shape), INTERVALS + 1);
        PreisachDensity { plane, law: DensityLaw::Lorentzian }
    }
}
