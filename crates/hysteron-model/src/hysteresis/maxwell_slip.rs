//! The Maxwell-slip model: elastic-plastic elements (stops) in parallel.
//!
//! Sources: W. D. Iwan, *J. Appl. Mech.* 33 (1966) 893–900, doi:10.1115/1.3625199; M. Goldfarb, N. Celanovic,
//! *IEEE Control Systems* 17:3 (1997) 69–79, doi:10.1109/37.588158; the duality of plays and stops: M.
//! Brokate, J. Sprekels, *Hysteresis and Phase Transitions*, Springer 1996, doi:10.1007/978-1-4612-4048-8.

use hysteron_rt::Scalar;

use super::columns::{ColumnKernel, parameter, positive, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit, RuntimeOperator, Search,
    ShapeNumber,
};
use super::plays::{PlayStates, check_thresholds, evenly_below, scaled};
use super::{HysteresisError, PlaySum};

/// Columns Eⱼ ← max(−rⱼ, min(rⱼ, Eⱼ + Δu)) \[V\], rⱼ = scale · `thresholds`\[j\]: the strain of an elastic
/// element that slips at rⱼ.
///
/// Eⱼ = u − Fⱼ with the play Fⱼ of the same half-width, so that Maxwell slip and a sum of plays are one
/// model in two coordinates: v = l\[u\] + Σ kⱼ Eⱼ has the weights −kⱼ and the linear coefficient l₁ + Σ kⱼ
/// there. Stored as plays, so that rounding does not accumulate from move to move.
///
/// Weights are the stiffnesses kⱼ \[µm/V\] (negative for a displacement that lags). Shape: `scale`, 1 for
/// unscaled thresholds. A virgin element is without strain.
#[derive(Clone, Debug, PartialEq)]
pub struct MaxwellSlip {
    /// Strains rⱼ at which the elements slip \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// Present voltage, and positions of the elements' sliding contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct MaxwellSlipState<S> {
    u: S,
    plays: PlayStates<S>,
}

impl ColumnKernel for MaxwellSlip {
    type State<S: Scalar<Real = f64>> = MaxwellSlipState<S>;

    simulate_with_sensitivities!(1);

    fn shape_names(&self) -> &'static [&'static str] {
        &["scale"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        check_thresholds(&self.thresholds)?;
        positive("scale of the thresholds", parameter(shape, 0))
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> MaxwellSlipState<S> {
        MaxwellSlipState { u, plays: PlayStates::at(self.thresholds.len(), u) }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut MaxwellSlipState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        state.u = S::constant(u);
        state.plays.advance(scaled(&self.thresholds, parameter(shape, 0)), u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &MaxwellSlipState<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.plays.plays).for_each(|(out, play)| *out = state.u - *play);
    }
}

/// The family: elements at `scale` · j/(elements + 1).
#[derive(Debug)]
pub(super) struct Entry;

/// A stop is the voltage minus its play: the voltage goes to the polynomial.
fn give_way(polynomial: &mut [f64], weights: &[f64]) {
    if let Some(linear) = polynomial.first_mut() {
        *linear += weights.iter().sum::<f64>();
    }
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "maxwell-slip"
    }

    fn summary(&self) -> &'static str {
        "12 elastic elements that slip: plays in other coordinates"
    }

    fn equation(&self) -> &'static str {
        "sum of weight_j (u - F_j), F_j the play of half-width scale j/(number + 1) (stops)"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let search = Search::Held(0.5 * span.stroke);
        vec![ShapeNumber::new("scale", NumberUnit::INPUT, "half-width beyond the widest element", search)]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        vec![vec![0.5 * span.stroke]]
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![0.31 * span.stroke]
    }

    fn as_plays(
        &self,
        elements: usize,
        polynomial: &[f64],
        shape: &[f64],
        weights: &[f64],
    ) -> Option<PlaySum> {
        let mut polynomial = polynomial.to_vec();
        give_way(&mut polynomial, weights);
        let thresholds = evenly_below(parameter(shape, 0), elements);
        Some(PlaySum { polynomial, thresholds, weights: weights.iter().map(|k| -k).collect() })
    }

    fn runtime(
        &self,
        elements: usize,
        polynomial: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        give_way(polynomial, weights);
        let thresholds = evenly_below(parameter(shape, 0), elements);
        RuntimeOperator::Plays { thresholds, weights: weights.iter().map(|k| -k).collect() }
    }
}

impl ColumnFamily for Entry {
    type Kernel = MaxwellSlip;

    fn kernel(&self, elements: usize, _: &[f64], _: f64) -> MaxwellSlip {
        MaxwellSlip { thresholds: evenly_below(1.0, elements) }
    }
}
