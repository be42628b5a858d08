//! Krasnosel'skii–Pokrovskii kernels on a discretised plane: relays with ramps for jumps.
//!
//! Sources: M. A. Krasnosel'skii, A. V. Pokrovskii, *Systems with Hysteresis*, Springer 1989,
//! doi:10.1007/978-3-642-61302-9; H. T. Banks, A. J. Kurdila, G. Webb, "Identification of hysteretic control
//! influence operators representing smart actuators, part I", *Math. Probl. Eng.* 3 (1997) 287–328,
//! doi:10.1155/S1024123X97000586.

use hysteron_rt::{Dual, Scalar, Sides, between_ramps, ramp};

use super::HysteresisError;
use super::columns::{ColumnKernel, is_plain, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, GRID_ENDS, MOST_OF_A_PLANE, NumberUnit,
    RuntimeOperator, Search, ShapeNumber, ends, on_a_plane,
};

/// Columns ξ ← max(ρ(u − p₂), min(ρ(u − p₁), ξ)), ρ(x) = max(−1, min(1, 2x/a)), for every pair p₁ ≤ p₂ of a
/// regular grid.
///
/// A column switches from −1 to 1 along a ramp of length a about p₂ where u rises, and back about p₁ where it
/// falls; with p₁ = p₂ it is that ramp and has no hysteresis. The ramp is centred (the literature lets it
/// begin at p), so that a grid symmetric about 0 makes an odd family. Shape: `rise` a \[V\]. A virgin column
/// stands at ρ(u − ½ (p₁ + p₂)).
///
/// Pairs are in the order (p₁, p₂) = (g₀, g₀), (g₀, g₁), (g₁, g₁), (g₀, g₂), … : column i(i + 1)/2 + j is
/// (gⱼ, gᵢ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KrasnoselskiiPokrovskii {
    /// Ends of the grid \[V\].
    pub range: [f64; 2],
    /// Lines of the grid, 2 to 64; the columns are lines (lines + 1)/2.
    pub lines: usize,
}

/// The columns, and the ramps at the present voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct KrasnoselskiiPokrovskiiState<S> {
    ramps: Vec<S>,
    columns: Vec<S>,
}

impl KrasnoselskiiPokrovskii {
    /// Line number `index` of the grid \[V\].
    pub fn line(&self, index: usize) -> f64 {
        let [low, high] = self.range;
        low + (high - low) * (index as f64 / (self.lines.max(2) - 1) as f64)
    }
}

/// 2/a.
fn steepness<S: Scalar<Real = f64>>(shape: &[S]) -> S {
    S::constant(2.0) / parameter(shape, 0)
}

impl ColumnKernel for KrasnoselskiiPokrovskii {
    type State<S: Scalar<Real = f64>> = KrasnoselskiiPokrovskiiState<S>;

    simulate_with_sensitivities!(1);

    fn shape_names(&self) -> &'static [&'static str] {
        &["rise"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let [low, high] = self.range;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        if !(2..=64).contains(&self.lines) {
            let (name, must) = ("number of grid lines", "2 to 64");
            return Err(HysteresisError::ShapeParameter { name, value: self.lines as f64, must });
        }
        positive("rise of the ramps", parameter(shape, 0))
    }

    fn columns(&self) -> usize {
        self.lines * (self.lines + 1) / 2
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> KrasnoselskiiPokrovskiiState<S> {
        let mut columns = vec![S::constant(0.0); self.columns()];
        let lines = (0..self.lines).map(|index| S::constant(self.line(index)));
        let _ = Sides::Ramps { steepness: steepness(shape) }.rest_at(lines, &mut columns, u);
        KrasnoselskiiPokrovskiiState { ramps: vec![S::constant(0.0); self.lines], columns }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut KrasnoselskiiPokrovskiiState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let steepness = steepness(shape);
        for (index, slot) in state.ramps.iter_mut().enumerate() {
            *slot = ramp(steepness, S::constant(u - self.line(index)));
        }
        between_ramps(&state.ramps, &mut state.columns);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &KrasnoselskiiPokrovskiiState<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.columns).for_each(|(out, column)| *out = *column);
    }

    fn with_derivatives_constant<const P: usize>(
        &self,
        shape: &[f64],
        state: &KrasnoselskiiPokrovskiiState<Dual<f64, P>>,
        [low, high]: [f64; 2],
    ) -> Option<KrasnoselskiiPokrovskiiState<f64>> {
        let steepness = steepness(shape);
        let at = |u: f64, index: usize| ramp(steepness, u - self.line(index));
        let pairs = (0..self.lines).flat_map(|i| (0..=i).map(move |j| (j, i)));
        let is_settled = |(column, (p1, p2)): (&Dual<f64, P>, (usize, usize))| {
            // Between the ramps it stays.
            is_plain(column) || at(high, p2) < column.value && column.value < at(low, p1)
        };
        if !state.columns.iter().zip(pairs).all(is_settled) || !state.ramps.iter().all(is_plain) {
            return None;
        }
        let numbers = |of: &[Dual<f64, P>]| of.iter().map(|number| number.value).collect();
        Some(KrasnoselskiiPokrovskiiState { ramps: numbers(&state.ramps), columns: numbers(&state.columns) })
    }
}

/// The family, on a grid from `low` to `high`.
#[derive(Debug)]
pub(super) struct Entry;

/// Distance of the lines of a grid: ramps of this length meet.
fn pitch(lines: usize, [low, high]: [f64; 2]) -> f64 {
    (high - low) / (lines.max(2) - 1) as f64
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "krasnoselskii-pokrovskii"
    }

    fn summary(&self) -> &'static str {
        "Ramped relays on a grid of 8 lines (36 weights)"
    }

    fn equation(&self) -> &'static str {
        "relays on a grid of lines from low to high, a weight a pair of lines, each switching along ramps of \
         length rise"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 8, most: MOST_OF_A_PLANE })
    }

    fn columns(&self, lines: usize) -> usize {
        lines * (lines + 1) / 2
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, lines: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let rise = Search::Held(pitch(lines, span.grid));
        let own = ShapeNumber::new("rise", NumberUnit::INPUT, "length of the ramps", rise);
        ShapeNumber::of_ends(span).into_iter().chain([own]).collect()
    }

    fn starts(&self, lines: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let [low, high] = span.grid;
        vec![vec![low, high, pitch(lines, span.grid)]]
    }

    fn example(&self, lines: usize, span: &DriveSpan) -> Vec<f64> {
        let [low, high] = span.grid;
        vec![low, high, 1.4 * pitch(lines, span.grid)]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn is_plane(&self) -> bool {
        true
    }

    fn neighbours(&self, lines: usize) -> Vec<(usize, usize)> {
        on_a_plane(lines)
    }

    fn runtime(
        &self,
        lines: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        let grid = self.kernel(lines, shape, 1.0);
        let sides = Sides::Ramps { steepness: steepness(shape.get(2..).unwrap_or_default()) };
        RuntimeOperator::sided(sides, (0..lines).map(|index| grid.line(index)).collect(), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = KrasnoselskiiPokrovskii;

    const FIXED: usize = GRID_ENDS;

    fn kernel(&self, lines: usize, shape: &[f64], _: f64) -> KrasnoselskiiPokrovskii {
        KrasnoselskiiPokrovskii { range: ends(shape), lines }
    }
}
