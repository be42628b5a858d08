//! Channels and the column headers that carry their names and units.

use crate::advice::ColumnRole;

use super::{Channel, Record, RecordError, Unit};

impl Channel {
    /// Channel from its parts.
    pub fn new(name: &str, unit: &str, samples: Vec<f64>) -> Self {
        Channel { name: name.to_string(), unit: Unit::new(unit), samples }
    }

    /// Column header that [`split_header`] splits again: `u_V`; `x [counts]` where the unit is not a known
    /// one; `y` or `x_s []` where there is none.
    pub fn header(&self) -> String {
        header_of(&self.name, &self.unit)
    }

    /// Name and unit for messages: `` `u` (V) ``.
    pub(crate) fn label(&self) -> String {
        if self.unit.symbol().is_empty() {
            format!("`{}`", self.name)
        } else {
            format!("`{}` ({})", self.name, self.unit)
        }
    }

    /// True if `asked` names this channel: its header or its bare name, exactly.
    pub(crate) fn is_called(&self, asked: &str) -> bool {
        self.name == asked || self.header() == asked
    }
}

impl Record {
    /// Index of the channel called so: exactly, else ignoring case.
    pub(super) fn position(&self, asked: &str, role: ColumnRole) -> Result<usize, RecordError> {
        let lower = asked.to_lowercase();
        let same = |c: &Channel| c.name.to_lowercase() == lower || c.header().to_lowercase() == lower;
        let exactly = |c: &Channel| c.is_called(asked);
        for accept in [&exactly as &dyn Fn(&Channel) -> bool, &same] {
            let mut found = (0..self.channels.len()).filter(|&i| accept(&self.channels[i]));
            if let (Some(one), None) = (found.next(), found.next()) {
                return Ok(one);
            }
        }
        Err(self.no_such(asked, role))
    }

    /// The error for a missing channel.
    pub(super) fn no_such(&self, asked: &str, role: ColumnRole) -> RecordError {
        RecordError::NoSuchChannel {
            record: self.name.clone(),
            asked: asked.to_string(),
            role,
            available: self.channels.iter().map(Channel::label).collect::<Vec<_>>().join(", "),
        }
    }
}

/// Column header of a name and a unit; the inverse of [`split_header`].
pub fn header_of(name: &str, unit: &Unit) -> String {
    let symbol = unit.symbol();
    let suffixed = if symbol.is_empty() { name.to_string() } else { format!("{name}_{symbol}") };
    let back = split_header(&suffixed);
    if back.0 == name && back.1 == *unit { suffixed } else { format!("{name} [{symbol}]") }
}

/// Splits a column header into name and unit.
///
/// The unit is the longest suffix after an underscore that is a known unit (`u_V`, `u_cmd_V`, `H_A_per_m`,
/// `y1_nm`; `in`, inches, only after the name of a displacement), or is in brackets, known or not (`Voltage
/// (V)`, `y [µm]`). A header without one has the empty unit.
pub fn split_header(header: &str) -> (String, Unit) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(inner) = header.strip_suffix(close)
            && let Some((name, symbol)) = inner.rsplit_once(open)
            && !name.trim().is_empty()
        {
            return (name.trim().to_string(), Unit::new(symbol.trim()));
        }
    }
    for (at, _) in header.match_indices('_') {
        let (name, symbol) = (&header[..at], Unit::new(&header[at + 1..]));
        if !name.is_empty() && (symbol.is_known() || symbol.symbol() == "in" && is_displacement(name)) {
            return (name.to_string(), symbol);
        }
    }
    (header.to_string(), Unit::new(""))
}

/// True if a name is that of a displacement, so that `in` after it means inches, whereas `u_in` is an input.
fn is_displacement(name: &str) -> bool {
    const WORDS: [&str; 11] = [
        "output",
        "displacement",
        "position",
        "stroke",
        "reference",
        "target",
        "setpoint",
        "trajectory",
        "pos",
        "disp",
        "ref",
    ];
    let lower = name.to_lowercase();
    let word =
        lower.split(['_', ' ']).next().unwrap_or_default().trim_end_matches(|c: char| c.is_ascii_digit());
    WORDS.contains(&word) || ["x", "y", "z", "r"].contains(&word)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn headers_split_into_name_and_unit() {
        for (header, name, unit) in [
            ("t_s", "t", "s"),
            ("u_V", "u", "V"),
            ("y_um", "y", "um"),
            ("y_µm", "y", "um"),
            ("H_A_per_m", "H", "A_per_m"),
            ("B_T", "B", "T"),
            ("u_cmd_V", "u_cmd", "V"),
            ("i_meas_mA", "i_meas", "mA"),
            ("y1_nm", "y1", "nm"),
            ("target_kg", "target", "kg"),
            ("target_in", "target", "in"),
            ("y1_in", "y1", "in"),
            ("u_in", "u_in", ""),
            ("drive_in", "drive_in", ""),
            ("y_mils", "y", "mils"),
            ("y_microns", "y", "um"),
            ("u_command", "u_command", ""),
            ("y_filtered", "y_filtered", ""),
            ("half_fringe_count", "half_fringe_count", ""),
            ("u", "u", ""),
            ("valid", "valid", ""),
            ("Voltage (V)", "Voltage", "V"),
            ("y [µm]", "y", "um"),
            ("x [counts]", "x", "counts"),
            ("_V", "_V", ""),
            ("gain_um_per_V", "gain", "um_per_V"),
        ] {
            assert_eq!(split_header(header), (name.to_string(), Unit::new(unit)), "{header}");
        }
    }

    proptest! {
        #[test]
        fn a_header_written_is_read_back(
            name in "[a-zA-Z][a-zA-Z0-9_]{0,12}",
            unit in prop_oneof![
                Just(""), Just("V"), Just("um"), Just("A_per_m"), Just("counts"), Just("s"), Just("m")
            ],
        ) {
            let unit = Unit::new(unit);
            prop_assert_eq!(split_header(&header_of(&name, &unit)), (name, unit));
        }
    }
}
