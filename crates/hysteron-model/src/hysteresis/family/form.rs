//! The families, their numbers and the units of these.

use super::super::dead_zone_plays::BANDS;
use super::super::parallel_bouc_wen::MOST_STATES;
use super::super::preisach::DensityLaw;
use super::super::{
    ColumnKernel, Dahl, DeadZonePlays, DriveGrid, Duhem, GeneralisedPlays, HysteresisError, JilesAtherton,
    KrasnoselskiiPokrovskii, MaxwellSlip, NonSymmetricBoucWen, OneSidedPlays, ParallelBoucWen, Preisach,
    PreisachDensity, RateDependentPlays, SongDerKiureghian,
};
use super::run;
use super::stream::Runner;
use crate::hysteresis::follow::{self, DriveLimits, Followed};
use crate::hysteresis::outputs::Columns;
use crate::start::Start;
use serde::{Deserialize, Serialize};

/// Intervals of the plane of a Preisach density.
const DENSITY_INTERVALS: usize = 40;

/// A family of columns with its fixed structure. Families on a grid take its ends from their shape numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FamilyForm {
    /// [`ParallelBoucWen`].
    ParallelBoucWen {
        /// Number of states, 1 to 3.
        states: usize,
    },
    /// [`NonSymmetricBoucWen`].
    NonSymmetricBoucWen,
    /// [`SongDerKiureghian`], n = 1.
    SongDerKiureghian,
    /// [`Dahl`].
    Dahl,
    /// [`Duhem`].
    Duhem {
        /// Highest power of u; the columns are one more.
        degree: usize,
    },
    /// [`MaxwellSlip`] with elements at `scale` · j/(elements + 1).
    MaxwellSlip {
        /// Number of elements.
        elements: usize,
    },
    /// [`OneSidedPlays`] with widths `scale` · j/(plays + 1).
    OneSidedPlays {
        /// Number of plays.
        plays: usize,
    },
    /// [`RateDependentPlays`] with half-widths `scale` · j/(plays + 1).
    RateDependentPlays {
        /// Number of plays.
        plays: usize,
    },
    /// [`DeadZonePlays`] over the voltages from `low` to `high`, with half-widths up to half of that.
    DeadZonePlays {
        /// Number of plays; the columns are six more.
        plays: usize,
    },
    /// [`GeneralisedPlays`] with thresholds (j − ½)/plays.
    GeneralisedPlays {
        /// Number of plays.
        plays: usize,
    },
    /// [`KrasnoselskiiPokrovskii`] on a grid from `low` to `high`.
    KrasnoselskiiPokrovskii {
        /// Lines of the grid; the columns are lines (lines + 1)/2.
        lines: usize,
    },
    /// [`Preisach`] with levels from `low` to `high`.
    Preisach {
        /// Intervals between levels; the columns are intervals (intervals + 1)/2.
        intervals: usize,
    },
    /// [`PreisachDensity`], Lorentzian, on a plane from `low` to `high`.
    PreisachDensity,
    /// [`JilesAtherton`].
    JilesAtherton,
}

/// Unit of a number: powers of the output's and of the input's unit, and of the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NumberUnit {
    /// Power of the output's unit.
    pub output: i32,
    /// Power of the input's unit.
    pub input: i32,
    /// Power of the second.
    pub time: i32,
}

const NONE: NumberUnit = NumberUnit { output: 0, input: 0, time: 0 };
const INPUT: NumberUnit = NumberUnit { input: 1, ..NONE };
const PER_INPUT: NumberUnit = NumberUnit { input: -1, ..NONE };
const OUTPUT: NumberUnit = NumberUnit { output: 1, ..NONE };
const SLOPE: NumberUnit = NumberUnit { output: 1, input: -1, ..NONE };
const TIME: NumberUnit = NumberUnit { time: 1, ..NONE };

