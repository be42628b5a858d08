//! Song's and Der Kiureghian's Bouc–Wen operator of six coefficients.
//!
//! Source: J. Song, A. Der Kiureghian, "Generalized Bouc–Wen model for highly asymmetric hysteresis", *J.
//! Eng. Mech.* 132 (2006) 610–618, doi:10.1061/(ASCE)0733-9399(2006)132:6(610).

use hysteron_rt::{BoucWen, Scalar, branch};

use super::HysteresisError;
use super::columns::{ColumnKernel, RelaxingState, finite, parameter, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, SKEWS, ShapeNumber,
};

/// Column ζ \[V\] of Song and Der Kiureghian's six coefficients, in the form with slope 1 from rest:
///
/// dζ/du = 1 − |ζ|ⁿ (β₁ sgn(u̇ζ) + β₂ sgn(u u̇) + β₃ sgn(uζ) + β₄ sgn u̇ + β₅ sgn ζ + β₆ sgn u).
///
/// Its weight is −α. At u of one sign a move is one of Bouc–Wen with β' = β₁ + s (β₃ sgn u + β₅) and γ' = s
/// (β₂ sgn u + β₄) + β₆ sgn u, s = sgn Δu; it is split where u passes 0, and so exact. β₁ = β' alone is
/// Bouc–Wen with γ' = 0; on loops about 0, β₁ = β' + γ', β₂ = −γ', β₃ = γ' is Bouc–Wen. A drive that keeps
/// one sign determines four combinations of the six. Shape: β₁ … β₆ \[V⁻ⁿ\]; odd in u where β₄ = β₅ = β₆ = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SongDerKiureghian {
    /// Smoothness of the transition, ≥ 1; closed forms for 1 and 2.
    pub n: f64,
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
    type State<S: Scalar<Real = f64>> = RelaxingState<S>;

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
        let from = state.u.value();
        let mut by = (-state.u).shift(u);
        if from * u < 0.0 {
            zeta = self.leg(shape, from.signum(), zeta, -state.u)?;
            by = S::constant(u);
        }
        let side = if u != 0.0 { u } else { from };
        zeta = self.leg(shape, side.signum(), zeta, by)?;
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

/// The family, n = 1.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "song-der-kiureghian"
    }

    fn summary(&self) -> &'static str {
        "Bouc-Wen with six coefficients"
    }

    fn equation(&self) -> &'static str {
        "weight_1 y, dy/du = 1 - |y| (s (beta_1 sign y + beta_2 sign u + beta_4) + sign u (beta_3 sign y + \
         beta_6) + beta_5 sign y)"
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let of = |k: usize| {
            let search = if k == 1 { span.relaxation() } else { span.skew() };
            ShapeNumber::new(
                format!("beta_{k}"),
                NumberUnit::PER_INPUT,
                "shape of one phase of the loop",
                search,
            )
        };
        (1..=6).map(of).collect()
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let skewed = |beta: f64| SKEWS.map(|skew| vec![beta, 0.0, skew * beta, 0.0, 0.0, 0.0]);
        span.bends().into_iter().flat_map(skewed).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        [5.0, 1.0, -0.8, 0.6, 0.5, -0.4].map(|x| x / span.stroke).into()
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        let [beta_1, beta_2, beta_3, beta_4, beta_5, beta_6] =
            [0, 1, 2, 3, 4, 5].map(|index| parameter(shape, index));
        let law = branch::SongDerKiureghian { beta_1, beta_2, beta_3, beta_4, beta_5, beta_6 };
        RuntimeOperator::branch(law, weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = SongDerKiureghian;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> SongDerKiureghian {
        SongDerKiureghian { n: 1.0 }
    }
}
