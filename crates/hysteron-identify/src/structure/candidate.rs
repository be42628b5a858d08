//! A candidate structure: dynamics, creep, polynomial degree, exponent, and family of hysteresis.

use std::fmt;
use std::str::FromStr;

use super::super::joint::RESONANCE_AND_LAG;
use super::super::options::{Choice, DynamicsChoice, FamilyChoice, HIGHEST_DEGREE, Method, Options};
use hysteron_model::dynamics::{Creep, MOST_INTEGER_POLES};
use hysteron_model::hysteresis::HysteresisForm;

/// Polynomial degree of a candidate that does not name one.
pub(super) const USUAL_DEGREE: usize = 3;
/// Highest degree compared by default.
const HIGHEST_USUAL_DEGREE: usize = 5;

/// With fewer poles the parallel form equals the series form.
const FEWEST_OF_MODES: usize = 4;
/// Names of the blocks.
const NAMES: &str = "none, integer1 to integer12, modes4 to modes12, arx, oe, bj, srivc, fractional, \
                     fractional-free-lowest, two-fractional";

fn creep(name: &str) -> Option<Creep> {
    Creep::USUAL.into_iter().find(|creep| creep.structure_name() == Some(name))
}

/// One structure: `BLOCK[+CREEP][+degreeN][+n-free][+FAMILY]`, e.g. `fractional`, `integer2+creep`,
/// `none+degree1`, `fractional+n-free`, `integer2+log-creep+FAMILY`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// Dynamic block.
    pub block: Block,
    /// Creep factor: `creep` is a fractional one, `log-creep`, `kelvin-voigt` (of two elements).
    pub creep: Creep,
    /// Polynomial degree of l\[u\].
    pub degree: usize,
    /// The exponent n of the family is searched instead of held at 1.
    pub n_free: bool,
    /// Family of the hysteresis block.
    pub hysteresis: HysteresisForm,
}

/// Dynamic block of a [`Candidate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Kind of dynamics; never [`DynamicsChoice::Auto`].
    pub dynamics: DynamicsChoice,
    /// Number of poles of [`DynamicsChoice::Integer`] (1 to 12) and [`DynamicsChoice::Modes`] (4 to 12, an
    /// odd one is a lag).
    pub order: usize,
}

/// Part of a structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StructurePart {
    /// The dynamic block.
    Block,
    /// The kind of creep.
    Creep,
    /// The family of hysteresis.
    Family,
    /// Degree of the polynomial, and the exponent n of the family.
    Shape,
}

impl StructurePart {
    /// All, in the order in which a search goes through them: dynamics show only behind the right family.
    pub const ALL: [Self; 4] = [Self::Family, Self::Block, Self::Creep, Self::Shape];
}

impl Block {
    /// Static model with delay.
    pub const NONE: Self = Self::of(DynamicsChoice::None);

    /// Blocks compared by default, simple before rich.
    pub const USUAL: [Self; 9] = [
        Self::NONE,
        Self::integer(1),
        Self::integer(2),
        Self::integer(3),
        Self::integer(4),
        Self::of(DynamicsChoice::Arx),
        Self::of(DynamicsChoice::Fractional),
        Self::of(DynamicsChoice::FractionalFreeLowest),
        Self::of(DynamicsChoice::TwoFractional),
    ];

    /// Blocks of a quick search.
    const COMMON: [Self; 3] = [Self::NONE, Self::integer(2), Self::of(DynamicsChoice::Fractional)];

    /// A block of this kind, with two poles where their number is free.
    pub const fn of(dynamics: DynamicsChoice) -> Self {
        Self { dynamics, order: 2 }
    }

    /// Integer-order dynamics with `order` poles.
    pub const fn integer(order: usize) -> Self {
        Self { dynamics: DynamicsChoice::Integer, order }
    }

    fn has_order(self) -> bool {
        matches!(self.dynamics, DynamicsChoice::Integer | DynamicsChoice::Modes)
    }

    /// True if it is identified in two steps.
    pub(super) fn takes_two_steps(self) -> bool {
        self.dynamics.takes_two_steps()
    }

    fn all() -> impl Iterator<Item = Self> {
        let integer = (1..=MOST_INTEGER_POLES).map(Self::integer);
        let modes = (FEWEST_OF_MODES..=MOST_INTEGER_POLES)
            .map(|order| Self { dynamics: DynamicsChoice::Modes, order });
        let regressions = [DynamicsChoice::OutputError, DynamicsChoice::BoxJenkins, DynamicsChoice::Srivc];
        Self::USUAL.into_iter().chain(integer).chain(modes).chain(regressions.map(Self::of))
    }

