//! Plays with thermally activated edges: one parameter for both creep and the widening of loops with rate.
//!
//! Sources: H. Eyring, *J. Chem. Phys.* 4 (1936) 283–291, doi:10.1063/1.1749836 (the kinetics); L. Prandtl,
//! *Z. angew. Math. Mech.* 8 (1928) 85–106, doi:10.1002/zamm.19280080202 (elements that slip by it).

use hysteron_numeric::InstructionSet;
use hysteron_rt::{RelaxingMove, SLOPES, Scalar};

mod abreast;

use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, GRID_ENDS, NumberUnit, RuntimeOperator,
    ShapeNumber, ends,
};
use super::{HysteresisError, HysteresisForm};
use crate::record::{Dependence, Pace};
use abreast::{Move, PLAYS, Readings};

/// Smallest and largest half-width of the plays, as shares of the range of the grid: no loop moves wider
/// ones, and their weights would fit the offsets of single records.
const WIDTHS: [f64; 2] = [0.0015, 0.5];
/// Decay of the narrowest density, as a share of the range; each further one is ten times as wide.
const NARROWEST: f64 = 0.01;

/// Columns H_(e,k) = Σᵢ gₑ(rᵢ) B_k(pᵢ) \[V\] of plays pᵢ = u − zᵢ with thermally activated edges
/// ([`RelaxingMove`]),
///
/// żᵢ = u̇ − sign(zᵢ) v₀ exp((|zᵢ| − rᵢ)/σ),  v₀ = 1 unit of the drive per second.
///
/// gₑ ∝ exp(−r/Rₑ) is a density over the half-widths, Σ g = 1, with one Rₑ per decade; B_k, k = 0, 1, 2, is
/// the integral of the Bernstein polynomial b_k of degree 2 over the grid, from its lower end on and straight
/// beyond its ends. So the slope of a play's output depends on its state, and non-negative weights make every
/// slope non-negative.
///
/// σ \[V\], the one shape number, widens loops by σ per factor e of the rate, and makes a device at rest
/// creep in proportion to σ ln t, more after a larger and faster move. σ → 0 gives plays. A virgin play is at
/// its voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivatedPlays {
    /// Ends of the grid \[V\].
    pub range: [f64; 2],
    /// Densities.
    pub densities: usize,
    /// Seconds between samples, where the drive has no paces.
    pub interval_s: f64,
    thresholds: [f64; PLAYS],
    /// gₑ of each play, density by density.
    shares: Vec<[f64; PLAYS]>,
    set: InstructionSet,
}

/// Lags zᵢ of the plays behind the drive, the drive, and the pace of its next move.
#[derive(Clone, Debug, PartialEq)]
pub struct ActivatedPlayStates<S> {
    behind: Vec<S>,
    u: S,
    moved: bool,
    pace: Option<Pace>,
}

impl ActivatedPlays {
    /// Plays over a grid, with this number of densities.
    pub fn new(range: [f64; 2], densities: usize, interval_s: f64) -> Self {
        let span = range[1] - range[0];
        let [least, most] = WIDTHS;
        let width = |i: usize| span * least * (most / least).powf((i as f64 + 0.5) / PLAYS as f64);
        let thresholds: [f64; PLAYS] = std::array::from_fn(width);
        let of_density = |e: usize| {
            let decay = span * NARROWEST * 10f64.powi(e as i32);
            // Nodes are at equal distances in ln r: dr is in proportion to r.
            let of = thresholds.map(|r| r * (-r / decay).exp());
            let total: f64 = of.iter().sum();
            of.map(|share| share / total)
        };
        let shares = (0..densities).map(of_density).collect();
        Self { range, densities, interval_s, thresholds, shares, set: InstructionSet::detected() }
    }
}

impl ColumnKernel for ActivatedPlays {
    type State<S: Scalar<Real = f64>> = ActivatedPlayStates<S>;

    simulate_with_sensitivities!(1);

