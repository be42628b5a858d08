//! Families whose columns are those of a [`ColumnKernel`].

use std::fmt;

use super::description::FamilyDescription;
use super::number::ends;
use super::run;
use crate::hysteresis::columns::{ColumnKernel, Rows, simulate};
use crate::hysteresis::follow::{self, DriveLimits, Followed};
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, HysteresisError};
use crate::start::Start;

/// A family and its kernel.
pub(in crate::hysteresis) trait ColumnFamily: FamilyDescription {
    /// The operators of its columns.
    type Kernel: ColumnKernel<State<f64>: fmt::Debug + Send + Sync>
        + Clone
        + fmt::Debug
        + Send
        + Sync
        + 'static;

    /// Leading numbers of the shape that are structure of the kernel: none, [`GRID_ENDS`] or [`WHOLE_SHAPE`].
    const FIXED: usize = 0;

    /// The kernel of this structure; `interval_s`: seconds between samples, for a rate-dependent family.
    fn kernel(&self, elements: usize, shape: &[f64], interval_s: f64) -> Self::Kernel;

    /// [`ColumnOperators::run`]; without derivatives with respect to the structure, unless the family
    /// provides them.
    fn run_columns(
        &self,
        (elements, shape, interval_s): (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        let kernel = self.kernel(elements, shape, interval_s);
        run::run(&kernel, (shape, Self::FIXED), grid, u, start, wanted, out)
    }
}

/// The two ends of the kernel's grid are structure of it.
pub(in crate::hysteresis) const GRID_ENDS: usize = 2;
/// All numbers of the shape are structure.
pub(in crate::hysteresis) const WHOLE_SHAPE: usize = usize::MAX;

/// Operations on a family, whatever its kernel.
pub(in crate::hysteresis) trait ColumnOperators: FamilyDescription {
    /// Checks structure and a shape of the right length.
    fn check(&self, elements: usize, shape: &[f64]) -> Result<(), HysteresisError>;

    /// [`crate::hysteresis::FamilyForm::run`]; `structure`: elements, shape, and seconds between samples.
    fn run(
        &self,
        structure: (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError>;

    /// Passes the columns to `put`, a few samples at a time.
    fn simulate(
        &self,
        structure: (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        put: &mut dyn FnMut(&Rows<f64>),
    ) -> Result<(), HysteresisError>;

    /// The operators, virgin at the voltage `u` \[V\], to be moved sample by sample.
    fn mover(&self, elements: usize, shape: &[f64], interval_s: f64, u: f64) -> Box<dyn Mover>;

    /// [`crate::hysteresis::Hysteresis::follow`], beside an `anhysteretic` part.
    fn follow(
        &self,
        structure: (usize, &[f64], f64),
        weights: &[f64],
        anhysteretic: &dyn Fn(f64) -> f64,
        wanted: &[f64],
        start: (f64, Option<f64>),
        limits: &DriveLimits,
    ) -> Result<Followed, HysteresisError>;
}

fn own<F: ColumnFamily>(shape: &[f64]) -> &[f64] {
    shape.get(F::FIXED..).unwrap_or_default()
}

impl<F: ColumnFamily> ColumnOperators for F {
    fn check(&self, elements: usize, shape: &[f64]) -> Result<(), HysteresisError> {
        let [low, high] = ends(shape);
        if F::FIXED == GRID_ENDS && !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        self.kernel(elements, shape, 1.0).check(own::<F>(shape))
    }

    fn run(
        &self,
        structure: (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        self.run_columns(structure, grid, u, start, wanted, out)
    }

    fn simulate(
        &self,
        (elements, shape, interval_s): (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        put: &mut dyn FnMut(&Rows<f64>),
    ) -> Result<(), HysteresisError> {
        let kernel = self.kernel(elements, shape, interval_s);
        simulate(&kernel, own::<F>(shape), grid, u, start, None, put).map(|_| ())
    }

    fn mover(&self, elements: usize, shape: &[f64], interval_s: f64, u: f64) -> Box<dyn Mover> {
        let kernel = self.kernel(elements, shape, interval_s);
        let shape = own::<F>(shape).to_vec();
        let state = kernel.virgin(&shape, u);
        Box::new(MovingKernel { kernel, shape, state })
    }

    fn follow(
        &self,
        (elements, shape, interval_s): (usize, &[f64], f64),
        weights: &[f64],
        anhysteretic: &dyn Fn(f64) -> f64,
        wanted: &[f64],
        start: (f64, Option<f64>),
        limits: &DriveLimits,
    ) -> Result<Followed, HysteresisError> {
        let kernel = self.kernel(elements, shape, interval_s);
        follow::columns(&kernel, own::<F>(shape), weights, anhysteretic, wanted, start, limits)
    }
}

/// Operators with their state.
pub(in crate::hysteresis) trait Mover: fmt::Debug + Send + Sync {
    /// Moves to `u` and reads the columns.
    fn step(&mut self, u: f64, row: &mut [f64]) -> Result<(), HysteresisError>;

    /// Makes the state virgin at `u` and reads the columns.
    fn rest_at(&mut self, u: f64, row: &mut [f64]);

    /// A copy in the same state.
    fn twin(&self) -> Box<dyn Mover>;
}

#[derive(Clone, Debug)]
struct MovingKernel<K, S> {
    kernel: K,
    shape: Vec<f64>,
    state: S,
}

impl<K> Mover for MovingKernel<K, K::State<f64>>
where
    K: ColumnKernel<State<f64>: fmt::Debug + Send + Sync> + Clone + fmt::Debug + Send + Sync + 'static,
{
    fn step(&mut self, u: f64, row: &mut [f64]) -> Result<(), HysteresisError> {
        self.kernel.step(&self.shape, &mut self.state, u, row)
    }

    fn rest_at(&mut self, u: f64, row: &mut [f64]) {
        self.state = self.kernel.virgin(&self.shape, u);
        self.kernel.read(&self.shape, &self.state, row);
    }

    fn twin(&self) -> Box<dyn Mover> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Mover> {
    fn clone(&self) -> Self {
        self.twin()
    }
}
