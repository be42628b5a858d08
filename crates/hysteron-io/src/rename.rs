//! New names for the columns of a file.

use std::collections::HashMap;
use std::str::FromStr;

use hysteron_model::advice::ColumnRole;
use hysteron_model::record::split_header;
use serde::{Deserialize, Serialize};

use crate::IoError;
use crate::columns::{ArrayHeading, Heading, Headings};
use crate::roles::chosen;

/// New name of a column, parsed from `OLD=NEW`, e.g. `Voltage=u` or `ch1=u_V`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rename {
    /// The column: its name, with or without unit, or its number from 1.
    pub from: String,
    /// Its new name. A unit with it is that of a column without one; no number is converted.
    pub to: String,
}

/// Error of a text that is no [`Rename`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected OLD=NEW, e.g. ch1=u_V")]
pub struct RenameError;

impl FromStr for Rename {
    type Err = RenameError;

    fn from_str(text: &str) -> Result<Self, RenameError> {
        let (from, to) = text.split_once('=').ok_or(RenameError)?;
        let (from, to) = (from.trim(), to.trim());
        if from.is_empty() || to.is_empty() || to.chars().any(char::is_control) {
            return Err(RenameError);
        }
        Ok(Rename { from: from.to_owned(), to: to.to_owned() })
    }
}

/// The headings with new names; all old ones are looked up before any is changed, so that two may be
/// exchanged.
pub(crate) fn renamed(headings: &Headings, renames: &[Rename]) -> Result<Headings, IoError> {
    let mut new = headings.clone();
    for Rename { from, to } in renames {
        let Some(index) = chosen(headings, Some(from), ColumnRole::Renamed)? else { continue };
        let Some(old) = headings.columns.get(index) else { continue };
        let (name, unit) = split_header(to);
        if !unit.symbol().is_empty() && !old.unit.symbol().is_empty() && unit != old.unit {
            return Err(IoError::RenamedUnit {
                place: headings.place(),
                name: old.header.clone(),
                unit: old.unit.to_string(),
                to: to.clone(),
            });
        }
        let unit = if unit.symbol().is_empty() { old.unit.clone() } else { unit };
        let header = hysteron_model::record::header_of(&name, &unit);
        if let Some(column) = new.columns.get_mut(index) {
            // A new name is a path of one component.
            let array = column.array.take().map(|array| ArrayHeading { group_bytes: 0, ..array });
            *column = Heading { header, name, unit, array };
        }
    }
    let mut known = HashMap::new();
    for (second, column) in new.columns.iter().enumerate() {
        let key = (column.name.as_str(), column.unit.symbol(), column.group());
        if let Some(first) = known.insert(key, second) {
            return Err(IoError::DuplicateColumn {
                place: headings.place(),
                name: column.header.clone(),
                first: first + 1,
                second: second + 1,
            });
        }
    }
    Ok(new)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(renames: &[&str]) -> Result<Vec<String>, String> {
        let headings = ["t_s", "ch1", "Voltage_V", "y_nm"].map(str::to_owned).to_vec();
        let headings = Headings::new("r.csv", Some(1), headings).unwrap();
        let renames: Vec<Rename> = renames.iter().map(|text| text.parse().unwrap()).collect();
        let new = renamed(&headings, &renames).map_err(|e| e.to_string())?;
        Ok(new.columns.into_iter().map(|c| c.header).collect())
    }

    #[test]
    fn names_change_and_units_stay() {
        assert_eq!(headers(&["voltage=u", "ch1=z_um"]).unwrap(), ["t_s", "z_um", "u_V", "y_nm"]);
        assert_eq!(headers(&["y=Voltage", "Voltage_V=y"]).unwrap(), ["t_s", "ch1", "y_V", "Voltage_nm"]);
        assert_eq!(headers(&["2=x"]).unwrap()[1], "x");
    }

    #[test]
    fn what_cannot_be_renamed_is_refused() {
        let text = headers(&["z=u"]).unwrap_err();
        assert!(text.contains("no column `z`") && text.contains("`Voltage_V`"), "{text}");
        let text = headers(&["y=y_um"]).unwrap_err();
        assert!(text.contains("`y_nm` is in nm") && text.contains("`y_um`"), "{text}");
        assert!(headers(&["ch1=Voltage_V"]).unwrap_err().contains("Voltage_V"));
        for text in ["u", "=u", "u=", "u= \n"] {
            assert!(text.parse::<Rename>().is_err(), "{text:?}");
        }
    }
}
