//! Simulation that assumes no stability.

use super::{DynamicsError, Scheme, TransferFunction};
use crate::dynamics_error::check_finite;
use crate::start::{LinearStart, Start};

impl TransferFunction {
    /// The response to `input` at `sample_rate_hz` by the causal recursion, O(N log² N), stable or not: for
    /// simulating on purpose what [`super::SimulationPlan`] refuses as unstable.
    ///
    /// # Errors
    /// [`DynamicsError::InfiniteDcGain`] under `Rest`; [`DynamicsError::PeriodicRecursion`];
    /// [`DynamicsError::InputNotFinite`]; [`DynamicsError::NoWeights`] for `BandLimited`,
    /// [`DynamicsError::ImproperOperator`] under `Tustin`, [`DynamicsError::ResultNotFinite`].
    pub fn simulate_causal(
        &self,
        input: &[f64],
        sample_rate_hz: f64,
        scheme: Scheme,
        initial: LinearStart,
    ) -> Result<Vec<f64>, DynamicsError> {
        self.validate()?;
        check_finite("input", input)?;
        let level = match initial {
            Start::AsIdentified => input.first().copied().unwrap_or(0.0),
            Start::Rest { voltage_v } => voltage_v,
            Start::Settled { .. } => return Err(DynamicsError::PeriodicRecursion),
            Start::Remembering { memory, .. } => match memory {},
        };
        let offset = if initial == Start::ZERO { 0.0 } else { self.dc_gain() * level };
        if initial != Start::ZERO && self.dc_gain().is_infinite() {
            return Err(self.infinite_dc_gain());
        }
        let relative: Vec<f64> = input.iter().map(|u| u - level).collect();
        let (b, a) = (&self.numerator, &self.denominator);
        let mut output = crate::fractional::simulate_causal(b, a, &relative, sample_rate_hz, scheme)?;
        output.iter_mut().for_each(|y| *y += offset);
        Ok(output)
    }
}
