//! Transfer functions with real orders, article Eq. 6.

/// One term `coefficient · s^order`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Coefficient.
    pub coefficient: f64,
    /// Real order ≥ 0.
    pub order: f64,
}

/// G(s) = Σ numerator / Σ denominator, terms in ascending order (article Eq. 6).
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Numerator terms, ascending order.
    pub numerator: Vec<Term>,
    /// Denominator terms, ascending order.
    pub denominator: Vec<Term>,
}
