//! Roles of the named parameters of one step: searched, projected out or held.

use super::IdentifyError;
use hysteron_optimize::{Bounds, Range};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Role of one named parameter in a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    /// Held at this value.
    Fixed(f64),
    /// Enters the output linearly and is eliminated by linear least squares at every candidate.
    Projected,
    /// `Projected` with the sign constrained to this one (+1 or −1), or zero.
    OneSided(f64),
    /// Searched: index into the search vector.
    Searched(usize),
}

impl Role {
    /// Value at the candidate `x`; `None` where it is projected out.
    pub(super) fn value(self, x: &[f64]) -> Option<f64> {
        match self {
            Role::Fixed(value) => Some(value),
            Role::Projected | Role::OneSided(_) => None,
            Role::Searched(index) => x.get(index).copied(),
        }
    }

    /// Index in the search vector, if searched.
    pub(super) fn index(self) -> Option<usize> {
        match self {
            Role::Searched(index) => Some(index),
            Role::Fixed(_) | Role::Projected | Role::OneSided(_) => None,
        }
    }

    /// True if linear least squares eliminates it.
    pub(super) fn is_eliminated(self) -> bool {
        matches!(self, Role::Projected | Role::OneSided(_))
    }
}

/// User's constraints on single parameters: `--fix NAME=VALUE` and `--bound NAME=LOW:HIGH`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Demands {
    /// Parameters held at a value.
    pub fixed: Vec<(String, f64)>,
    /// Parameters kept within a range.
    pub bounded: Vec<(String, f64, f64)>,
}

impl Demands {
    pub(super) fn fixed(&self, name: &str) -> Option<f64> {
        self.fixed.iter().find(|(n, _)| n == name).map(|&(_, value)| value)
    }

    pub(super) fn bounded(&self, name: &str) -> Option<(f64, f64)> {
        self.bounded.iter().find(|(n, ..)| n == name).map(|&(_, low, high)| (low, high))
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.fixed.iter().map(|(n, _)| n.as_str()).chain(self.bounded.iter().map(|(n, ..)| n.as_str()))
    }

    /// Checks every demand against the parameter names of this fit.
    pub(super) fn check(&self, known: &[&str]) -> Result<(), IdentifyError> {
        for name in self.names() {
            if !known.contains(&name) {
                return Err(IdentifyError::UnknownParameter {
                    name: name.to_owned(),
                    known: known.join(", "),
                });
            }
        }
        for (name, value) in &self.fixed {
            if !value.is_finite() {
                return Err(IdentifyError::Demand { name: name.clone(), wanted: "a finite value" });
            }
            if self.bounded(name).is_some() {
                return Err(IdentifyError::Demand {
                    name: name.clone(),
                    wanted: "either fixed or bounded, not both",
                });
            }
        }
        for (name, low, high) in &self.bounded {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(IdentifyError::Demand {
                    name: name.clone(),
                    wanted: "LOW:HIGH with LOW < HIGH, both finite",
                });
            }
        }
        Ok(())
    }
}

/// Builds a search box entry by entry, honouring the user's demands.
#[derive(Debug)]
pub(super) struct BoxBuilder<'a> {
    demands: &'a Demands,
    ranges: Vec<Range>,
}

impl<'a> BoxBuilder<'a> {
    pub(super) fn new(demands: &'a Demands) -> Self {
        Self { demands, ranges: Vec::new() }
    }

    /// Searched over `range` unless the user fixed the parameter or gave a range.
    pub(super) fn searched(&mut self, range: Range) -> Role {
        if let Some(value) = self.demands.fixed(&range.name) {
            return Role::Fixed(value);
        }
        let range = match self.demands.bounded(&range.name) {
            Some((low, high)) => Range { low, high, logarithmic: range.logarithmic && low > 0.0, ..range },
            None => range,
        };
        self.ranges.push(range);
        Role::Searched(self.ranges.len() - 1)
    }

    /// Projected out unless the user fixed it or gave a range (then searched).
    pub(super) fn projected(&mut self, range: Range) -> Role {
        if self.demands.fixed(&range.name).is_none() && self.demands.bounded(&range.name).is_none() {
            return Role::Projected;
        }
        self.searched(range)
    }

    /// [`Self::projected`] with the sign constrained to `sign`, or zero.
    pub(super) fn one_sided(&mut self, range: Range, sign: f64) -> Role {
        match self.projected(range) {
            Role::Projected => Role::OneSided(sign),
            other => other,
        }
    }

    pub(super) fn finish(self) -> Bounds {
        Bounds { ranges: self.ranges }
    }
}

/// A start: each parameter at `value` of its name, else in the middle of its range, clamped to the box.
pub(super) fn pick(bounds: &Bounds, value: impl Fn(&str) -> Option<f64>) -> Vec<f64> {
    bounds
        .ranges
        .iter()
        .map(|r| value(&r.name).unwrap_or_else(|| r.from_unit(0.5)).clamp(r.low, r.high))
        .collect()
}
