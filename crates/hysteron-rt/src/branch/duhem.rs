//! Coleman's and Hodgdon's law: Duhem's model with relaxing states, by the moments of a relaxation.

use super::law::{BranchLaw, Change, is_positive, law_numbers};
use super::{MOST_MOMENTS, moments};
use crate::increment::IncrementMemory;
use crate::real::Real;
use crate::series::relaxation;

law_numbers! {
    /// dyⱼ/du = uʲ − s `rate` yⱼ, j = 0, 1, … (B. D. Coleman, M. L. Hodgdon 1987, doi:10.1007/BF00282052):
    /// [`MOST_MOMENTS`] states at most, exact.
    Duhem {
        /// b > 0.
        rate,
    }
}

impl<T: Real> BranchLaw<T> for Duhem<T> {
    const C: &'static str = include_str!("duhem.c");

    fn is_sound(&self, states: usize) -> bool {
        is_positive(self.rate) && states <= MOST_MOMENTS
    }

    #[inline(always)]
    fn change(&self, memory: &[IncrementMemory<T>], from: T, to: T) -> Change<T> {
        change(self.rate, memory.len(), from, to)
    }
}

/// yⱼ e^(−b|Δ|) + Δ Σₖ (j over k) u₀ʲ⁻ᵏ Δᵏ mₖ(b|Δ|).
#[inline]
fn change<T: Real>(rate: T, states: usize, from: T, to: T) -> Change<T> {
    let by = to - from;
    let x = rate * by.abs();
    let (_, lost) = relaxation(T::of(1.0), x);
    // Σₖ (j over k) u₀ʲ⁻ᵏ aₖ for every j: aₖ ← u₀ aₖ + aₖ₊₁ raises j by one.
    let mut a = moments(x, states);
    let mut power = by;
    for a in a.iter_mut().take(states) {
        *a = power * *a;
        power = power * by;
    }
    let mut own = [T::of(0.0); MOST_MOMENTS];
    for slot in own.iter_mut().take(states) {
        let [first, ..] = a;
        *slot = first;
        let mut rest = &mut a[..];
        while let [low, tail @ ..] = rest {
            *low = from * *low + tail.first().copied().unwrap_or(T::of(0.0));
            rest = tail;
        }
    }
    Change { lost, own }
}
