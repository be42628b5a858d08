//! Bouc–Wen operators without the symmetry of rising and falling.
//!
//! Sources: J. Song, A. Der Kiureghian, "Generalized Bouc–Wen model for highly asymmetric hysteresis", *J. Eng. Mech.* 132
//! (2006) 610–618, doi:10.1061/(ASCE)0733-9399(2006)132:6(610); W. Zhu, D.-H. Wang, "Non-symmetrical Bouc–Wen model for
//! piezoelectric ceramic actuators", *Sens. Actuators A* 181 (2012) 51–60, doi:10.1016/j.sna.2012.03.048.

use hysteron_rt::{BoucWen, Scalar, moments};

use super::HysteresisError;
use super::columns::{ColumnKernel, finite, parameter, simulate_with_sensitivities};

/// Column ζ \[V\] of Song and Der Kiureghian's six coefficients, in the form with slope 1 from rest:
///
/// dζ/du = 1 − |ζ|ⁿ (β₁ sgn(u̇ζ) + β₂ sgn(u u̇) + β₃ sgn(uζ) + β₄ sgn u̇ + β₅ sgn ζ + β₆ sgn u).
///
/// Its weight is −α. At u of one sign a move is one of Bouc–Wen with β' = β₁ + s (β₃ sgn u + β₅) and γ' = s (β₂ sgn u + β₄) +
/// β₆ sgn u, s = sgn Δu; it is split where u passes 0, and so exact. β₁ = β' alone is Bouc–Wen with γ' = 0; on loops about 0,
/// β₁ = β' + γ', β₂ = −γ', β₃ = γ' is Bouc–Wen. A drive that keeps one sign determines four combinations of the six.
/// Shape: β₁ … β₆ \[V⁻ⁿ\]; odd in u where β₄ = β₅ = β₆ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SongDerKiureghian {
    /// Smoothness of the transition, ≥ 1; closed forms for 1 and 2.
    pub n: f64,
}

/// Present voltage and ζ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AsymmetricState<S> {
    u: S,
    zeta: [S; 1],
}

impl<S: Scalar<Real = f64>> AsymmetricState<S> {
    fn virgin(u: S) -> Self {
        Self { u, zeta: [S::constant(0.0)] }
    }

    fn read(&self, out: &mut [S]) {
        out.iter_mut().zip(self.zeta).for_each(|(out, zeta)| *out = zeta);
    }
}

impl SongDerKiureghian {
    /// ζ after a move of u by `by` on one side of 0 (`side` = sgn u).
    fn leg<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        side: f64,
        zeta: S,
        by: S,
    ) -> Result<S, HysteresisError> {
        let s = if by.value() < 0.0 { -1.0 } else { 1.0 };
        let [b1, b2, b3, b4, b5, b6] = [0, 1, 2, 3, 4, 5].map(|index| parameter(shape, index));
        let beta = b1 + (b3.scale(side) + b5).scale(s);
        let gamma = (b2.scale(side) + b4).scale(s) + b6.scale(side);
        let distance = by.value();
        let end = BoucWen::advance_unit(beta, gamma, self.n, zeta, distance)
            .map_err(|cause| HysteresisError::RunsAway { index: 0, cause })?;
        // A start that moves shortens the way: dζ/du at its end.
        let sign = if end.value() < 0.0 { -1.0 } else { 1.0 };
        let slope = 1.0 - (s * beta.value() * sign + gamma.value()) * end.value().abs().powf(self.n);
        Ok(end + by.shift(-distance).scale(slope))
    }
}

impl ColumnKernel for SongDerKiureghian {
    type State<S: Scalar<Real = f64>> = AsymmetricState<S>;

    simulate_with_sensitivities!(6);

    fn shape_names(&self) -> &'static [&'static str] {
        &["beta_1", "beta_2", "beta_3", "beta_4", "beta_5", "beta_6"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        if !(self.n.is_finite() && self.n >= 1.0) {
            return Err(HysteresisError::Exponent { n: self.n });
        }
        shape.iter().try_for_each(|&beta| finite("coefficient of Song and Der Kiureghian", beta))
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> AsymmetricState<S> {
        AsymmetricState::virgin(u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut AsymmetricState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let [mut zeta] = state.zeta;
        let from = state.u.value();
        let mut by = (-state.u).shift(u);
        if from * u < 0.0 {
            zeta = self.leg(shape, from.signum(), zeta, -state.u)?;
            by = S::constant(u);
        }
        let side = if u != 0.0 { u } else { from };
        zeta = self.leg(shape, side.signum(), zeta, by)?;
        *state = AsymmetricState { u: S::constant(u), zeta: [zeta] };
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &AsymmetricState<S>, out: &mut [S]) {
        state.read(out);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut AsymmetricState<S>) -> &mut [S] {
        &mut state.zeta
    }
}

/// Column ζ \[V\] of the Bouc–Wen operator for n = 1 with the term of Zhu and Wang that makes its loop asymmetric,
///
/// dζ/du = 1 − (β s + γ sgn ζ) ζ + δ s u,  s = sgn Δu,
///
/// so that the branches saturate at levels that follow the voltage. Zhu and Wang write δ u sgn u̇ in the equation for ż, which
/// depends on the rate; here it is δ u |u̇|, which does not. Its weight is −α. Shape: `beta`, `gamma` \[1/V\], β ≥ |γ|, β > 0,
/// and `delta` \[1/V\]; δ = 0 is Bouc–Wen.
///
/// Where ζ and 1 + δ s u keep their signs, ζ(t) = ζ e^(−κt) + (s + δ u₀) t m₀(κt) + δ s t² m₁(κt) with the moments of
/// [`super::Duhem`], t = |Δu|, κ = β + s γ sgn ζ; a move is split where one of them changes sign.
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
    type State<S: Scalar<Real = f64>> = AsymmetricState<S>;

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

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> AsymmetricState<S> {
        AsymmetricState::virgin(u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut AsymmetricState<S>,
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
        *state = AsymmetricState { u: S::constant(u), zeta: [zeta] };
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &AsymmetricState<S>, out: &mut [S]) {
        state.read(out);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut AsymmetricState<S>) -> &mut [S] {
        &mut state.zeta
    }
}
