//! A family of columns with its number of elements.

use std::fmt;
use std::hash::{Hash, Hasher};

use super::description::FamilyDescription;
use super::number::{DriveSpan, NumberUnit};
use super::operators::{ColumnOperators, Mover};
use crate::hysteresis::follow::{DriveLimits, Followed};
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, HysteresisError};
use crate::record::Dependence;
use crate::start::Start;

/// A family of columns with its fixed structure. Families on a grid take its ends from their shape numbers.
#[derive(Clone, Copy)]
pub struct FamilyForm {
    family: &'static dyn ColumnOperators,
    /// 0 where the number is fixed.
    elements: usize,
}

impl FamilyForm {
    /// A family with this number of elements, 0 where it is fixed.
    pub(in crate::hysteresis) fn of(family: &'static dyn ColumnOperators, elements: usize) -> Self {
        Self { family, elements }
    }

    /// The family with this number of elements; [`crate::hysteresis::HysteresisForm::with_elements`] checks
    /// their number.
    pub(in crate::hysteresis) fn of_elements(self, elements: usize) -> Self {
        Self { elements, ..self }
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

    /// Number of elements; 0 where it is fixed.
    pub fn elements(self) -> usize {
        self.elements
    }

    /// Name, as on the command line and in model files.
    pub fn name(self) -> &'static str {
        self.family.name()
    }

    /// Number of columns, and of weights.
    pub fn columns(self) -> usize {
        self.family.columns(self.elements)
    }

    /// Names and units of the weights.
    pub fn weight_numbers(self) -> Vec<(String, NumberUnit)> {
        (0..self.columns()).map(|j| (self.family.weight_name(j), self.family.weight_unit(j))).collect()
    }

    /// Names and units of the shape numbers.
    pub fn shape_numbers(self) -> Vec<(String, NumberUnit)> {
        let numbers = self.family.shape_numbers(self.elements, &DriveSpan::UNIT).into_iter();
        numbers.map(|number| (number.name, number.unit)).collect()
    }

    /// True if every column of a slow drive rises with u and falls with it, so that weights of one sign make
    /// a monotone model.
    pub fn is_monotone(self) -> bool {
        self.family.is_monotone()
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
        self.family.check(self.elements, shape)
    }

    /// Seconds between samples where the family needs them; otherwise arbitrary.
    fn interval(self, interval_s: Option<f64>) -> Result<f64, HysteresisError> {
        match interval_s {
            Some(interval_s) => Ok(interval_s),
            None if self.family.depends_on() != Dependence::Order => Err(HysteresisError::Interval),
            None => Ok(1.0),
        }
    }

    /// The operators, virgin at the voltage `u` \[V\], to be moved sample by sample. The shape has been
    /// checked.
    pub(super) fn mover(
        self,
        shape: &[f64],
        interval_s: Option<f64>,
        u: f64,
    ) -> Result<Box<dyn Mover>, HysteresisError> {
        Ok(self.family.mover(self.elements, shape, self.interval(interval_s)?, u))
    }

    /// Adds Σⱼ `weights`\[j\] Hⱼ at every sample of the grid to `out`.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub(super) fn add_weighted(
        self,
        (shape, weights): (&[f64], &[f64]),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.check(shape)?;
        let structure = (self.elements, shape, self.interval_of(grid)?);
        self.family.simulate(structure, grid, u, start, &mut |rows| rows.add_weighted(weights, out))
    }

    /// Seconds between the samples of a grid; where the paces are given, they do not matter.
    fn interval_of(self, grid: DriveGrid<'_>) -> Result<f64, HysteresisError> {
        self.interval(grid.interval_s.or(grid.paces.map(|_| 1.0)))
    }

    /// [`crate::hysteresis::HysteresisForm::run`].
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
        self.family.run(structure, grid, u, start, wanted, out)
    }

    /// [`crate::hysteresis::Hysteresis::follow`], beside an `anhysteretic` part.
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
        let structure = (self.elements, shape, interval_s);
        self.family.follow(structure, weights, &anhysteretic, wanted, start, limits)
    }
}

impl fmt::Debug for FamilyForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.family.elements() {
            Some(_) => write!(f, "{} of {}", self.name(), self.elements),
            None => f.write_str(self.name()),
        }
    }
}

impl PartialEq for FamilyForm {
    fn eq(&self, other: &Self) -> bool {
        (self.name(), self.elements) == (other.name(), other.elements)
    }
}

impl Eq for FamilyForm {}

impl Hash for FamilyForm {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.name(), self.elements).hash(state);
    }
}
