//! Forward-mode derivatives: a value with its P first derivatives.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::real::{Real, Scalar, sealed};

/// A value and its derivatives with respect to P parameters (dual number of P infinitesimals).
///
/// Arithmetic follows the chain rule exactly, so a step computed in duals returns the derivatives of the
/// numbers it returns, across zero crossings of z included. Source: A. Griewank, A. Walther, *Evaluating
/// Derivatives*, SIAM 2008, ch. 3, doi:10.1137/1.9780898717761.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T, const P: usize> {
    /// The value.
    pub value: T,
    /// ∂value/∂θ₁ … ∂value/∂θ_P.
    pub partials: [T; P],
}

impl<T: Real, const P: usize> Dual<T, P> {
    /// Parameter `index` itself: derivative 1 with respect to it, 0 to the others (to all, where `index` is
    /// out of range).
    #[inline(always)]
    pub fn variable(value: T, index: usize) -> Self {
        let mut partials = [T::of(0.0); P];
        if let Some(own) = partials.get_mut(index) {
            *own = T::of(1.0);
        }
        Dual { value, partials }
    }

    /// Zeroes the derivatives from number `first` on that have [vanished](Real::VANISHED): those with respect
    /// to an initial state decay for ever.
    #[inline(always)]
    pub fn without_vanished(mut self, first: usize) -> Self {
        for p in self.partials.iter_mut().skip(first) {
            *p = if p.abs() < T::VANISHED { T::of(0.0) } else { *p };
        }
        self
    }
}

impl<T: Real, const P: usize> Add for Dual<T, P> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self.value = self.value + other.value;
        for (p, q) in self.partials.iter_mut().zip(&other.partials) {
            *p = *p + *q;
        }
        self
    }
}

impl<T: Real, const P: usize> Neg for Dual<T, P> {
    type Output = Self;
    #[inline(always)]
    // Not in place: rustc 1.95 at optimisation level 1 lets a closure that inlines it change the caller's
    // copy.
    fn neg(self) -> Self {
        Self { value: -self.value, partials: self.partials.map(|p| -p) }
    }
}

impl<T: Real, const P: usize> Sub for Dual<T, P> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value = self.value - other.value;
        for (p, q) in self.partials.iter_mut().zip(&other.partials) {
            *p = *p - *q;
        }
        self
    }
}

impl<T: Real, const P: usize> Mul for Dual<T, P> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.join(other, self.value * other.value, [other.value, self.value])
    }
}

impl<T: Real, const P: usize> Div for Dual<T, P> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let inverse = T::of(1.0) / other.value;
        self.join(other, quotient, [inverse, -(quotient * inverse)])
    }
}

impl<T: Real, const P: usize> sealed::Sealed for Dual<T, P> {}

impl<T: Real, const P: usize> Scalar for Dual<T, P> {
    type Real = T;
    const DERIVATIVES: usize = P;
    #[inline(always)]
    fn constant(value: T) -> Self {
        Dual { value, partials: [T::of(0.0); P] }
    }
    #[inline(always)]
    fn value(self) -> T {
        self.value
    }
    #[inline(always)]
    fn derivative(self, index: usize) -> T {
        self.partials.get(index).copied().unwrap_or(T::of(0.0))
    }
    #[inline(always)]
    fn with_derivative(mut self, index: usize, derivative: T) -> Self {
        if let Some(p) = self.partials.get_mut(index) {
            *p = derivative;
        }
        self
    }
    #[inline]
    fn magnitude(self) -> T {
        self.partials.iter().fold(self.value.abs(), |sum, p| sum + p.abs())
    }
    #[inline(always)]
    fn scale(self, factor: T) -> Self {
        self.chain(self.value * factor, factor)
    }
    #[inline(always)]
    fn shift(self, term: T) -> Self {
        Dual { value: self.value + term, partials: self.partials }
    }
    #[inline(always)]
    fn chain(mut self, value: T, slope: T) -> Self {
        self.value = value;
        // In place: `map` and `into_iter` of an array are not inlined, one call a number.
        for p in &mut self.partials {
            *p = slope * *p;
        }
        self
    }
    #[inline(always)]
    fn join(mut self, other: Self, value: T, [x, y]: [T; 2]) -> Self {
        self.value = value;
        for (p, q) in self.partials.iter_mut().zip(&other.partials) {
            *p = x * *p + y * *q;
        }
        self
    }
    #[inline(always)]
    fn implicit(root: T, slope: impl FnOnce() -> T, function: impl FnOnce(Self) -> Self) -> Self {
        function(Self::constant(root)).chain(root, -(T::of(1.0) / slope()))
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), T::of(1.0) / self.value)
    }
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), T::of(1.0) / (T::of(1.0) + self.value))
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, T::of(0.5) / root)
    }
    fn tan(self) -> Self {
        let t = self.value.tan();
        self.chain(t, T::of(1.0) + t * t)
    }
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        self.chain(t, (T::of(1.0) - t) * (T::of(1.0) + t))
    }
    fn atan(self) -> Self {
        self.chain(self.value.atan(), T::of(1.0) / (T::of(1.0) + self.value * self.value))
    }
    fn powf(self, exponent: Self) -> Self {
        let power = self.value.powf(exponent.value);
        let base_slope = exponent.value * (power / self.value);
        self.join(exponent, power, [base_slope, power * self.value.ln()])
    }
}
