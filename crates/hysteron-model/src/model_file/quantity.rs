//! Numbers with a unit.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number of the model: value, unit and standard error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object {\"value\": …, \"unit\": …, \"std_error\": …|null}")]
pub struct Quantity {
    /// The value, finite.
    pub value: f64,
    /// Its unit; `1` for a pure number.
    pub unit: String,
    /// Standard error in the same unit, ≥ 0; null where unknown, or where the value was given, not fitted.
    #[serde(default)]
    pub std_error: Option<f64>,
}

impl Quantity {
    /// A value without standard error.
    pub fn new(value: f64, unit: impl Into<String>) -> Self {
        Quantity { value, unit: unit.into(), std_error: None }
    }
}

/// A closed interval.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object {\"low\": …, \"high\": …, \"unit\": …}")]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end, ≥ `low`.
    pub high: f64,
    /// Unit of both.
    pub unit: String,
}

/// `um/V^2` as µm/V².
pub fn typographic(unit: &str) -> String {
    const RAISED: [&str; 10] = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    let mut text = unit.replace("um", "µm").replace('*', " ");
    for (digit, raised) in RAISED.iter().enumerate() {
        text = text.replace(&format!("^{digit}"), raised);
    }
    text
}
