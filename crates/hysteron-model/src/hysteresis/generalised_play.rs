//! Generalised plays: the Prandtl–Ishlinskii model with saturating, unequal envelopes, and its inverse.
//!
//! Source: M. Al Janaideh, S. Rakheja, C.-Y. Su, "An analytical generalized Prandtl–Ishlinskii model inversion for
//! hysteresis compensation in micropositioning control", *IEEE/ASME Trans. Mechatronics* 16 (2011) 734–744,
//! doi:10.1109/TMECH.2010.2052366.

use hysteron_rt::Scalar;

use super::HysteresisError;
use super::columns::{ColumnKernel, ColumnModel, between, parameter, positive, simulate_with_sensitivities};

/// Columns Fⱼ ← max(γ_r(u) − rⱼ, min(γ_l(u) + rⱼ, Fⱼ)) with the envelopes
///
/// γ_r(u) = tanh(a_r (u − c_r)) where u rises,  γ_l(u) = tanh(a_l (u − c_l)) where it falls.
///
/// Columns and thresholds are in units of the envelopes, in which these end at ±1. Shape: `rise_right` a_r \[1/V\],
/// `centre_right` c_r \[V\], `rise_left` a_l, `centre_left` c_l. A play has a place to stand wherever γ_r − γ_l ≤ 2rⱼ; a
/// voltage at which the narrowest has none is an error. A virgin play stands at ½ (γ_l + γ_r).
///
/// Equal envelopes make it the Prandtl–Ishlinskii model of γ(u).
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedPlays {
    /// Half-widths, from 0 on (where the envelopes allow it), increasing.
    pub thresholds: Vec<f64>,
}

/// Present voltage and plays.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralisedPlayStates<S> {
    u: f64,
    plays: Vec<S>,
}

/// tanh(a (u − c)).
fn envelope<S: Scalar<Real = f64>>(rise: S, centre: S, u: S) -> S {
    (rise * (u - centre)).tanh()
}

/// (γ_r, γ_l) at u.
fn envelopes<S: Scalar<Real = f64>>(shape: &[S], u: S) -> (S, S) {
    let [rise_right, centre_right, rise_left, centre_left] = [0, 1, 2, 3].map(|i| parameter(shape, i));
    (envelope(rise_right, centre_right, u), envelope(rise_left, centre_left, u))
}

impl ColumnKernel for GeneralisedPlays {
    type State<S: Scalar<Real = f64>> = GeneralisedPlayStates<S>;

    simulate_with_sensitivities!(4);

    fn shape_names(&self) -> &'static [&'static str] {
        &["rise_right", "centre_right", "rise_left", "centre_left"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let mut above = -1.0;
        for (index, &value) in self.thresholds.iter().enumerate() {
            let least: f64 = if index == 0 { 0.0 } else { above };
            if !(value.is_finite() && value >= least && value > above) {
                return Err(HysteresisError::Threshold { index, value, above: least });
            }
            above = value;
        }
        positive("rise of the right envelope", parameter(shape, 0))?;
        positive("rise of the left envelope", parameter(shape, 2))?;
        for (name, index) in [("centre of the right envelope", 1), ("centre of the left envelope", 3)] {
            let value: f64 = parameter(shape, index);
            if !value.is_finite() {
                return Err(HysteresisError::ShapeParameter { name, value, must: "finite" });
            }
        }
        Ok(())
    }

    fn columns(&self) -> usize {
        self.thresholds.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> GeneralisedPlayStates<S> {
        let (right, left) = envelopes(shape, u);
        let middle = (right + left).scale(0.5);
        GeneralisedPlayStates { u: u.value(), plays: vec![middle; self.thresholds.len()] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut GeneralisedPlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let (right, left) = envelopes(shape, S::constant(u));
        let narrowest = self.thresholds.first().copied().unwrap_or(0.0);
        if right.value() - left.value() > 2.0 * narrowest + 4.0 * f64::EPSILON {
            return Err(HysteresisError::Envelopes { u, by: right.value() - left.value(), narrowest });
        }
        state.u = u;
        for (play, &r) in state.plays.iter_mut().zip(&self.thresholds) {
            *play = between(right.shift(-r), *play, left.shift(r));
        }
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &GeneralisedPlayStates<S>, out: &mut [S]) {
        out.iter_mut().zip(&state.plays).for_each(|(out, play)| *out = *play);
    }
}

impl ColumnModel<GeneralisedPlays> {
    /// The voltage \[V\] to which one monotone move from `state` gives the output `v` \[µm\], in closed form: on each piece the
    /// plays that move give Σ wⱼ (γ ∓ rⱼ), so that γ follows by one division and u by the inverse of the envelope. Where v
    /// is the present output the voltage stays.
    ///
    /// The state must be one that a simulation from a virgin start left behind.
    ///
    /// # Errors
    /// As [`Self::validate`]; [`HysteresisError::NotLinear`] with a polynomial that is not zero;
    /// [`HysteresisError::PartialSlope`] where a weight is negative or the first not positive;
    /// [`HysteresisError::PlayStates`]; [`HysteresisError::OutOfReach`] for an output beyond saturation (sample 0);
    /// [`HysteresisError::Drive`] where v is not finite.
    pub fn inverse_step(&self, state: &GeneralisedPlayStates<f64>, v: f64) -> Result<f64, HysteresisError> {
        self.validate()?;
        if let Some(index) = self.polynomial.iter().rposition(|&c| c != 0.0) {
            return Err(HysteresisError::NotLinear { degree: index + 1 });
        }
        for (&slope, plays) in self.weights.iter().zip(1..) {
            if slope < 0.0 || (plays == 1 && slope == 0.0) {
                return Err(HysteresisError::PartialSlope { plays, slope });
            }
        }
        let found = state.plays.len();
        if found != self.weights.len() {
            return Err(HysteresisError::PlayStates { expected: self.weights.len(), found });
        }
        if !v.is_finite() {
            return Err(HysteresisError::Drive { index: 0 });
        }
        let present: f64 = self.weights.iter().zip(&state.plays).map(|(w, play)| w * play).sum();
        if v == present {
            return Ok(state.u);
        }
        // Upwards: plays take hold at γ = Fⱼ + rⱼ, the narrowest first. Downwards the same with every sign turned.
        let (sign, side) = if v > present { (1.0, 0) } else { (-1.0, 2) };
        let (mut slope, mut rest) = (0.0, sign * (v - present));
        let plays = || self.kernel.thresholds.iter().zip(&self.weights).zip(&state.plays);
        for ((r, weight), play) in plays() {
            let from = sign * play + r;
            if slope > 0.0 && rest <= slope * from {
                break;
            }
            slope += weight;
            rest += weight * from;
        }
        let gamma = sign * rest / slope;
        let [rise, centre] = [side, side + 1].map(|i| parameter::<f64>(&self.shape, i));
        if gamma.abs() < 1.0 {
            Ok(centre + gamma.atanh() / rise)
        } else {
            let reach = |sign: f64| plays().map(|((r, w), play)| w * sign * (sign * play).max(1.0 - r)).sum();
            Err(HysteresisError::OutOfReach { index: 0, v, from: reach(-1.0), to: reach(1.0) })
        }
    }
}
