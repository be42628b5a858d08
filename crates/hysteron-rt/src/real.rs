//! The numbers the arithmetic is written for: `f32`, `f64`, and duals over them.

use core::fmt::{Debug, Display};
use core::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) mod sealed {
    /// Closes [`super::Real`] and [`super::Scalar`].
    pub trait Sealed {}
}

/// A number a step can be computed in: a [`Real`], or a [`crate::Dual`] that carries derivatives along.
/// Sealed.
pub trait Scalar:
    sealed::Sealed
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Type of the value (and of each derivative).
    type Real: Real;
    /// Number of derivatives that it carries along.
    const DERIVATIVES: usize;
    /// Whether it carries derivatives along.
    const HAS_DERIVATIVES: bool = Self::DERIVATIVES > 0;
    /// A number with zero derivatives.
    fn constant(value: Self::Real) -> Self;
    /// The value without the derivatives.
    fn value(self) -> Self::Real;
    /// Derivative number `index`; 0 beyond the last.
    fn derivative(self, index: usize) -> Self::Real;
    /// This number with derivative number `index` replaced; none beyond the last.
    fn with_derivative(self, index: usize, derivative: Self::Real) -> Self;
    /// |value| + Σ |derivatives|, which decides whether a term is negligible.
    fn magnitude(self) -> Self::Real;
    /// Product with a constant.
    fn scale(self, factor: Self::Real) -> Self;
    /// Sum with a constant.
    fn shift(self, term: Self::Real) -> Self;
    /// f(self) for a function with the value `value` and the derivative `slope` at [`Self::value`].
    fn chain(self, value: Self::Real, slope: Self::Real) -> Self;
    /// f(self, other) for a function with the value `value` and the partial derivatives `slopes`.
    fn join(self, other: Self, value: Self::Real, slopes: [Self::Real; 2]) -> Self;
    /// Root of a function: its value is `root`, where the function has the slope `slope`; its derivatives
    /// follow by the implicit function theorem.
    fn implicit(
        root: Self::Real,
        slope: impl FnOnce() -> Self::Real,
        function: impl FnOnce(Self) -> Self,
    ) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// ln x.
    fn ln(self) -> Self;
    /// ln(1 + x).
    fn ln_1p(self) -> Self;
    /// √x.
    fn sqrt(self) -> Self;
    /// tan x.
    fn tan(self) -> Self;
    /// tanh x.
    fn tanh(self) -> Self;
    /// arctan x.
    fn atan(self) -> Self;
    /// self^exponent, self > 0.
    fn powf(self, exponent: Self) -> Self;
}

/// `f32` or `f64`. Sealed.
pub trait Real: Scalar<Real = Self> + PartialOrd + Debug + Display + Send + Sync + 'static {
    /// Distance from 1 to the next number.
    const EPSILON: Self;
    /// Up to this |x| the polynomial of degree 6 gives (1 − e⁻ˣ)/x to a fraction of a unit in the last place.
    const SMALL: Self;
    /// Derivatives below this are set to 0. Above the (slow) subnormal numbers by more than any factor of one
    /// step.
    const VANISHED: Self;
    /// A level far below any signal whose rounding errors are still far above the subnormal numbers.
    const FLOOR: Self;
    /// Least positive number that is not subnormal.
    const LEAST_NORMAL: Self;
    /// A level far above any signal, from which linear dynamics do not leave the range of the number type.
    const LARGEST: Self;
    /// Bytes of a number.
    const BYTES: usize = size_of::<Self>();
    /// The bits of IEEE 754, in the lowest places.
    fn to_bits(self) -> u64;
    /// The number with these bits.
    fn from_bits(bits: u64) -> Self;
    /// Conversion of a literal, rounded to nearest.
    fn of(literal: f64) -> Self;
    /// The least number not below a literal.
    fn at_least(literal: f64) -> Self;
    /// The largest number not above a literal.
    fn at_most(literal: f64) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Integer part of a positive number; 0 for any other.
    fn truncated(self) -> usize;
}

macro_rules! elementary {
    ($name:ident, $std:path, $libm:path) => {
        #[inline]
        fn $name(self) -> Self {
            #[cfg(feature = "std")]
            return $std(self);
            #[cfg(not(feature = "std"))]
            return $libm(self);
        }
    };
}

