//! Coefficients and memory of a controller in one number type.

use hysteron_rt::{Controller, Observer, Real};

use super::{ControlError, FeedbackParts, Loop};
use crate::compensator::CompensatorParts;
use crate::realise::{Realisation, RealiseError, RuntimeParts};

/// Coefficients and memory of the controller of a [`Loop`] with an inverse: what `play` runs, for use away from
/// a plant. Adaptive weights are no part of it.
#[derive(Clone, Debug)]
pub struct ControllerParts<T> {
    inverse: CompensatorParts<T>,
    feedback: Option<FeedbackParts<T>>,
    observer: Option<(RuntimeParts<T>, T)>,
    due: Vec<T>,
}

impl<T: Real> ControllerParts<T> {
    /// The parts of a loop, rounded to `T`; `None` for a loop without inverse.
    ///
    /// # Errors
    /// Those of [`CompensatorParts::new`] and [`RuntimeParts::new`].
    pub fn new(made: &Loop) -> Result<Option<Self>, ControlError> {
        let Some(inverse) = &made.inverse else { return Ok(None) };
        let settings = &made.settings;
        let observed = || Realisation {
            model: made.model.clone(),
            dynamics: made.dynamics.clone(),
            sample_rate_hz: settings.sample_rate_hz,
            joins_means: false,
        };
        let observer = match made.observer {
            Some((gain, _)) => Some((RuntimeParts::new(&observed())?, T::of(gain))),
            None => None,
        };
        Ok(Some(Self {
            inverse: CompensatorParts::new(inverse, settings.range_v, settings.slew_v_per_s)?,
            feedback: made.feedback.as_ref().map(|tuned| FeedbackParts::new(&tuned.law)),
            observer,
            due: vec![T::of(0.0); inverse.preview + 1],
        }))
    }

    /// The controller, its stage at rest and virgin at the voltage of its range nearest to 0 V; clears its
    /// memory.
    ///
    /// # Errors
    /// [`ControlError::Realise`] where the coefficients are not finite in this number type.
    pub fn controller(&mut self) -> Result<Controller<'_, T>, ControlError> {
        let rounded = |_| ControlError::Realise(RealiseError::Rounded);
        let feedback = match &mut self.feedback {
            Some(parts) => Some(parts.feedback()?),
            None => None,
        };
        let observer = match &mut self.observer {
            Some((parts, gain)) => Some(Observer::new(parts.model()?, *gain).map_err(rounded)?),
            None => None,
        };
        Controller::new(self.inverse.compensator()?, feedback, observer, &mut self.due).map_err(rounded)
    }
}
