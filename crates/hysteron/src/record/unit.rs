//! Units of channels.

use std::fmt;

/// Physical quantity a unit measures, as far as the library cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Time, base unit s.
    Time,
    /// Voltage, base unit V.
    Voltage,
    /// Length, base unit µm.
    Length,
    /// Angle, base unit µrad.
    Angle,
    /// Anything else; never converted.
    Other,
}

/// Unit of a channel: its symbol as in a column header's suffix (`V`, `mV`, `um`, `nm`, `urad`, `A_per_m`, …; empty: none given).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Unit(String);

impl Unit {
    /// Unit with this symbol; `µ` is written `u`.
    pub fn new(symbol: &str) -> Self {
        Unit(symbol.replace(['µ', 'μ'], "u"))
    }

    /// Symbol as used in column headers (`um`).
    pub fn symbol(&self) -> &str {
        &self.0
    }

    /// Quantity and the factor to its base unit (s, V, µm, µrad); `(Other, 1.0)` for an unknown unit.
    pub fn base(&self) -> (Quantity, f64) {
        match self.0.as_str() {
            "s" => (Quantity::Time, 1.0),
            "ms" => (Quantity::Time, 1e-3),
            "us" => (Quantity::Time, 1e-6),
            "V" => (Quantity::Voltage, 1.0),
            "mV" => (Quantity::Voltage, 1e-3),
            "kV" => (Quantity::Voltage, 1e3),
            "pm" => (Quantity::Length, 1e-6),
            "nm" => (Quantity::Length, 1e-3),
            "um" => (Quantity::Length, 1.0),
            "mm" => (Quantity::Length, 1e3),
            "cm" => (Quantity::Length, 1e4),
            "m" => (Quantity::Length, 1e6),
            "nrad" => (Quantity::Angle, 1e-3),
            "urad" => (Quantity::Angle, 1.0),
            "mrad" => (Quantity::Angle, 1e3),
            "rad" => (Quantity::Angle, 1e6),
            _ => (Quantity::Other, 1.0),
        }
    }
}

/// Displays the typographic form (`µm`, `A/m`), for labels.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = match self.0.as_str() {
            "us" | "um" | "uV" | "urad" => self.0.replacen('u', "µ", 1),
            other => other.replace("_per_", "/"),
        };
        f.write_str(&s)
    }
}
