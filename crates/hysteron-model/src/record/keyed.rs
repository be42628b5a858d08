//! Results as JSON objects whose keys name the units.

use std::fmt;

use serde::de::{DeserializeOwned, Deserializer, Error as _, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};
use serde_json::value::{RawValue, to_raw_value};

/// A JSON object, its entries in the order they were put in.
#[derive(Clone, Debug, Default)]
pub struct Keyed(Vec<(String, Box<RawValue>)>);

impl Keyed {
    /// These entries and one more; numbers that are not finite are null.
    #[must_use]
    pub fn with(mut self, key: impl Into<String>, value: impl Serialize) -> Self {
        self.0.push((key.into(), to_raw_value(&value).unwrap_or_default()));
        self
    }

    /// These entries and those of an object; a value that is not an object adds nothing.
    #[must_use]
    pub fn with_all(mut self, object: &impl Serialize) -> Self {
        let entries = to_raw_value(object).and_then(|text| serde_json::from_str::<Self>(text.get()));
        self.0.extend(entries.unwrap_or_default().0);
        self
    }

    /// These entries and one in a unit, by its symbol.
    #[must_use]
    pub fn in_unit(self, key: &str, symbol: &str, value: impl Serialize) -> Self {
        self.with(key_in(key, symbol), value)
    }

    /// Value of an entry; a missing one reads as null.
    ///
    /// # Errors
    /// The value is of another type, or the entry is missing and null is not allowed.
    pub fn get<T: DeserializeOwned, E: serde::de::Error>(&self, key: &str) -> Result<T, E> {
        let text = self.0.iter().find(|(own, _)| own == key).map_or("null", |(_, value)| value.get());
        serde_json::from_str(text).map_err(|error| E::custom(format_args!("{key}: {error}")))
    }

    /// An object of those entries that it has a name for.
    ///
    /// # Errors
    /// An entry is missing or its value is of another type.
    pub fn get_all<T: DeserializeOwned, E: serde::de::Error>(&self) -> Result<T, E> {
        to_raw_value(self).and_then(|text| serde_json::from_str(text.get())).map_err(E::custom)
    }

    /// Value of an entry in a unit, by its symbol.
    ///
    /// # Errors
    /// Those of [`Keyed::get`].
    pub fn get_in_unit<T: DeserializeOwned, E: serde::de::Error>(
        &self,
        key: &str,
        symbol: &str,
    ) -> Result<T, E> {
        self.get(&key_in(key, symbol))
    }

    /// Symbol of the unit in which there is an entry, by its key; empty where the key has none.
    pub fn unit_of(&self, key: &str) -> Option<&str> {
        self.0.iter().find_map(|(own, _)| {
            let rest = own.strip_prefix(key)?;
            if rest.is_empty() { Some(rest) } else { rest.strip_prefix('_') }
        })
    }
}

/// `rmse_um`: a key with its unit, where it has one.
pub fn key_in(key: &str, symbol: &str) -> String {
    if symbol.is_empty() { key.to_owned() } else { format!("{key}_{symbol}") }
}

impl Serialize for Keyed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (key, value) in &self.0 {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Keyed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;
        impl<'de> Visitor<'de> for Entries {
            type Value = Keyed;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a JSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Keyed, A::Error> {
                let mut entries: Vec<(String, Box<RawValue>)> = Vec::new();
                while let Some((key, value)) = map.next_entry::<String, Box<RawValue>>()? {
                    if entries.iter().any(|(own, _)| *own == key) {
                        return Err(A::Error::custom(format_args!("duplicate key {key}")));
                    }
                    entries.push((key, value));
                }
                Ok(Keyed(entries))
            }
        }
        deserializer.deserialize_map(Entries)
    }
}
