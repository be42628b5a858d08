//! Families of hysteresis operators as used by a fit.
//!
//! Every family is v = Σ cᵢ uⁱ + Σ_j w_j s H_j\[u; θ\]: linear in its weights w, nonlinear in a few shape
//! numbers θ, with columns H_j, the outputs of an operator, and a sign s that is the family's convention.
//! [`HysteresisForm`] names the numbers, runs the operators into [`Columns`] with their derivatives, and
//! builds the [`Hysteresis`] that they define.

mod bouc_wen;
mod json;
mod memory;

use super::outputs::Columns;
use super::{
    BoucWen, DriveGrid, DriveSpan, Elements, Family, FamilyDescription, FamilyForm, Hysteresis,
    HysteresisError, ShapeNumber, UnitShape,
};
use crate::record::Dependence;
use crate::start::Start;
use crate::unknown_name::UnknownName;

/// A family of hysteresis operators with its fixed structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum HysteresisForm {
    /// H = ζ of the unit-α form, s = −1: weight α; shape β', γ', n. Memory of a record: ζ(0) \[V\].
    #[default]
    BoucWen,
    /// A family of columns, s = 1. Memory of a record: the voltage at which the device was virgin before it
    /// moved monotonically to rest.
    Family(FamilyForm),
}

impl std::str::FromStr for HysteresisForm {
    type Err = UnknownName;

    /// The family of this name, with its usual number of elements.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("hysteresis family", name, Self::usual(), Self::name)
    }
}

impl HysteresisForm {
    /// Every family with its usual number of elements, the article's first.
    pub fn usual() -> Vec<Self> {
        [Self::BoucWen].into_iter().chain(FamilyForm::all().map(Self::Family)).collect()
    }

    /// Description of the family.
    pub fn description(self) -> &'static dyn FamilyDescription {
        match self {
            Self::BoucWen => &super::bouc_wen::Entry,
            Self::Family(form) => form.description(),
        }
    }

    /// Number of elements: plays, slip elements, states, lines or intervals of a plane, degree; 0 where it is
    /// fixed.
    pub fn elements(self) -> usize {
        match self {
            Self::BoucWen => 0,
            Self::Family(form) => form.elements(),
        }
    }

    /// The family with another number of elements.
    ///
    /// # Errors
    /// [`HysteresisError::Elements`] for a number that the family cannot have.
    pub fn with_elements(self, count: usize) -> Result<Self, HysteresisError> {
        let allowed = match self.description().elements() {
            None => "their number is fixed".to_owned(),
            Some(Elements { most, .. }) if !(1..=most).contains(&count) => format!("it has 1 to {most}"),
            Some(_) => {
                return Ok(match self {
                    Self::BoucWen => self,
                    Self::Family(form) => Self::Family(form.of_elements(count)),
                });
            }
        };
        Err(HysteresisError::Elements { family: self.name(), found: count, allowed })
    }

    /// Name, as on the command line and in model files.
    pub fn name(self) -> &'static str {
        self.description().name()
    }

    /// The family in a line.
    pub fn summary(self) -> &'static str {
        self.description().summary()
    }

    /// Names of the weights.
    pub fn weight_names(self) -> Vec<String> {
        (0..self.columns()).map(|index| self.description().weight_name(index)).collect()
    }

    /// The shape numbers θ, with their ranges for drives that span `span`.
    pub fn shape_numbers(self, span: &DriveSpan) -> Vec<ShapeNumber> {
        self.description().shape_numbers(self.elements(), span)
    }

    /// Names of the shape numbers θ.
    pub fn shape_names(self) -> Vec<String> {
        self.shape_numbers(&DriveSpan::UNIT).into_iter().map(|number| number.name).collect()
    }

    /// Shapes for a fit to start from.
    pub fn starts(self, span: &DriveSpan) -> Vec<Vec<f64>> {
        self.description().starts(self.elements(), span)
    }

    /// A generic shape within its ranges, for tests.
    pub fn example(self, span: &DriveSpan) -> Vec<f64> {
        self.description().example(self.elements(), span)
    }

    /// Number of columns, and of weights.
    pub fn columns(self) -> usize {
        self.description().columns(self.elements())
    }

    /// The sign s of a weighted column in v.
    pub fn sign(self) -> f64 {
        match self {
            Self::BoucWen => -1.0,
            Self::Family(_) => 1.0,
        }
    }

    /// True if all weights have the sign of the slope dv/du, so that every move raises v with u.
    pub fn is_monotone(self) -> bool {
        self.description().is_monotone()
    }

    /// Pairs of weights of adjacent cells of a plane.
    pub fn neighbours(self) -> Vec<(usize, usize)> {
        self.description().neighbours(self.elements())
    }

    /// Pairs of weights of plays of neighbouring thresholds, and of neighbouring bands; the widest play has
    /// the neighbour `None`, of weight 0. Empty for families without plays that are weighted one by one.
    pub fn chain(self) -> Vec<(usize, Option<usize>)> {
        self.description().chain(self.elements())
    }

    /// Runs the operators over the drive `u` \[V\], given on a time base finer by a factor, from `start`;
    /// derivatives with respect to those shape numbers that `wanted` marks, and to the memory, where it is
    /// given.
    ///
    /// # Errors
    /// [`HysteresisError`] for invalid numbers or an invalid drive.
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
        match self {
            Self::BoucWen => bouc_wen::run(unit_shape(shape)?, grid.factor, u, start, wanted, out),
            Self::Family(form) => form.run(shape, grid, u, start, wanted, out),
        }
    }

    /// Property of the drive that the memory depends on.
    pub fn depends_on(self) -> Dependence {
        self.description().depends_on()
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
            Self::Family(form) => {
                Family::new(polynomial, form, shape.to_vec(), weights.to_vec()).map(Hysteresis::Family)
            }
        }
    }

    /// A record's memory in the operator's own scale, z(0) = α ζ(0) for Bouc–Wen, from that of the columns.
    pub fn own_memory(self, memory: f64, weights: &[f64]) -> f64 {
        match self {
            Self::BoucWen => memory * weights.first().copied().unwrap_or(0.0),
            Self::Family(_) => memory,
        }
    }
}

impl HysteresisForm {
    /// A record's memory in the scale of the columns, from that in the operator's own; 0 without memory.
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
            Self::Family(model) => HysteresisForm::Family(model.form),
        }
    }

    /// Weights in the order of [`HysteresisForm::weight_names`].
    pub fn weights(&self) -> Vec<f64> {
        match self {
            Self::BoucWen(model) => vec![model.alpha],
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

fn unit_shape(shape: &[f64]) -> Result<UnitShape, HysteresisError> {
    match *shape {
        [beta, gamma, n] => Ok(UnitShape { beta, gamma, n }),
        _ => Err(HysteresisError::ShapeCount { expected: 3, found: shape.len() }),
    }
}

#[cfg(test)]
mod tests;
