//! Piecewise-linear function of the mean of a bank of plays: Kuhnen's dead zones as bands.

use super::between;
use crate::ParameterError;
use crate::real::{Real, Scalar};

/// Σ wₖ bₖ(h) of the mean h = u + Σ gⱼ (Fⱼ − u) of plays Fⱼ, with corners c₁ < c₂ < …: band k is max(0, min(h
/// − cₖ, cₖ₊₁ − cₖ)), the outermost are unbounded: min(h − c₁, 0) and max(h − c_last, 0); there is one band
/// more than corners.
///
/// K. Kuhnen, *Eur. J. Control* 9 (2003) 407–418, doi:10.3166/ejc.9.407-418.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrokenLine<'a, T> {
    shares: &'a [T],
    corners: &'a [T],
    slopes: &'a [T],
}

impl<'a, T: Real> BrokenLine<'a, T> {
    /// Shares gⱼ, one a play; corners, at least one, increasing; slopes wₖ, one more.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn new(shares: &'a [T], corners: &'a [T], slopes: &'a [T]) -> Result<Self, ParameterError<T>> {
        if corners.is_empty() || slopes.len() != corners.len() + 1 {
            return Err(ParameterError::Lengths { thresholds: corners.len() + 1, weights: slopes.len() });
        }
        let mut above = T::of(f64::NEG_INFINITY);
        for (index, &value) in corners.iter().enumerate() {
            if !(value.is_finite() && value > above) {
                return Err(ParameterError::Threshold { index, value, above });
            }
            above = value;
        }
        for (index, &value) in shares.iter().chain(slopes).enumerate() {
            if !value.is_finite() {
                return Err(ParameterError::Weight { index, value });
            }
        }
        Ok(Self { shares, corners, slopes })
    }

    /// Shares of the plays.
    pub fn shares(&self) -> &'a [T] {
        self.shares
    }

    /// Its value at h.
    #[inline]
    pub fn at(&self, h: T) -> T {
        let (mut sum, mut slopes) = (T::of(0.0), self.slopes.iter());
        each_band(self.corners, h, |band| {
            if let Some(slope) = slopes.next() {
                sum = sum + *slope * band;
            }
        });
        sum
    }
}

/// Calls `take` with the bands of h, one more than corners: min(h − c₁, 0), max(0, min(h − cₖ, cₖ₊₁ − cₖ)),
/// …, max(h − c_last, 0).
#[inline(always)]
pub fn each_band<S: Scalar>(corners: &[S::Real], h: S, mut take: impl FnMut(S)) {
    let Some((&first, inner)) = corners.split_first() else { return };
    let mut band = |low, high, zero: S::Real| {
        take(between([S::constant(low), S::constant(high)], h).shift(-zero));
    };
    band(S::Real::of(f64::NEG_INFINITY), first, first);
    let mut low = first;
    for &high in inner {
        band(low, high, low);
        low = high;
    }
    band(low, S::Real::of(f64::INFINITY), low);
}
