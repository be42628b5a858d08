//! The closed set of algorithms behind one enum.

use super::{
    AbcOptions, CmaEsOptions, DeAbcOptions, DeOptions, LeastSquaresOptions, OptimizeError, PsoOptions,
    Settings,
};
use serde::{Deserialize, Serialize};

/// An algorithm with its options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// Refuses a population too small for its mutation.
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

/// Refuses a real option outside its range.
pub(super) fn check_option(
    option: &'static str,
    value: f64,
    allowed: bool,
    wanted: &'static str,
) -> Result<(), OptimizeError> {
    if allowed { Ok(()) } else { Err(OptimizeError::Option { option, value, wanted }) }
}
