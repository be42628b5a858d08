//! Coefficients that a correction can adapt, by name.

use std::fmt;
use std::str::FromStr;

use hysteron_numeric::display::short;
use serde::{Deserialize, Serialize};

/// An adapted coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Term {
    /// Offset \[µm\], regressor 1; nominally the model's.
    Offset,
    /// Gain \[1\], regressor w, the model's output less its offset \[µm\]; nominally 1.
    Gain,
    /// Change of the polynomial's coefficient of uⁿ \[µm/Vⁿ\], regressor G ∗ uⁿ with the model's delay;
    /// nominally 0. With [`Self::Gain`] it is the change after the gain.
    Power(u32),
    /// Creep \[1\], regressor w after a first-order lag, 1/(1 + `lag_s`·s), settled at the first sample;
    /// nominally 0. One term per decade of time gives the usual sum of lags.
    Creep {
        /// Time constant \[s\].
        lag_s: f64,
    },
}

impl fmt::Display for Term {
    /// `offset`, `gain`, `power=2`, `creep=10`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Offset => f.pad("offset"),
            Self::Gain => f.pad("gain"),
            Self::Power(n) => f.pad(&format!("power={n}")),
            Self::Creep { lag_s } => f.pad(&format!("creep={}", short(*lag_s))),
        }
    }
}

/// Text that names no [`Term`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected offset, gain, power=N or creep=SECONDS")]
pub struct UnknownTerm;

impl FromStr for Term {
    type Err = UnknownTerm;

    fn from_str(text: &str) -> Result<Self, UnknownTerm> {
        match text.trim().split_once('=') {
            None if text.trim() == "offset" => Ok(Self::Offset),
            None if text.trim() == "gain" => Ok(Self::Gain),
            Some(("power", n)) => n.parse().map(Self::Power).map_err(|_| UnknownTerm),
            Some(("creep", lag)) => {
                let lag_s = lag.parse::<f64>().ok().filter(|s| *s > 0.0 && s.is_finite());
                lag_s.map(|lag_s| Self::Creep { lag_s }).ok_or(UnknownTerm)
            }
            _ => Err(UnknownTerm),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for term in [Term::Offset, Term::Gain, Term::Power(3), Term::Creep { lag_s: 2.5 }] {
            assert_eq!(term.to_string().parse(), Ok(term));
        }
        for text in ["", "power", "power=x", "creep=-1", "creep=inf", "drift"] {
            assert_eq!(text.parse::<Term>(), Err(UnknownTerm));
        }
    }
}
