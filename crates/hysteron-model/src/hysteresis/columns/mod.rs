//! Families of hysteresis that are linear in weights: v = Σ cᵢ uⁱ + Σⱼ wⱼ Hⱼ\[u; θ\].
//!
//! A [`ColumnKernel`] is the operators Hⱼ of one family, its *columns*: their response to moves of the
//! voltage, in numbers that carry derivatives where requested. A fit needs nothing else of a family: the
//! columns enter linearly, the few numbers θ (its *shape*) do not.

mod pass;
mod relaxing;
mod rows;

pub use pass::ColumnSensitivities;
pub(super) use pass::{differentiate, put_into, simulate};
pub(super) use relaxing::{RelaxingState, branch_kernel};
pub(super) use rows::Rows;

use hysteron_rt::{Dual, Scalar};

use super::{DriveGrid, HysteresisError};
use crate::record::Pace;
use crate::start::Start;

/// The operators of one family: fixed structure in the type, shape θ beside it.
///
/// The memory of a [`Start::Remembering`] is the voltage \[V\] at which the device was virgin before it moved
/// monotonically to its rest voltage; with respect to it, or to the rest voltage of a virgin device, the
/// columns are differentiated. Wiping-out operators (plays, relays) are in the steady state after one period;
/// what the drive never moves is in the state of a device virgin at the middle of the drive's range. For
/// relaxing operators the secant method finds the steady state.
///
/// A move is monotone from the present voltage to the next and exact whatever its length, so that the sample
/// rate does not matter as long as every turning point of u is a sample. Numbers are `f64`, or duals that
/// carry the derivatives of everything with respect to θ and the start.
///
/// `virgin`, `advance` and `read` are the arithmetic of one sample and take a checked shape; the methods over
/// records check it.
pub trait ColumnKernel {
    /// Present voltage and memory.
    type State<S: Scalar<Real = f64>>: Clone;

    /// Names of the shape parameters θ.
    fn shape_names(&self) -> &'static [&'static str];

    /// Checks the structure and the values of a shape that has one number per name.
    ///
    /// # Errors
    /// The first [`HysteresisError`] found.
    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError>;

    /// Number of columns K.
    fn columns(&self) -> usize;

    /// Index of the first column that depends on θ; those before do not.
    fn first_shaped(&self) -> usize {
        0
    }

    /// The virgin state at the voltage `u` \[V\].
    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> Self::State<S>;

    /// Moves monotonically to the voltage `u` \[V\].
    ///
    /// # Errors
    /// [`HysteresisError`] with sample 0 where the move has no result; the state is then invalid.
    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut Self::State<S>,
        u: f64,
    ) -> Result<(), HysteresisError>;

    /// The K columns at the present voltage into `out`.
    fn read<S: Scalar<Real = f64>>(&self, shape: &[S], state: &Self::State<S>, out: &mut [S]);

    /// The relaxing part of the memory: uncoupled numbers, each converging to its steady state by an
    /// increasing map. Empty for wiping-out memory.
    fn relaxing<S: Scalar<Real = f64>>(state: &mut Self::State<S>) -> &mut [S] {
        let _ = state;
        &mut []
    }

    /// This state in plain numbers where no drive between the voltages `reach` changes a derivative anymore; `None`
    /// where one may, and by default.
    fn with_derivatives_constant<const P: usize>(
        &self,
        shape: &[f64],
        state: &Self::State<Dual<f64, P>>,
        reach: [f64; 2],
    ) -> Option<Self::State<f64>> {
        let _ = (shape, state, reach);
        None
    }

    /// Sets the voltage before the next one for a memory that depends on time; nothing moves.
    fn preceded<S: Scalar<Real = f64>>(state: &mut Self::State<S>, by: Option<f64>) {
        let _ = (state, by);
    }

    /// Sets the pace of the next move for a memory that depends on time; nothing moves.
    fn paced<S: Scalar<Real = f64>>(state: &mut Self::State<S>, pace: Pace) {
        let _ = (state, pace);
    }

    /// [`Self::advance`] and [`Self::read`].
    ///
    /// # Errors
    /// Those of [`Self::advance`].
    fn step<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut Self::State<S>,
        u: f64,
        out: &mut [S],
    ) -> Result<(), HysteresisError> {
        self.advance(shape, state, u)?;
        self.read(shape, state, out);
        Ok(())
    }

    /// The columns for the voltages `u` \[V\] given on a time base finer by the factor of a grid, one after
    /// the other into `out`: value k of column j is `out[j * n + k]` and belongs to `u[k * factor]`, n = ⌈len
    /// u / factor⌉. Returns the state at the last sample of u. Of the grid, only factor and paces are used:
    /// the interval is the kernel's. Allocates a state and a few rows of K numbers, nothing per sample.
    ///
    /// # Errors
    /// [`HysteresisError::ShapeCount`] and as [`Self::check`]; [`HysteresisError::Factor`];
    /// [`HysteresisError::Lengths`]; [`HysteresisError::Drive`] where u is not finite;
    /// [`HysteresisError::NotSettled`] for a periodic start; [`HysteresisError::Overflow`] where a column is
    /// not finite; and as [`Self::advance`], with the sample.
    fn simulate_every<'a>(
        &self,
        shape: &[f64],
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<Self::State<f64>, HysteresisError>
    where
        Self: Sized,
    {
        pass::simulate_into(self, shape, grid.into(), u, start, out)
    }

    /// [`Self::simulate_every`] from a known `state`, which ends at the last sample of u.
    ///
    /// # Errors
    /// Those of [`Self::simulate_every`]; `state` is then invalid.
    fn continue_every<'a>(
        &self,
        shape: &[f64],
        state: &mut Self::State<f64>,
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        out: &mut [f64],
    ) -> Result<(), HysteresisError>
    where
        Self: Sized,
    {
        pass::continue_from(self, shape, state, grid.into(), u, out)
    }

    /// [`Self::simulate_every`], with the derivatives of every column with respect to θ and the start.
    /// Those of a periodic start are total: the steady state moves with θ.
    ///
    /// # Errors
    /// Those of [`Self::simulate_every`]; [`HysteresisError::NotContracting`] where a steady state does not
    /// determine its derivatives.
    fn simulate_with_sensitivities<'a>(
        &self,
        shape: &[f64],
        grid: impl Into<DriveGrid<'a>>,
        u: &[f64],
        start: Start<f64>,
        out: &mut ColumnSensitivities,
    ) -> Result<(), HysteresisError>
    where
        Self: Sized;
}

