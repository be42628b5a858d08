//! Operations on a family: most have those of a [`ColumnKernel`], by [`ColumnFamily`].

use std::fmt;

use super::description::FamilyDescription;
use super::number::ends;
use super::run;
use crate::hysteresis::columns::{ColumnKernel, Rows, simulate};
use crate::hysteresis::follow::{self, DriveLimits, Followed};
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, Hysteresis, HysteresisError, Invertibility, polynomial};
use crate::start::Start;
use hysteron_numeric::Meter;

/// A family and its kernel. Its models have the numbers of its columns, and the sign 1.
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

    /// The family that fits search in its place.
    fn searched(&self) -> Option<&'static dyn ColumnOperators> {
        None
    }

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

    /// [`ColumnOperators::add_hysteresis`].
    fn add_columns(
        &self,
        model: &Hysteresis,
        interval_s: f64,
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        let kernel = self.kernel(model.form().elements(), model.own_shape(), interval_s);
        let add = |rows: &Rows<f64>| rows.add_weighted(model.weights(), out);
        simulate(&kernel, own::<Self>(model.own_shape()), grid, u, start, None, add).map(|_| ())
    }
}

/// The two ends of the kernel's grid are structure of it.
pub(in crate::hysteresis) const GRID_ENDS: usize = 2;
/// All numbers of the shape are structure.
pub(in crate::hysteresis) const WHOLE_SHAPE: usize = usize::MAX;

/// Operations on a family: on its columns, and on a model of it.
pub(in crate::hysteresis) trait ColumnOperators: FamilyDescription {
    /// The family that fits search in place of this one, for the same models with fewer unknowns.
    fn searched(&self) -> Option<&'static dyn ColumnOperators> {
        None
    }

    /// Checks structure and a shape of the right length, of the columns or of a model.
    fn check(&self, elements: usize, shape: &[f64]) -> Result<(), HysteresisError>;

    /// [`HysteresisForm::run`](super::HysteresisForm::run); `structure`: elements, shape, and seconds between
    /// samples.
    fn run(
        &self,
        structure: (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError>;

    /// The operators of the columns, virgin at the voltage `u` \[V\], to be moved sample by sample.
    fn mover(
        &self,
        elements: usize,
        shape: &[f64],
        interval_s: f64,
        u: f64,
    ) -> Result<Box<dyn Mover>, HysteresisError>;

    /// Adds the hysteretic part of a checked model at every sample of the grid to `out`.
    fn add_hysteresis(
        &self,
        model: &Hysteresis,
        interval_s: f64,
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError>;

    /// [`Hysteresis::follow`] of a checked model.
    fn follow(
        &self,
        model: &Hysteresis,
        interval_s: f64,
        wanted: &[f64],
        start: (f64, Option<f64>),
        limits: (&DriveLimits, &Meter<'_>),
    ) -> Result<Followed, HysteresisError>;

    /// [`Hysteresis::at_rest`].
    fn at_rest(&self, model: &Hysteresis, rest: f64, memory: Option<f64>) -> f64 {
        let mut columns = Columns::default();
        let start = Start::Rest { voltage_v: memory.unwrap_or(rest) };
        // The one move is without rate, whatever the time.
        let grid = DriveGrid::new(Some(1.0), 1, 1);
        match model.form().run(&model.shape(), grid, &[rest], start, None, &mut columns) {
            Ok(()) => {
                let at_rest = columns.values.iter().map(|h| h.first().copied().unwrap_or(0.0));
                let sum: f64 = at_rest.zip(model.weights()).map(|(h, w)| w * h).sum();
                model.polynomial_at(rest) + sum
            }
            Err(_) => f64::NAN,
        }
    }

    /// [`Hysteresis::memory_of_move`].
    fn memory_of_move(&self, model: &Hysteresis, virgin: f64, rest: f64) -> Result<f64, HysteresisError> {
        let _ = (model, rest);
        Ok(virgin)
    }

    /// [`Hysteresis::memory_range`].
    fn memory_range_of_model(&self, model: &Hysteresis, low: f64, high: f64) -> Option<(f64, f64)> {
        let reach = high - low;
        (low < high && model.weights().iter().any(|w| *w != 0.0)).then_some((low - reach, high + reach))
    }

    /// [`Hysteresis::invertibility`] over the `range` of the drive by a condition of the family, where that
    /// decides.
    fn invertibility(
        &self,
        model: &Hysteresis,
        range: [f64; 2],
        interval_s: Option<f64>,
    ) -> Option<Invertibility> {
        let (shape, weights) = (model.own_shape(), model.weights());
        match self.as_plays(model.form().elements(), model.polynomial(), shape, weights) {
            Some(same) => same.invertibility(range),
            None => {
                let pushed_back = self.pushes_back(shape, weights, interval_s)?;
                let rises = self.is_monotone()
                    && weights.iter().all(|w| *w >= 0.0)
                    && polynomial::not_steeper(model.polynomial(), pushed_back, range).is_none();
                rises.then_some(Invertibility::Everywhere)
            }
        }
    }
}

fn own<F: ColumnFamily + ?Sized>(shape: &[f64]) -> &[f64] {
    shape.get(F::FIXED..).unwrap_or_default()
}

impl<F: ColumnFamily> ColumnOperators for F {
    fn searched(&self) -> Option<&'static dyn ColumnOperators> {
        ColumnFamily::searched(self)
    }

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

    fn mover(
        &self,
        elements: usize,
        shape: &[f64],
        interval_s: f64,
        u: f64,
    ) -> Result<Box<dyn Mover>, HysteresisError> {
        let kernel = self.kernel(elements, shape, interval_s);
        let shape = own::<F>(shape).to_vec();
        let state = kernel.virgin(&shape, u);
        Ok(Box::new(MovingKernel { kernel, shape, state }))
    }

    fn add_hysteresis(
        &self,
        model: &Hysteresis,
        interval_s: f64,
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        self.add_columns(model, interval_s, grid, u, start, out)
    }

    fn follow(
        &self,
        model: &Hysteresis,
        interval_s: f64,
        wanted: &[f64],
        start: (f64, Option<f64>),
        limits: (&DriveLimits, &Meter<'_>),
    ) -> Result<Followed, HysteresisError> {
        let kernel = self.kernel(model.form().elements(), model.own_shape(), interval_s);
        follow::columns(&kernel, (own::<F>(model.own_shape()), model), wanted, start, limits)
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
