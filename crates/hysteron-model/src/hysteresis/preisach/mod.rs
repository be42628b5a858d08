//! The Preisach model: a plane of relays.
//!
//! Sources: F. Preisach, *Z. Phys.* 94 (1935) 277–302, doi:10.1007/BF01349418; D. H. Everett, *Trans. Faraday
//! Soc.* 51 (1955) 1551–1557, doi:10.1039/TF9555101551; I. D. Mayergoyz, *Mathematical Models of Hysteresis*,
//! Springer 1991, doi:10.1007/978-1-4612-3028-1.

pub(super) mod density;
mod staircase;

pub use density::{DensityLaw, PreisachDensity};

use hysteron_rt::{Dual, Scalar, between};

use super::HysteresisError;
use super::columns::{ColumnKernel, is_plain, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, GRID_ENDS, MOST_OF_A_PLANE, NumberUnit,
    RuntimeOperator, ShapeNumber, ends, on_a_plane,
};
use staircase::{Edge, MovePiece, Staircase};

/// Most levels of a plane.
const MOST_LEVELS: usize = 201;

/// Columns of a discretised Preisach plane: for every pair i > j of intervals between levels x₀ < x₁ < …, the
/// mean of the relays that switch up at α in \[xᵢ, xᵢ₊₁\] and down at β in \[xⱼ, xⱼ₊₁\]; for i = j, on the
/// diagonal, the ramp from −1 at xᵢ to 1 at xᵢ₊₁, which is without hysteresis.
///
/// All columns are continuous and lie in \[−1, 1\]. Column i(i + 1)/2 + j belongs to (i, j); with weights w
/// the Everett function is Σ w over the cells of its triangle, bilinear between the levels and linear next to
/// the diagonal. Weights that are not negative, found by regularised non-negative least squares, are a
/// measured Preisach density.
///
/// Without shape parameters. Virgin at u: relays with α + β < 2u are up, the others down, as an alternating
/// voltage about u that decays slowly leaves them.
#[derive(Clone, Debug, PartialEq)]
pub struct Preisach {
    /// Levels \[V\], increasing, 2 to 201.
    pub levels: Vec<f64>,
}

/// Staircase of turning points, and the mean of the relays of every cell.
#[derive(Clone, Debug, PartialEq)]
pub struct PreisachState<S> {
    stairs: Staircase<S>,
    cells: Vec<S>,
}

impl Preisach {
    /// `count` levels at equal distances over a range.
    pub fn regular([low, high]: [f64; 2], count: usize) -> Self {
        let last = count.max(2) - 1;
        let level = |k: usize| low + (high - low) * (k as f64 / last as f64);
        Self { levels: (0..=last).map(level).collect() }
    }

    /// Ends of interval `index` between levels.
    fn interval(&self, index: usize) -> [f64; 2] {
        match self.levels.get(index..index + 2) {
            Some(&[low, high]) => [low, high],
            _ => [f64::NAN; 2],
        }
    }

    /// Number of intervals between levels.
    fn intervals(&self) -> usize {
        self.levels.len().saturating_sub(1)
    }

