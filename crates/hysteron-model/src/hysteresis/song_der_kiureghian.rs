//! Song's and Der Kiureghian's Bouc–Wen operator of six coefficients.
//!
//! Source: J. Song, A. Der Kiureghian, "Generalized Bouc–Wen model for highly asymmetric hysteresis", *J.
//! Eng. Mech.* 132 (2006) 610–618, doi:10.1061/(ASCE)0733-9399(2006)132:6(610).

use std::ops::Range;

use hysteron_rt::branch;

use super::columns::branch_kernel;
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, SKEWS, ShapeNumber,
};

/// Column ζ \[V\] of Song and Der Kiureghian's six coefficients that generalise the article's Eq. 1 for n =
/// 1, in the form with slope 1 from rest:
///
/// dζ/du = 1 − |ζ| (β₁ sgn(u̇ζ) + β₂ sgn(u u̇) + β₃ sgn(uζ) + β₄ sgn u̇ + β₅ sgn ζ + β₆ sgn u).
///
/// Its weight is −α. At u of one sign a move is one of Eq. 1 with β' = β₁ + s (β₃ sgn u + β₅) and γ' = s
/// (β₂ sgn u + β₄) + β₆ sgn u, s = sgn Δu; it is split where u passes 0, and so exact. β₁ = β' alone is
/// Eq. 1 with γ' = 0; on loops about 0, β₁ = β' + γ', β₂ = −γ', β₃ = γ' is Eq. 1. A drive that keeps
/// one sign determines four combinations of the six. Shape: β₁ … β₆ \[1/V\]; odd in u where β₄ = β₅ = β₆ = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SongDerKiureghian;

branch_kernel!(SongDerKiureghian, 6);

/// The family.
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

    fn shapes_together_with(&self, _: usize) -> Range<usize> {
        0..6
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        [5.0, 1.0, -0.8, 0.6, 0.5, -0.4].map(|x| x / span.stroke).into()
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::SongDerKiureghian::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = SongDerKiureghian;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> SongDerKiureghian {
        SongDerKiureghian
    }
}
