//! Plays and bands of their mean output: Kuhnen's modified play operator with free weights.
//!
//! Source: K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities: a
//! modified Prandtl–Ishlinskii approach", *Eur. J. Control* 9 (2003) 407–418, doi:10.3166/ejc.9.407-418.

use hysteron_rt::{Dual, Scalar, Sides, each_band};

use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, GRID_ENDS, MOST_ELEMENTS, MeanLine, NumberUnit,
    RuntimeOperator, Search, ShapeNumber, ends, in_a_row,
};
use super::outputs::Columns;
use super::pass::{Every, at_rest};
use super::play_sums::PlaySums;
use super::plays::PlayStates;
use super::{DriveGrid, HysteresisError};
use crate::start::Start;

mod pass;

/// Bands that divide the mean output of the plays.
pub(super) const BANDS: usize = 6;

/// Columns Fⱼ ← max(u − rⱼ, min(u + rⱼ, Fⱼ)) \[V\], one per play, then six bands of the mean output of the
/// plays.
///
/// With the mean h = (1 − s) u + s Σ gⱼ Fⱼ, gⱼ ∝ exp(−rⱼ/reach), Σ gⱼ = 1, \[V\] and five corners c₁ < … < c₅
/// at equal distances within `range`, band k is max(0, min(h − cₖ, cₖ₊₁ − cₖ)); the first and the last are
/// unbounded outwards: min(h − c₁, 0) and max(h − c₅, 0). A band is the difference of two dead zones of
/// Kuhnen's, so a sum of bands is S(h), S a broken line.
///
/// Every column rises and falls with u. Non-negative weights give every increasing S.
///
/// Shape: `loop_share` s from 0 to below 1, `reach` \[V\]. A virgin play stands at its voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZonePlays {
    /// Ends of the voltages that the bands divide \[V\].
    pub range: [f64; 2],
    /// Half-widths rⱼ \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// States of the plays, their shares gⱼ, the corners, and the present voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZonePlayStates<S> {
    plays: PlayStates<S>,
    shares: Vec<S>,
    corners: Vec<f64>,
    u: S,
}

impl DeadZonePlays {
    /// Plays at equal distances up to half of the range.
    pub fn regular(range: [f64; 2], plays: usize) -> Self {
        let [low, high] = range;
        let distance = 0.5 * (high - low) / (plays + 1) as f64;
        Self { range, thresholds: (1..=plays).map(|j| j as f64 * distance).collect() }
    }

    /// The corners \[V\].
    pub(crate) fn corners(&self) -> Vec<f64> {
        let [low, high] = self.range;
        (1..BANDS).map(|index| low + (high - low) * index as f64 / BANDS as f64).collect()
    }

    /// s gⱼ: the weight of each play in the mean.
    pub(crate) fn shares<S: Scalar<Real = f64>>(&self, shape: &[S]) -> Vec<S> {
        let [share, reach] = [0, 1].map(|index| parameter(shape, index));
        let narrowest = self.thresholds.first().copied().unwrap_or(0.0);
        // Relative to the narrowest play, whose share does not vanish however short the reach.
        let mut shares: Vec<S> =
            self.thresholds.iter().map(|r| (S::constant(narrowest - r) / reach).exp()).collect();
        let total = shares.iter().fold(S::constant(0.0), |sum, g| sum + *g);
        shares.iter_mut().for_each(|g| *g = *g / total * share);
        shares
    }
}

impl ColumnKernel for DeadZonePlays {
    type State<S: Scalar<Real = f64>> = DeadZonePlayStates<S>;

    simulate_with_sensitivities!(2);

