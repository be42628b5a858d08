//! Interface of a branch law, and the two macros that generate the code common to all laws.

use crate::ParameterError;
use crate::real::{Real, Scalar};

/// The law of a branch: states y, weights w, v = Σ wⱼ yⱼ; s = sign Δu.
///
/// Its C fragment defines `branch_change`, and `branch_output` and `branch_virgin` where the law overrides
/// the provided methods of these names; its parameters there are `SHAPE[0]`, `SHAPE[1]`, …, in the order of
/// the fields. It may call `relaxation`, `log_distance`, `moments`, `rising_root` and the `increment` of a
/// [`crate::StateLaw`] with n = 1.
pub trait BranchLaw<S: Scalar> {
    /// The law in C99.
    const C: &'static str;
    /// Maximum number of states.
    const MOST_STATES: usize = 1;
    /// Whether valid parameters keep the states bounded under a bounded drive.
    const IS_BOUNDED: bool = true;

    /// Checks the parameters.
    ///
    /// # Errors
    /// [`ParameterError`] with the first number that is not finite or out of its range.
    fn check(&self) -> Result<(), ParameterError<S::Real>>;

    /// The states, virgin at `u`: all the same.
    #[inline(always)]
    fn virgin(&self, u: S) -> S {
        let _ = u;
        S::constant(S::Real::of(0.0))
    }

    /// Output of a state at `u`.
    #[inline(always)]
    fn output(&self, state: S, u: S) -> S {
        let _ = u;
        state
    }

    /// Change of the first state along a monotone move.
    fn increment(&self, y: S, from: S, to: S) -> S;

    /// Replaces every state by its change along a monotone move.
    #[inline(always)]
    fn increments(&self, states: &mut [S], from: S, to: S) {
        if let [y] = states {
            *y = self.increment(*y, from, to);
        }
    }
}

/// Checks one parameter.
#[inline(always)]
pub(super) fn number<T: Real>(
    name: &'static str,
    value: T,
    is_sound: bool,
    must: &'static str,
) -> Result<(), ParameterError<T>> {
    if is_sound { Ok(()) } else { Err(ParameterError::Number { name, value, must }) }
}

/// Checks that a parameter is finite.
pub(super) fn finite<T: Real>(name: &'static str, value: T) -> Result<(), ParameterError<T>> {
    number(name, value, value.is_finite(), "finite")
}

/// Checks that a parameter is finite and above 0.
pub(super) fn positive<T: Real>(name: &'static str, value: T) -> Result<(), ParameterError<T>> {
    number(name, value, value.is_finite() && value > T::of(0.0), "positive and finite")
}

/// Checks that a parameter is finite and not below 0.
pub(super) fn not_negative<T: Real>(name: &'static str, value: T) -> Result<(), ParameterError<T>> {
    number(name, value, value.is_finite() && value >= T::of(0.0), "finite and not negative")
}

/// Defines a law by its parameters, generic in the number type.
macro_rules! law_numbers {
    ($(#[$about:meta])* $law:ident { $($(#[$meaning:meta])* $number:ident),+ $(,)? }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $law<T> {
            $($(#[$meaning])* pub $number: T,)+
        }

        impl<S: Scalar> $law<S> {
            /// Names of the parameters.
            pub const NUMBERS: &'static [&'static str] = &[$(stringify!($number)),+];

            /// The law with these parameters, in the order of the fields; NaN for a missing one.
            #[inline(always)]
            pub fn of(numbers: &[S]) -> Self {
                let mut numbers = numbers.iter();
                $(let $number = numbers.next().copied().unwrap_or(S::constant(S::Real::of(f64::NAN)));)+
                Self { $($number),+ }
            }
        }

        impl<T: Copy> $law<T> {
            /// The law with its parameters mapped.
            pub(super) fn map<U>(self, of: impl Fn(T) -> U) -> $law<U> {
                $law { $($number: of(self.$number)),+ }
            }

            /// Calls `each` with every parameter and its name.
            pub(super) fn for_each_number(&self, mut each: impl FnMut(&'static str, T)) {
                $(each(stringify!($number), self.$number);)+
            }
        }
    };
}
pub(super) use law_numbers;

/// Defines the enum of all branch laws.
macro_rules! branch_laws {
    ($($file:ident::$law:ident),+ $(,)?) => {
        $(pub use $file::$law;)+

        /// The law of one branch; states y, weights w, v = Σ wⱼ yⱼ.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Branch<T> {
            $(#[doc = concat!("[`", stringify!($law), "`].")] $law($law<T>),)+
        }

        $(impl<T> From<$law<T>> for Branch<T> {
            fn from(law: $law<T>) -> Self {
                Self::$law(law)
            }
        })+

        impl<T: Copy> Branch<T> {
            /// The law with its parameters mapped, e.g. to another number type.
            pub fn map<U>(self, of: impl Fn(T) -> U) -> Branch<U> {
                match self { $(Self::$law(law) => Branch::$law(law.map(of)),)+ }
            }

            /// Calls `each` with every parameter and its name, in the order of the fields.
            pub fn for_each_number(&self, each: impl FnMut(&'static str, T)) {
                match self { $(Self::$law(law) => law.for_each_number(each),)+ }
            }

            /// Name of the law's type.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$law(_) => stringify!($law),)+ }
            }
        }

        impl<T: Real> Branch<T> {
            /// C99 template of the law: `R(x)` is a number, `F(f)` a function of `<math.h>`, `SHAPE` the
            /// parameters of the law.
            pub fn c_fragment(&self) -> &'static str {
                match self { $(Self::$law(_) => <$law<T> as BranchLaw<T>>::C,)+ }
            }

            /// Whether the parameters are valid and the law supports this number of states.
            pub(crate) fn is_sound(&self, states: usize) -> bool {
                match self {
                    $(Self::$law(law) => {
                        (1..=<$law<T> as BranchLaw<T>>::MOST_STATES).contains(&states) && law.check().is_ok()
                    })+
                }
            }

            /// The states, virgin at `u`: all the same.
            #[inline(always)]
            pub(crate) fn virgin(&self, u: T) -> T {
                match self { $(Self::$law(law) => law.virgin(u),)+ }
            }

            /// Output of a state at `u`.
            #[inline(always)]
            fn output(&self, state: T, u: T) -> T {
                match self { $(Self::$law(law) => law.output(state, u),)+ }
            }

            /// Replaces every state by its change along a monotone move.
            #[inline(always)]
            fn increments(&self, states: &mut [T], from: T, to: T) {
                match self { $(Self::$law(law) => law.increments(states, from, to),)+ }
            }
        }
    };
}
pub(super) use branch_laws;
