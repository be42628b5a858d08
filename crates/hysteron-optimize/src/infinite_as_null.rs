//! JSON has no infinity: +∞ is written as `null`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A number.
pub mod one {
    use super::*;

    /// `null` for a number that is not finite.
    pub fn serialize<S: Serializer>(x: &f64, s: S) -> Result<S::Ok, S::Error> {
        x.is_finite().then_some(*x).serialize(s)
    }

    /// +∞ for `null`.
    pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
        Ok(Option::<f64>::deserialize(d)?.unwrap_or(f64::INFINITY))
    }
}

/// Several numbers.
pub mod many {
    use super::*;

    /// `null` for a number that is not finite.
    pub fn serialize<S: Serializer>(xs: &[f64], s: S) -> Result<S::Ok, S::Error> {
        s.collect_seq(xs.iter().map(|x| x.is_finite().then_some(*x)))
    }

    /// +∞ for `null`.
    pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<f64>, D::Error> {
        let xs = Vec::<Option<f64>>::deserialize(d)?;
        Ok(xs.into_iter().map(|x| x.unwrap_or(f64::INFINITY)).collect())
    }
}
