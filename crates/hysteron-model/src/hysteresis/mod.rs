//! Hysteresis block: operators, most of them rate independent, a file or folder for each family.
//!
//! * [`BoucWen`] (article Eq. 1) and its [`UnitShape`], the two or three numbers that enter nonlinearly.
//! * [`PrandtlIshlinskii`]: polynomial and plays, with their inverse.
//! * [`ColumnKernel`]: the operators of a family that is linear in weights, with a few nonlinear numbers.
//!   Each family has a file of its name here: its kernel, and its [`FamilyDescription`].
//! * [`HysteresisForm`]: a family as used by a fit, evaluated into [`Columns`] with their derivatives.
//! * [`Hysteresis`]: a model of such a family; [`FamilyStream`] runs it sample by sample. [`DriveGrid`] gives
//!   rate-dependent families the timing of the drive.
//! * [`crate::Start`]: the state before the first sample, with a memory in the operator's scale.
//! * [`InterSample`]: inter-sample behaviour of the drive.
//! * [`Admissibility`]: boundedness of a parameter set; [`Invertibility`]: whether every move raises the
//!   output.

mod activated_plays;
pub mod bouc_wen;
mod columns;
mod dahl;
mod dead_zone_plays;
mod drive_grid;
mod duhem;
mod error;
mod family;
mod follow;
mod generalised_play;
mod inter_sample;
mod invertibility;
mod jiles_atherton;
mod krasnoselskii_pokrovskii;
mod maxwell_slip;
mod non_symmetric_bouc_wen;
mod one_sided_plays;
mod outputs;
mod parallel_bouc_wen;
mod pass;
mod play_sums;
mod plays;
mod polynomial;
mod prandtl_ishlinskii;
mod preisach;
mod rate_dependent_plays;
mod song_der_kiureghian;
mod takacs;

pub use crate::record::InterSample;
pub use activated_plays::ActivatedPlays;
/// The hysteresis of the article (Eq. 1), for its two-step method and for models that are fixed to it.
pub use bouc_wen::BoucWen as ArticleOperator;
pub use bouc_wen::{Admissibility, BoucWen, BoucWenState, Sensitivities, UnitShape};
pub use columns::{ColumnKernel, ColumnSensitivities};
pub use dahl::Dahl;
pub use dead_zone_plays::DeadZonePlays;
pub use drive_grid::DriveGrid;
pub use duhem::Duhem;
pub use error::HysteresisError;
#[doc(hidden)]
pub use family::examples;
pub use family::{
    DriveSpan, Elements, FamilyDescription, FamilyStream, Hysteresis, HysteresisForm, MeanLine, ModelNumber,
    NumberUnit, Place, RuntimeOperator, Search, ShapeNumber,
};
pub use follow::{DriveLimits, Followed};
pub use generalised_play::{GeneralisedPlayStates, GeneralisedPlays};
pub use inter_sample::RecordEnds;
#[doc(hidden)]
pub use inter_sample::polygon_of_means;
pub use invertibility::{Invertibility, TimedDrive};
pub use jiles_atherton::JilesAtherton;
pub use krasnoselskii_pokrovskii::KrasnoselskiiPokrovskii;
pub use maxwell_slip::MaxwellSlip;
pub use non_symmetric_bouc_wen::NonSymmetricBoucWen;
pub use one_sided_plays::OneSidedPlays;
pub use outputs::{Columns, Partial};
pub use parallel_bouc_wen::ParallelBoucWen;
pub use polynomial::polynomial_name;
/// The sum of plays that other families may be equal to.
use prandtl_ishlinskii::PrandtlIshlinskii as PlaySum;
pub use prandtl_ishlinskii::{PrandtlIshlinskii, StepInverse};
pub use preisach::{DensityLaw, Preisach, PreisachDensity};
pub use rate_dependent_plays::RateDependentPlays;
pub use song_der_kiureghian::SongDerKiureghian;

/// The list of families, in the order in which they are shown to users, the article's first. A new one is
/// a line here, its own file with its `mod`, and the law of its moves in `hysteron-rt`.
static FAMILIES: &[&dyn family::ColumnOperators] = &[
    &bouc_wen::Entry,
    &prandtl_ishlinskii::Entry,
    &parallel_bouc_wen::Entry,
    &non_symmetric_bouc_wen::Entry,
    &song_der_kiureghian::Entry,
    &dahl::Entry,
    &duhem::Entry,
    &maxwell_slip::Entry,
    &one_sided_plays::Entry,
    &rate_dependent_plays::Entry,
    &activated_plays::Entry,
    &dead_zone_plays::Entry,
    &generalised_play::Entry,
    &krasnoselskii_pokrovskii::Entry,
    &preisach::Entry,
    &preisach::density::Entry,
    &jiles_atherton::Entry,
    &takacs::Entry,
];