    /// Intervals (i, j) of the cells, in order.
    fn pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.intervals()).flat_map(|i| (0..=i).map(move |j| (i, j)))
    }

    fn check_levels(&self) -> Result<(), HysteresisError> {
        if !(2..=MOST_LEVELS).contains(&self.levels.len()) {
            let (name, must) = ("number of Preisach levels", "2 to 201");
            return Err(HysteresisError::ShapeParameter { name, value: self.levels.len() as f64, must });
        }
        let mut above = f64::NEG_INFINITY;
        for &value in &self.levels {
            if !(value.is_finite() && value > above) {
                let (name, must) = ("Preisach level", "finite and above the one before it");
                return Err(HysteresisError::ShapeParameter { name, value, must });
            }
            above = value;
        }
        Ok(())
    }

    fn virgin_state<S: Scalar<Real = f64>>(&self, u: S) -> PreisachState<S> {
        let cells = self.pairs().map(|(i, j)| {
            let ([a, b], [c, d]) = (self.interval(i), self.interval(j));
            // Area of α + β < 2u within the cell.
            let below = |corner: f64| square(u.scale(2.0).shift(-corner));
            let up = below(a + c) - below(b + c) - below(a + d) + below(b + d);
            up.scale(2.0 / ((b - a) * (d - c))).shift(-1.0)
        });
        PreisachState { stairs: Staircase::virgin(u), cells: cells.collect() }
    }

    /// Moves monotonically to `u`; `changed` receives the number of a cell and the change of its mean.
    fn move_to<S: Scalar<Real = f64>>(
        &self,
        state: &mut PreisachState<S>,
        u: f64,
        mut changed: impl FnMut(usize, S),
    ) {
        let PreisachState { stairs, cells } = state;
        stairs.advance(u, |rising, piece| {
            if rising {
                self.raise(piece, cells, &mut changed);
            } else {
                self.lower(piece.mirrored(), cells, &mut changed);
            }
        });
    }

    /// Switches relays up. Rows that the piece has passed are up whatever they were.
    fn raise<S: Scalar<Real = f64>>(
        &self,
        piece: MovePiece<S>,
        cells: &mut [S],
        changed: &mut impl FnMut(usize, S),
    ) {
        let (from, to) = (piece.from.value(), piece.to.value());
        let first = self.levels.partition_point(|x| *x <= from).saturating_sub(1);
        for i in first..self.intervals() {
            let row = self.interval(i);
            let [low, high] = row;
            if low >= to {
                break;
            }
            let begin = i * (i + 1) / 2;
            for (j, cell) in cells.iter_mut().skip(begin).take(i).enumerate() {
                let before = *cell;
                *cell = if to >= high {
                    S::constant(1.0)
                } else {
                    let [c, d] = self.interval(j);
                    *cell + swept(piece, row, [c, d]).scale(2.0 / ((high - low) * (d - c)))
                };
                changed(begin + j, *cell - before);
            }
        }
    }

    /// Switches relays down, given the mirrored piece.
    fn lower<S: Scalar<Real = f64>>(
        &self,
        piece: MovePiece<S>,
        cells: &mut [S],
        changed: &mut impl FnMut(usize, S),
    ) {
        let (from, to) = (-piece.from.value(), -piece.to.value());
        let beyond = self.levels.partition_point(|x| *x < from).min(self.intervals());
        for j in (0..beyond).rev() {
            let [c, d] = self.interval(j);
            if d <= to {
                break;
            }
            for i in j + 1..self.intervals() {
                let at = i * (i + 1) / 2 + j;
                let Some(cell) = cells.get_mut(at) else { continue };
                let before = *cell;
                *cell = if to <= c {
                    S::constant(-1.0)
                } else {
                    let [low, high] = self.interval(i);
                    *cell - swept(piece, [-d, -c], [-high, -low]).scale(2.0 / ((high - low) * (d - c)))
                };
                changed(at, *cell - before);
            }
        }
    }

    /// Passes column number i(i + 1)/2 + j to `put` in this order.
    fn read_cells<S: Scalar<Real = f64>>(&self, state: &PreisachState<S>, mut put: impl FnMut(usize, S)) {
        let u = state.stairs.voltage();
        let mut at = 0;
        for i in 0..self.intervals() {
            for &cell in state.cells.iter().skip(at).take(i) {
                put(at, cell);
                at += 1;
            }
            let [low, high] = self.interval(i);
            let share = u.shift(-low).scale(2.0 / (high - low)).shift(-1.0);
            put(at, between([-1.0, 1.0].map(S::constant), share));
            at += 1;
        }
    }
}

/// ½ max(x, 0)².
fn square<S: Scalar<Real = f64>>(x: S) -> S {
    if x.value() > 0.0 { (x * x).scale(0.5) } else { S::constant(0.0) }
}

