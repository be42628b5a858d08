//! The numbers that the article prints, each with its place. Nothing here was computed by this program.
//!
//! *Rate-Dependent Modeling of Piezoelectric Actuators for Nano Manipulation Based on Fractional Hammerstein
//! Model.*

use serde::{Deserialize, Serialize};

/// Table 1 (§4.2): best fitness after 150 generations, by algorithm, in the order of the table.
pub const TABLE_1: [(&str, f64); 3] = [("DE", 0.0247), ("ABC", 0.0144), ("DE-ABC", 0.0120)];

/// Table 2 (§4.3): parameters of the improved Bouc–Wen block, Eq. 1, and its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table2 {
    /// x, factor of u² \[µm/V²\].
    pub x: f64,
    /// y, factor of u \[µm/V\].
    pub y: f64,
    /// α \[µm/V\].
    pub alpha: f64,
    /// β \[1/V for n = 1\].
    pub beta: f64,
    /// γ, as β.
    pub gamma: f64,
    /// Relative error.
    pub re: f64,
    /// Root mean square error; no unit is printed.
    pub rmse: f64,
}

/// Table 2. The exponent n is not printed.
pub const TABLE_2: Table2 =
    Table2 { x: 0.0031, y: 2.0000, alpha: -1.2039, beta: 0.1111, gamma: 0.0024, re: 0.0208, rmse: 0.0120 };

/// Eq. 13 (§4.3): G(s) = b / (s^α₂ + c₁ s^α₁ + c₀).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransferFunction13 {
    /// b.
    pub b: f64,
    /// α₂.
    pub alpha2: f64,
    /// c₁.
    pub c1: f64,
    /// α₁.
    pub alpha1: f64,
    /// c₀.
    pub c0: f64,
}

/// Eq. 13.
pub const EQ_13: TransferFunction13 =
    TransferFunction13 { b: 5.2589e6, alpha2: 2.0384, c1: 3081.0, alpha1: 1.0523, c0: 5.4955e6 };

/// Errors of one model at one frequency, Table 3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Max error \[µm\].
    pub max_um: f64,
    /// RMSE; no unit is printed, µm presumed.
    pub rmse_um: f64,
}

/// A row block of Table 3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table3Row {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Classic Bouc–Wen.
    pub classic: Errors,
    /// Hammerstein, integer-order dynamics.
    pub integer: Errors,
    /// Hammerstein, fractional dynamics.
    pub fractional: Errors,
}

const fn errors(max_um: f64, rmse_um: f64) -> Errors {
    Errors { max_um, rmse_um }
}

/// Table 3 (§4.4). ARX has no row there.
pub const TABLE_3: [Table3Row; 4] = [
    Table3Row {
        frequency_hz: 10.0,
        classic: errors(0.5000, 0.1127),
        integer: errors(0.1144, 0.0413),
        fractional: errors(0.0753, 0.0264),
    },
    Table3Row {
        frequency_hz: 20.0,
        classic: errors(0.5161, 0.1095),
        integer: errors(0.2572, 0.0627),
        fractional: errors(0.0915, 0.0244),
    },
    Table3Row {
        frequency_hz: 50.0,
        classic: errors(0.6292, 0.1411),
        integer: errors(0.5266, 0.1086),
        fractional: errors(0.0788, 0.0228),
    },
    Table3Row {
        frequency_hz: 100.0,
        classic: errors(1.2012, 0.2698),
        integer: errors(0.5039, 0.1101),
        fractional: errors(0.0727, 0.0221),
    },
];

/// Max error of the fractional model at 100 Hz in the running text of §4.4 \[µm\]; the table has 0.0727.
pub const TEXT_MAX_100HZ_UM: f64 = 0.0728;

/// Abstract: "the maximum error is 0.0915 µm and the maximum mean square error is 0.0244".
pub const ABSTRACT: Errors = errors(0.0915, 0.0244);

/// The search box of §4.2 as printed, MinX and MaxX: every lower bound lies above its upper bound.
pub const SEARCH_BOX: ([f64; 5], [f64; 5]) = ([2.0, 0.0, 1.0, 1.0, 0.0], [1.0, -2.0, 0.0, 0.0, -1.0]);

/// Bias of the two-step identification on noise-free data of Table 2 and Eq. 13, found by an earlier,
/// independent prototype of this project (not the article's numbers).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrototypeBias {
    /// x, relative \[%\].
    pub x_percent: f64,
    /// b, relative \[%\].
    pub b_percent: f64,
    /// α₂, absolute.
    pub alpha2: f64,
}

/// The prototype's figures.
pub const PROTOTYPE_BIAS: PrototypeBias = PrototypeBias { x_percent: 39.0, b_percent: -39.0, alpha2: -0.08 };