/// Runs `$body` with the kernel of a family, and the number of leading shape numbers that the kernel's structure takes. `$interval`:
/// seconds between samples.
macro_rules! with_kernel {
    ($form:expr, $shape:expr, $interval:expr, |$kernel:ident, $fixed:ident| $body:expr) => {{
        let at = |index: usize| $shape.get(index).copied().unwrap_or(f64::NAN);
        let range = [at(0), at(1)];
        match $form {
            FamilyForm::ParallelBoucWen { states } => {
                let ($kernel, $fixed) = (ParallelBoucWen { states }, 0);
                $body
            }
            FamilyForm::NonSymmetricBoucWen => {
                let ($kernel, $fixed) = (NonSymmetricBoucWen, 0);
                $body
            }
            FamilyForm::SongDerKiureghian => {
                let ($kernel, $fixed) = (SongDerKiureghian { n: 1.0 }, 0);
                $body
            }
            FamilyForm::Dahl => {
                let ($kernel, $fixed) = (Dahl, 0);
                $body
            }
            FamilyForm::Duhem { degree } => {
                let ($kernel, $fixed) = (Duhem { degree }, 0);
                $body
            }
            FamilyForm::MaxwellSlip { elements } => {
                let ($kernel, $fixed) = (MaxwellSlip { thresholds: inner_grid(elements) }, 0);
                $body
            }
            FamilyForm::OneSidedPlays { plays } => {
                let ($kernel, $fixed) = (OneSidedPlays { thresholds: inner_grid(plays) }, 0);
                $body
            }
            FamilyForm::RateDependentPlays { plays } => {
                let (thresholds, interval_s) = (inner_grid(plays), $interval);
                let ($kernel, $fixed) = (RateDependentPlays { thresholds, interval_s }, 0);
                $body
            }
            FamilyForm::DeadZonePlays { plays } => {
                let ($kernel, $fixed) = (DeadZonePlays::regular(range, plays), 2);
                $body
            }
            FamilyForm::GeneralisedPlays { plays } => {
                let ($kernel, $fixed) = (GeneralisedPlays { thresholds: middle_grid(plays) }, 0);
                $body
            }
            FamilyForm::KrasnoselskiiPokrovskii { lines } => {
                let ($kernel, $fixed) = (KrasnoselskiiPokrovskii { range, lines }, 2);
                $body
            }
            FamilyForm::Preisach { intervals } => {
                let ($kernel, $fixed) = (Preisach::regular(range, intervals + 1), 2);
                $body
            }
            FamilyForm::PreisachDensity => {
                let ($kernel, $fixed) = (density(range), 2);
                $body
            }
            FamilyForm::JilesAtherton => {
                let ($kernel, $fixed) = (JilesAtherton, 0);
                $body
            }
        }
    }};
}

/// j/(count + 1), j = 1 … count.
fn inner_grid(count: usize) -> Vec<f64> {
    (1..=count).map(|j| j as f64 / (count + 1) as f64).collect()
}

/// (j − ½)/count, j = 1 … count.
fn middle_grid(count: usize) -> Vec<f64> {
    (0..count).map(|j| (j as f64 + 0.5) / count as f64).collect()
}

/// The plane of [`FamilyForm::PreisachDensity`].
fn density(range: [f64; 2]) -> PreisachDensity {
    let plane = Preisach::regular(range, DENSITY_INTERVALS + 1);
    PreisachDensity { plane, law: DensityLaw::Lorentzian }
}

