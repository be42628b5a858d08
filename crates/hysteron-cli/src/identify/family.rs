//! Names of the hysteresis families on the command line.

use clap::ValueEnum;
use hysteron::hysteresis::{FamilyForm, HysteresisForm};

use crate::failure::Failure;

/// A family of hysteresis operators.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum HysteresisArg {
    /// Polynomial less one relaxing state: few parameters
    BoucWen,
    /// Polynomial and 12 plays: minor loops, exact inverse (this and the following: joint)
    PrandtlIshlinskii,
    /// Two Bouc-Wen states of unlike sharpness
    ParallelBoucWen,
    /// Bouc-Wen with a term that makes its loop asymmetric
    NonSymmetricBoucWen,
    /// Bouc-Wen with six coefficients
    SongDerKiureghian,
    /// One relaxing state with an exponent of its own
    Dahl,
    /// Coleman's and Hodgdon's equation with slopes up to u^2
    Duhem,
    /// 12 elastic elements that slip: plays in other coordinates
    MaxwellSlip,
    /// 12 plays for a drive to one side of rest
    OneSidedPlays,
    /// 8 plays behind saturating, unequal envelopes
    GeneralisedPlays,
    /// Ramped relays on a grid of 8 lines (36 weights)
    KrasnoselskiiPokrovskii,
    /// Relays on a plane of 10 intervals (55 weights)
    Preisach,
    /// Relays on a plane with a density of four numbers
    PreisachDensity,
    /// Jiles' and Atherton's magnetisation
    JilesAtherton,
}

/// Most elements of a family; a plane has a weight for every pair.
const MOST: usize = 60;
const MOST_OF_A_PLANE: usize = 16;

impl HysteresisArg {
    /// The family with so many elements.
    pub fn form(self, elements: Option<usize>) -> Result<HysteresisForm, Failure> {
        let count = |default: usize, most: usize| match elements {
            None => Ok(default),
            Some(n) if (1..=most).contains(&n) => Ok(n),
            Some(n) => Err(Failure::usage(format!("--elements {n}: this hysteresis has 1 to {most}"))),
        };
        let single = |form: FamilyForm| match elements {
            None => Ok(form),
            Some(_) => Err(Failure::usage("--elements: this hysteresis has a fixed number".to_owned())),
        };
        let family = match self {
            Self::BoucWen if elements.is_some() => {
                return Err(Failure::usage(
                    "--elements: bouc-wen has one state; take parallel-bouc-wen for more".to_owned(),
                ));
            }
            Self::BoucWen => return Ok(HysteresisForm::BoucWen),
            Self::PrandtlIshlinskii => {
                return Ok(HysteresisForm::PrandtlIshlinskii { plays: count(12, MOST)? });
            }
            Self::ParallelBoucWen => FamilyForm::ParallelBoucWen { states: count(2, 3)? },
            Self::NonSymmetricBoucWen => single(FamilyForm::NonSymmetricBoucWen)?,
            Self::SongDerKiureghian => single(FamilyForm::SongDerKiureghian)?,
            Self::Dahl => single(FamilyForm::Dahl)?,
            Self::Duhem => FamilyForm::Duhem { degree: count(2, 9)? },
            Self::MaxwellSlip => FamilyForm::MaxwellSlip { elements: count(12, MOST)? },
            Self::OneSidedPlays => FamilyForm::OneSidedPlays { plays: count(12, MOST)? },
            Self::GeneralisedPlays => FamilyForm::GeneralisedPlays { plays: count(8, MOST)? },
            Self::KrasnoselskiiPokrovskii => {
                FamilyForm::KrasnoselskiiPokrovskii { lines: count(8, MOST_OF_A_PLANE)? }
            }
            Self::Preisach => FamilyForm::Preisach { intervals: count(10, MOST_OF_A_PLANE)? },
            Self::PreisachDensity => single(FamilyForm::PreisachDensity)?,
            Self::JilesAtherton => single(FamilyForm::JilesAtherton)?,
        };
        Ok(HysteresisForm::Family(family))
    }
}
