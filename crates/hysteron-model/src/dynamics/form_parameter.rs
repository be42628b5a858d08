//! One number of a family of transfer functions.

/// One parameter of a [`DynamicForm`](super::DynamicForm).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FormParameter {
    /// Name, as on the command line.
    pub name: &'static str,
    /// Symbol; its name where it has none.
    pub symbol: &'static str,
    /// What it is, in a few words.
    pub meaning: &'static str,
    /// Unit; empty for a number without one.
    pub unit: &'static str,
    /// Whether it is positive and naturally searched on a logarithmic scale.
    pub logarithmic: bool,
    range: Range,
}

impl FormParameter {
    pub(super) const fn meaning(self, symbol: &'static str, meaning: &'static str) -> Self {
        Self { symbol, meaning, ..self }
    }

    /// As [`Self::meaning`], under its own name.
    pub(super) const fn is(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }

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

/// Positive, on a logarithmic scale.
pub(super) const fn scale(name: &'static str, unit: &'static str) -> FormParameter {
    FormParameter { unit, logarithmic: true, range: Range::Positive, ..plain(name) }
}

/// An order of differentiation, at least 0.
pub(super) const fn order(name: &'static str) -> FormParameter {
    FormParameter { range: Range::NotNegative, ..plain(name) }
}

/// At least 0, on a logarithmic scale.
pub(super) const fn not_negative(name: &'static str) -> FormParameter {
    FormParameter { logarithmic: true, range: Range::NotNegative, ..plain(name) }
}

/// Any number.
pub(super) const fn free(name: &'static str, unit: &'static str, logarithmic: bool) -> FormParameter {
    FormParameter { unit, logarithmic, ..plain(name) }
}

const fn plain(name: &'static str) -> FormParameter {
    FormParameter { name, symbol: name, meaning: "", unit: "", logarithmic: false, range: Range::Finite }
}
