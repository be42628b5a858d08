//! Static hysteresis block: rate-independent operators, one file a model behind one enum.
//!
//! * [`BoucWen`] (article Eq. 1) and its [`UnitShape`], the two or three numbers that enter nonlinearly.
//! * [`NormalisedBoucWen`], [`ClassicalBoucWen`]: the same operator in other symbols.
//! * [`PrandtlIshlinskii`] (plays) with its inverses, a model of its own beside the enum, and [`PlayStart`].
//! * [`ColumnKernel`]: families that are linear in weights, with a few nonlinear numbers, and [`ColumnModel`]: [`Duhem`],
//!   [`Dahl`], [`Plays`], [`OneSidedPlays`], [`MaxwellSlip`],
//!   [`GeneralisedPlays`], [`DeadZones`], [`KrasnoselskiiPokrovskii`], [`Preisach`],
//!   [`PreisachDensity`], [`JilesAtherton`], [`SongDerKiureghian`], [`NonSymmetricBoucWen`]; [`ModifiedPrandtlIshlinskii`] is a cascade.
//! * [`Sensitivities`]: ζ with its derivatives, in one pass.
//! * [`Start`]: where an operator stands before the first sample.
//! * [`InterSample`]: how the drive goes from one sample to the next.
//! * [`Admissibility`]: whether a parameter set can run away.

mod admissibility;
mod asymmetric_bouc_wen;
pub mod bouc_wen;
mod bouc_wen_forms;
mod columns;
mod dahl;
mod dead_zones;
mod duhem;
mod error;
mod generalised_play;
mod inter_sample;
mod jiles_atherton;
mod krasnoselskii_pokrovskii;
mod maxwell_slip;
mod pass;
mod plays;
mod polynomial;
mod prandtl_ishlinskii;
mod preisach;
mod sensitivities;

pub use crate::record::InterSample;
pub use admissibility::Admissibility;
pub use asymmetric_bouc_wen::{NonSymmetricBoucWen, SongDerKiureghian};
pub use bouc_wen::{BoucWen, BoucWenState, UnitShape};
pub use bouc_wen_forms::{ClassicalBoucWen, NormalisedBoucWen};
pub use columns::{ColumnKernel, ColumnModel, ColumnSensitivities, ColumnStart, MOST_SHAPE_PARAMETERS};
pub use dahl::Dahl;
pub use dead_zones::{BrokenLine, DeadZones, ModifiedInverse, ModifiedPrandtlIshlinskii};
pub use duhem::Duhem;
pub use error::HysteresisError;
pub use generalised_play::{GeneralisedPlayStates, GeneralisedPlays};
pub use inter_sample::RecordEnds;
pub(crate) use inter_sample::polygon_of_means;
pub use jiles_atherton::JilesAtherton;
pub use krasnoselskii_pokrovskii::KrasnoselskiiPokrovskii;
pub use maxwell_slip::MaxwellSlip;
pub use plays::{OneSidedPlays, Plays};
pub use prandtl_ishlinskii::{PlayStart, PrandtlIshlinskii, StepInverse};
pub use preisach::{DensityLaw, Preisach, PreisachDensity, ReversalCurve};
pub use sensitivities::Sensitivities;

/// A rate-independent hysteresis operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Hysteresis {
    /// Bouc–Wen, article Eq. 1.
    BoucWen(BoucWen),
}

/// Where a hysteresis operator stands before the first sample of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// Virgin (z = 0) at the rest voltage `u` \[V\], from which the first sample is reached by a monotone move.
    Rest {
        /// Rest voltage \[V\], in general not the first sample.
        u: f64,
    },
    /// A known state, e.g. the one a previous record ended in; the first sample is reached by a monotone move.
    State(BoucWenState),
    /// Steady state of the record repeated for ever; the record must be a whole number of periods.
    Periodic,
}

impl Hysteresis {
    /// Checks the parameters.
    ///
    /// # Errors
    /// As the model's own `validate`.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        match self {
            Self::BoucWen(model) => model.validate(),
        }
    }

    /// Output v \[µm\] for the voltages `u` \[V\] into `out` (same length); returns the state at the last sample. Moves
    /// between samples are monotone ([`InterSample::Linear`] and [`InterSample::Hold`] alike). Allocates nothing.
    ///
    /// # Errors
    /// As [`BoucWen::simulate`].
    pub fn simulate(
        &self,
        u: &[f64],
        start: Start,
        out: &mut [f64],
    ) -> Result<BoucWenState, HysteresisError> {
        self.simulate_every(1, u, start, out)
    }

    /// As [`Self::simulate`] for a drive `u` given on a time base finer by `factor` ([`InterSample::upsample`]):
    /// `out[k]` belongs to `u[k * factor]`.
    ///
    /// # Errors
    /// As [`BoucWen::simulate`].
    pub fn simulate_every(
        &self,
        factor: usize,
        u: &[f64],
        start: Start,
        out: &mut [f64],
    ) -> Result<BoucWenState, HysteresisError> {
        match self {
            Self::BoucWen(model) => model.simulate_every(factor, u, start, out),
        }
    }

    /// The anhysteretic polynomial l\[u\] \[µm\] at the voltage `u` \[V\].
    pub fn polynomial_at(&self, u: f64) -> f64 {
        match self {
            Self::BoucWen(model) => model.polynomial_at(u),
        }
    }
}
