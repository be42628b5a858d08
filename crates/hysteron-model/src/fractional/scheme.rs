//! The discretisation schemes and their δ(z).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

use crate::unknown_name::UnknownName;
use hysteron_numeric::Complex64;

/// Discretisation of a transfer function in s: convolution quadrature, s → δ(z)/h, with z the unit delay and
/// h the sample period (`docs/theory/fractional.md`).
///
/// All three substitutions map |z| < 1 into the right half-plane. Error of the simulated article Eq. 13 on
/// a 1–100 Hz chirp at 10 kHz: 1.7e-2, 7.2e-4 and 1.8e-4 of the maximum for `GrunwaldLetnikov`, `Bdf2` and
/// `Tustin` (`tests/scheme_errors.rs`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// δ = 2(1 − z)/(1 + z): second order, for proper transfer functions.
    #[default]
    Tustin,
    /// δ = 1 − z: the article's (Eq. 3), first order. Parameters belong to the sample rate they were
    /// identified at.
    GrunwaldLetnikov,
    /// δ = (1 − z) + (1 − z)²/2: second order, damps the highest frequencies.
    Bdf2,
    /// No substitution: G at s = σ + iω by damped Fourier inversion; exact for a band-limited input.
    BandLimited,
}

impl Scheme {
    /// Every scheme.
    pub const ALL: [Self; 4] = [Self::Tustin, Self::GrunwaldLetnikov, Self::Bdf2, Self::BandLimited];

    /// Name as on the command line and in a model file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Tustin => "tustin",
            Self::GrunwaldLetnikov => "grunwald-letnikov",
            Self::Bdf2 => "bdf2",
            Self::BandLimited => "band-limited",
        }
    }

    /// One-line description.
    pub const fn summary(self) -> &'static str {
        match self {
            Self::Tustin => "s = 2 (1 - z)/(h (1 + z)): second order",
            Self::GrunwaldLetnikov => {
                "s = (1 - z)/h, the article's: first order, parameters belong to one sample rate"
            }
            Self::Bdf2 => "s = ((1 - z) + (1 - z)^2/2)/h: second order, damps the highest frequencies",
            Self::BandLimited => "No substitution: exact for a band-limited input",
        }
    }

    /// True if parameters identified under this scheme hold at their own sample rate only: for
    /// `GrunwaldLetnikov`, whose parameters absorb its first-order error (`docs/theory/fractional.md`).
    pub const fn parameters_belong_to_sample_rate(self) -> bool {
        matches!(self, Self::GrunwaldLetnikov)
    }

    /// True if a plant that is unstable in continuous time may be stable under this scheme: δ maps the unit
    /// disc into a part of the right half-plane (`Tustin`: onto all of it).
    pub const fn may_damp(self) -> bool {
        matches!(self, Self::GrunwaldLetnikov | Self::Bdf2)
    }

    /// δ(z); for `BandLimited` −ln z, what the other three approximate.
    pub fn delta(self, z: Complex64) -> Complex64 {
        let one_minus = 1.0 - z;
        match self {
            Self::Tustin => 2.0 * one_minus / (1.0 + z),
            Self::GrunwaldLetnikov => one_minus,
            Self::Bdf2 => one_minus * (3.0 - z) * 0.5,
            Self::BandLimited => -z.ln(),
        }
    }

    /// (ln |δ|, arg δ) at z = exp(−damping − i·angle), damping ≥ 0, 0 ≤ angle ≤ π, without the
    /// cancellation of 1 − z near z = 1. The argument lies in \[0, π/2\] and is exactly 0 at angles 0 and π
    /// (π only for the three substitutions; there with damping 0, `Tustin` is infinite).
    pub fn log_delta(self, damping: f64, angle: f64) -> (f64, f64) {
        if self == Self::BandLimited {
            return (damping.hypot(angle).ln(), angle.atan2(damping));
        }
        let radius = (-damping).exp();
        let (sin, cos) = if angle == std::f64::consts::PI { (0.0, -1.0) } else { angle.sin_cos() };
        let half_sin = (0.5 * angle).sin();
        let half_cos = if cos == -1.0 { 0.0 } else { (0.5 * angle).cos() };
        let gap = -(-damping).exp_m1();
        let log_polar = |re: f64, im: f64| (re.hypot(im).ln(), im.atan2(re));
        let one_minus = log_polar(gap + 2.0 * radius * half_sin * half_sin, radius * sin);
        match self {
            Self::GrunwaldLetnikov | Self::BandLimited => one_minus,
            Self::Bdf2 => {
                let other = log_polar(3.0 - radius * cos, radius * sin);
                (one_minus.0 + other.0 - std::f64::consts::LN_2, one_minus.1 + other.1)
            }
            Self::Tustin => {
                let one_plus = log_polar(gap + 2.0 * radius * half_cos * half_cos, -radius * sin);
                (one_minus.0 - one_plus.0 + std::f64::consts::LN_2, one_minus.1 - one_plus.1)
            }
        }
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Scheme {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("scheme", name, Self::ALL, Self::name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_delta_is_the_logarithm_of_delta() {
        for scheme in Scheme::ALL {
            for damping in [1e-3, 0.3, 1.0] {
                for angle in [0.0, 1e-3, 0.7, 2.0, 3.1] {
                    let (log_abs, arg) = scheme.log_delta(damping, angle);
                    let direct = scheme.delta(Complex64::from_polar((-damping).exp(), -angle)).ln();
                    assert!((log_abs - direct.re).abs() < 1e-12, "{scheme} {damping} {angle}");
                    assert!((arg - direct.im).abs() < 1e-12, "{scheme} {damping} {angle}");
                }
            }
            let (_, start) = scheme.log_delta(1e-4, 0.0);
            assert_eq!(start, 0.0);
            if scheme != Scheme::BandLimited {
                assert_eq!(scheme.log_delta(1e-4, std::f64::consts::PI).1, 0.0);
            }
        }
    }

    #[test]
    fn names_read_back() {
        for scheme in Scheme::ALL {
            assert_eq!(scheme.name().parse(), Ok(scheme));
        }
        assert!("euler".parse::<Scheme>().is_err());
    }
}
