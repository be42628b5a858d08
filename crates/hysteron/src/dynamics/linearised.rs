//! A transfer function with the derivatives of its coefficients and orders.

use hysteron_rt::{Dual, Scalar};

use super::{DynamicsError, Term, TransferFunction};

/// Derivative of one term b s^β in one direction: d(b s^β) = (db + b dβ ln s) s^β.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TermTangent {
    /// db.
    pub coefficient: f64,
    /// b dβ. Where terms of equal order were merged, the sum over them, so that nothing is divided by a
    /// coefficient that may vanish.
    pub weighted_order: f64,
}

impl TermTangent {
    /// Whether the term does not change in this direction.
    pub(super) fn is_zero(self) -> bool {
        self == Self::default()
    }
}

/// A transfer function and, for each of a number of parameters, the derivative of each of its terms. Made by
/// [`super::DynamicForm::linearise`]; its buffers are reused.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearised {
    /// The transfer function.
    pub transfer_function: TransferFunction,
    parameters: usize,
    /// Term by term, all parameters of a term together.
    numerator: Vec<TermTangent>,
    denominator: Vec<TermTangent>,
}

impl Linearised {
    /// Empty buffers, no transfer function yet.
    pub fn new() -> Self {
        let transfer_function = TransferFunction { numerator: Vec::new(), denominator: Vec::new() };
        Self { transfer_function, parameters: 0, numerator: Vec::new(), denominator: Vec::new() }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Derivatives of numerator term `term` in all parameters; empty where there is no such term.
    pub fn numerator_term(&self, term: usize) -> &[TermTangent] {
        of_term(&self.numerator, term, self.parameters)
    }

    /// Derivatives of denominator term `term` in all parameters; empty where there is no such term.
    pub fn denominator_term(&self, term: usize) -> &[TermTangent] {
        of_term(&self.denominator, term, self.parameters)
    }

    /// Whether no term changes with this parameter.
    pub(super) fn is_still(&self, parameter: usize) -> bool {
        let of = |tangents: &[TermTangent]| {
            tangents.iter().skip(parameter).step_by(self.parameters.max(1)).all(|t| t.is_zero())
        };
        of(&self.numerator) && of(&self.denominator)
    }

    /// Stores numerator / denominator. Allocates nothing once it held as many terms and parameters.
    pub(super) fn store<const P: usize>(
        &mut self,
        numerator: &Sum<Dual<f64, P>>,
        denominator: &Sum<Dual<f64, P>>,
        parameters: usize,
    ) -> Result<(), DynamicsError> {
        self.parameters = parameters;
        numerator.store(&mut self.transfer_function.numerator, |merged, term| {
            gather(&mut self.numerator, merged, term, parameters);
        });
        denominator.store(&mut self.transfer_function.denominator, |merged, term| {
            gather(&mut self.denominator, merged, term, parameters);
        });
        self.numerator.truncate(self.transfer_function.numerator.len() * parameters);
        self.denominator.truncate(self.transfer_function.denominator.len() * parameters);
        self.transfer_function.validate()
    }
}

impl Default for Linearised {
    fn default() -> Self {
        Self::new()
    }
}

fn of_term(tangents: &[TermTangent], term: usize, parameters: usize) -> &[TermTangent] {
    tangents.get(term * parameters..(term + 1) * parameters).unwrap_or(&[])
}

/// Adds the derivatives of `term` to those of merged term number `merged`.
fn gather<const P: usize>(
    tangents: &mut Vec<TermTangent>,
    merged: Merged,
    (coefficient, order): (Dual<f64, P>, Dual<f64, P>),
    parameters: usize,
) {
    let at = merged.index * parameters;
    if merged.is_new {
        tangents.truncate(at);
        tangents.resize(at + parameters, TermTangent::default());
    }
    for ((t, db), dorder) in tangents[at..].iter_mut().zip(coefficient.partials).zip(order.partials) {
        t.coefficient += db;
        t.weighted_order += coefficient.value * dorder;
    }
}

/// A number that carries derivatives along or not, with what normalising a frequency response needs beside
/// [`Scalar`].
pub(super) trait Number: Scalar<Real = f64> {
    fn sin(self) -> Self;
    fn cos(self) -> Self;
}

impl Number for f64 {
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn cos(self) -> Self {
        f64::cos(self)
    }
}

impl<const P: usize> Number for Dual<f64, P> {
    fn sin(self) -> Self {
        let slope = self.value.cos();
        Dual { value: self.value.sin(), partials: self.partials.map(|p| slope * p) }
    }
    fn cos(self) -> Self {
        let slope = -self.value.sin();
        Dual { value: self.value.cos(), partials: self.partials.map(|p| slope * p) }
    }
}

/// Most terms before merging: two fractional modes in parallel with creep have a numerator of 12.
const TERMS: usize = 12;

/// Σ c s^α with few terms, in any order, on the stack.
#[derive(Clone, Copy)]
pub(super) struct Sum<S> {
    terms: [(S, S); TERMS],
    count: usize,
}

/// Where a term went.
#[derive(Clone, Copy)]
pub(super) struct Merged {
    index: usize,
    /// No term of this order came before.
    is_new: bool,
}

impl<S: Number> Sum<S> {
    /// Σ c s^α of (c, α).
    pub(super) fn of(terms: impl IntoIterator<Item = (S, S)>) -> Self {
        let zero = S::constant(0.0);
        let mut sum = Self { terms: [(zero, zero); TERMS], count: 0 };
        for (slot, term) in sum.terms.iter_mut().zip(terms) {
            *slot = term;
            sum.count += 1;
        }
        sum
    }

    pub(super) fn constant(value: S) -> Self {
        Self::of([(value, S::constant(0.0))])
    }

    pub(super) fn terms(&self) -> &[(S, S)] {
        &self.terms[..self.count]
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self::of(self.terms().iter().chain(other.terms()).copied())
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let products =
            |&(c, order): &(S, S)| other.terms().iter().map(move |&(d, more)| (c * d, order + more));
        Self::of(self.terms().iter().flat_map(products))
    }

    /// Writes the terms in ascending order, those of equal order added up; `each` is told where each went.
    pub(super) fn store(&self, to: &mut Vec<Term>, mut each: impl FnMut(Merged, (S, S))) {
        let mut sorted = *self;
        sorted.terms[..self.count].sort_by(|a, b| a.1.value().total_cmp(&b.1.value()));
        to.clear();
        for &(coefficient, order) in sorted.terms() {
            let is_new = to.last().is_none_or(|last| last.order != order.value());
            match to.last_mut() {
                Some(last) if !is_new => last.coefficient += coefficient.value(),
                _ => to.push(Term::new(coefficient.value(), order.value())),
            }
            each(Merged { index: to.len() - 1, is_new }, (coefficient, order));
        }
    }
}
