//! Units of channels.

use std::fmt;

/// Physical quantity of a unit, as far as the library distinguishes it.
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

/// Unit of a channel: its symbol as in a column header's suffix (`V`, `mV`, `um`, `nm`, `urad`, `A_per_m`, …;
/// empty: none given).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Unit(String);

impl Unit {
    /// Unit with this symbol; `µ` is written `u`, a micron `um`.
    pub fn new(symbol: &str) -> Self {
        Unit(match symbol {
            "micron" | "microns" => "um".to_string(),
            _ => symbol.replace(['µ', 'μ'], "u"),
        })
    }

    /// Symbol as used in column headers (`um`).
    pub fn symbol(&self) -> &str {
        &self.0
    }

    /// The unit after a number, with a space before it (` µm`); nothing where there is none.
    pub fn spaced(&self) -> String {
        if self.0.is_empty() { String::new() } else { format!(" {self}") }
    }

    /// True if a header's suffix may be read as this unit: one that [`Unit::base`] converts, another usual
    /// one, never converted (`A`, `mA`, `T`, `N`, `Hz`, `kg`, `inch`, …), or a quotient of two (`A_per_m`).
    pub fn is_known(&self) -> bool {
        match self.0.split_once("_per_") {
            Some((over, under)) => is_simple(over) && is_simple(under),
            None => is_simple(&self.0),
        }
    }

    /// True for a unit of force or of torque.
    pub fn is_force(&self) -> bool {
        ["N", "mN", "uN", "kN", "lbf", "kgf", "Nm", "mNm"].contains(&self.symbol())
    }

    /// Base unit of the quantity (`s`, `V`, `um`, `urad`); the unit itself where it is not converted.
    pub fn base_unit(&self) -> Unit {
        match self.base().0 {
            Quantity::Time => Unit::new("s"),
            Quantity::Voltage => Unit::new("V"),
            Quantity::Length => Unit::new("um"),
            Quantity::Angle => Unit::new("urad"),
            Quantity::Other => self.clone(),
        }
    }

    /// Quantity and the factor to its base unit (s, V, µm, µrad); `(Other, 1.0)` for an unknown unit.
    pub fn base(&self) -> (Quantity, f64) {
        match self.0.as_str() {
            "s" => (Quantity::Time, 1.0),
            "ms" => (Quantity::Time, 1e-3),
            "us" => (Quantity::Time, 1e-6),
            "ns" => (Quantity::Time, 1e-9),
            "min" => (Quantity::Time, 60.0),
            "uV" => (Quantity::Voltage, 1e-6),
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
            "arcsec" => (Quantity::Angle, std::f64::consts::PI / 0.648),
            "deg" => (Quantity::Angle, std::f64::consts::PI / 180.0 * 1e6),
            _ => (Quantity::Other, 1.0),
        }
    }
}

fn is_simple(symbol: &str) -> bool {
    const OTHERS: [&str; 53] = [
        "A", "mA", "uA", "nA", "T", "mT", "uT", "N", "mN", "uN", "kN", "Hz", "kHz", "MHz", "W", "mW", "J",
        "C", "nC", "uC", "Pa", "kPa", "MPa", "bar", "K", "degC", "g", "kg", "mg", "ug", "inch", "inches",
        "mil", "mils", "thou", "ft", "yd", "angstrom", "Å", "km", "dm", "lb", "lbf", "kgf", "Nm", "mNm",
        "psi", "mbar", "GPa", "degF", "°C", "Ohm", "rpm",
    ];
    Unit(symbol.to_string()).base().0 != Quantity::Other || OTHERS.contains(&symbol)
}

/// Displays the typographic form (`µm`, `A/m`), for labels.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = match self.0.as_str() {
            "deg" => "°".to_string(),
            "degC" => "°C".to_string(),
            other => other
                .split("_per_")
                .map(|part| match part.strip_prefix('u') {
                    Some(rest) if !rest.is_empty() && is_simple(part) => format!("µ{rest}"),
                    _ => part.to_string(),
                })
                .collect::<Vec<_>>()
                .join("/"),
        };
        f.write_str(&s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_display_as_printed() {
        for (symbol, shown) in [
            ("um", "µm"),
            ("V", "V"),
            ("A_per_m", "A/m"),
            ("um_per_V", "µm/V"),
            ("urad", "µrad"),
            ("", ""),
            ("u", "u"),
            ("counts", "counts"),
        ] {
            assert_eq!(Unit::new(symbol).to_string(), shown);
        }
    }

    #[test]
    fn an_arc_second_is_4_848_microradians() {
        let (quantity, factor) = Unit::new("arcsec").base();
        assert_eq!(quantity, Quantity::Angle);
        assert!((factor - 4.848_136_811_095_36).abs() < 1e-12, "{factor}");
        let (_, degree) = Unit::new("deg").base();
        assert!((degree - 3600.0 * factor).abs() < 1e-8);
    }
}
