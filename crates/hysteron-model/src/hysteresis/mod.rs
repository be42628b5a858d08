//! Hysteresis block: operators, most of them rate independent, one file per model behind one enum.
//!
//! * [`BoucWen`] (article Eq. 1) and its [`UnitShape`], the two or three numbers that enter nonlinearly.
//! * [`PrandtlIshlinskii`]: polynomial and plays, with their inverse.
//! * [`ColumnKernel`]: the operators of a family that is linear in weights, with a few nonlinear numbers.
//!   Each family has a file of its name here: its kernel, and its [`FamilyDescription`].
//! * [`HysteresisForm`]: a family as used by a fit, evaluated into [`Columns`] with their derivatives;
//!   [`FamilyForm`] where it is one of columns.
//! * [`Family`]: a model of such a family; [`FamilyStream`] runs it sample by sample. [`DriveGrid`] gives
//!   rate-dependent families the timing of the drive.
//! * [`Start`]: the state before the first sample, with a memory in the operator's scale; [`Sensitivities`]
//!   are those of Bouc–Wen.
//! * [`InterSample`]: inter-sample behaviour of the drive.
//! * [`Admissibility`]: boundedness of a parameter set; [`Invertibility`]: whether every move raises the
//!   output.

mod activated_plays;
mod admissibility;
pub mod bouc_wen;
mod columns;
mod dahl;
mod dead_zone_plays;
mod drive_grid;
mod duhem;
mod error;
mod family;
mod follow;
mod form;
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
mod plays;
mod polynomial;
mod prandtl_ishlinskii;
mod preisach;
mod rate_dependent_plays;
mod sensitivities;
mod song_der_kiureghian;
mod takacs;

pub use crate::record::InterSample;
pub use activated_plays::ActivatedPlays;
pub use admissibility::Admissibility;
pub use bouc_wen::{BoucWen, BoucWenState, UnitShape};
pub use columns::{ColumnKernel, ColumnSensitivities};
pub use dahl::Dahl;
pub use dead_zone_plays::DeadZonePlays;
pub use drive_grid::DriveGrid;
pub use duhem::Duhem;
pub use error::HysteresisError;
#[doc(hidden)]
pub use family::examples;
pub use family::{
    DriveSpan, Elements, Family, FamilyDescription, FamilyForm, FamilyStream, MeanLine, NumberUnit,
    RuntimeOperator, Search, ShapeNumber,
};
pub use follow::{DriveLimits, Followed};
pub use form::HysteresisForm;
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
pub use prandtl_ishlinskii::{PrandtlIshlinskii, StepInverse};
pub use preisach::{DensityLaw, Preisach, PreisachDensity};
pub use rate_dependent_plays::RateDependentPlays;
pub use sensitivities::Sensitivities;
pub use song_der_kiureghian::SongDerKiureghian;

use crate::start::Start;

