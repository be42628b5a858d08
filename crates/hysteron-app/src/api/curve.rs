//! A curve reduced to what a drawing can show.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Query of a curve of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CurveQuery {
    /// Column across, by name; `t`: time.
    #[serde(default = "time")]
    pub x: String,
    /// Column upwards, by name; left out: the output.
    pub y: Option<String>,
    /// First time shown \[s\] (sample number where there is no time).
    pub from: Option<f64>,
    /// Last time shown \[s\].
    pub to: Option<f64>,
    /// Width of the drawing in pixels.
    #[serde(default = "pixels")]
    pub pixels: usize,
}

pub(super) fn time() -> String {
    "t".to_owned()
}

pub(super) fn pixels() -> usize {
    1000
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Axis {
    /// Name of the quantity, e.g. of the column.
    pub name: String,
    /// Symbol of its unit, as printed; empty: none.
    pub unit: String,
    /// Least value of the whole record.
    pub low: f64,
    /// Greatest value of the whole record.
    pub high: f64,
}

/// Points of a curve. Over time it holds the first, least, greatest and last point of each pixel column; a
/// loop is drawn pass by pass, a pass that lies on those drawn before left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Curve {
    /// Across.
    pub x: Vec<f64>,
    /// Upwards, as many.
    pub y: Vec<f64>,
    /// Indices of points that no line joins to the point before.
    pub breaks: Vec<usize>,
    /// What `x` is.
    pub across: Axis,
    /// What `y` is.
    pub up: Axis,
    /// Samples behind the points.
    pub samples: usize,
    /// What is shown, in words: `all 8060 samples`, `periods 1, 2 and 36 to 40 of 40`.
    pub shown: String,
}
