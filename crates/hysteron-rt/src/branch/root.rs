//! Root of an increasing function.

use crate::real::Real;

/// Most evaluations: a Newton step that leaves the bracket is replaced by bisection.
const MOST: u8 = 80;

/// Root of a function that increases from `low` to `high`; `f` gives value and slope.
#[inline]
pub(super) fn rising_root<T: Real>(f: impl Fn(T) -> (T, T), mut low: T, mut high: T, start: T) -> T {
    let zero = T::of(0.0);
    let mut x = if start < low { low } else { start };
    x = if x > high { high } else { x };
    for _ in 0..MOST {
        let (value, slope) = f(x);
        if value == zero {
            return x;
        }
        if value > zero {
            high = x;
        } else {
            low = x;
        }
        let newton = x - value / slope;
        let next = if low < newton && newton < high { newton } else { T::of(0.5) * (low + high) };
        if (next - x).abs() <= T::of(2.0) * T::EPSILON * x.abs() || next <= low || next >= high {
            return next;
        }
        x = next;
    }
    x
}
