//! Results as JSON objects whose keys name the units.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use serde_json::value::{RawValue, to_raw_value};

/// A JSON object, its entries in the order they were put in.
#[derive(Clone, Debug, Default)]
pub struct Keyed(Vec<(String, Box<RawValue>)>);

impl Keyed {
    /// The same with one more entry; numbers that are not finite are null.
    #[must_use]
    pub fn with(mut self, key: impl Into<String>, value: impl Serialize) -> Self {
        self.0.push((key.into(), to_raw_value(&value).unwrap_or_default()));
        self
    }

    /// The same with an entry in a unit, by its symbol.
    #[must_use]
    pub fn in_unit(self, key: &str, symbol: &str, value: impl Serialize) -> Self {
        self.with(key_in(key, symbol), value)
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
