//! A structure that can be compared: its dynamics, creep, polynomial degree, exponent, and family of hysteresis.

use std::fmt;
use std::str::FromStr;

use super::super::options::{Choice, DynamicsChoice, HIGHEST_DEGREE, Method, Options};
use crate::hysteresis::HysteresisForm;

/// Polynomial degree of a candidate that does not name one.
const USUAL_DEGREE: usize = 3;

/// One structure: `BLOCK[+creep][+degreeN][+n-free][+FAMILY]`, e.g. `fractional`, `integer2+creep`, `none+degree1`,
/// `fractional+n-free`, `integer2+creep+prandtl-ishlinskii`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Dynamic block.
    pub block: Block,
    /// Has a creep factor 1 + k s^−μ.
    pub creep: bool,
    /// Polynomial degree of l\[u\].
    pub degree: usize,
    /// The Bouc–Wen exponent n is searched instead of held at 1.
    pub n_free: bool,
    /// Family of the hysteresis block.
    pub hysteresis: HysteresisForm,
}

/// Dynamic block of a [`Candidate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// Static model with delay.
    None,
    /// Integer-order dynamics of this many poles, 1 to 4.
    Integer(usize),
    /// Autoregressive (identified in two steps).
    Arx,
    /// b / (s^α₂ + c₁ s^α₁ + c₀).
    Fractional,
    /// b / (s^α₂ + c₁ s^α₁ + c₀ s^α₀).
    FractionalFreeLowest,
    /// Two fractional modes in parallel.
    TwoFractional,
}

impl Block {
    /// Every block, simple before rich.
    pub const ALL: [Self; 9] = [
        Self::None,
        Self::Integer(1),
        Self::Integer(2),
        Self::Integer(3),
        Self::Integer(4),
        Self::Arx,
        Self::Fractional,
        Self::FractionalFreeLowest,
        Self::TwoFractional,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Integer(1) => "integer1",
            Self::Integer(2) => "integer2",
            Self::Integer(3) => "integer3",
            Self::Integer(_) => "integer4",
            Self::Arx => "arx",
            Self::Fractional => "fractional",
            Self::FractionalFreeLowest => "fractional-free-lowest",
            Self::TwoFractional => "two-fractional",
        }
    }
}

/// A name that is no [`Candidate`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{name}' is no structure: expected BLOCK[+creep][+degreeN][+n-free][+FAMILY] with BLOCK one of {}, N from 1 to \
     {HIGHEST_DEGREE}, FAMILY (n-free is bouc-wen's own) one of {}, and neither creep nor another family than bouc-wen with \
     arx; e.g. integer2+creep",
    Block::ALL.map(Block::name).join(", "),
    HysteresisForm::usual().map(HysteresisForm::name).join(", ")
)]
pub struct UnknownCandidate {
    /// As given.
    pub name: String,
}

impl Candidate {
    /// This block with a cubic polynomial and n = 1, without creep.
    pub fn of(block: Block) -> Self {
        Self { block, creep: false, degree: USUAL_DEGREE, n_free: false, hysteresis: HysteresisForm::BoucWen }
    }

    /// The same dynamics with creep, with every other polynomial degree up to 5, and with n free.
    pub fn variants(self) -> Vec<Self> {
        let mut list = Vec::new();
        if self.block != Block::Arx && !self.creep {
            list.push(Self { creep: true, ..self });
        }
        list.extend((1..=5).filter(|d| *d != self.degree).map(|degree| Self { degree, ..self }));
        if !self.n_free && self.hysteresis == HysteresisForm::BoucWen {
            list.push(Self { n_free: true, ..self });
        }
        list
    }

    /// `base` with this structure.
    pub fn options(self, base: &Options) -> Options {
        let (dynamics, order) = match self.block {
            Block::None => (DynamicsChoice::None, 2),
            Block::Integer(order) => (DynamicsChoice::Integer, order),
            Block::Arx => (DynamicsChoice::Arx, 2),
            Block::Fractional => (DynamicsChoice::Fractional, 2),
            Block::FractionalFreeLowest => (DynamicsChoice::FractionalFreeLowest, 2),
            Block::TwoFractional => (DynamicsChoice::TwoFractional, 2),
        };
        Options {
            method: if self.block == Block::Arx { Method::TwoStep } else { Method::Joint },
            dynamics,
            order,
            creep: self.creep,
            hysteresis: self.hysteresis,
            degree: Choice::Given(self.degree),
            n: if self.n_free { Choice::Auto } else { Choice::Given(1.0) },
            ..base.clone()
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.block.name())?;
        if self.creep {
            f.write_str("+creep")?;
        }
        if self.degree != USUAL_DEGREE {
            write!(f, "+degree{}", self.degree)?;
        }
        if self.n_free {
            f.write_str("+n-free")?;
        }
        if self.hysteresis != HysteresisForm::BoucWen {
            write!(f, "+{}", self.hysteresis.name())?;
        }
        Ok(())
    }
}

impl FromStr for Candidate {
    type Err = UnknownCandidate;

    fn from_str(text: &str) -> Result<Self, UnknownCandidate> {
        let unknown = || UnknownCandidate { name: text.to_owned() };
        let mut words = text.trim().split('+');
        let first = words.next().unwrap_or_default();
        let block = Block::ALL.into_iter().find(|b| b.name() == first).ok_or_else(unknown)?;
        let mut candidate = Self::of(block);
        for word in words {
            match (word, word.strip_prefix("degree").map(str::parse)) {
                ("creep", _) if block != Block::Arx => candidate.creep = true,
                ("n-free", _) => candidate.n_free = true,
                (_, Some(Ok(degree))) if (1..=HIGHEST_DEGREE).contains(&degree) => candidate.degree = degree,
                _ => {
                    let family = HysteresisForm::usual().into_iter().find(|form| form.name() == word);
                    candidate.hysteresis = family.ok_or_else(unknown)?;
                }
            }
        }
        let of_bouc_wen = candidate.n_free || block == Block::Arx;
        if of_bouc_wen && candidate.hysteresis != HysteresisForm::BoucWen {
            return Err(unknown());
        }
        Ok(candidate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_and_its_structure_are_one_to_one() {
        for block in Block::ALL {
            let base = Candidate::of(block);
            for candidate in base.variants().into_iter().chain([base]) {
                assert_eq!(candidate.to_string().parse(), Ok(candidate));
            }
        }
        let full: Candidate = "integer4+n-free+degree1+creep".parse().unwrap();
        assert_eq!(
            full,
            Candidate { creep: true, degree: 1, n_free: true, ..Candidate::of(Block::Integer(4)) }
        );
        for hysteresis in HysteresisForm::usual() {
            let candidate = Candidate { hysteresis, creep: true, ..Candidate::of(Block::Fractional) };
            assert_eq!(candidate.to_string().parse(), Ok(candidate));
        }
    }

    #[test]
    fn a_name_that_is_no_structure_is_refused_with_those_there_are() {
        for name in [
            "",
            "fractal",
            "integer5",
            "integer",
            "arx+creep",
            "none+degree0",
            "none+degree10",
            "none+degree",
            "none+",
            "arx+dahl",
            "integer2+n-free+dahl",
        ] {
            let error = name.parse::<Candidate>().unwrap_err().to_string();
            assert!(error.contains(&format!("'{name}'")) && error.contains("two-fractional"), "{error}");
        }
    }
}
