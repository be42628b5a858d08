//! Coleman's and Hodgdon's law: Duhem's model with relaxing states, by the moments of a relaxation.

use super::law::{BranchLaw, law_numbers, positive};
use super::moments::{MOST_MOMENTS, moments};
use crate::ParameterError;
use crate::real::{Real, Scalar};
use crate::series::absolute;

law_numbers! {
    /// dyⱼ/du = uʲ − s `rate` yⱼ, j = 0, 1, … (B. D. Coleman, M. L. Hodgdon 1987, doi:10.1007/BF00282052):
    /// [`MOST_MOMENTS`] states at most, exact.
    Duhem {
        /// b > 0.
        rate,
    }
}

impl<S: Scalar> BranchLaw<S> for Duhem<S> {
    const C: &'static str = include_str!("duhem.c");
    const MOST_STATES: usize = MOST_MOMENTS;

    fn check(&self) -> Result<(), ParameterError<S::Real>> {
        positive("Duhem rate b", self.rate.value())
    }

    fn increment(&self, y: S, from: S, to: S) -> S {
        let ([own, ..], lost) = self.relaxation(1, from, to);
        own - lost * y
    }

    #[inline]
    fn increments(&self, states: &mut [S], from: S, to: S) {
        let (own, lost) = self.relaxation(states.len(), from, to);
        for (y, own) in states.iter_mut().zip(&own) {
            *y = *own - lost * *y;
        }
    }
}

impl<S: Scalar> Duhem<S> {
    /// For the change −yⱼ (1 − e^(−b|Δ|)) + Δ Σₖ (j over k) u₀ʲ⁻ᵏ Δᵏ mₖ(b|Δ|) of the states: its part
    /// independent of them, and the factor 1 − e^(−b|Δ|).
    #[inline(always)]
    pub fn relaxation(&self, states: usize, from: S, to: S) -> ([S; MOST_MOMENTS], S) {
        let by = to - from;
        let x = self.rate * absolute(by);
        let mut own = moments(x, states);
        // 1 − e⁻ˣ = x m₀.
        let [zeroth, ..] = own;
        let lost = x * zeroth;
        let mut power = by;
        for own in own.iter_mut().take(states) {
            *own = power * *own;
            power = power * by;
        }
        // Binomial sums in place: after pass j, place k ≥ j holds Σᵢ (j over i) u₀ʲ⁻ⁱ aₖ₋ⱼ₊ᵢ.
        for j in 1..states {
            for k in (j..states).rev() {
                if let Some([low, high]) = own.get_mut(k - 1..=k) {
                    *high = *high + from * *low;
                }
            }
        }
        (own, lost)
    }
}