    fn shape_names(&self) -> &'static [&'static str] {
        &["loop_share", "reach"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        super::plays::check_thresholds(&self.thresholds)?;
        let [low, high] = self.range;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        let value = parameter(shape, 0);
        if !(0.0..1.0).contains(&value) {
            let (name, must) = ("loop share", "from 0 to below 1");
            return Err(HysteresisError::ShapeParameter { name, value, must });
        }
        positive("reach of the plays", parameter(shape, 1))
    }

    fn columns(&self) -> usize {
        self.thresholds.len() + BANDS
    }

    fn first_shaped(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> DeadZonePlayStates<S> {
        let (shares, corners) = (self.shares(shape), self.corners());
        DeadZonePlayStates { plays: PlayStates::at(self.thresholds.len(), u), shares, corners, u }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut DeadZonePlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        state.plays.advance(self.thresholds.iter().map(|&threshold| S::constant(threshold)), u);
        state.u = S::constant(u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &DeadZonePlayStates<S>, out: &mut [S]) {
        let DeadZonePlayStates { plays, shares, corners, u } = state;
        // (1 − Σ g) u + Σ g F, from the lags of the plays.
        let behind =
            plays.plays.iter().zip(shares).fold(S::constant(0.0), |sum, (f, g)| sum + *g * (*f - *u));
        let h = *u + behind;
        plays.read(out);
        let mut rest = out.iter_mut().skip(self.thresholds.len());
        each_band(corners, h, |band| {
            if let Some(out) = rest.next() {
                *out = band;
            }
        });
    }
}

/// The family, on a grid from `low` to `high`.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "dead-zone-plays"
    }

    fn summary(&self) -> &'static str {
        "12 plays and six bands of their outputs: minor loops that differ with bias"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j F_j, plays of half-width j (high - low)/(2 (number + 1)); then six bands, from low \
         to high, of h = (1 - loop_share) u + loop_share sum of g_j F_j, g_j in proportion to exp(-r_j/reach)"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn columns(&self, plays: usize) -> usize {
        plays + BANDS
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let share = Search::Linear(0.0, 0.95);
        let own = [
            ShapeNumber::new(
                "loop_share",
                NumberUnit::NONE,
                "share of the plays in the input of the bands",
                share,
            ),
            ShapeNumber::new(
                "reach",
                NumberUnit::INPUT,
                "half-width over which that share decays",
                span.strokes(0.02, 2.0),
            ),
        ];
        ShapeNumber::of_ends(span).into_iter().chain(own).collect()
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let [low, high] = span.grid;
        let with = |share: f64| [0.1, 0.5].map(|reach| vec![low, high, share, reach * span.stroke]);
        [0.1, 0.5].into_iter().flat_map(with).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        let [low, high] = span.grid;
        vec![low, high, 0.37, 0.2 * span.stroke]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn is_compared_unasked(&self) -> bool {
        true
    }

    fn is_chosen_unasked(&self) -> bool {
        true
    }

    fn chain(&self, plays: usize) -> Vec<(usize, Option<usize>)> {
        let last = plays.checked_sub(1).map(|last| (last, None));
        in_a_row(0, plays).chain(last).chain(in_a_row(plays, plays + BANDS)).collect()
    }

    fn runtime(
        &self,
        plays: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        let kernel = self.kernel(plays, shape, 1.0);
        let (own, slopes) = weights.split_at(plays.min(weights.len()));
        let shares = kernel.shares(shape.get(2..).unwrap_or_default());
        let line = MeanLine { shares, corners: kernel.corners(), slopes: slopes.to_vec() };
        let sides = Sides::Even { widening: 0.0 };
        RuntimeOperator::SidedPlays { sides, thresholds: kernel.thresholds, weights: own.to_vec(), line }
    }
}

impl ColumnFamily for Entry {
    type Kernel = DeadZonePlays;

    const FIXED: usize = GRID_ENDS;

    fn kernel(&self, plays: usize, shape: &[f64], _: f64) -> DeadZonePlays {
        DeadZonePlays::regular(ends(shape), plays)
    }

    fn run_columns(
        &self,
        (plays, shape, _): (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        Every::new(grid.factor)?;
        let kernel = self.kernel(plays, shape, 1.0);
        let is_wanted = |shape: &usize| wanted.is_some_and(|wanted| wanted.get(*shape) == Some(&true));
        let bands = plays..plays + BANDS;
        let pairs: Vec<(usize, usize)> = (GRID_ENDS..shape.len())
            .filter(is_wanted)
            .flat_map(|shape| bands.clone().map(move |column| (shape, column)))
            .collect();
        out.resize_with_memory(bands.end, u.len().div_ceil(grid.factor), &pairs)?;
        PlaySums::single(&kernel.thresholds).run(grid.factor, u, start, wanted.is_some(), out)?;
        let rest = at_rest(start, u)?.map(|(rest, _)| rest);
        let own = shape.get(GRID_ENDS..).unwrap_or_default();
        let shares = kernel.shares(&[0, 1].map(|index| Dual::variable(parameter(own, index), index)));
        pass::bands_of_mean((&shares, &kernel.corners()), (u, grid.factor), rest, out)
    }
}

#[cfg(test)]
mod tests;
