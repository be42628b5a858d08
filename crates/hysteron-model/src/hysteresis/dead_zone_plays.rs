//! Plays beside bands of their common output: Kuhnen's modified Prandtl–Ishlinskii operator with weights left open.
//!
//! Source: K. Kuhnen, "Modeling, identification and compensation of complex hysteretic nonlinearities: a modified
//! Prandtl–Ishlinskii approach", *Eur. J. Control* 9 (2003) 407–418, doi:10.3166/ejc.9.407-418.

use hysteron_rt::Scalar;

use super::HysteresisError;
use super::columns::{ColumnKernel, between, parameter, positive, simulate_with_sensitivities};
use super::plays::PlayStates;

/// Bands that the output of the plays is cut into.
pub(super) const BANDS: usize = 6;

/// Columns Fⱼ ← max(u − rⱼ, min(u + rⱼ, Fⱼ)) \[V\], one a play, then six bands of what the plays put out together.
///
/// With the mean h = (1 − s) u + s Σ gⱼ Fⱼ, gⱼ ∝ exp(−rⱼ/reach), Σ gⱼ = 1, \[V\] and five corners c₁ < … < c₅ at equal
/// distances within `range`, band k is max(0, min(h − cₖ, cₖ₊₁ − cₖ)); the first and the last have no end outwards: min(h − c₁, 0)
/// and max(h − c₅, 0). A band is the difference of two dead zones of Kuhnen's, so a sum of bands is S(h), S a broken line.
///
/// A column rises with u and falls with it. Weights that are not negative make every S that rises.
///
/// Shape: `loop_share` s from 0 to below 1, `reach` \[V\]. A virgin play stands at its voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZonePlays {
    /// Ends of the voltages that the bands divide \[V\].
    pub range: [f64; 2],
    /// Half-widths rⱼ \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// Where the plays stand, their shares gⱼ, and the present voltage.
#[derive(Clone, Debug, PartialEq)]
pub struct DeadZonePlayStates<S> {
    plays: PlayStates<S>,
    shares: Vec<S>,
    u: S,
}

impl DeadZonePlays {
    /// Plays at equal distances up to half of the range.
    pub fn regular(range: [f64; 2], plays: usize) -> Self {
        let [low, high] = range;
        let distance = 0.5 * (high - low) / (plays + 1) as f64;
        Self { range, thresholds: (1..=plays).map(|j| j as f64 * distance).collect() }
    }

    /// Corner number `index`, from 1 on.
    fn corner(&self, index: usize) -> f64 {
        let [low, high] = self.range;
        low + (high - low) * index as f64 / BANDS as f64
    }

    /// The corners \[V\].
    pub(crate) fn corners(&self) -> Vec<f64> {
        (1..BANDS).map(|index| self.corner(index)).collect()
    }

    /// s gⱼ: what each play counts in the mean.
    pub(crate) fn shares<S: Scalar<Real = f64>>(&self, shape: &[S]) -> Vec<S> {
        let [share, reach] = [0, 1].map(|index| parameter(shape, index));
        let narrowest = self.thresholds.first().copied().unwrap_or(0.0);
        // Relative to the narrowest play, of which something is left however short the reach.
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

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> DeadZonePlayStates<S> {
        let shares = self.shares(shape);
        DeadZonePlayStates { plays: PlayStates::at(self.thresholds.len(), u), shares, u }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut DeadZonePlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        state.plays.advance(&self.thresholds, S::constant(1.0), [1.0, 1.0], u);
        state.u = S::constant(u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &DeadZonePlayStates<S>, out: &mut [S]) {
        let DeadZonePlayStates { plays, shares, u } = state;
        // (1 − Σ g) u + Σ g F, from how far the plays are behind.
        let behind =
            plays.plays.iter().zip(shares).fold(S::constant(0.0), |sum, (f, g)| sum + *g * (*f - *u));
        let h = *u + behind;
        let (own, bands) = out.split_at_mut(self.thresholds.len().min(out.len()));
        own.iter_mut().zip(&plays.plays).for_each(|(out, play)| *out = *play);
        for (index, band) in bands.iter_mut().enumerate() {
            let low = if index == 0 { f64::NEG_INFINITY } else { self.corner(index) };
            let high = if index + 1 == BANDS { f64::INFINITY } else { self.corner(index + 1) };
            let within = between(S::constant(low), h, S::constant(high));
            *band = within.shift(-self.corner(index.max(1)));
        }
    }
}
