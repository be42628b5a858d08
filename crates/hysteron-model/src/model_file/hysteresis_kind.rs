//! Names of the static block's models.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::hysteresis::{Hysteresis, HysteresisForm};

/// Model of the static block: a family of hysteresis, by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HysteresisKind(HysteresisForm);

impl HysteresisKind {
    /// Of this operator.
    pub fn of(hysteresis: &Hysteresis) -> Self {
        Self(hysteresis.form())
    }

    /// The family; the file gives its number of elements.
    pub fn family(self) -> HysteresisForm {
        self.0
    }
}

impl Serialize for HysteresisKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl<'de> Deserialize<'de> for HysteresisKind {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<str>::deserialize(deserializer)?;
        name.parse().map(Self).map_err(de::Error::custom)
    }
}

impl JsonSchema for HysteresisKind {
    fn schema_name() -> Cow<'static, str> {
        "HysteresisKind".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let kinds: Vec<Schema> = HysteresisForm::usual()
            .into_iter()
            .map(|form| {
                let equation = form.description().equation();
                let description = format!("v = linear·u + quadratic·u² + … + {equation}; s = sgn u̇.");
                json_schema!({ "description": description, "type": "string", "const": form.name() })
            })
            .collect();
        json_schema!({ "description": "Models of the static block.", "oneOf": kinds })
    }
}
