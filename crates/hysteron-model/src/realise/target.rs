//! Target of a realisation: the response of the dynamic block in the batch simulation.

use std::f64::consts::PI;

use hysteron_rt::MOST_TAPS;

use crate::dynamics::{Arx, TransferFunction};
use crate::fractional::Scheme;
use hysteron_numeric::Complex64;

/// The response without delay, on one of two planes.
///
/// Under a scheme that replaces s by δ(q)/h the batch simulation is a response in q, and so is ARX. Under
/// `BandLimited` it is G on the imaginary axis; poles are fitted there, and the inter-sample behaviour of the
/// input is added exactly afterwards.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target<'a> {
    Continuous { g: &'a TransferFunction, rate_hz: f64 },
    Sampled { g: &'a TransferFunction, scheme: Scheme, rate_hz: f64 },
    Arx { arx: &'a Arx, first: usize },
}

/// A pole of a fit, which defines its first-order section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pole {
    /// p h on the s-plane, 1 − a on the q-plane. With an imaginary part above 0 it represents a pair.
    pub place: Complex64,
}

impl Pole {
    pub fn is_pair(self) -> bool {
        self.place.im != 0.0
    }

    fn conjugate(self) -> Self {
        Self { place: self.place.conj() }
    }
}

impl Target<'_> {
    pub fn is_continuous(self) -> bool {
        matches!(self, Self::Continuous { .. })
    }

    /// The response at the angle θ = ωh, above π on the s-plane alone.
    pub fn at(self, theta: f64) -> Complex64 {
        match self {
            Self::Continuous { g, rate_hz } => g.response_at(Complex64::new(0.0, theta * rate_hz)),
            Self::Sampled { g, scheme, rate_hz } => {
                let (log, angle) = scheme.log_delta(0.0, theta);
                if log.is_finite() {
                    g.response_at(Complex64::from_polar(log.exp() * rate_hz, angle))
                } else if log > 0.0 {
                    g.high_frequency_gain().into()
                } else {
                    g.dc_gain().into()
                }
            }
            Self::Arx { arx, first } => {
                let q = Complex64::from_polar(1.0, -theta);
                let horner =
                    |numbers: &[f64]| numbers.iter().rev().fold(Complex64::ZERO, |sum, &c| sum * q + c);
                horner(arx.b.get(first..).unwrap_or_default()) / (1.0 + q * horner(&arx.a))
            }
        }
    }

    /// Gain at zero frequency, infinite where there is none.
    pub fn at_rest(self) -> f64 {
        match self {
            Self::Continuous { g, .. } | Self::Sampled { g, .. } => g.dc_gain(),
            Self::Arx { arx, .. } => arx.dc_gain(),
        }
    }

    /// The section of a pole at the angle θ, 1 at rest: −ph/(iθ − ph), or q^taps (1 − a)/(1 − a q).
    fn section(self, pole: Pole, taps: usize, theta: f64) -> Complex64 {
        if self.is_continuous() {
            return -pole.place / (Complex64::new(0.0, theta) - pole.place);
        }
        let half = (0.5 * theta).sin();
        let one_minus_q = Complex64::new(2.0 * half * half, theta.sin());
        let q = Complex64::from_polar(1.0, -theta);
        q.powu(taps as u32) * pole.place / (one_minus_q + pole.place * q)
    }

    /// Basis functions of a pole at θ: one for a real pole, those of Re c and Im c for a pair.
    pub fn basis(self, pole: Pole, taps: usize, theta: f64) -> [Complex64; 2] {
        let own = self.section(pole, taps, theta);
        if !pole.is_pair() {
            return [own, Complex64::ZERO];
        }
        let other = self.section(pole.conjugate(), taps, theta);
        [0.5 * (own + other), 0.5 * Complex64::I * (own - other)]
    }

    /// The poles that represent a pole of G at `s` \[rad/s\], upper half-plane.
    pub fn poles_of(self, s: Complex64) -> Vec<Pole> {
        let (scheme, y) = match self {
            Self::Continuous { rate_hz, .. } => return vec![Pole { place: s / rate_hz }],
            Self::Sampled { scheme, rate_hz, .. } => (scheme, -s / rate_hz),
            Self::Arx { .. } => return Vec::new(),
        };
        let place = match scheme {
            Scheme::Tustin => y / (1.0 + 0.5 * y),
            Scheme::GrunwaldLetnikov => y / (1.0 + y),
            Scheme::Bdf2 => {
                // q = 2 ∓ √(1 − 2y), both on the sheet. The farther one, and all of the cut beyond y = ½,
                // where q is complex, have
                // |q| ≥ 2: taps represent them.
                if y.im == 0.0 && y.re >= 0.5 {
                    return Vec::new();
                }
                let beyond = 2.0 * y / (1.0 + (1.0 - 2.0 * y).sqrt());
                beyond / (1.0 + beyond)
            }
            Scheme::BandLimited => 1.0 - (-y).exp(),
        };
        vec![Pole { place: upper(real_if_close(place)) }]
    }

    /// Number of taps needed beside the poles.
    pub fn taps(self) -> usize {
        match self {
            Self::Continuous { .. } => 1,
            Self::Sampled { scheme: Scheme::Bdf2, .. } => MOST_TAPS - 1,
            Self::Sampled { .. } => 1,
            Self::Arx { arx, first } => {
                let last = arx.b.iter().rposition(|b| *b != 0.0).unwrap_or(first);
                let order = arx.a.iter().rposition(|a| *a != 0.0).map_or(0, |last| last + 1);
                (last - first + 1).saturating_sub(order).max(1)
            }
        }
    }

    /// True if there is a branch cut beside the poles.
    pub fn has_cut(self) -> bool {
        match self {
            Self::Continuous { g, .. } | Self::Sampled { g, .. } => !g.is_integer_order(),
            Self::Arx { .. } => false,
        }
    }

    /// |density| of the branch cut at x rad/s: that of G = … + ∫ ρ(x)/(s + x) dx.
    pub fn cut_density(self, x: f64) -> f64 {
        match self {
            Self::Continuous { g, .. } | Self::Sampled { g, .. } if self.has_cut() => {
                g.response_at(Complex64::new(-x, 0.0)).im.abs() / PI
            }
            _ => 0.0,
        }
    }
}

/// Drops an imaginary part that is only rounding.
pub(super) fn real_if_close(z: Complex64) -> Complex64 {
    if z.im.abs() < 1e-13 * z.norm() { z.re.into() } else { z }
}

fn upper(z: Complex64) -> Complex64 {
    if z.im < 0.0 { z.conj() } else { z }
}