impl FamilyForm {
    /// Name, as on the command line and in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::ParallelBoucWen { .. } => "parallel-bouc-wen",
            Self::NonSymmetricBoucWen => "non-symmetric-bouc-wen",
            Self::SongDerKiureghian => "song-der-kiureghian",
            Self::Dahl => "dahl",
            Self::Duhem { .. } => "duhem",
            Self::MaxwellSlip { .. } => "maxwell-slip",
            Self::OneSidedPlays { .. } => "one-sided-plays",
            Self::RateDependentPlays { .. } => "rate-dependent-plays",
            Self::DeadZonePlays { .. } => "dead-zone-plays",
            Self::GeneralisedPlays { .. } => "generalised-plays",
            Self::KrasnoselskiiPokrovskii { .. } => "krasnoselskii-pokrovskii",
            Self::Preisach { .. } => "preisach",
            Self::PreisachDensity => "preisach-density",
            Self::JilesAtherton => "jiles-atherton",
        }
    }

    /// Number of columns, and of weights.
    pub fn columns(self) -> usize {
        match self {
            Self::ParallelBoucWen { states } => states,
            Self::Duhem { degree } => degree + 1,
            Self::MaxwellSlip { elements } => elements,
            Self::OneSidedPlays { plays }
            | Self::RateDependentPlays { plays }
            | Self::GeneralisedPlays { plays } => plays,
            Self::DeadZonePlays { plays } => plays + BANDS,
            Self::KrasnoselskiiPokrovskii { lines: n } | Self::Preisach { intervals: n } => n * (n + 1) / 2,
            Self::NonSymmetricBoucWen
            | Self::SongDerKiureghian
            | Self::Dahl
            | Self::PreisachDensity
            | Self::JilesAtherton => 1,
        }
    }

    /// The same family with this number of weights; `None` where it has no such member.
    pub fn with_weights(self, weights: usize) -> Option<Self> {
        // n (n + 1)/2 = weights.
        let side = ((8 * weights + 1) as f64).sqrt() as usize / 2;
        let form = match self {
            Self::ParallelBoucWen { .. } => Self::ParallelBoucWen { states: weights },
            Self::Duhem { .. } => Self::Duhem { degree: weights.checked_sub(1)? },
            Self::MaxwellSlip { .. } => Self::MaxwellSlip { elements: weights },
            Self::OneSidedPlays { .. } => Self::OneSidedPlays { plays: weights },
            Self::RateDependentPlays { .. } => Self::RateDependentPlays { plays: weights },
            Self::DeadZonePlays { .. } => Self::DeadZonePlays { plays: weights.checked_sub(BANDS)? },
            Self::GeneralisedPlays { .. } => Self::GeneralisedPlays { plays: weights },
            Self::KrasnoselskiiPokrovskii { .. } => {
                let lines = if side * (side + 1) / 2 == weights { side } else { side.checked_sub(1)? };
                Self::KrasnoselskiiPokrovskii { lines }
            }
            Self::Preisach { .. } => {
                let intervals = if side * (side + 1) / 2 == weights { side } else { side.checked_sub(1)? };
                Self::Preisach { intervals }
            }
            single => single,
        };
        (weights > 0 && form.columns() == weights).then_some(form)
    }

    /// Names and units of the weights.
    pub fn weight_numbers(self) -> Vec<(String, NumberUnit)> {
        let unit = |j: usize| match self {
            Self::Duhem { .. } => NumberUnit { output: 1, input: -(j as i32 + 1), ..NONE },
            Self::GeneralisedPlays { .. }
            | Self::KrasnoselskiiPokrovskii { .. }
            | Self::Preisach { .. }
            | Self::PreisachDensity
            | Self::JilesAtherton => OUTPUT,
            _ => SLOPE,
        };
        (0..self.columns()).map(|j| (format!("weight_{}", j + 1), unit(j))).collect()
    }

    /// Names and units of the shape numbers.
    pub fn shape_numbers(self) -> Vec<(String, NumberUnit)> {
        let named =
            |list: &[(&str, NumberUnit)]| list.iter().map(|(n, unit)| ((*n).to_owned(), *unit)).collect();
        match self {
            Self::ParallelBoucWen { states } => (1..=states.min(MOST_STATES))
                .flat_map(|k| [(format!("beta_{k}"), PER_INPUT), (format!("gamma_{k}"), PER_INPUT)])
                .collect(),
            Self::NonSymmetricBoucWen => {
                named(&[("beta", PER_INPUT), ("gamma", PER_INPUT), ("delta", PER_INPUT)])
            }
            Self::SongDerKiureghian => (1..=6).map(|k| (format!("beta_{k}"), PER_INPUT)).collect(),
            Self::Dahl => named(&[("reach", INPUT), ("exponent", NONE)]),
            Self::Duhem { .. } => named(&[("rate", PER_INPUT)]),
            Self::MaxwellSlip { .. } | Self::OneSidedPlays { .. } => named(&[("scale", INPUT)]),
            Self::RateDependentPlays { .. } => named(&[("scale", INPUT), ("rate_gain", TIME)]),
            Self::DeadZonePlays { .. } => {
                named(&[("low", INPUT), ("high", INPUT), ("loop_share", NONE), ("reach", INPUT)])
            }
            Self::GeneralisedPlays { .. } => named(&[
                ("rise_right", PER_INPUT),
                ("centre_right", INPUT),
                ("rise_left", PER_INPUT),
                ("centre_left", INPUT),
            ]),
            Self::KrasnoselskiiPokrovskii { .. } => {
                named(&[("low", INPUT), ("high", INPUT), ("rise", INPUT)])
            }
            Self::Preisach { .. } => named(&[("low", INPUT), ("high", INPUT)]),
            Self::PreisachDensity => named(&[
                ("low", INPUT),
                ("high", INPUT),
                ("half_width", INPUT),
                ("half_width_spread", INPUT),
                ("bias", INPUT),
                ("bias_spread", INPUT),
            ]),
            Self::JilesAtherton => named(&[
                ("anhysteretic", INPUT),
                ("pinning", INPUT),
                ("reversibility", NONE),
                ("coupling", INPUT),
            ]),
        }
    }

    /// Whether every column of a slow drive rises with u and falls with it, so that weights of one sign make a monotone model.
    pub fn is_monotone(self) -> bool {
        matches!(
            self,
            Self::OneSidedPlays { .. }
                | Self::RateDependentPlays { .. }
                | Self::DeadZonePlays { .. }
                | Self::GeneralisedPlays { .. }
                | Self::KrasnoselskiiPokrovskii { .. }
                | Self::Preisach { .. }
        )
    }

    /// Thresholds of a family of plays as they are, in volts or in units of the envelopes; none for others.
    pub(crate) fn thresholds(self, shape: &[f64]) -> Vec<f64> {
        let at = |index: usize| shape.get(index).copied().unwrap_or(f64::NAN);
        match self {
            Self::MaxwellSlip { elements: count }
            | Self::OneSidedPlays { plays: count }
            | Self::RateDependentPlays { plays: count } => {
                inner_grid(count).into_iter().map(|threshold| at(0) * threshold).collect()
            }
            Self::DeadZonePlays { plays } => DeadZonePlays::regular([at(0), at(1)], plays).thresholds,
            Self::GeneralisedPlays { plays } => middle_grid(plays),
            _ => Vec::new(),
        }
    }

    /// Intervals of a plane of relays, and the weights of its cells where all of it has the weights `weights`.
    pub(super) fn cells(self, shape: &[f64], weights: &[f64]) -> (usize, Vec<f64>) {
        match self {
            Self::Preisach { intervals } => (intervals, weights.to_vec()),
            Self::PreisachDensity => {
                let at = |index: usize| shape.get(index).copied().unwrap_or(f64::NAN);
                let weight = weights.first().copied().unwrap_or(f64::NAN);
                let cells = density([at(0), at(1)]).weights(shape.get(2..).unwrap_or_default());
                (DENSITY_INTERVALS, cells.into_iter().map(|cell: f64| weight * cell).collect())
            }
            _ => (0, Vec::new()),
        }
    }

    /// Pairs of weights whose cells lie side by side on a plane of relays; none for other families. Those on the diagonal, which are
    /// without hysteresis, are neighbours of one another alone.
    pub fn neighbours(self) -> Vec<(usize, usize)> {
        let (Self::KrasnoselskiiPokrovskii { lines: n } | Self::Preisach { intervals: n }) = self else {
            return Vec::new();
        };
        let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let beside = |i: usize, j: usize| {
            let next = match i == j {
                true => [(i + 1, j + 1), (n, n)],
                false => [(i + 1, j), if j + 1 < i { (i, j + 1) } else { (n, n) }],
            };
            next.into_iter().filter(|(i, _)| *i < n).map(move |(k, l)| (at(i, j), at(k, l)))
        };
        (0..n).flat_map(|i| (0..=i).flat_map(move |j| beside(i, j).collect::<Vec<_>>())).collect()
    }

    /// Whether the memory depends on how fast the voltage moves, so that the time between samples must be known.
    pub fn depends_on_rate(self) -> bool {
        matches!(self, Self::RateDependentPlays { .. })
    }

    /// Checks structure and shape.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn check(self, shape: &[f64]) -> Result<(), HysteresisError> {
        let expected = self.shape_numbers().len();
        if shape.len() != expected {
            return Err(HysteresisError::ShapeCount { expected, found: shape.len() });
        }
        let [low, high] = [0, 1].map(|index| shape.get(index).copied().unwrap_or(f64::NAN));
        let gridded = matches!(
            self,
            Self::DeadZonePlays { .. }
                | Self::KrasnoselskiiPokrovskii { .. }
                | Self::Preisach { .. }
                | Self::PreisachDensity
        );
        if gridded && !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        with_kernel!(self, shape, 1.0, |kernel, fixed| kernel.check(shape.get(fixed..).unwrap_or_default()))
    }

    /// Seconds between samples where the family asks for them; any number where it does not.
    fn interval(self, interval_s: Option<f64>) -> Result<f64, HysteresisError> {
        match interval_s {
            Some(interval_s) => Ok(interval_s),
            None if self.depends_on_rate() => Err(HysteresisError::Interval),
            None => Ok(1.0),
        }
    }

    /// The kernel, virgin at the voltage `u` \[V\], to be moved sample by sample. The shape has been checked.
    pub(super) fn runner(
        self,
        shape: &[f64],
        interval_s: Option<f64>,
        u: f64,
    ) -> Result<Runner, HysteresisError> {
        let interval_s = self.interval(interval_s)?;
        Ok(with_kernel!(self, shape, interval_s, |kernel, fixed| {
            Runner::from((kernel, shape.get(fixed..).unwrap_or_default().to_vec(), u))
        }))
    }

    /// As [`crate::hysteresis::HysteresisForm::run`].
    ///
    /// # Errors
    /// [`HysteresisError`]: a shape that the family has not, a drive that is not finite, a state that runs away, a time between
    /// samples that is not known where the family asks for it.
    pub fn run<'a>(
        self,
        shape: &[f64],
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        let grid = grid.into();
        self.check(shape)?;
        // Where the rates are given, the interval does not matter.
        let interval_s = self.interval(grid.interval_s.or(grid.rates.map(|_| 1.0)))?;
        with_kernel!(self, shape, interval_s, |kernel, fixed| run::run(
            &kernel,
            (shape, fixed),
            grid,
            u,
            start,
            wanted,
            out
        ))
    }

    /// As [`crate::hysteresis::Hysteresis::follow`], beside an `anhysteretic` part.
    pub(in crate::hysteresis) fn follow(
        self,
        shape: &[f64],
        weights: &[f64],
        anhysteretic: impl Fn(f64) -> f64,
        wanted: &[f64],
        start: (f64, Option<f64>),
        limits: &DriveLimits,
    ) -> Result<Followed, HysteresisError> {
        let interval_s = self.interval(limits.interval_s)?;
        with_kernel!(self, shape, interval_s, |kernel, fixed| {
            let own = shape.get(fixed..).unwrap_or_default();
            follow::columns(&kernel, own, weights, anhysteretic, wanted, start, limits)
        })
    }
}