    /// The block of an identification with these options; with [`DynamicsChoice::Auto`] the one that its search
    /// begins with.
    pub(super) fn of_options(options: &Options) -> Self {
        if options.dynamics == DynamicsChoice::Auto {
            return Self::integer(RESONANCE_AND_LAG);
        }
        let block = Self { dynamics: options.dynamics, order: options.order };
        if block.has_order() { block } else { Self::of(options.dynamics) }
    }

    fn name(self) -> String {
        let order = if self.has_order() { self.order.to_string() } else { String::new() };
        self.dynamics.name().to_owned() + &order
    }
}

/// A name that is no [`Candidate`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "'{name}' is no structure: expected BLOCK[+CREEP][+degreeN][+n-free][+FAMILY] with BLOCK one of {}, \
     CREEP one of {}, N from 1 to {HIGHEST_DEGREE}, FAMILY (n-free is {usual}'s \
     own) one of {}, and neither creep nor another family than {usual} with arx, oe, bj and srivc; e.g. \
     integer2+creep",
    NAMES,
    Creep::USUAL.into_iter().filter_map(Creep::structure_name).collect::<Vec<_>>().join(", "),
    HysteresisForm::usual().into_iter().map(HysteresisForm::name).collect::<Vec<_>>().join(", "),
    usual = HysteresisForm::default().name(),
)]
pub struct UnknownCandidate {
    /// As given.
    pub name: String,
}

impl Candidate {
    /// This block with a cubic polynomial and n = 1, without creep.
    pub fn of(block: Block) -> Self {
        Self {
            block,
            creep: Creep::None,
            degree: USUAL_DEGREE,
            n_free: false,
            hysteresis: HysteresisForm::default(),
        }
    }

    /// This structure and those compared by default that differ from it in `part` alone. Blocks identified in
    /// two steps are combined with the default family without creep only.
    pub fn alternatives(self, part: StructurePart) -> Vec<Self> {
        let list: Vec<Self> = match part {
            StructurePart::Block => Block::USUAL.map(|block| self.with_block(block)).into(),
            StructurePart::Creep => {
                [Creep::None].into_iter().chain(Creep::USUAL).map(|creep| Self { creep, ..self }).collect()
            }
            StructurePart::Family => HysteresisForm::usual()
                .into_iter()
                .filter(|form| form.description().is_compared_unasked())
                .map(|hysteresis| Self { hysteresis, n_free: false, ..self })
                .collect(),
            StructurePart::Shape => {
                let degrees = (1..=HIGHEST_USUAL_DEGREE).map(|degree| Self { degree, ..self });
                let has_exponent = self.hysteresis.description().has_exponent();
                let free = has_exponent.then_some(Self { n_free: true, ..self });
                degrees.chain(free).collect()
            }
        };
        let of_its_own = |c: &Self| c.creep == Creep::None && c.hysteresis == HysteresisForm::default();
        list.into_iter().filter(|c| !c.block.takes_two_steps() || of_its_own(c)).collect()
    }

    /// True if both have this `part` in common.
    pub(super) fn shares(self, other: Self, part: StructurePart) -> bool {
        match part {
            StructurePart::Block => self.block == other.block,
            StructurePart::Creep => self.creep == other.creep,
            StructurePart::Family => self.hysteresis == other.hysteresis,
            StructurePart::Shape => (self.degree, self.n_free) == (other.degree, other.n_free),
        }
    }

    /// This structure with another block, which has its own hysteresis if it is identified in two steps.
    fn with_block(self, block: Block) -> Self {
        if block.takes_two_steps() {
            Self { degree: self.degree, ..Self::of(block) }
        } else {
            Self { block, ..self }
        }
    }

    /// The commonest of [`Self::alternatives`]: the default set for a quick search.
    pub fn common_alternatives(self, part: StructurePart) -> Vec<Self> {
        let is_common = |candidate: &Self| match part {
            StructurePart::Block => Block::COMMON.contains(&candidate.block),
            StructurePart::Creep => matches!(candidate.creep, Creep::None | Creep::Fractional),
            StructurePart::Family => true,
            StructurePart::Shape => !candidate.n_free && candidate.degree <= USUAL_DEGREE,
        };
        self.alternatives(part).into_iter().filter(is_common).collect()
    }

