//! The Maxwell-slip model: elastic-plastic elements (stops) in parallel.
//!
//! Sources: W. D. Iwan, *J. Appl. Mech.* 33 (1966) 893–900, doi:10.1115/1.3625199; M. Goldfarb, N. Celanovic, *IEEE Control
//! Systems* 17:3 (1997) 69–79, doi:10.1109/37.588158; the duality of plays and stops: M. Brokate, J. Sprekels,
//! *Hysteresis and Phase Transitions*, Springer 1996, doi:10.1007/978-1-4612-4048-8.

use hysteron_rt::Scalar;

use super::columns::{ColumnKernel, ColumnModel, between, parameter, positive, simulate_with_sensitivities};
use super::plays::check_thresholds;
use super::{HysteresisError, PrandtlIshlinskii};

/// Columns Eⱼ ← max(−rⱼ, min(rⱼ, Eⱼ + Δu)) \[V\], rⱼ = scale · `thresholds`\[j\]: the strain of an elastic element that slips
/// at rⱼ.
///
/// Eⱼ = u − Fⱼ with the play Fⱼ of the same half-width, so that Maxwell slip and Prandtl–Ishlinskii are one model in two
/// coordinates: v = l\[u\] + Σ kⱼ Eⱼ has the weights −kⱼ and the linear coefficient l₁ + Σ kⱼ there
/// ([`PrandtlIshlinskii::from`] and [`ColumnModel::from`]). Kept as plays, so that nothing adds up from move to move.
///
/// Weights are the stiffnesses kⱼ \[µm/V\] (negative for a displacement that lags). Shape: `scale`, 1 for the thresholds
/// as they are. A virgin element is without strain.
#[derive(Clone, Debug, PartialEq)]
pub struct MaxwellSlip {
    /// Strains rⱼ at which the elements slip \[V\], positive and increasing.
    pub thresholds: Vec<f64>,
}

/// Present voltage, and where the elements touch their ground.
#[derive(Clone, Debug, PartialEq)]
pub struct MaxwellSlipState<S> {
    u: S,
    plays: Vec<S>,
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
        MaxwellSlipState { u, plays: vec![u; self.thresholds.len()] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut MaxwellSlipState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let scale = parameter(shape, 0);
        state.u = S::constant(u);
        for (play, &threshold) in state.plays.iter_mut().zip(&self.thresholds) {
            let r = scale.scale(threshold);
            *play = between((-r).shift(u), *play, r.shift(u));
        }
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &MaxwellSlipState<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.plays).for_each(|(out, play)| *out = state.u - *play);
    }
}

impl From<&PrandtlIshlinskii> for ColumnModel<MaxwellSlip> {
    /// The same operator in stops: stiffnesses −wᵢ, linear coefficient p₁ + Σ wᵢ, scale 1.
    fn from(plays: &PrandtlIshlinskii) -> Self {
        Self {
            polynomial: steeper(&plays.polynomial, plays.weights.iter().sum()),
            kernel: MaxwellSlip { thresholds: plays.thresholds.clone() },
            shape: vec![1.0],
            weights: plays.weights.iter().map(|w| -w).collect(),
        }
    }
}

impl From<&ColumnModel<MaxwellSlip>> for PrandtlIshlinskii {
    /// The same operator in plays: weights −kⱼ, linear coefficient l₁ + Σ kⱼ.
    fn from(stops: &ColumnModel<MaxwellSlip>) -> Self {
        let scale = stops.shape.first().copied().unwrap_or(1.0);
        Self {
            polynomial: steeper(&stops.polynomial, stops.weights.iter().sum()),
            thresholds: stops.kernel.thresholds.iter().map(|r| scale * r).collect(),
            weights: stops.weights.iter().map(|k| -k).collect(),
        }
    }
}

/// The polynomial with its linear coefficient raised by `by`.
fn steeper(polynomial: &[f64], by: f64) -> Vec<f64> {
    let mut polynomial = polynomial.to_vec();
    if let Some(linear) = polynomial.first_mut() {
        *linear += by;
    }
    polynomial
}
