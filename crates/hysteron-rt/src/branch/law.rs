//! The interface of a law of one branch, and the two macros that write what every law has in common.

use super::MOST_MOMENTS;
use crate::increment::IncrementMemory;
use crate::real::Real;

/// Change of the states along a move: yⱼ by ownⱼ − lost yⱼ.
pub(super) struct Change<T> {
    pub lost: T,
    pub own: [T; MOST_MOMENTS],
}

impl<T: Real> Change<T> {
    /// Change of a single state by an increment.
    #[inline(always)]
    pub fn of_one(increment: T) -> Self {
        let mut own = [T::of(0.0); MOST_MOMENTS];
        if let Some(slot) = own.first_mut() {
            *slot = increment;
        }
        Self { lost: T::of(0.0), own }
    }
}

/// The law of a branch: states y, weights w, v = Σ wⱼ yⱼ; s = sign Δu.
///
/// Its C fragment defines `branch_change`, and `branch_output` and `branch_virgin` where the law does not
/// keep the provided methods of these names; its numbers are `SHAPE[0]`, `SHAPE[1]`, … there, in the order of
/// the fields. It may call `relaxation`, `log_distance`, `moments`, `rising_root` and the `increment` of a
/// Bouc–Wen operator with n = 1.
pub(super) trait BranchLaw<T: Real> {
    /// The law in C99.
    const C: &'static str;

    /// Whether the numbers are finite and in order, and the law has so many states.
    fn is_sound(&self, states: usize) -> bool;

    /// The states, virgin at `u`: all the same.
    #[inline(always)]
    fn virgin(&self, u: T) -> T {
        let _ = u;
        T::of(0.0)
    }

    /// Output of a state at `u`.
    #[inline(always)]
    fn output(&self, state: T, u: T) -> T {
        let _ = u;
        state
    }

    /// Change of the states along a monotone move.
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T>;
}

/// The single state of a law that has one.
#[inline(always)]
pub(super) fn single<T: Real>(memory: &[IncrementMemory<T>]) -> T {
    memory.first().map_or(T::of(0.0), IncrementMemory::z)
}

/// Finite and above 0.
#[inline(always)]
pub(super) fn is_positive<T: Real>(x: T) -> bool {
    x.is_finite() && x > T::of(0.0)
}

/// The numbers of a law, in one type of numbers.
macro_rules! law_numbers {
    ($(#[$about:meta])* $law:ident { $($(#[$meaning:meta])* $number:ident),+ $(,)? }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $law<T> {
            $($(#[$meaning])* pub $number: T,)+
        }

        impl<T: Copy> $law<T> {
            /// These numbers in another type.
            pub(super) fn map<U>(self, of: impl Fn(T) -> U) -> $law<U> {
                $law { $($number: of(self.$number)),+ }
            }

            /// Hands out every number with its name.
            pub(super) fn for_each_number(&self, mut each: impl FnMut(&'static str, T)) {
                $(each(stringify!($number), self.$number);)+
            }
        }
    };
}
pub(super) use law_numbers;

/// The laws of one branch as one type.
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
            /// The law with other numbers, or with these in another type.
            pub fn map<U>(self, of: impl Fn(T) -> U) -> Branch<U> {
                match self { $(Self::$law(law) => Branch::$law(law.map(of)),)+ }
            }

            /// Hands out every number of the law with its name, in the order of its fields.
            pub fn for_each_number(&self, each: impl FnMut(&'static str, T)) {
                match self { $(Self::$law(law) => law.for_each_number(each),)+ }
            }

            /// Name of the law's type.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$law(_) => stringify!($law),)+ }
            }
        }

        impl<T: Real> Branch<T> {
            /// The law in C99, to be filled in: `R(x)` is a number, `F(f)` a function of `<math.h>`, `SHAPE`
            /// the numbers of the law.
            pub fn c_fragment(&self) -> &'static str {
                match self { $(Self::$law(_) => <$law<T> as BranchLaw<T>>::C,)+ }
            }

            /// Whether the numbers are finite and in order, and the law has so many states.
            pub(crate) fn is_sound(&self, states: usize) -> bool {
                match self { $(Self::$law(law) => law.is_sound(states),)+ }
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

            /// Change of the states along a monotone move.
            #[inline(always)]
            fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
                match self { $(Self::$law(law) => law.change(memory, from, to),)+ }
            }
        }
    };
}
pub(super) use branch_laws;
