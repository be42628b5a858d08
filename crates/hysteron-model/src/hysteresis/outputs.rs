//! Outputs of the operators of a family over a record.

use hysteron_numeric::Stop;

use super::HysteresisError;
use super::Sensitivities;
use super::columns::ColumnSensitivities;
use crate::start::Start;

/// Columns H_j of a family over a record, and their derivatives. The buffers are kept between calls.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// H_j \[V\], as many samples each as the record has.
    pub values: Vec<Vec<f64>>,
    /// ∂H_j/∂θ_p, where it is not zero and was requested.
    pub partials: Vec<Partial>,
    /// ∂H_j/∂memory of [`crate::Start::Remembering`], 0 beyond its end; of a run with derivatives.
    pub by_memory: Vec<Vec<f64>>,
    /// H_j before the first sample; 0 for a steady state, which has none.
    pub rest: Vec<f64>,
    /// ∂(H_j before the first sample)/∂memory.
    pub rest_by_memory: Vec<f64>,
    /// Part of every value, and of `rest`, that is in neither: of operators that no sample moves. 0 for most
    /// families.
    pub standing: Vec<f64>,
    /// ∂standing/∂memory.
    pub standing_by_memory: Vec<f64>,
    /// Ends a long pass early.
    pub stop: Option<Stop>,
    /// Leading samples of every column that the run may have changed; the others are those of the earlier
    /// run ([`HysteresisForm::run_again`]). At most the samples of the column.
    ///
    /// [`HysteresisForm::run_again`]: super::HysteresisForm::run_again
    pub changed: Vec<usize>,
    /// The course of the run, for families that keep what does not change.
    pub(in crate::hysteresis) course: Option<PlayCourse>,
    /// The contents are those of an earlier run over the same drive.
    pub(in crate::hysteresis) is_again: bool,
    pub(in crate::hysteresis) sensitivities: Sensitivities,
    pub(in crate::hysteresis) scratch: ColumnSensitivities,
}

/// The course of a run of plays: one from another memory is the same from where the states of its plays are.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::hysteresis) struct PlayCourse {
    pub(in crate::hysteresis) thresholds: Vec<f64>,
    pub(in crate::hysteresis) start: Start<f64>,
    /// Derivatives with respect to the memory were computed.
    pub(in crate::hysteresis) is_derived: bool,
    /// Plays that no sample moves.
    pub(in crate::hysteresis) standing: Vec<bool>,
    /// States of the others at growing distances from the first sample.
    pub(in crate::hysteresis) states: Vec<Vec<f64>>,
}

/// Derivative of one column with respect to one shape number.
#[derive(Clone, Debug, Default)]
pub struct Partial {
    /// Index p of the shape number.
    pub shape: usize,
    /// Index j of the column.
    pub column: usize,
    /// ∂H_j/∂θ_p at every sample.
    pub values: Vec<f64>,
    /// ∂(H_j before the first sample)/∂θ_p.
    pub rest: f64,
}

impl Columns {
    /// Resizes every buffer, with derivatives for the pairs (θ, column) given.
    ///
    /// # Errors
    /// [`HysteresisError::Stopped`] on a stop meanwhile: clearing the buffers of long records takes time.
    pub(in crate::hysteresis) fn resize(
        &mut self,
        columns: usize,
        samples: usize,
        pairs: &[(usize, usize)],
        memory: bool,
    ) -> Result<(), HysteresisError> {
        let Self { values, by_memory, partials, stop, .. } = self;
        values.resize_with(columns, Vec::new);
        by_memory.resize_with(if memory { columns } else { 0 }, Vec::new);
        partials.resize_with(pairs.len(), Partial::default);
        for (partial, &(shape, column)) in partials.iter_mut().zip(pairs) {
            (partial.shape, partial.column, partial.rest) = (shape, column, 0.0);
        }
        let of_partials = partials.iter_mut().map(|partial| &mut partial.values);
        for buffer in values.iter_mut().chain(by_memory).chain(of_partials) {
            look(stop.as_ref())?;
            buffer.resize(samples, 0.0);
        }
        let Self { rest, rest_by_memory, standing, standing_by_memory, .. } = self;
        for constants in [rest, rest_by_memory, standing, standing_by_memory] {
            constants.clear();
            constants.resize(columns, 0.0);
        }
        Ok(())
    }

    /// [`Self::resize`] that keeps the derivatives with respect to the memory.
    pub(in crate::hysteresis) fn resize_with_memory(
        &mut self,
        columns: usize,
        samples: usize,
        pairs: &[(usize, usize)],
    ) -> Result<(), HysteresisError> {
        let mut by_memory = std::mem::take(&mut self.by_memory);
        by_memory.resize_with(columns, Vec::new);
        let done = self.resize(columns, samples, pairs, false);
        self.by_memory = by_memory;
        done
    }
}

/// # Errors
/// [`HysteresisError::Stopped`] on a stop.
pub(in crate::hysteresis) fn look(stop: Option<&Stop>) -> Result<(), HysteresisError> {
    if stop.is_some_and(Stop::is_requested) { Err(HysteresisError::Stopped) } else { Ok(()) }
}
