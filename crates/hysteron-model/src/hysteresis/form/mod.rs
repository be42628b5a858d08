//! Families of hysteresis operators as a fit sees them.
//!
//! Every family is v = Σ cᵢ uⁱ + Σ_j w_j s H_j\[u; θ\]: linear in its weights w, nonlinear in a few shape numbers θ, with
//! columns H_j that an operator puts out and a sign s that is the family's convention. [`HysteresisForm`] names the numbers,
//! runs the operators into [`Columns`] with their derivatives, and makes the [`Hysteresis`] that they stand for.

mod bouc_wen;
mod memory;
mod plays;

use super::outputs::Columns;
use super::{
    BoucWen, DriveGrid, Family, FamilyForm, Hysteresis, HysteresisError, PrandtlIshlinskii, UnitShape,
};
use crate::start::Start;
use crate::unknown_name::UnknownName;
use serde::{Deserialize, Serialize};

/// A family of hysteresis operators with its fixed structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HysteresisForm {
    /// H = ζ of the unit-α form, s = −1: weight α; shape β', γ', n. Memory of a record: ζ(0) \[V\].
    #[default]
    BoucWen,
    /// H_j = F_rⱼ, s = 1: a weight and a threshold r a play. Memory of a record: the voltage at which the device was
    /// virgin before it moved, without turning, to where it rested.
    PrandtlIshlinskii {
        /// Number of plays.
        plays: usize,
    },
    /// Another family of columns, s = 1. Memory of a record as for plays.
    Family(FamilyForm),
}

/// Most elements of a family; a plane has a weight for every pair.
const MOST_ELEMENTS: usize = 60;
const MOST_OF_A_PLANE: usize = 16;

impl std::str::FromStr for HysteresisForm {
    type Err = UnknownName;

    /// The family of this name, with its usual number of elements.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("hysteresis family", name, Self::usual(), Self::name)
    }
}