/// max(x, 0).
fn positive_part<S: Scalar<Real = f64>>(x: S) -> S {
    if x.value() > 0.0 { x } else { S::constant(0.0) }
}

/// Area of the relays of a cell (α in `row`, β in `column`, below all of the row) that a rising piece
/// switches.
fn swept<S: Scalar<Real = f64>>(piece: MovePiece<S>, [low, high]: [f64; 2], [c, d]: [f64; 2]) -> S {
    let clip = |x: S| between([low, high].map(S::constant), x);
    let (from, to) = (clip(piece.from), clip(piece.to));
    match piece.edge {
        Edge::Turn(turn) => {
            let begin = between([c, d].map(S::constant), turn);
            positive_part((-begin).shift(d)) * (to - from)
        }
        Edge::Virgin(rest) => {
            // ∫ (length of β < 2 rest − α within the column) dα, from the two ends of the move.
            let left_out = |corner: f64| {
                let ends = [from, to].map(|alpha| square((rest.scale(2.0) - alpha).shift(-corner)));
                let [first, last] = ends;
                first - last
            };
            (to - from).scale(d - c) - left_out(c) + left_out(d)
        }
    }
}

impl ColumnKernel for Preisach {
    type State<S: Scalar<Real = f64>> = PreisachState<S>;

    simulate_with_sensitivities!(0);

    fn shape_names(&self) -> &'static [&'static str] {
        &[]
    }

    fn check(&self, _: &[f64]) -> Result<(), HysteresisError> {
        self.check_levels()
    }

    fn columns(&self) -> usize {
        self.intervals() * (self.intervals() + 1) / 2
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> PreisachState<S> {
        self.virgin_state(u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut PreisachState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        self.move_to(state, u, |_, _| {});
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PreisachState<S>, out: &mut [S]) {
        self.read_cells(state, |at, value| {
            if let Some(slot) = out.get_mut(at) {
                *slot = value;
            }
        });
    }

    fn with_derivatives_constant<const P: usize>(
        &self,
        _: &[f64],
        state: &PreisachState<Dual<f64, P>>,
        reach: [f64; 2],
    ) -> Option<PreisachState<f64>> {
        let is_settled = |(cell, (i, j)): (&Dual<f64, P>, (usize, usize))| {
            // Relays beyond the reach stay virgin. Cells on the diagonal are not read.
            let keeps_some = reach[1] < self.interval(i)[1] && self.interval(j)[0] < reach[0];
            is_plain(cell) || i == j || keeps_some
        };
        if !state.cells.iter().zip(self.pairs()).all(is_settled) {
            return None;
        }
        let cells = state.cells.iter().map(|cell| cell.value).collect();
        Some(PreisachState { cells, stairs: state.stairs.settled(reach)? })
    }
}

/// The family, with levels from `low` to `high`.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "preisach"
    }

    fn summary(&self) -> &'static str {
        "Preisach relays on a grid of 10 intervals (55 weights)"
    }

    fn equation(&self) -> &'static str {
        "relays on a plane with levels from low to high, a weight a cell"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 10, most: MOST_OF_A_PLANE })
    }

    fn columns(&self, intervals: usize) -> usize {
        intervals * (intervals + 1) / 2
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        ShapeNumber::of_ends(span).into()
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        vec![span.grid.into()]
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        span.grid.into()
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn is_plane(&self) -> bool {
        true
    }

    fn neighbours(&self, intervals: usize) -> Vec<(usize, usize)> {
        on_a_plane(intervals)
    }

    fn runtime(
        &self,
        intervals: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        let range = ends(shape);
        RuntimeOperator::plane(range, intervals, weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = Preisach;

    const FIXED: usize = GRID_ENDS;

    fn kernel(&self, intervals: usize, shape: &[f64], _: f64) -> Preisach {
        Preisach::regular(ends(shape), intervals + 1)
    }
}
