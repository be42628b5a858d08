//! Step and impulse responses.

use super::{DynamicsError, Scheme, SimulationPlan, TransferFunction};
use crate::start::Start;

impl TransferFunction {
    /// Response to a unit step at t = 0 at t = k/`sample_rate_hz`, k = 0 … `samples` − 1, from zero.
    ///
    /// The input's first sample is ½, the mean of before and after: with 1 every scheme is of first order
    /// (`tests/step_response.rs`). `BandLimited` rings about the jump, as a step is not band-limited.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::new`] and [`SimulationPlan::simulate`].
    pub fn step_response(
        &self,
        samples: usize,
        sample_rate_hz: f64,
        scheme: Scheme,
    ) -> Result<Vec<f64>, DynamicsError> {
        let mut step = vec![1.0; samples];
        if let Some(first) = step.first_mut() {
            *first = 0.5;
        }
        self.simulate_from_zero(&step, sample_rate_hz, scheme)
    }

    /// Response to a unit impulse at t = 0 (unit of G times 1/s), sampled as
    /// [`TransferFunction::step_response`]: the response to one sample of height `sample_rate_hz`, the
    /// convolution quadrature weights over h.
    ///
    /// Second order away from t = 0 under `Bdf2` and `Tustin`; the value at t = 0 is G(δ(0)/h)/h. A G that
    /// does not vanish at high frequency has a δ-function in its response, which appears as G(∞)/h there.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::new`] and [`SimulationPlan::simulate`].
    pub fn impulse_response(
        &self,
        samples: usize,
        sample_rate_hz: f64,
        scheme: Scheme,
    ) -> Result<Vec<f64>, DynamicsError> {
        let mut impulse = vec![0.0; samples];
        if let Some(first) = impulse.first_mut() {
            *first = sample_rate_hz;
        }
        self.simulate_from_zero(&impulse, sample_rate_hz, scheme)
    }

    fn simulate_from_zero(
        &self,
        input: &[f64],
        sample_rate_hz: f64,
        scheme: Scheme,
    ) -> Result<Vec<f64>, DynamicsError> {
        let plan = SimulationPlan::new(input.len(), sample_rate_hz, scheme, Start::ZERO)?;
        let mut output = vec![0.0; input.len()];
        plan.simulate(self, input, &mut plan.workspace(), &mut output)?;
        Ok(output)
    }
}
