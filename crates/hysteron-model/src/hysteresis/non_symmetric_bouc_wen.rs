//! Zhu's and Wang's non-symmetrical Bouc–Wen operator.
//!
//! Source: W. Zhu, D.-H. Wang, "Non-symmetrical Bouc–Wen model for piezoelectric ceramic actuators", *Sens.
//! Actuators A* 181 (2012) 51–60, doi:10.1016/j.sna.2012.03.048.

use std::ops::Range;

use hysteron_rt::branch;

use super::columns::branch_kernel;
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
/// moments of `hysteron_rt::branch`, t = |Δu|, κ = β + s γ sgn ζ; a move is split where one of them changes
/// sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NonSymmetricBoucWen;

branch_kernel!(NonSymmetricBoucWen, 3);

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

    /// β and γ.
    fn shapes_together_with(&self, index: usize) -> Range<usize> {
        if index < 2 { 0..2 } else { index..index + 1 }
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        [5.0, -2.0, 0.3].map(|x| x / span.stroke).into()
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::NonSymmetricBoucWen::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = NonSymmetricBoucWen;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> NonSymmetricBoucWen {
        NonSymmetricBoucWen
    }
}
