//! A family with its number of elements.

use std::fmt;
use std::hash::{Hash, Hasher};

use super::description::{Elements, FamilyDescription};
use super::number::{DriveSpan, ModelNumber, ShapeNumber};
use super::operators::{ColumnOperators, Mover};
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, FAMILIES, Hysteresis, HysteresisError};
use crate::record::Dependence;
use crate::start::Start;
use crate::unknown_name::UnknownName;

/// A family of hysteresis operators with its fixed structure.
///
/// Every family is v = Σ cᵢ uⁱ + Σ_j w_j s H_j\[u; θ\]: linear in its weights w, nonlinear in a few shape
/// numbers θ, with columns H_j, the outputs of an operator, and a sign s that is the family's convention.
/// Families on a grid take its ends from their shape numbers.
#[derive(Clone, Copy)]
pub struct HysteresisForm {
    family: &'static dyn ColumnOperators,
    /// 0 where the number is fixed.
    elements: usize,
}

impl Default for HysteresisForm {
    /// The first of the list: the article's.
    fn default() -> Self {
        Self::of(FAMILIES[0], 0)
    }
}

impl std::str::FromStr for HysteresisForm {
    type Err = UnknownName;

    /// The family of this name, with its usual number of elements.
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("hysteresis family", name, Self::usual(), Self::name)
    }
}

impl HysteresisForm {
    /// A family with this number of elements, 0 where it is fixed.
    pub(in crate::hysteresis) const fn of(family: &'static dyn ColumnOperators, elements: usize) -> Self {
        Self { family, elements }
    }

    /// Every family with its usual number of elements, the article's first.
    pub fn usual() -> Vec<Self> {
        let usual = |family: &dyn ColumnOperators| family.elements().map_or(0, |elements| elements.usual);
        FAMILIES.iter().map(|&family| Self::of(family, usual(family))).collect()
    }

    /// The family with another number of elements.
    ///
    /// # Errors
    /// [`HysteresisError::Elements`] for a number that the family cannot have.
    pub fn with_elements(self, count: usize) -> Result<Self, HysteresisError> {
        let allowed = match self.family.elements() {
            None => "their number is fixed".to_owned(),
            Some(Elements { most, .. }) if !(1..=most).contains(&count) => format!("it has 1 to {most}"),
            Some(_) => return Ok(Self { elements: count, ..self }),
        };
        Err(HysteresisError::Elements { family: self.name(), found: count, allowed })
    }

    /// The family that a fit searches for models of this one: itself, or one with fewer unknowns.
    pub fn searched(self) -> Self {
        Self { family: self.family.searched().unwrap_or(self.family), ..self }
    }

    /// This family with another number of weights; `None` where it has no such member.
    pub fn with_weights(self, weights: usize) -> Option<Self> {
        let elements = if self.family.elements().is_some() { 0..=weights } else { 0..=0 };
        let of = |elements| Self { elements, ..self };
        elements.map(of).find(|form| weights > 0 && form.columns() == weights)
    }

