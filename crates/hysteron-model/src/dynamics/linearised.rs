//! A transfer function with the derivatives of its coefficients and orders.

use std::sync::OnceLock;

use hysteron_rt::{Dual, Scalar};

use super::stability::{Stability, stability};
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
    /// True if the term does not change in this direction.
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
    /// Found once for all records: of many terms, it takes as long as a simulation.
    stability: OnceLock<Stability>,
}

impl Linearised {
    /// Empty buffers, no transfer function yet.
    pub fn new() -> Self {
        let transfer_function = TransferFunction { numerator: Vec::new(), denominator: Vec::new() };
        let (numerator, denominator) = (Vec::new(), Vec::new());
        Self { transfer_function, parameters: 0, numerator, denominator, stability: OnceLock::new() }
    }

    /// Stability of the transfer function.
    pub(super) fn stability(&self) -> Stability {
        *self.stability.get_or_init(|| stability(&self.transfer_function))
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

    /// True if no term changes with this parameter.
    pub(super) fn is_still(&self, parameter: usize) -> bool {
        let of = |tangents: &[TermTangent]| {
            tangents.iter().skip(parameter).step_by(self.parameters.max(1)).all(|t| t.is_zero())
        };
        of(&self.numerator) && of(&self.denominator)
    }

    /// Stores numerator / denominator. Allocates nothing once it held as many terms and parameters.
    pub(super) fn store<const P: usize, const T: usize>(
        &mut self,
        numerator: &Sum<Dual<f64, P>, T>,
        denominator: &Sum<Dual<f64, P>, T>,
        parameters: usize,
    ) -> Result<(), DynamicsError> {
        self.parameters = parameters;
        self.stability = OnceLock::new();
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

/// A number with or without derivatives, with the functions beyond [`Scalar`] that normalising a frequency
/// response needs.
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

/// One term c s^α of a [`Sum`].
#[derive(Clone, Copy)]
struct SumTerm<S> {
    coefficient: S,
    order: S,
    /// The order is a whole number whatever the parameters are: such terms are merged at once, with and
    /// without derivatives alike.
    is_whole: bool,
}

/// Σ c s^α with at most T terms, in any order, on the stack.
#[derive(Clone, Copy)]
pub(super) struct Sum<S, const T: usize> {
    terms: [SumTerm<S>; T],
    count: usize,
}

/// Destination of a term.
#[derive(Clone, Copy)]
pub(super) struct Merged {
    index: usize,
    /// No term of this order came before.
    is_new: bool,
}

impl<S: Number, const T: usize> Sum<S, T> {
    fn empty() -> Self {
        let zero = S::constant(0.0);
        Self { terms: [SumTerm { coefficient: zero, order: zero, is_whole: true }; T], count: 0 }
    }

    fn push(&mut self, term: SumTerm<S>) {
        let same = |other: &&mut SumTerm<S>| {
            other.is_whole && term.is_whole && other.order.value() == term.order.value()
        };
        if let Some(other) = self.terms[..self.count].iter_mut().find(same) {
            other.coefficient = other.coefficient + term.coefficient;
        } else if let Some(slot) = self.terms.get_mut(self.count) {
            *slot = term;
            self.count += 1;
        } else {
            debug_assert!(false, "a sum of more than {T} terms");
        }
    }

    /// Σ c s^α of (c, α).
    pub(super) fn of(terms: impl IntoIterator<Item = (S, S)>) -> Self {
        let mut sum = Self::empty();
        for (coefficient, order) in terms {
            sum.push(SumTerm { coefficient, order, is_whole: false });
        }
        sum
    }

    /// Σ c_k s^k, lowest first.
    pub(super) fn whole(coefficients: impl IntoIterator<Item = S>) -> Self {
        let mut sum = Self::empty();
        for (k, coefficient) in coefficients.into_iter().enumerate() {
            sum.push(SumTerm { coefficient, order: S::constant(k as f64), is_whole: true });
        }
        sum
    }

    pub(super) fn constant(value: S) -> Self {
        Self::whole([value])
    }

    /// Coefficient of the term that came first.
    pub(super) fn first(&self) -> Option<S> {
        self.terms[..self.count].first().map(|term| term.coefficient)
    }

    pub(super) fn terms(&self) -> impl Iterator<Item = (S, S)> + '_ {
        self.terms[..self.count].iter().map(|term| (term.coefficient, term.order))
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        other.terms[..other.count].iter().for_each(|term| sum.push(*term));
        sum
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = Self::empty();
        for x in &self.terms[..self.count] {
            for y in &other.terms[..other.count] {
                product.push(SumTerm {
                    coefficient: x.coefficient * y.coefficient,
                    order: x.order + y.order,
                    is_whole: x.is_whole && y.is_whole,
                });
            }
        }
        product
    }

    /// n/d + m/e = (n e + m d)/(d e), each as numerator and denominator.
    pub(super) fn add_fractions((n, d): &(Self, Self), (m, e): &(Self, Self)) -> (Self, Self) {
        (n.times(e).plus(&m.times(d)), d.times(e))
    }

    /// Writes the terms in ascending order, those of equal order added up; `each` receives the destination of
    /// each.
    pub(super) fn store(&self, to: &mut Vec<Term>, mut each: impl FnMut(Merged, (S, S))) {
        let mut sorted = *self;
        sorted.terms[..self.count].sort_unstable_by(|a, b| a.order.value().total_cmp(&b.order.value()));
        to.clear();
        for (coefficient, order) in sorted.terms() {
            let is_new = to.last().is_none_or(|last| last.order != order.value());
            match to.last_mut() {
                Some(last) if !is_new => last.coefficient += coefficient.value(),
                _ => to.push(Term::new(coefficient.value(), order.value())),
            }
            each(Merged { index: to.len() - 1, is_new }, (coefficient, order));
        }
    }
}
