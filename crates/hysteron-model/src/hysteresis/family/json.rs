//! A family in JSON: its name, and its number of elements where that is not fixed.

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
