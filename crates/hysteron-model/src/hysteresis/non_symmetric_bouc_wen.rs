//! Zhu's and Wang's non-symmetrical Bouc–Wen operator.
//!
//! Source: W. Zhu, D.-H. Wang, "Non-symmetrical Bouc–Wen model for piezoelectric ceramic actuators", *Sens.
//! Actuators A* 181 (2012) 51–60, doi:10.1016/j.sna.2012.03.048.

use hysteron_rt::{Scalar, branch, moments};

use super::HysteresisError;
use super::columns::{ColumnKernel, RelaxingState, finite, parameter, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, SKEWS, ShapeNumber,
};

/// Column ζ \[V\] of the Bouc–Wen operator for n = 1 with the term of Zhu and Wang that makes its loop
/// asymmetric,
///
/// dζ/du = 1 − (β s + γ sgn ζ) ζ + δ s u,  s = sgn Δu,
///
/// so that the branches saturate at levels that follow the voltage. Zhu and Wang write δ u sgn u̇ in the
/// equation for ż, which depends on the rate; here it is δ u |u̇|, which does not. Its weight is −α. Shape:
/// `beta`, `gamma` \[1/V\], β ≥ |γ|, β > 0, and `delta` \[1/V\]; δ = 0 is Bouc–Wen.
///
/// Where ζ and 1 + δ s u keep their signs, ζ(t) = ζ e^(−κt) + (s + δ u₀) t m₀(κt) + δ s t² m₁(κt) with the
/// moments of [`super::Duhem`], t = |Δu|, κ = β + s γ sgn ζ; a move is split where one of them changes sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NonSymmetricBoucWen;

impl NonSymmetricBoucWen {
    /// ζ after a way t at a rate κ, from u in the direction s.
    fn along<S: Scalar<Real = f64>>(delta: S, kappa: S, s: f64, u: S, zeta: S, t: S) -> S {
        let x = kappa * t;
        let [m_0, m_1, ..] = moments(x, 2);
        let drive = (delta * u).shift(s);
        zeta * (-x).exp() + drive * t * m_0 + delta.scale(s) * t * t * m_1
    }

    /// ζ after a move on which 1 + δ s u keeps its sign.
    fn leg<S: Scalar<Real = f64>>(shape: &[S], s: f64, from: S, to: S, zeta: S) -> S {
        let [beta, gamma, delta] = [0, 1, 2].map(|index| parameter(shape, index));
        let way = |from: S| (to - from).scale(s);
        let middle = 0.5 * (from.value() + to.value());
        let drive = if s + delta.value() * middle < 0.0 { -1.0 } else { 1.0 };
        let sign = if zeta.value() == 0.0 { drive } else { zeta.value().signum() };
        let rate = |sign: f64| beta + gamma.scale(s * sign);
        let end = Self::along(delta, rate(sign), s, from, zeta, way(from));
        if end.value() * sign >= 0.0 {
            return end;
        }
        // ζ passes 0 once, towards the drive.
        let values = (delta.value(), rate(sign).value(), from.value(), zeta.value());
        let at = |t: f64| Self::along(values.0, values.1, s, values.2, values.3, t);
        let (mut low, mut high) = (0.0, way(from).value());
        for _ in 0..200 {
            let t = 0.5 * (low + high);
            if t <= low || t >= high {
                break;
            }
            if at(t) * sign > 0.0 {
                low = t;
            } else {
                high = t;
            }
        }
        // One Newton step for the derivatives of the place: dζ/dt = s + δu where ζ = 0.
        let t = 0.5 * (low + high);
        let slope = s + values.0 * (values.2 + s * t);
        let left = Self::along(delta, rate(sign), s, from, zeta, S::constant(t));
        let zero = from + (-(left.scale(1.0 / slope))).shift(t).scale(s);
        Self::along(delta, rate(-sign), s, zero, S::constant(0.0), way(zero))
    }
}

impl ColumnKernel for NonSymmetricBoucWen {
    type State<S: Scalar<Real = f64>> = RelaxingState<S>;

    simulate_with_sensitivities!(3);

    fn shape_names(&self) -> &'static [&'static str] {
        &["beta", "gamma", "delta"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let [beta, gamma, delta] = [0, 1, 2].map(|index| parameter::<f64>(shape, index));
        finite("non-symmetrical Bouc–Wen γ", gamma)?;
        finite("non-symmetrical Bouc–Wen δ", delta)?;
        if beta.is_finite() && beta > 0.0 && beta >= gamma.abs() {
            Ok(())
        } else {
            let (name, must) = ("non-symmetrical Bouc–Wen β", "finite, positive and at least |γ|");
            Err(HysteresisError::ShapeParameter { name, value: beta, must })
        }
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> RelaxingState<S> {
        RelaxingState::virgin(u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut RelaxingState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let [mut zeta] = state.zeta;
        let mut from = state.u;
        let s = if u < from.value() { -1.0 } else { 1.0 };
        let delta = parameter(shape, 2);
        if delta.value() != 0.0 {
            // Where 1 + δ s u changes sign.
            let turn = S::constant(-s) / delta;
            if (turn.value() - from.value()) * s > 0.0 && (u - turn.value()) * s > 0.0 {
                zeta = Self::leg(shape, s, from, turn, zeta);
                from = turn;
            }
        }
        zeta = Self::leg(shape, s, from, S::constant(u), zeta);
        *state = RelaxingState { u: S::constant(u), zeta: [zeta] };
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &RelaxingState<S>, out: &mut [S]) {
        state.read(out);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut RelaxingState<S>) -> &mut [S] {
        &mut state.zeta
    }
}

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "non-symmetric-bouc-wen"
    }

    fn summary(&self) -> &'static str {
        "Bouc-Wen with a term that makes its loop asymmetric"
    }

    fn equation(&self) -> &'static str {
        "weight_1 y, dy/du = 1 - (beta s + gamma sign y) y + delta s u"
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let unit = NumberUnit::PER_INPUT;
        vec![
            ShapeNumber::new("beta", unit, "sharpness of the loop", span.relaxation()),
            ShapeNumber::new("gamma", unit, "skew of the loop", span.skew()),
            ShapeNumber::new("delta", unit, "asymmetry that grows with the input", span.skew()),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        span.bends().into_iter().flat_map(|beta| SKEWS.map(|skew| vec![beta, skew * beta, 0.0])).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        [5.0, -2.0, 0.3].map(|x| x / span.stroke).into()
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        let [beta, gamma, delta] = [0, 1, 2].map(|index| parameter(shape, index));
        RuntimeOperator::branch(branch::NonSymmetricBoucWen { beta, gamma, delta }, weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = NonSymmetricBoucWen;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> NonSymmetricBoucWen {
        NonSymmetricBoucWen
    }
}
