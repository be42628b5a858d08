//! The algorithms and their options.

use super::{
    AbcOptions, CmaEsOptions, DeAbcOptions, DeOptions, LeastSquaresOptions, OptimizeError, PsoOptions,
    Settings,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A name that no [`Algorithm`] has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no optimiser is called `{name}`: expected one of {known}")]
pub struct UnknownAlgorithm {
    /// The name given.
    pub name: String,
    /// The known names.
    pub known: String,
}

/// An algorithm with its options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Algorithm {
    /// The article's bee colony with differential mutation and chaotic scout.
    DeAbc(DeAbcOptions),
    /// Artificial bee colony.
    Abc(AbcOptions),
    /// Differential evolution rand/1/bin.
    De(DeOptions),
    /// Particle swarm.
    Pso(PsoOptions),
    /// Covariance matrix adaptation with restarts.
    CmaEs(CmaEsOptions),
    /// Bounded Levenberg–Marquardt from many starts.
    LeastSquares(LeastSquaresOptions),
}

impl Algorithm {
    /// Name as on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::DeAbc(_) => "de-abc",
            Self::Abc(_) => "abc",
            Self::De(_) => "de",
            Self::Pso(_) => "pso",
            Self::CmaEs(_) => "cma-es",
            Self::LeastSquares(_) => "least-squares",
        }
    }

    /// The algorithm of this name with default options except `population` (least squares: number of starts).
    ///
    /// # Errors
    /// [`UnknownAlgorithm`].
    pub fn called(name: &str, population: Option<usize>) -> Result<Self, UnknownAlgorithm> {
        let or = |default: usize| population.unwrap_or(default);
        let all = [
            Self::DeAbc(DeAbcOptions {
                population: or(DeAbcOptions::default().population),
                ..Default::default()
            }),
            Self::Abc(AbcOptions { population: or(AbcOptions::default().population), ..Default::default() }),
            Self::De(DeOptions { population: or(DeOptions::default().population), ..Default::default() }),
            Self::Pso(PsoOptions { population: or(PsoOptions::default().population), ..Default::default() }),
            Self::CmaEs(CmaEsOptions { population, ..Default::default() }),
            Self::LeastSquares(LeastSquaresOptions {
                starts: or(LeastSquaresOptions::default().starts),
                ..Default::default()
            }),
        ];
        let known = all.each_ref().map(Self::name);
        let unknown = || UnknownAlgorithm { name: name.to_owned(), known: known.join(", ") };
        all.into_iter().find(|one| one.name() == name).ok_or_else(unknown)
    }

    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        match self {
            Self::DeAbc(options) => options.validate(),
            Self::Abc(options) => options.validate(),
            Self::De(options) => options.validate(),
            Self::Pso(options) => options.validate(),
            Self::CmaEs(options) => options.validate(),
            Self::LeastSquares(options) => options.validate(),
        }
    }

    /// Most generations a run can take.
    pub(super) fn planned_generations(&self, settings: &Settings) -> usize {
        match self {
            Self::LeastSquares(options) => options.planned_iterations(settings),
            _ => settings.generations,
        }
    }
}

/// Rejects a population too small for its mutation.
pub(super) fn check_population(
    population: usize,
    least: usize,
    wanted: &'static str,
) -> Result<(), OptimizeError> {
    if population < least {
        return Err(OptimizeError::Option { option: "population", value: population as f64, wanted });
    }
    Ok(())
}

/// Rejects a real option outside its range.
pub(super) fn check_option(
    option: &'static str,
    value: f64,
    allowed: bool,
    wanted: &'static str,
) -> Result<(), OptimizeError> {
    if allowed { Ok(()) } else { Err(OptimizeError::Option { option, value, wanted }) }
}