/// [`ColumnKernel::simulate_with_sensitivities`] of a kernel with this number of shape parameters: its
/// numbers carry that many derivatives and the one with respect to the start. A literal, so that no kernel is
/// compiled for other counts.
macro_rules! simulate_with_sensitivities {
    ($($parameters:literal)|+) => {
        fn simulate_with_sensitivities<'a>(
            &self,
            shape: &[f64],
            grid: impl Into<$crate::hysteresis::DriveGrid<'a>>,
            u: &[f64],
            start: $crate::start::Start<f64>,
            out: &mut $crate::hysteresis::ColumnSensitivities,
        ) -> Result<(), $crate::hysteresis::HysteresisError> {
            use $crate::hysteresis::columns::differentiate;
            match shape.len() {
                $($parameters =>
                    differentiate::<{ $parameters + 1 }, _>(self, shape, grid.into(), u, start, out),)+
                given => Err($crate::hysteresis::HysteresisError::ShapeCount {
                    expected: self.shape_names().len(),
                    found: given,
                }),
            }
        }
    };
}
pub(super) use simulate_with_sensitivities;

/// Shape parameter number `index`.
#[inline(always)]
pub(super) fn parameter<S: Scalar<Real = f64>>(shape: &[S], index: usize) -> S {
    shape.get(index).copied().unwrap_or(S::constant(f64::NAN))
}

/// True of a number without derivatives.
pub(super) fn is_plain<const P: usize>(number: &Dual<f64, P>) -> bool {
    number.partials.iter().all(|partial| *partial == 0.0)
}

/// Finite and above 0.
pub(super) fn positive(name: &'static str, value: f64) -> Result<(), HysteresisError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(HysteresisError::ShapeParameter { name, value, must: "positive and finite" })
    }
}

/// Finite.
pub(super) fn finite(name: &'static str, value: f64) -> Result<(), HysteresisError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(HysteresisError::ShapeParameter { name, value, must: "finite" })
    }
}
