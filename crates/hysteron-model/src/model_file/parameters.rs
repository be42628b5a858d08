//! Named parameters in the order they are written.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Visitor};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::Quantity;
use crate::hysteresis::{HysteresisForm, polynomial_name};

/// Parameters by name, in file order; a JSON object. A name occurs once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(Vec<(String, Quantity)>);

impl Parameters {
    /// The parameter of this name.
    pub fn get(&self, name: &str) -> Option<&Quantity> {
        self.0.iter().find(|(n, _)| n == name).map(|(_, q)| q)
    }

    /// The parameter of this name, to set its standard error.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut Quantity> {
        self.0.iter_mut().find(|(n, _)| n == name).map(|(_, q)| q)
    }

    /// Adds a parameter at the end, or replaces the one of this name.
    pub fn set(&mut self, name: &str, quantity: Quantity) {
        match self.get_mut(name) {
            Some(slot) => *slot = quantity,
            None => self.0.push((name.to_owned(), quantity)),
        }
    }

    /// Names and quantities in file order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Quantity)> {
        self.0.iter().map(|(name, quantity)| (name.as_str(), quantity))
    }
}

impl Serialize for Parameters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, quantity) in &self.0 {
            map.serialize_entry(name, quantity)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Parameters {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;
        impl<'de> Visitor<'de> for Entries {
            type Value = Parameters;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of named parameters")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Parameters, A::Error> {
                let mut entries: Vec<(String, Quantity)> = Vec::new();
                while let Some((name, quantity)) = map.next_entry::<String, Quantity>()? {
                    // Bounded, so that the search for duplicates cannot take quadratic time in a hostile
                    // file.
                    if entries.len() >= MAX_PARAMETERS {
                        return Err(A::Error::custom(format!("more than {MAX_PARAMETERS} parameters")));
                    }
                    if entries.iter().any(|(n, _)| *n == name) {
                        return Err(A::Error::custom(format!("duplicate parameter `{name}`")));
                    }
                    entries.push((name, quantity));
                }
                Ok(Parameters(entries))
            }
        }
        deserializer.deserialize_map(Entries)
    }
}

/// Most parameters a hysteresis block may have.
const MAX_PARAMETERS: usize = 1000;

impl JsonSchema for Parameters {
    fn schema_name() -> Cow<'static, str> {
        "Parameters".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let quantity = generator.subschema_for::<Quantity>();
        let mut properties = serde_json::Map::new();
        let polynomial = (1..=5).map(polynomial_name);
        let form = HysteresisForm::default();
        let own: Vec<String> = form.model_numbers().into_iter().map(|number| number.name).collect();
        for name in polynomial.map(Cow::into_owned).chain(own.iter().cloned()) {
            properties.insert(name, quantity.clone().to_value());
        }
        let required: Vec<&str> = std::iter::once("linear").chain(own.iter().map(String::as_str)).collect();
        let description = format!(
            "Parameters of {}: polynomial coefficients without gaps, {}.",
            form.name(),
            own.join(", ")
        );
        json_schema!({
            "type": "object",
            "description": description,
            "properties": properties,
            "patternProperties": { "^degree_([6-9]|[1-9][0-9]+)$": quantity },
            "required": required,
            "additionalProperties": false,
        })
    }
}
