//! Every number of a model of any kind, with its unit and standard error.

use serde_json::Value;

use super::Model;
use crate::model_file::{ModelFileError, Quantity};

/// Blocks whose numbers a model file knows by their short names (`alpha`, `denominator[0].order`).
const BLOCKS: [&str; 2] = ["hysteresis.", "dynamics."];

impl Model {
    /// Every number of the model file that has a unit and a standard error or none, sorted by place,
    /// by the name that its correlation has for it: `alpha`, `denominator[0].coefficient`, `delay`; elsewhere
    /// by its place in the file, without `parameters`.
    ///
    /// # Errors
    /// [`ModelFileError`] for invalid data.
    pub fn numbers(&self) -> Result<Vec<(String, Quantity)>, ModelFileError> {
        let text = self.to_json()?;
        let file: Value = serde_json::from_str(&text).unwrap_or_default();
        let mut numbers = Vec::new();
        collect(&file, "", &mut numbers);
        Ok(numbers)
    }
}

fn collect(value: &Value, place: &str, numbers: &mut Vec<(String, Quantity)>) {
    match value {
        Value::Object(fields) if fields.contains_key("value") && fields.contains_key("std_error") => {
            if let Ok(quantity) = serde_json::from_value(value.clone()) {
                let own = BLOCKS.iter().find_map(|block| place.strip_prefix(block));
                numbers.push((own.unwrap_or(place).to_owned(), quantity));
            }
        }
        Value::Object(fields) => {
            for (name, inner) in fields {
                let inside = match (name.as_str(), place) {
                    ("parameters", _) => place.to_owned(),
                    (_, "") => name.clone(),
                    _ => format!("{place}.{name}"),
                };
                collect(inner, &inside, numbers);
            }
        }
        Value::Array(list) => {
            for (i, inner) in list.iter().enumerate() {
                collect(inner, &format!("{place}[{i}]"), numbers);
            }
        }
        _ => {}
    }
}