impl HysteresisForm {
    /// What the family is, in a line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::BoucWen => "Polynomial less one relaxing state: few parameters",
            Self::PrandtlIshlinskii { .. } => {
                "Polynomial and 12 plays: minor loops, exact inverse (this and the following: joint)"
            }
            Self::Family(family) => match family {
                FamilyForm::ParallelBoucWen { .. } => "Two Bouc-Wen states of unlike sharpness",
                FamilyForm::NonSymmetricBoucWen => "Bouc-Wen with a term that makes its loop asymmetric",
                FamilyForm::SongDerKiureghian => "Bouc-Wen with six coefficients",
                FamilyForm::Dahl => "One relaxing state with an exponent of its own",
                FamilyForm::Duhem { .. } => "Coleman's and Hodgdon's equation with slopes up to u^2",
                FamilyForm::MaxwellSlip { .. } => "12 elastic elements that slip: plays in other coordinates",
                FamilyForm::OneSidedPlays { .. } => "12 plays for a drive to one side of rest",
                FamilyForm::RateDependentPlays { .. } => "12 plays that get wider with the rate of the drive",
                FamilyForm::DeadZonePlays { .. } => {
                    "12 plays and six bands of what they put out: minor loops that differ with bias"
                }
                FamilyForm::GeneralisedPlays { .. } => "8 plays behind saturating, unequal envelopes",
                FamilyForm::KrasnoselskiiPokrovskii { .. } => {
                    "Ramped relays on a grid of 8 lines (36 weights)"
                }
                FamilyForm::Preisach { .. } => "Relays on a plane of 10 intervals (55 weights)",
                FamilyForm::PreisachDensity => "Relays on a plane with a density of four numbers",
                FamilyForm::JilesAtherton => "Jiles' and Atherton's magnetisation",
            },
        }
    }

    /// The family with another number of elements: plays, slip elements, states, lines or intervals of a plane, degree.
    ///
    /// # Errors
    /// [`HysteresisError::Elements`] for a number that the family cannot have.
    pub fn with_elements(self, count: usize) -> Result<Self, HysteresisError> {
        let refused =
            |allowed: String| HysteresisError::Elements { family: self.name(), found: count, allowed };
        let within = |most: usize| {
            (1..=most).contains(&count).then_some(count).ok_or_else(|| refused(format!("it has 1 to {most}")))
        };
        let family = match self {
            Self::PrandtlIshlinskii { .. } => {
                return Ok(Self::PrandtlIshlinskii { plays: within(MOST_ELEMENTS)? });
            }
            Self::BoucWen => {
                return Err(refused("it has one state; take parallel-bouc-wen for more".to_owned()));
            }
            Self::Family(family) => family,
        };
        Ok(Self::Family(match family {
            FamilyForm::ParallelBoucWen { .. } => FamilyForm::ParallelBoucWen { states: within(3)? },
            FamilyForm::Duhem { .. } => FamilyForm::Duhem { degree: within(9)? },
            FamilyForm::MaxwellSlip { .. } => FamilyForm::MaxwellSlip { elements: within(MOST_ELEMENTS)? },
            FamilyForm::OneSidedPlays { .. } => FamilyForm::OneSidedPlays { plays: within(MOST_ELEMENTS)? },
            FamilyForm::RateDependentPlays { .. } => {
                FamilyForm::RateDependentPlays { plays: within(MOST_ELEMENTS)? }
            }
            FamilyForm::DeadZonePlays { .. } => FamilyForm::DeadZonePlays { plays: within(MOST_ELEMENTS)? },
            FamilyForm::GeneralisedPlays { .. } => {
                FamilyForm::GeneralisedPlays { plays: within(MOST_ELEMENTS)? }
            }
            FamilyForm::KrasnoselskiiPokrovskii { .. } => {
                FamilyForm::KrasnoselskiiPokrovskii { lines: within(MOST_OF_A_PLANE)? }
            }
            FamilyForm::Preisach { .. } => FamilyForm::Preisach { intervals: within(MOST_OF_A_PLANE)? },
            FamilyForm::NonSymmetricBoucWen
            | FamilyForm::SongDerKiureghian
            | FamilyForm::Dahl
            | FamilyForm::PreisachDensity
            | FamilyForm::JilesAtherton => return Err(refused("their number is fixed".to_owned())),
        }))
    }

    /// Every family with its usual number of elements, the article's first.
    pub fn usual() -> [Self; 16] {
        let family = Self::Family;
        [
            Self::BoucWen,
            Self::PrandtlIshlinskii { plays: 12 },
            family(FamilyForm::ParallelBoucWen { states: 2 }),
            family(FamilyForm::NonSymmetricBoucWen),
            family(FamilyForm::SongDerKiureghian),
            family(FamilyForm::Dahl),
            family(FamilyForm::Duhem { degree: 2 }),
            family(FamilyForm::MaxwellSlip { elements: 12 }),
            family(FamilyForm::OneSidedPlays { plays: 12 }),
            family(FamilyForm::RateDependentPlays { plays: 12 }),
            family(FamilyForm::DeadZonePlays { plays: 12 }),
            family(FamilyForm::GeneralisedPlays { plays: 8 }),
            family(FamilyForm::KrasnoselskiiPokrovskii { lines: 8 }),
            family(FamilyForm::Preisach { intervals: 10 }),
            family(FamilyForm::PreisachDensity),
            family(FamilyForm::JilesAtherton),
        ]
    }

    /// Name, as on the command line and in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::BoucWen => "bouc-wen",
            Self::PrandtlIshlinskii { .. } => "prandtl-ishlinskii",
            Self::Family(form) => form.name(),
        }
    }

    /// Names of the weights.
    pub fn weight_names(self) -> Vec<String> {
        match self {
            Self::BoucWen => vec!["alpha".into()],
            Self::PrandtlIshlinskii { plays } => numbered("weight", plays),
            Self::Family(form) => form.weight_numbers().into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// Names of the shape numbers θ.
    pub fn shape_names(self) -> Vec<String> {
        match self {
            Self::BoucWen => ["beta", "gamma", "n"].map(String::from).into(),
            Self::PrandtlIshlinskii { plays } => numbered("threshold", plays),
            Self::Family(form) => form.shape_numbers().into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// Number of columns, and of weights.
    pub fn columns(self) -> usize {
        match self {
            Self::BoucWen => 1,
            Self::PrandtlIshlinskii { plays } => plays,
            Self::Family(form) => form.columns(),
        }
    }

    /// The sign s of a weighted column in v.
    pub fn sign(self) -> f64 {
        match self {
            Self::BoucWen => -1.0,
            Self::PrandtlIshlinskii { .. } | Self::Family(_) => 1.0,
        }
    }

    /// Whether all weights have the sign of the slope dv/du, so that every move raises v with u.
    pub fn is_monotone(self) -> bool {
        match self {
            Self::BoucWen => false,
            Self::PrandtlIshlinskii { .. } => true,
            Self::Family(form) => form.is_monotone(),
        }
    }

    /// Pairs of weights whose cells lie side by side on a plane ([`FamilyForm::neighbours`]).
    pub fn neighbours(self) -> Vec<(usize, usize)> {
        match self {
            Self::BoucWen | Self::PrandtlIshlinskii { .. } => Vec::new(),
            Self::Family(form) => form.neighbours(),
        }
    }

    /// Pairs of weights of plays of neighbouring thresholds, and of neighbouring bands; behind the widest play there is none, of weight
    /// 0. Empty for families without plays that are weighted one by one.
    pub fn chain(self) -> Vec<(usize, Option<usize>)> {
        let next = |from: usize, to: usize| (from + 1..to).map(|i| (i - 1, Some(i)));
        match self {
            Self::PrandtlIshlinskii { plays } => next(0, plays).chain([(plays - 1, None)]).collect(),
            Self::Family(FamilyForm::DeadZonePlays { plays }) => {
                let bands = next(plays, self.weight_names().len());
                next(0, plays).chain([(plays - 1, None)]).chain(bands).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Runs the operators over the drive `u` \[V\], given on a time base finer by a factor, from `start`; derivatives with
    /// respect to those shape numbers that `wanted` marks, and to the memory, where it is given.
    ///
    /// # Errors
    /// What the family refuses: [`HysteresisError`].
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
        let factor = grid.factor;
        match self {
            Self::BoucWen => bouc_wen::run(unit_shape(shape)?, factor, u, start, wanted, out),
            Self::PrandtlIshlinskii { .. } => plays::run(shape, factor, u, start, wanted, out),
            Self::Family(form) => form.run(shape, grid, u, start, wanted, out),
        }
    }

    /// Whether its memory depends on how fast the voltage moves ([`FamilyForm::depends_on_rate`]).
    pub fn sees_rate(self) -> bool {
        matches!(self, Self::Family(form) if form.depends_on_rate())
    }

    /// The operator with these numbers.
    ///
    /// # Errors
    /// As the family's own `validate`; with α = 0 the article's β and γ exist for n = 1 only.
    pub fn operator(
        self,
        polynomial: Vec<f64>,
        weights: &[f64],
        shape: &[f64],
    ) -> Result<Hysteresis, HysteresisError> {
        match self {
            Self::BoucWen => {
                let alpha = weights.first().copied().unwrap_or(0.0);
                BoucWen::from_unit(polynomial, alpha, unit_shape(shape)?).map(Hysteresis::BoucWen)
            }
            Self::PrandtlIshlinskii { .. } => {
                PrandtlIshlinskii::new(polynomial, shape.to_vec(), weights.to_vec())
                    .map(Hysteresis::PrandtlIshlinskii)
            }
            Self::Family(form) => {
                Family::new(polynomial, form, shape.to_vec(), weights.to_vec()).map(Hysteresis::Family)
            }
        }
    }

    /// A record's memory in the operator's own scale, z(0) = α ζ(0) for Bouc–Wen, from that of the columns.
    pub fn own_memory(self, memory: f64, weights: &[f64]) -> f64 {
        match self {
            Self::BoucWen => memory * weights.first().copied().unwrap_or(0.0),
            Self::PrandtlIshlinskii { .. } | Self::Family(_) => memory,
        }
    }
}

impl HysteresisForm {
    /// A record's memory in the scale of the columns, from that in the operator's own; 0 where nothing is remembered.
    pub fn memory_of_columns(self, memory: f64, weights: &[f64]) -> f64 {
        match (self, weights) {
            (Self::BoucWen, &[alpha]) => {
                if alpha == 0.0 {
                    0.0
                } else {
                    memory / alpha
                }
            }
            _ => memory,
        }
    }
}

impl Hysteresis {
    /// The family of this operator.
    pub fn form(&self) -> HysteresisForm {
        match self {
            Self::BoucWen(_) => HysteresisForm::BoucWen,
            Self::PrandtlIshlinskii(model) => {
                HysteresisForm::PrandtlIshlinskii { plays: model.thresholds.len() }
            }
            Self::Family(model) => HysteresisForm::Family(model.form),
        }
    }

    /// Weights in the order of [`HysteresisForm::weight_names`].
    pub fn weights(&self) -> Vec<f64> {
        match self {
            Self::BoucWen(model) => vec![model.alpha],
            Self::PrandtlIshlinskii(model) => model.weights.clone(),
            Self::Family(model) => model.weights.clone(),
        }
    }

    /// Shape numbers in the order of [`HysteresisForm::shape_names`]; β', γ' for Bouc–Wen.
    pub fn shape(&self) -> Vec<f64> {
        match self {
            Self::BoucWen(model) => {
                let UnitShape { beta, gamma, n } = model.unit_shape();
                vec![beta, gamma, n]
            }
            Self::PrandtlIshlinskii(model) => model.thresholds.clone(),
            Self::Family(model) => model.shape.clone(),
        }
    }
}

impl Hysteresis {
    /// Names and values of the numbers beside the polynomial, as a model file has them.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        let of = |names: Vec<String>, values: &[f64]| names.into_iter().zip(values.to_vec());
        match self {
            Self::BoucWen(b) => [("alpha", b.alpha), ("beta", b.beta), ("gamma", b.gamma), ("n", b.n)]
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            Self::PrandtlIshlinskii(p) => {
                let form = self.form();
                of(form.shape_names(), &p.thresholds).chain(of(form.weight_names(), &p.weights)).collect()
            }
            Self::Family(p) => {
                let form = self.form();
                of(form.shape_names(), &p.shape).chain(of(form.weight_names(), &p.weights)).collect()
            }
        }
    }

    /// The number of this name beside the polynomial.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers().into_iter().find(|(own, _)| own == name).map(|(_, value)| value)
    }

    /// The number of this name beside the polynomial.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        match self {
            Self::BoucWen(b) => match name {
                "alpha" => Some(&mut b.alpha),
                "beta" => Some(&mut b.beta),
                "gamma" => Some(&mut b.gamma),
                "n" => Some(&mut b.n),
                _ => None,
            },
            Self::PrandtlIshlinskii(p) => {
                let (list, index) = name.rsplit_once('_')?;
                let index = index.parse::<usize>().ok()?.checked_sub(1)?;
                match list {
                    "threshold" => p.thresholds.get_mut(index),
                    "weight" => p.weights.get_mut(index),
                    _ => None,
                }
            }
            Self::Family(p) => {
                let form = HysteresisForm::Family(p.form);
                let place = |names: Vec<String>| names.iter().position(|own| own == name);
                match place(form.shape_names()) {
                    Some(index) => p.shape.get_mut(index),
                    None => p.weights.get_mut(place(form.weight_names())?),
                }
            }
        }
    }
}

fn numbered(name: &str, count: usize) -> Vec<String> {
    (1..=count).map(|index| format!("{name}_{index}")).collect()
}

fn unit_shape(shape: &[f64]) -> Result<UnitShape, HysteresisError> {
    match *shape {
        [beta, gamma, n] => Ok(UnitShape { beta, gamma, n }),
        _ => Err(HysteresisError::ShapeCount { expected: 3, found: shape.len() }),
    }
}

#[cfg(test)]
mod tests;