    /// `base` with this structure.
    pub fn options(self, base: &Options) -> Options {
        Options {
            method: if self.block.takes_two_steps() { Method::TwoStep } else { Method::Joint },
            dynamics: self.block.dynamics,
            order: self.block.order,
            creep: self.creep,
            hysteresis: FamilyChoice::Given(self.hysteresis),
            degree: Choice::Given(self.degree),
            n: if self.n_free { Choice::Auto } else { Choice::Given(1.0) },
            ..base.clone()
        }
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.block.name())?;
        if let Some(name) = self.creep.structure_name() {
            write!(f, "+{name}")?;
            if !Creep::USUAL.contains(&self.creep) {
                write!(f, " of {} elements", self.creep.elements())?;
            }
        }
        if self.degree != USUAL_DEGREE {
            write!(f, "+degree{}", self.degree)?;
        }
        if self.n_free {
            f.write_str("+n-free")?;
        }
        if self.hysteresis != HysteresisForm::default() {
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
        let block = Block::all().find(|b| b.name() == first).ok_or_else(unknown)?;
        let mut candidate = Self::of(block);
        for word in words {
            match (word, word.strip_prefix("degree").map(str::parse)) {
                (word, _) if !block.takes_two_steps() && creep(word).is_some() => {
                    candidate.creep = creep(word).unwrap_or_default();
                }
                ("n-free", _) => candidate.n_free = true,
                (_, Some(Ok(degree))) if (1..=HIGHEST_DEGREE).contains(&degree) => candidate.degree = degree,
                _ => {
                    let family = HysteresisForm::usual().into_iter().find(|form| form.name() == word);
                    candidate.hysteresis = family.ok_or_else(unknown)?;
                }
            }
        }
        let of_default_family = candidate.n_free || block.takes_two_steps();
        if of_default_family && candidate.hysteresis != HysteresisForm::default() {
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
        for block in Block::all() {
            let base = Candidate::of(block);
            for candidate in StructurePart::ALL.into_iter().flat_map(|part| base.alternatives(part)) {
                assert_eq!(candidate.to_string().parse(), Ok(candidate));
            }
        }
        let full: Candidate = "integer4+n-free+degree1+creep".parse().unwrap();
        assert_eq!(
            full,
            Candidate {
                creep: Creep::Fractional,
                degree: 1,
                n_free: true,
                ..Candidate::of(Block::integer(4))
            }
        );
        for hysteresis in HysteresisForm::usual() {
            let candidate = Candidate {
                hysteresis,
                creep: Creep::Fractional,
                ..Candidate::of(Block::of(DynamicsChoice::Fractional))
            };
            assert_eq!(candidate.to_string().parse(), Ok(candidate));
        }
    }

    #[test]
    fn alternatives_differ_in_their_part_alone() {
        let own: Candidate = "fractional+creep+degree2+n-free".parse().unwrap();
        let names = |of: Candidate, part| -> Vec<String> {
            of.alternatives(part).iter().map(ToString::to_string).collect()
        };
        let behind = |family: &str| format!("fractional+creep+degree2{family}");
        let unasked = HysteresisForm::usual().into_iter().filter(|f| f.description().is_compared_unasked());
        let families: Vec<String> = unasked
            .map(
                |form| if form == own.hysteresis { behind("") } else { behind(&format!("+{}", form.name())) },
            )
            .collect();
        assert!(families.len() > 1 && families[0] == behind(""), "{families:?}");
        assert_eq!(names(own, StructurePart::Family), families);
        let plays: Candidate = families[1].replace("+degree2", "").parse().unwrap();
        assert!(names(plays, StructurePart::Block).contains(&"arx".to_owned()));
        assert_eq!(names(plays, StructurePart::Block).len(), Block::USUAL.len());
        assert_eq!(names(plays, StructurePart::Shape).len(), 5);
        assert_eq!(names(own, StructurePart::Creep).len(), 4);
        let arx = Candidate::of(Block::of(DynamicsChoice::Arx));
        assert_eq!(
            (names(arx, StructurePart::Family), names(arx, StructurePart::Creep)),
            (vec!["arx".to_owned()], vec!["arx".to_owned()])
        );
        assert_eq!(names(arx, StructurePart::Shape).len(), 6);
    }

    #[test]
    fn a_name_that_is_no_structure_is_refused_with_those_there_are() {
        for name in [
            "",
            "fractal",
            "integer13",
            "modes2",
            "modes13",
            "integer",
            "arx+creep",
            "arx+log-creep",
            "srivc+creep",
            "integer2+slow-creep",
            "none+degree0",
            "none+degree10",
            "none+degree",
            "none+",
        ] {
            let error = name.parse::<Candidate>().unwrap_err().to_string();
            assert!(error.contains(&format!("'{name}'")) && error.contains("two-fractional"), "{error}");
        }
        for form in HysteresisForm::usual().into_iter().filter(|form| *form != HysteresisForm::default()) {
            let family = form.name();
            for block in ["oe", "arx", "integer2+n-free"] {
                assert!(format!("{block}+{family}").parse::<Candidate>().is_err(), "{block}+{family}");
            }
        }
    }
}
