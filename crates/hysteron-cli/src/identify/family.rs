//! Names of the hysteresis families on the command line.

use clap::ValueEnum;
use hysteron_model::hysteresis::{FamilyForm, HysteresisForm};

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
    /// 12 plays that get wider with the rate of the drive
    RateDependentPlays,
    /// 12 plays and six bands of what they put out: minor loops that differ with bias
    DeadZonePlays,
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
        let usual = HysteresisForm::usual();
        let own = self.to_possible_value();
        let named =
            usual.into_iter().find(|form| own.as_ref().is_some_and(|own| own.get_name() == form.name()));
        let form = named.unwrap_or_default();
        let Some(count) = elements else { return Ok(form) };
        let within = |most: usize| {
            let refused = || Failure::usage(format!("--elements {count}: {} has 1 to {most}", form.name()));
            (1..=most).contains(&count).then_some(count).ok_or_else(refused)
        };
        let family = match form {
            HysteresisForm::PrandtlIshlinskii { .. } => {
                return Ok(HysteresisForm::PrandtlIshlinskii { plays: within(MOST)? });
            }
            HysteresisForm::Family(family) => family,
            HysteresisForm::BoucWen => {
                let hint = "bouc-wen has one state; take parallel-bouc-wen for more";
                return Err(Failure::usage(format!("--elements {count}: {hint}")));
            }
        };
        Ok(HysteresisForm::Family(match family {
            FamilyForm::ParallelBoucWen { .. } => FamilyForm::ParallelBoucWen { states: within(3)? },
            FamilyForm::Duhem { .. } => FamilyForm::Duhem { degree: within(9)? },
            FamilyForm::MaxwellSlip { .. } => FamilyForm::MaxwellSlip { elements: within(MOST)? },
            FamilyForm::OneSidedPlays { .. } => FamilyForm::OneSidedPlays { plays: within(MOST)? },
            FamilyForm::RateDependentPlays { .. } => FamilyForm::RateDependentPlays { plays: within(MOST)? },
            FamilyForm::DeadZonePlays { .. } => FamilyForm::DeadZonePlays { plays: within(MOST)? },
            FamilyForm::GeneralisedPlays { .. } => FamilyForm::GeneralisedPlays { plays: within(MOST)? },
            FamilyForm::KrasnoselskiiPokrovskii { .. } => {
                FamilyForm::KrasnoselskiiPokrovskii { lines: within(MOST_OF_A_PLANE)? }
            }
            FamilyForm::Preisach { .. } => FamilyForm::Preisach { intervals: within(MOST_OF_A_PLANE)? },
            FamilyForm::NonSymmetricBoucWen
            | FamilyForm::SongDerKiureghian
            | FamilyForm::Dahl
            | FamilyForm::PreisachDensity
            | FamilyForm::JilesAtherton => {
                let refused = format!("--elements {count}: {} has a fixed number", form.name());
                return Err(Failure::usage(refused));
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_of_the_library_has_its_name_here() {
        let names: Vec<&str> = HysteresisForm::usual().map(HysteresisForm::name).into();
        for (own, name) in HysteresisArg::value_variants().iter().zip(&names) {
            assert_eq!(own.to_possible_value().unwrap().get_name(), *name);
            assert_eq!(own.form(None).unwrap().name(), *name);
        }
        assert_eq!(HysteresisArg::value_variants().len(), names.len());
    }

    #[test]
    fn elements_beyond_a_family_are_refused() {
        assert_eq!(HysteresisArg::Preisach.form(Some(4)).unwrap().columns(), 10);
        for (family, elements) in [
            (HysteresisArg::BoucWen, 1),
            (HysteresisArg::Dahl, 1),
            (HysteresisArg::ParallelBoucWen, 4),
            (HysteresisArg::Preisach, 17),
            (HysteresisArg::PrandtlIshlinskii, 61),
        ] {
            assert!(family.form(Some(elements)).is_err());
        }
    }
}