/// The list of families, in the order in which they are shown to users. A new one is a line here, its own
/// file with its `mod`, and the law of its moves in `hysteron-rt`.
static FAMILIES: &[&dyn family::ColumnOperators] = &[
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

impl FamilyForm {
    /// All families, with their usual numbers of elements.
    pub fn all() -> impl Iterator<Item = Self> {
        FAMILIES.iter().map(|&family| {
            let usual = family.elements().map_or(0, |elements| elements.usual);
            Self::of(family, usual)
        })
    }
}

/// A hysteresis operator.
#[derive(Clone, Debug, PartialEq)]
pub enum Hysteresis {
    /// Bouc–Wen, article Eq. 1.
    BoucWen(BoucWen),
    /// Polynomial and the columns of a family.
    Family(Family),
}

impl Hysteresis {
    /// Checks the parameters.
    ///
    /// # Errors
    /// As the model's own `validate`.
    pub fn validate(&self) -> Result<(), HysteresisError> {
        match self {
            Self::BoucWen(model) => model.validate(),
            Self::Family(model) => model.validate(),
        }
    }

    /// Output v \[µm\] for the voltages `u` \[V\] into `out` (same length). Moves between samples are
    /// monotone ([`InterSample::Linear`] and [`InterSample::Hold`] alike). The memory of a
    /// [`Start::Remembering`] is in the operator's own scale: z(0) \[µm\] for Bouc–Wen.
    ///
    /// # Errors
    /// As the model's own `simulate`.
    pub fn simulate(&self, u: &[f64], start: Start<f64>, out: &mut [f64]) -> Result<(), HysteresisError> {
        self.simulate_every(1, u, start, out)
    }

    /// [`Self::simulate`] for a drive `u` given on a time base finer by a factor ([`InterSample::upsample`]):
    /// `out[k]` belongs to `u[k * factor]`. A rate-dependent operator takes the rate from the grid.
    ///
    /// # Errors
    /// As the model's own `simulate`.
    pub fn simulate_every<'a>(
        &self,
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        let grid = grid.into();
        match self {
            Self::BoucWen(model) => model.simulate_every(grid.factor, u, start, out).map(|_| ()),
            Self::Family(model) => model.simulate_every(grid, u, start, out),
        }
    }

    /// Output \[µm\] of an operator at rest at the voltage `rest` \[V\] with a memory (see
    /// [`Start::Remembering`]), `None` where it is virgin there.
    pub fn at_rest(&self, rest: f64, memory: Option<f64>) -> f64 {
        match self {
            Self::BoucWen(model) => model.polynomial_at(rest) - memory.unwrap_or(0.0),
            Self::Family(model) => model.at_rest(memory.unwrap_or(rest), rest),
        }
    }

    /// Memory of an operator, in its own scale, that was virgin at the voltage `virgin` \[V\] and moved
    /// monotonically to `rest`.
    ///
    /// # Errors
    /// As the model's own `validate`; voltages that are not finite.
    pub fn memory_of_move(&self, virgin: f64, rest: f64) -> Result<f64, HysteresisError> {
        match self {
            Self::BoucWen(model) => {
                let mut state = BoucWenState { u: virgin, z: 0.0 };
                let moved = model.operator()?.step(&mut state, rest);
                moved.map_err(|cause| HysteresisError::RunsAway { index: 0, cause })
            }
            Self::Family(_) => Ok(virgin),
        }
    }

    /// Polynomial and operator of the runtime at this sample rate.
    pub fn runtime(&self, sample_rate_hz: f64) -> (Vec<f64>, RuntimeOperator) {
        let mut polynomial = self.polynomial().to_vec();
        let operator = match self {
            Self::BoucWen(b) => RuntimeOperator::BoucWen(vec![[b.alpha, b.beta, b.gamma, b.n]]),
            Self::Family(Family { form, shape, weights, .. }) => {
                let family = form.description();
                family.runtime(form.elements(), &mut polynomial, shape, weights, sample_rate_hz)
            }
        };
        (polynomial, operator)
    }

    /// Mutable coefficients of the polynomial l\[u\].
    pub fn polynomial_mut(&mut self) -> &mut Vec<f64> {
        match self {
            Self::BoucWen(model) => &mut model.polynomial,
            Self::Family(model) => &mut model.polynomial,
        }
    }

    /// Coefficients of the polynomial l\[u\], from that of u on \[µm/V, µm/V², …\].
    pub fn polynomial(&self) -> &[f64] {
        match self {
            Self::BoucWen(model) => &model.polynomial,
            Self::Family(model) => &model.polynomial,
        }
    }

    /// The operator whose output is `gain` times that of this one. For Bouc–Wen, with z = g Z: ż = g α u̇ −
    /// g¹⁻ⁿ (β |u̇| z |z|ⁿ⁻¹ + γ u̇ |z|ⁿ).
    ///
    /// # Errors
    /// As the model's own `validate`.
    pub fn scaled(&self, gain: f64) -> Result<Self, HysteresisError> {
        let times_gain = |numbers: &[f64]| numbers.iter().map(|c| gain * c).collect();
        match self {
            Self::BoucWen(b) => {
                let shape = gain.powf(1.0 - b.n);
                let polynomial = times_gain(&b.polynomial);
                BoucWen::new(polynomial, gain * b.alpha, shape * b.beta, shape * b.gamma, b.n)
                    .map(Self::BoucWen)
            }
            Self::Family(model) => {
                let (polynomial, weights) = (times_gain(&model.polynomial), times_gain(&model.weights));
                Family::new(polynomial, model.form, model.shape.clone(), weights).map(Self::Family)
            }
        }
    }
}
