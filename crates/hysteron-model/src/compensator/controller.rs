//! The inverse of a model as one self-contained object.

use hysteron_rt::{Compensator, Drive};
use self_cell::{MutBorrow, self_cell};
use serde::{Deserialize, Serialize};

use super::{Compensation, CompensatorOptions, CompensatorParts, InversionError};
use crate::hammerstein::Model;

/// Limits of a drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Least voltage \[V\].
    pub low: f64,
    /// Largest voltage \[V\].
    pub high: f64,
    /// Largest rate of the voltage \[V/s\]; infinite for none.
    #[serde(default = "unlimited", with = "crate::unlimited")]
    pub slew_v_per_s: f64,
}

fn unlimited() -> f64 {
    f64::INFINITY
}

impl Limits {
    /// Between two voltages \[V\], at any rate.
    pub fn range(low: f64, high: f64) -> Self {
        Self { low, high, slew_v_per_s: f64::INFINITY }
    }

    /// These limits with a largest rate \[V/s\].
    #[must_use]
    pub fn slew(self, v_per_s: f64) -> Self {
        Self { slew_v_per_s: v_per_s, ..self }
    }
}

type Running<'a> = Compensator<'a, f64>;

self_cell!(
    struct Cell {
        owner: MutBorrow<CompensatorParts<f64>>,

        #[not_covariant]
        dependent: Running,
    }
);

/// The inverse of a model, sample by sample: reference in, voltage out. It owns its coefficients and its
/// memory.
pub struct Controller {
    cell: Cell,
    preview: usize,
    sample_rate_hz: f64,
}

impl Controller {
    /// The controller of a model at its rate \[Hz\], at rest and virgin at the voltage of the range nearest
    /// to 0 V.
    ///
    /// # Errors
    /// Those of [`Compensation::new`] and [`CompensatorParts::new`].
    pub fn new(
        model: &Model,
        sample_rate_hz: f64,
        limits: Limits,
        options: &CompensatorOptions,
    ) -> Result<Self, InversionError> {
        Self::of_law(Compensation::new(model, sample_rate_hz, options)?, limits)
    }

    /// The controller of a law, at rest as [`Self::new`].
    ///
    /// # Errors
    /// Those of [`CompensatorParts::new`].
    pub fn of_law(compensation: Compensation, limits: Limits) -> Result<Self, InversionError> {
        let range = [limits.low, limits.high];
        let parts = CompensatorParts::new(&compensation, range, limits.slew_v_per_s)?;
        let (preview, sample_rate_hz) = (compensation.preview, compensation.sample_rate_hz);
        let cell = Cell::try_new(MutBorrow::new(parts), |parts| parts.borrow_mut().compensator())?;
        Ok(Self { cell, preview, sample_rate_hz })
    }

    /// The voltage for the next period. `reference` is the newest known value, [`Self::preview`] samples
    /// ahead; a value that is not finite repeats the previous one.
    pub fn step(&mut self, reference: f64) -> Drive<f64> {
        self.cell.with_dependent_mut(|_, compensator| compensator.step(reference))
    }

    /// Displacement that the model expects \[µm\].
    pub fn displacement(&self) -> f64 {
        self.cell.with_dependent(|_, compensator| compensator.displacement())
    }

    /// Resets the stage to rest, its hysteresis virgin, at `voltage` \[V\] clamped to the range; returns the
    /// displacement there \[µm\]. A voltage that is not finite changes nothing.
    pub fn rest_at(&mut self, voltage: f64) -> f64 {
        self.cell.with_dependent_mut(|_, compensator| {
            let rested = compensator.rest_at(voltage);
            rested.unwrap_or_else(|_| compensator.displacement())
        })
    }

    /// Samples by which the reference must be supplied ahead.
    pub fn preview(&self) -> usize {
        self.preview
    }

    /// Rate at which [`Self::step`] is to be called \[Hz\].
    pub fn sample_rate_hz(&self) -> f64 {
        self.sample_rate_hz
    }
}
