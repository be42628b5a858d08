//! One number of a family of transfer functions.

/// One parameter of a [`DynamicForm`](super::DynamicForm).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FormParameter {
    /// Name, as on the command line.
    pub name: &'static str,
    /// Unit; empty for a number without one.
    pub unit: &'static str,
    /// Whether it is positive and naturally searched on a logarithmic scale.
    pub logarithmic: bool,
    range: Range,
}

impl FormParameter {
    /// Whether it may have this value; if not, what it may be.
    pub(super) fn check(&self, value: f64) -> Result<(), &'static str> {
        let (allowed, inside) = match self.range {
            Range::Positive => ("positive and finite", value > 0.0),
            Range::NotNegative => ("a finite number ≥ 0", value >= 0.0),
            Range::Finite => ("a finite number", true),
        };
        if inside && value.is_finite() { Ok(()) } else { Err(allowed) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Range {
    Positive,
    NotNegative,
    Finite,
}

pub(super) const fn scale(name: &'static str, unit: &'static str) -> FormParameter {
    FormParameter { name, unit, logarithmic: true, range: Range::Positive }
}

pub(super) const fn order(name: &'static str) -> FormParameter {
    FormParameter { name, unit: "", logarithmic: false, range: Range::NotNegative }
}

pub(super) const fn not_negative(name: &'static str) -> FormParameter {
    FormParameter { name, unit: "", logarithmic: true, range: Range::NotNegative }
}

pub(super) const fn free(name: &'static str, unit: &'static str, logarithmic: bool) -> FormParameter {
    FormParameter { name, unit, logarithmic, range: Range::Finite }
}
