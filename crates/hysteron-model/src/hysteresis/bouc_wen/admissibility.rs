//! Boundedness of a Bouc–Wen parameter set.

use hysteron_numeric::display::short;
use std::fmt::{Display, Formatter};

use super::UnitShape;

/// Verdict on a parameter set, from the unit-α form (β', γ', n). It is reported, never a silent constraint.
///
/// Moving away from 0, dζ/du = 1 − (β' + γ')|ζ|ⁿ; moving back towards 0 after a reversal, 1 + (β' − γ')|ζ|ⁿ.
/// Classes after F. Ikhouane, V. Mañosa, J. Rodellar, *Nonlinear Dynamics* 42 (2005) 63–78,
/// doi:10.1007/s11071-005-0069-3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admissibility {
    /// β' + γ' > 0 and β' − γ' ≥ 0: z is bounded for every drive and every start.
    Bounded {
        /// |z| saturates at |α| times this \[V\]: (β' + γ')^(−1/n).
        saturation_v: f64,
    },
    /// β' + γ' > 0, β' − γ' < 0, β' ≥ 0: bounded from every start with |ζ| ≤ `limit_v`, from rest in
    /// particular.
    BoundedFromRest {
        /// |z| saturates at |α| times this \[V\].
        saturation_v: f64,
        /// Largest |ζ| to start from \[V\]: (γ' − β')^(−1/n).
        limit_v: f64,
    },
    /// β' + γ' > 0 but β' < γ' and β' < 0: z diverges after a reversal from saturation.
    UnboundedAfterReversal,
    /// β' + γ' = 0: no saturation, z grows in proportion to the drive.
    NoSaturation,
    /// β' + γ' < 0 (hardening): z grows ever faster with the drive; for n > 1 it is infinite at a finite
    /// voltage.
    Hardening,
}

impl Admissibility {
    /// The verdict on a shape.
    pub fn of(shape: UnitShape) -> Self {
        let UnitShape { beta, gamma, n } = shape;
        let out = beta + gamma;
        let back = beta - gamma;
        if out < 0.0 || out.is_nan() {
            return Self::Hardening;
        }
        if out == 0.0 {
            return if back < 0.0 { Self::UnboundedAfterReversal } else { Self::NoSaturation };
        }
        let saturation_v = out.powf(-1.0 / n);
        if back >= 0.0 {
            Self::Bounded { saturation_v }
        } else if beta >= 0.0 {
            Self::BoundedFromRest { saturation_v, limit_v: (-back).powf(-1.0 / n) }
        } else {
            Self::UnboundedAfterReversal
        }
    }

    /// In the bounded-input bounded-output class: the only verdict without a condition.
    pub fn is_bounded(&self) -> bool {
        matches!(self, Self::Bounded { .. })
    }
}

impl Display for Admissibility {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bounded { saturation_v } => write!(
                f,
                "bounded: the hysteretic part stays finite for every drive (it saturates at {} times α)",
                short(*saturation_v)
            ),
            Self::BoundedFromRest { saturation_v, limit_v } => write!(
                f,
                "bounded from rest: the hysteretic part stays finite for every drive as long as it starts \
                 below {} times α (it saturates at {} times α)",
                short(*limit_v),
                short(*saturation_v)
            ),
            Self::UnboundedAfterReversal => {
                write!(f, "not bounded: reversing a large drive can make the hysteretic part run away")
            }
            Self::NoSaturation => {
                write!(
                    f,
                    "not bounded: the hysteretic part does not saturate but grows in proportion to the drive"
                )
            }
            Self::Hardening => write!(
                f,
                "not bounded (hardening): the hysteretic part grows ever faster with the drive; do not use \
                 the model beyond the inputs it was identified on"
            ),
        }
    }
}
