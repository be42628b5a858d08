//! A model of any family, sample by sample.

use super::super::columns::ColumnKernel;
use super::super::{
    Dahl, DeadZonePlays, Duhem, GeneralisedPlays, HysteresisError, JilesAtherton, KrasnoselskiiPokrovskii,
    MaxwellSlip, NonSymmetricBoucWen, OneSidedPlays, ParallelBoucWen, Preisach, PreisachDensity,
    RateDependentPlays, SongDerKiureghian, polynomial,
};
use super::Family;

macro_rules! runners {
    ($($kernel:ident),*) => {
        /// A kernel with its shape and state.
        #[derive(Clone, Debug)]
        pub(super) enum Runner {
            $($kernel($kernel, Vec<f64>, <$kernel as ColumnKernel>::State<f64>)),*
        }

        $(impl From<($kernel, Vec<f64>, f64)> for Runner {
            fn from((kernel, shape, u): ($kernel, Vec<f64>, f64)) -> Self {
                let state = kernel.virgin(&shape, u);
                Self::$kernel(kernel, shape, state)
            }
        })*

        impl Runner {
            /// Moves to `u` and reads the columns.
            fn step(&mut self, u: f64, row: &mut [f64]) -> Result<(), HysteresisError> {
                match self {
                    $(Self::$kernel(kernel, shape, state) => kernel.step(shape, state, u, row)),*
                }
            }

            /// Makes the state virgin at `u` and reads the columns.
            fn rest_at(&mut self, u: f64, row: &mut [f64]) {
                match self {
                    $(Self::$kernel(kernel, shape, state) => {
                        *state = kernel.virgin(shape, u);
                        kernel.read(shape, state, row);
                    }),*
                }
            }
        }
    };
}

runners!(
    ParallelBoucWen,
    NonSymmetricBoucWen,
    SongDerKiureghian,
    Dahl,
    Duhem,
    MaxwellSlip,
    OneSidedPlays,
    RateDependentPlays,
    DeadZonePlays,
    GeneralisedPlays,
    KrasnoselskiiPokrovskii,
    Preisach,
    PreisachDensity,
    JilesAtherton
);

/// A [`Family`] with its memory: voltage \[V\] in, v \[µm\] out, what [`Family::simulate_every`] gives for a whole record.
#[derive(Clone, Debug)]
pub struct FamilyStream {
    runner: Runner,
    polynomial: Vec<f64>,
    weights: Vec<f64>,
    row: Vec<f64>,
}

impl FamilyStream {
    /// The model, virgin at 0 V; `interval_s`: seconds between samples, for a family that sees the rate.
    ///
    /// # Errors
    /// As [`Family::validate`]; [`HysteresisError::Interval`].
    pub fn new(model: &Family, interval_s: Option<f64>) -> Result<Self, HysteresisError> {
        model.validate()?;
        let runner = model.form.runner(&model.shape, interval_s, 0.0)?;
        let row = vec![0.0; model.weights.len()];
        Ok(Self { runner, polynomial: model.polynomial.clone(), weights: model.weights.clone(), row })
    }

    /// Makes the model virgin at `voltage`; v there.
    pub fn rest_at(&mut self, voltage: f64) -> f64 {
        self.runner.rest_at(voltage, &mut self.row);
        self.output(voltage)
    }

    /// Moves monotonically to `voltage`; v there.
    ///
    /// # Errors
    /// [`HysteresisError::Drive`] for a voltage that is not finite; [`HysteresisError::Overflow`]; as the family's own move.
    pub fn step(&mut self, voltage: f64) -> Result<f64, HysteresisError> {
        if !voltage.is_finite() {
            return Err(HysteresisError::Drive { index: 0 });
        }
        self.runner.step(voltage, &mut self.row)?;
        let v = self.output(voltage);
        if v.is_finite() { Ok(v) } else { Err(HysteresisError::Overflow { index: 0 }) }
    }

    fn output(&self, voltage: f64) -> f64 {
        let memory: f64 = self.weights.iter().zip(&self.row).map(|(w, h)| w * h).sum();
        polynomial::value(&self.polynomial, voltage) + memory
    }
}