macro_rules! real {
    (
        $t:ident, $small:expr, $vanished:expr, $floor:expr, $largest:expr,
        $exp:path, $ln_1p:path, $sqrt:path, $tan:path, $tanh:path, $atan:path, $pow:path, $ln:path
    ) => {
        impl sealed::Sealed for $t {}

        impl Scalar for $t {
            type Real = $t;
            const DERIVATIVES: usize = 0;
            #[inline(always)]
            fn constant(value: $t) -> $t {
                value
            }
            #[inline(always)]
            fn value(self) -> $t {
                self
            }
            #[inline(always)]
            fn derivative(self, _: usize) -> $t {
                0.0
            }
            #[inline(always)]
            fn with_derivative(self, _: usize, _: $t) -> $t {
                self
            }
            #[inline(always)]
            fn magnitude(self) -> $t {
                $t::abs(self)
            }
            #[inline(always)]
            fn scale(self, factor: $t) -> $t {
                self * factor
            }
            #[inline(always)]
            fn shift(self, term: $t) -> $t {
                self + term
            }
            #[inline(always)]
            fn chain(self, value: $t, _: $t) -> $t {
                value
            }
            #[inline(always)]
            fn join(self, _: $t, value: $t, _: [$t; 2]) -> $t {
                value
            }
            #[inline(always)]
            fn implicit(root: $t, _: impl FnOnce() -> $t, _: impl FnOnce($t) -> $t) -> $t {
                root
            }
            elementary!(exp, $t::exp, $exp);
            elementary!(ln, $t::ln, $ln);
            elementary!(ln_1p, $t::ln_1p, $ln_1p);
            elementary!(sqrt, $t::sqrt, $sqrt);
            elementary!(tan, $t::tan, $tan);
            elementary!(tanh, $t::tanh, $tanh);
            elementary!(atan, $t::atan, $atan);
            #[inline]
            fn powf(self, exponent: $t) -> $t {
                #[cfg(feature = "std")]
                return $t::powf(self, exponent);
                #[cfg(not(feature = "std"))]
                return $pow(self, exponent);
            }
        }

        impl Real for $t {
            const EPSILON: $t = $t::EPSILON;
            const SMALL: $t = $small;
            const VANISHED: $t = $vanished;
            const FLOOR: $t = $floor;
            const LEAST_NORMAL: $t = $t::MIN_POSITIVE;
            const LARGEST: $t = $largest;
            #[inline]
            fn to_bits(self) -> u64 {
                u64::from($t::to_bits(self))
            }
            #[inline]
            #[allow(clippy::cast_possible_truncation)]
            fn from_bits(bits: u64) -> $t {
                $t::from_bits(bits as _)
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation)]
            fn of(literal: f64) -> $t {
                literal as $t
            }
            #[inline]
            fn at_least(literal: f64) -> $t {
                let nearest = Self::of(literal);
                if f64::from(nearest) < literal { nearest.next_up() } else { nearest }
            }
            #[inline]
            fn at_most(literal: f64) -> $t {
                let nearest = Self::of(literal);
                if f64::from(nearest) > literal { nearest.next_down() } else { nearest }
            }
            #[inline(always)]
            fn abs(self) -> $t {
                $t::abs(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $t::is_finite(self)
            }
            #[inline(always)]
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            fn truncated(self) -> usize {
                self as usize
            }
        }
    };
}

// Truncation x⁷/8!: 5.6e-18 at 1/64, 2.6e-8 (0.2 units of f32) at 3/8.
real!(
    f32,
    0.375,
    1e-30,
    1e-20,
    1e15,
    libm::expf,
    libm::log1pf,
    libm::sqrtf,
    libm::tanf,
    libm::tanhf,
    libm::atanf,
    libm::powf,
    libm::logf
);
real!(
    f64,
    0.015625,
    1e-250,
    1e-200,
    1e150,
    libm::exp,
    libm::log1p,
    libm::sqrt,
    libm::tan,
    libm::tanh,
    libm::atan,
    libm::pow,
    libm::log
);
