//! Dahl's model.
//!
//! Sources: P. R. Dahl, *A Solid Friction Model*, Aerospace Corporation TOR-0158(3107–18)-1, 1968; "Solid
//! friction damping of mechanical vibrations", *AIAA J.* 14 (1976) 1675–1682, doi:10.2514/3.61511.

use hysteron_rt::branch;

use super::HysteresisForm;
use super::columns::branch_kernel;
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, Search, ShapeNumber,
};

/// Dahl's operator dz/du = σ (1 − s z/z_c)ⁱ, s = sign Δu, in the form with slope 1 from rest: z = σ ζ,
///
/// dζ/du = (1 − s ζ/u_c)ⁱ,  u_c = z_c/σ.
///
/// One column ζ \[V\]; its weight is σ \[µm/V\] (negative for a displacement that lags). Shape: `reach` u_c
/// \[V\], at which ζ saturates, and `exponent` i ≥ 0. i = 1 is the article's Eq. 1 with n = 1, γ = 0, β =
/// 1/u_c; i = 0 is the stop of half-width u_c.
///
/// With x = 1 − s ζ/u_c a move by Δ is exact, xᵢ¹⁻ⁱ growing in proportion to |Δ|: x ← x exp(−ln(1 + (i − 1)
/// y)/(i − 1)), y = xⁱ⁻¹ |Δ|/u_c, which passes smoothly through i = 1. For i < 1 x reaches 0 and stays there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dahl;

branch_kernel!(Dahl, 2);

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl HysteresisForm {
    /// Dahl's model: friction that builds up over a displacement, the usual family for forces.
    pub fn dahl() -> Self {
        Self::of(&Entry, 0)
    }
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "dahl"
    }

    fn summary(&self) -> &'static str {
        "One relaxing state with an exponent"
    }

    fn equation(&self) -> &'static str {
        "weight_1 y, dy/du = (1 - s y/reach)^exponent"
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let reach = Search::Logarithmic(1.0 / span.sharpest(), 1.0 / span.bluntest());
        vec![
            ShapeNumber::new("reach", NumberUnit::INPUT, "voltage at which the state saturates", reach),
            ShapeNumber::new("exponent", NumberUnit::NONE, "sharpness of the knee", Search::Linear(0.2, 3.0)),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        span.bends().map(|bend| vec![1.0 / bend, 1.0]).into()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![0.17 * span.stroke, 1.4]
    }

    fn is_compared_unasked(&self) -> bool {
        true
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::Dahl::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = Dahl;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> Dahl {
        Dahl
    }
}