    fn shape_names(&self) -> &'static [&'static str] {
        &["sigma"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let [low, high] = self.range;
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        positive("time between samples", self.interval_s)?;
        positive("activation σ of the plays", parameter(shape, 0))
    }

    fn columns(&self) -> usize {
        SLOPES * self.densities
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> ActivatedPlayStates<S> {
        ActivatedPlayStates { behind: vec![S::constant(0.0); PLAYS], u, moved: false, pace: None }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut ActivatedPlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let by = (-state.u).shift(u);
        let is_first = !state.moved;
        let interval_s = match state.pace.take() {
            Some(pace) => S::constant(pace.interval_s),
            None if state.moved => S::constant(self.interval_s),
            // The duration of the move to rest is unknown: at the rate v₀.
            None if by.value() < 0.0 => -by,
            None => by,
        };
        (state.u, state.moved) = (S::constant(u), true);
        let sigma = parameter(shape, 0);
        if is_first {
            // The drive before may carry derivatives.
            let step = RelaxingMove::new(sigma, by, interval_s);
            for (z, &r) in state.behind.iter_mut().zip(&self.thresholds) {
                *z = step.distance(r, *z);
            }
        } else {
            Move::new(sigma, by.value(), interval_s.value(), &self.thresholds)
                .apply(self.set, &mut state.behind);
        }
        Ok(())
    }

    fn preceded<S: Scalar<Real = f64>>(state: &mut ActivatedPlayStates<S>, by: Option<f64>) {
        if let Some(before) = by {
            // The plays keep their states while the previous voltage is replaced.
            let moved = (-state.u).shift(before);
            state.behind.iter_mut().for_each(|z| *z = *z + moved);
            (state.u, state.moved) = (S::constant(before), true);
        }
    }

    fn paced<S: Scalar<Real = f64>>(state: &mut ActivatedPlayStates<S>, pace: Pace) {
        state.pace = Some(pace);
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &ActivatedPlayStates<S>, out: &mut [S]) {
        Readings::new(self.range, state.u, &state.behind).sum(self.set, &self.shares, out);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut ActivatedPlayStates<S>) -> &mut [S] {
        &mut state.behind
    }
}

/// The family, on a grid from `low` to `high`.
#[derive(Debug)]
pub(super) struct Entry;

/// Default number of densities.
const USUAL: usize = 3;

impl HysteresisForm {
    /// Plays with thermally activated edges, the family for records of small oscillations beside wide moves.
    pub fn activated_plays() -> Self {
        Self::of(&Entry, USUAL)
    }
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "activated-plays"
    }

    fn summary(&self) -> &'static str {
        "Plays that creep and widen with the logarithm of the rate, by one number"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j H_j, three densities exp(-r/R), R = 0.01 (high - low) times 1, 10, 100, each with \
         three slopes over low to high, of plays p = u - z, dz/dt = du/dt - sign(z) exp((|z| - r)/sigma)"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: USUAL, most: USUAL })
    }

    fn columns(&self, densities: usize) -> usize {
        SLOPES * densities
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let meaning = "activation: how much wider the loops are for a factor e of the rate";
        let sigma = ShapeNumber::new("sigma", NumberUnit::INPUT, meaning, span.strokes(0.001, 0.2));
        ShapeNumber::of_ends(span).into_iter().chain([sigma]).collect()
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let [low, high] = span.grid;
        [0.006, 0.02].map(|sigma| vec![low, high, sigma * span.stroke]).into()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        let [low, high] = span.grid;
        vec![low, high, 0.017 * span.stroke]
    }

    /// A creeping output may fall while the drive rises, but of two moves of the same duration the larger
    /// gives the larger output.
    fn is_monotone(&self) -> bool {
        true
    }

    fn depends_on(&self) -> Dependence {
        Dependence::Time
    }

    fn runtime(
        &self,
        densities: usize,
        _: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        sample_rate_hz: f64,
    ) -> RuntimeOperator {
        let interval_s = 1.0 / sample_rate_hz;
        let ActivatedPlays { range, thresholds, shares, .. } = self.kernel(densities, shape, interval_s);
        let slope = |i: usize, k: usize| {
            let of = |(shares, weights): (&[f64; PLAYS], &[f64])| {
                weights.get(k).map_or(0.0, |weight| shares[i] * weight)
            };
            shares.iter().zip(weights.chunks(SLOPES)).map(of).sum::<f64>()
        };
        let slopes =
            (0..PLAYS).flat_map(|i| (0..SLOPES).map(move |k| (i, k))).map(|(i, k)| slope(i, k)).collect();
        let pace = (parameter(shape, 2), interval_s);
        RuntimeOperator::RelaxingPlays { pace, range, thresholds: thresholds.into(), slopes }
    }
}

impl ColumnFamily for Entry {
    type Kernel = ActivatedPlays;

    const FIXED: usize = GRID_ENDS;

    fn kernel(&self, densities: usize, shape: &[f64], interval_s: f64) -> ActivatedPlays {
        ActivatedPlays::new(ends(shape), densities, interval_s)
    }
}
