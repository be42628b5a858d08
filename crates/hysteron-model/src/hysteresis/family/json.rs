//! A family in JSON: its name, and its number of elements where that is not fixed.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::HysteresisForm;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename = "HysteresisForm")]
struct NamedFamily {
    name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    elements: Option<usize>,
}

impl Serialize for HysteresisForm {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let elements = self.description().elements().map(|_| self.elements());
        NamedFamily { name: self.name().to_owned(), elements }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for HysteresisForm {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let NamedFamily { name, elements } = NamedFamily::deserialize(deserializer)?;
        let form: Self = name.parse().map_err(de::Error::custom)?;
        elements.map_or(Ok(form), |count| form.with_elements(count)).map_err(de::Error::custom)
    }
}

impl JsonSchema for HysteresisForm {
    fn schema_name() -> Cow<'static, str> {
        "HysteresisForm".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let families: Vec<Schema> = Self::usual().into_iter().map(family_schema).collect();
        json_schema!({
            "description": "A family of hysteresis, with its number of elements where that is not fixed.",
            "oneOf": families,
        })
    }
}

fn family_schema(form: HysteresisForm) -> Schema {
    let name = json_schema!({ "type": "string", "const": form.name() });
    match form.description().elements() {
        None => json_schema!({
            "description": form.summary(),
            "type": "object",
            "properties": { "name": name },
            "required": ["name"],
            "additionalProperties": false,
        }),
        Some(_) => json_schema!({
            "description": form.summary(),
            "type": "object",
            "properties": {
                "name": name,
                "elements": { "type": "integer", "minimum": 1, "default": form.elements() },
            },
            "required": ["name"],
            "additionalProperties": false,
        }),
    }
}