    /// Description of the family.
    pub fn description(self) -> &'static dyn FamilyDescription {
        self.family
    }

    pub(in crate::hysteresis) fn family(self) -> &'static dyn ColumnOperators {
        self.family
    }

    /// Number of elements: plays, slip elements, states, lines or intervals of a plane, degree; 0 where it is
    /// fixed.
    pub fn elements(self) -> usize {
        self.elements
    }

    /// Name, as on the command line and in model files.
    pub fn name(self) -> &'static str {
        self.family.name()
    }

    /// The family in a line.
    pub fn summary(self) -> &'static str {
        self.family.summary()
    }

    /// Number of columns, and of weights.
    pub fn columns(self) -> usize {
        self.family.columns(self.elements)
    }

    /// Names of the weights.
    pub fn weight_names(self) -> Vec<String> {
        (0..self.columns()).map(|index| self.family.weight_name(index)).collect()
    }

    /// The shape numbers θ, with their ranges for drives that span `span`.
    pub fn shape_numbers(self, span: &DriveSpan) -> Vec<ShapeNumber> {
        self.family.shape_numbers(self.elements, span)
    }

    /// Names of the shape numbers θ.
    pub fn shape_names(self) -> Vec<String> {
        self.shape_numbers(&DriveSpan::UNIT).into_iter().map(|number| number.name).collect()
    }

    /// The numbers of a model beside its polynomial, in the order of a model file.
    pub fn model_numbers(self) -> Vec<ModelNumber> {
        self.family.model_numbers(self.elements)
    }

    /// Shapes for a fit to start from.
    pub fn starts(self, span: &DriveSpan) -> Vec<Vec<f64>> {
        self.family.starts(self.elements, span)
    }

    /// A generic shape within its ranges, for tests.
    pub fn example(self, span: &DriveSpan) -> Vec<f64> {
        self.family.example(self.elements, span)
    }

    /// The sign s of a weighted column in v.
    pub fn sign(self) -> f64 {
        self.family.sign()
    }

    /// True if every column of a slow drive rises with u and falls with it, so that weights of one sign make
    /// a monotone model.
    pub fn is_monotone(self) -> bool {
        self.family.is_monotone()
    }

    /// Pairs of weights of adjacent cells of a plane.
    pub fn neighbours(self) -> Vec<(usize, usize)> {
        self.family.neighbours(self.elements)
    }

    /// Pairs of weights of plays of neighbouring thresholds, and of neighbouring bands; the widest play has
    /// the neighbour `None`, of weight 0. Empty for families without plays that are weighted one by one.
    pub fn chain(self) -> Vec<(usize, Option<usize>)> {
        self.family.chain(self.elements)
    }

    /// Property of the drive that the memory depends on.
    pub fn depends_on(self) -> Dependence {
        self.family.depends_on()
    }

    /// A record's memory in a model's own scale, from that of the columns.
    pub fn own_memory(self, memory: f64, weights: &[f64]) -> f64 {
        self.family.own_memory(memory, weights)
    }

    /// A record's memory in the scale of the columns, from a model's own; 0 without memory.
    pub fn memory_of_columns(self, memory: f64, weights: &[f64]) -> f64 {
        self.family.memory_of_columns(memory, weights)
    }

    /// Checks structure and shape.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    pub fn check(self, shape: &[f64]) -> Result<(), HysteresisError> {
        let expected = self.shape_names().len();
        if shape.len() != expected {
            return Err(HysteresisError::ShapeCount { expected, found: shape.len() });
        }
        self.family.check(self.elements, shape)
    }

    /// Seconds between samples where the family needs them; otherwise arbitrary.
    pub(in crate::hysteresis) fn interval(self, interval_s: Option<f64>) -> Result<f64, HysteresisError> {
        match interval_s {
            Some(interval_s) => Ok(interval_s),
            None if self.family.depends_on() != Dependence::Order => Err(HysteresisError::Interval),
            None => Ok(1.0),
        }
    }

    /// Seconds between the samples of a grid; where the paces are given, they do not matter.
    pub(super) fn interval_of(self, grid: DriveGrid<'_>) -> Result<f64, HysteresisError> {
        self.interval(grid.interval_s.or(grid.paces.map(|_| 1.0)))
    }

    /// The operators of the columns, virgin at the voltage `u` \[V\], to be moved sample by sample. The shape
    /// has been checked.
    pub(super) fn mover(
        self,
        shape: &[f64],
        interval_s: Option<f64>,
        u: f64,
    ) -> Result<Box<dyn Mover>, HysteresisError> {
        self.family.mover(self.elements, shape, self.interval(interval_s)?, u)
    }

    /// Runs the operators of the columns over the drive `u` \[V\], given on a time base finer by a factor,
    /// from `start`; derivatives with respect to those shape numbers that `wanted` marks, and to the memory,
    /// where it is given.
    ///
    /// # Errors
    /// [`HysteresisError`]: a shape invalid for the family, a drive that is not finite, a state that runs
    /// away, an unknown time between samples where the family needs it.
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
        let structure = (self.elements, shape, self.interval_of(grid)?);
        out.changed.clear();
        self.family.run(structure, grid, u, start, wanted, out)?;
        // Families that keep nothing do not say so.
        let samples = |values: &Vec<f64>| values.len();
        out.changed.extend(out.values.iter().map(samples).skip(out.changed.len()));
        Ok(())
    }

    /// [`Self::run`] where `out` is of an earlier run over the same drive, from the same start but for its
    /// memory: families may keep what does not change.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_again<'a>(
        self,
        shape: &[f64],
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        out.is_again = true;
        let done = self.run(shape, grid, u, start, wanted, out);
        out.is_again = false;
        done
    }

    /// The operator with these numbers, `shape` being that of the columns.
    ///
    /// # Errors
    /// Those of [`Hysteresis::validate`].
    pub fn operator(
        self,
        polynomial: Vec<f64>,
        weights: &[f64],
        shape: &[f64],
    ) -> Result<Hysteresis, HysteresisError> {
        if self.family.is_written_as_plays()
            && let Some(plays) = self.family.as_plays(self.elements, &polynomial, shape, weights)
        {
            plays.validate()?;
            return Ok(plays.into());
        }
        Hysteresis::new(polynomial, self, self.family.own_shape(shape, weights), weights.to_vec())
    }
}

impl fmt::Debug for HysteresisForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.family.elements() {
            Some(_) => write!(f, "{} of {}", self.name(), self.elements),
            None => f.write_str(self.name()),
        }
    }
}

impl PartialEq for HysteresisForm {
    fn eq(&self, other: &Self) -> bool {
        (self.name(), self.elements) == (other.name(), other.elements)
    }
}

impl Eq for HysteresisForm {}

impl Hash for HysteresisForm {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.name(), self.elements).hash(state);
    }
}
