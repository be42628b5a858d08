//! Dahl's model.
//!
//! Sources: P. R. Dahl, *A Solid Friction Model*, Aerospace Corporation TOR-0158(3107–18)-1, 1968; "Solid friction damping
//! of mechanical vibrations", *AIAA J.* 14 (1976) 1675–1682, doi:10.2514/3.61511.

use hysteron_rt::{Scalar, log_distance};

use super::HysteresisError;
use super::columns::{ColumnKernel, ColumnModel, parameter, positive, simulate_with_sensitivities};

/// Dahl's operator dz/du = σ (1 − s z/z_c)ⁱ, s = sign Δu, in the form with slope 1 from rest: z = σ ζ,
///
/// dζ/du = (1 − s ζ/u_c)ⁱ,  u_c = z_c/σ.
///
/// One column ζ \[V\]; its weight is σ \[µm/V\] (negative for a displacement that lags, as −α in Bouc–Wen). Shape: `reach` u_c
/// \[V\], at which ζ saturates, and `exponent` i ≥ 0. i = 1 is Bouc–Wen with n = 1, γ = 0, β = 1/u_c; i = 0 is the stop of
/// half-width u_c.
///
/// With x = 1 − s ζ/u_c a move by Δ is exact, xᵢ¹⁻ⁱ growing in proportion to |Δ|:
/// x ← x exp(−ln(1 + (i − 1) y)/(i − 1)), y = xⁱ⁻¹ |Δ|/u_c, which passes smoothly through i = 1. For i < 1 x reaches 0 and
/// stays there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dahl;

/// Present voltage and ζ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DahlState<S> {
    u: S,
    zeta: [S; 1],
}

impl Dahl {
    /// The model v = l\[u\] − z with dz/du = σ (1 − s z/z_c)ⁱ: `stiffness` σ \[µm/V\], `saturation` z_c \[µm\] of its sign.
    ///
    /// # Errors
    /// As [`ColumnModel::validate`].
    pub fn from_saturation(
        polynomial: Vec<f64>,
        stiffness: f64,
        saturation: f64,
        exponent: f64,
    ) -> Result<ColumnModel<Self>, HysteresisError> {
        ColumnModel::new(polynomial, Self, vec![saturation / stiffness, exponent], vec![-stiffness])
    }
}

impl ColumnKernel for Dahl {
    type State<S: Scalar<Real = f64>> = DahlState<S>;

    simulate_with_sensitivities!(2);

    fn shape_names(&self) -> &'static [&'static str] {
        &["reach", "exponent"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        positive("Dahl reach", parameter(shape, 0))?;
        let exponent: f64 = parameter(shape, 1);
        if exponent.is_finite() && exponent >= 0.0 {
            Ok(())
        } else {
            let must = "finite and not negative";
            Err(HysteresisError::ShapeParameter { name: "Dahl exponent", value: exponent, must })
        }
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> DahlState<S> {
        DahlState { u, zeta: [S::constant(0.0)] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut DahlState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let (reach, exponent) = (parameter(shape, 0), parameter(shape, 1));
        let by = (-state.u).shift(u);
        state.u = S::constant(u);
        let down = by.value() < 0.0;
        let turn = |x: S| if down { -x } else { x };
        let [zeta] = state.zeta;
        let x = (-(turn(zeta) / reach)).shift(1.0);
        let end = if x.value() > 0.0 {
            let over = exponent.shift(-1.0);
            let y = x.powf(over) * (turn(by) / reach);
            if over.value() * y.value() > -1.0 {
                x * (-log_distance(over, y)).exp()
            } else {
                S::constant(0.0)
            }
        } else {
            S::constant(0.0)
        };
        state.zeta = [turn(reach * (-end).shift(1.0))];
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &DahlState<S>, out: &mut [S]) {
        out.iter_mut().zip(state.zeta).for_each(|(out, zeta)| *out = zeta);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut DahlState<S>) -> &mut [S] {
        &mut state.zeta
    }
}
