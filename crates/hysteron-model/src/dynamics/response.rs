//! Frequency response of a candidate on a plan's frequencies, with its derivatives: computed once, applied to
//! any number of inputs.
//!
//! With N = Σ b s^β and D = Σ a s^α, G = N/D and E the factor of the delay,
//!
//! - d(G E) = (dN − G dD)/D · E, dN = Σ (db + b dβ ln s) s^β: the powers are those of the value;
//! - d(G E)/dτ = G dE/dτ.
//!
//! G is taken at the s of the plan's scheme, δ(z)/h. The delay and the signal between its samples are taken
//! at the true s, z = e^(−sh), so they do not depend on the scheme.

use super::images::SUMS;
use super::tangent::Tangent;
use super::{DynamicsError, InputSpectrum, Linearised, Scheme, SimulationPlan, TransferFunction, Workspace};
use crate::dynamics_error::check_length;
use crate::record::InterSample;
use hysteron_numeric::{Complex64, multiply};

/// Inter-sample behaviour of delay and input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampling {
    /// Rule of the delay. `BandLimited` is e^(−sτ), exact for a band-limited signal; one that starts with a
    /// corner rings by about a tenth of the corner, which a G that rolls off towards half the sample rate
    /// removes except in the first samples. `Linear` is what [`super::delay::delay_linear`] does; `Hold` a
    /// delay by whole samples, rounded up, with derivative zero.
    pub delay: InterSample,
    /// Inter-sample behaviour of the input of the dynamics, under the scheme `BandLimited`; the other schemes
    /// imply a rule and ignore this one. The staircase of `Hold` and the polygon of `Linear` have content
    /// above half the sample rate, and their images that G passes are in the samples of the output, delayed
    /// by e^(−sτ) at the s of each image (`tests/driven_between_samples.rs`).
    pub reconstruction: InterSample,
}

impl Sampling {
    /// The usual rules for a scheme: the delay exact under `BandLimited`, linear under the others; the input
    /// band-limited.
    pub const fn of(scheme: Scheme) -> Self {
        let delay = match scheme {
            Scheme::BandLimited => InterSample::BandLimited,
            _ => InterSample::Linear,
        };
        Self { delay, reconstruction: InterSample::BandLimited }
    }
}

/// Frequency response and its derivatives on the frequencies of the plan that made it.
#[derive(Clone, Debug)]
pub struct Response {
    pub(super) values: Vec<Complex64>,
    /// One for each parameter, then that of the delay; an unused one is left as it was.
    pub(super) tangents: Vec<Tangent>,
    /// True if the tangents belong to the values.
    pub(super) differentiated: bool,
    /// Images of the values.
    pub(super) images: Box<[Complex64; SUMS]>,
}

impl Response {
    /// Number of derivatives there is room for: the parameters and the delay.
    pub fn tangents(&self) -> usize {
        self.tangents.len()
    }

    /// True if derivative `which` is zero at every frequency (or not there), so that it need not be applied.
    pub fn tangent_is_zero(&self, which: usize) -> bool {
        self.tangents.get(which).is_none_or(|tangent| tangent.zero)
    }
}

impl SimulationPlan {
    /// Buffers for the response of a form with `parameters` parameters and its derivatives.
    pub fn empty_response(&self, parameters: usize) -> Response {
        self.response_with(vec![Tangent::new(self.bins()); parameters + 1])
    }

    /// Buffers for a response without derivatives.
    pub fn empty_values(&self) -> Response {
        self.response_with(vec![Tangent::new(0)])
    }

    fn response_with(&self, tangents: Vec<Tangent>) -> Response {
        let values = vec![Complex64::ZERO; self.bins()];
        Response { values, tangents, differentiated: false, images: Box::new([Complex64::ZERO; SUMS]) }
    }

    /// The frequency response of `tf` with a delay \[s\]. Allocates nothing, except tables that a plan makes
    /// once for the first reconstruction by `Hold` or `Linear`, or for a resonance above half the sample
    /// rate.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::simulate_spectrum`]; [`DynamicsError::Parameter`] for a delay that is
    /// negative or not finite; [`DynamicsError::Length`] for a response of another plan.
    pub fn response(
        &self,
        tf: &TransferFunction,
        delay_s: f64,
        sampling: Sampling,
        response: &mut Response,
    ) -> Result<(), DynamicsError> {
        self.respond(tf, None, delay_s, sampling, response)
    }

    /// The frequency response with its derivative in each parameter, and in the delay \[1/s\] as the last.
    /// Allocates nothing, as [`SimulationPlan::response`]; the values are the same to the last bit.
    ///
    /// A derivative that is zero (a parameter that moves no term, the delay by the `Hold` rule) costs
    /// nothing. The derivative in the delay by the `Linear` rule is that from the right. Under
    /// [`crate::Start::PERIODIC`] the derivatives at zero frequency are those of the quotient of the lowest
    /// terms, their orders held.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::response`]; [`DynamicsError::Tangents`] for a response made for another
    /// number of parameters.
    pub fn response_with_tangents(
        &self,
        linearised: &Linearised,
        delay_s: f64,
        sampling: Sampling,
        response: &mut Response,
    ) -> Result<(), DynamicsError> {
        let expected = linearised.parameters() + 1;
        let found = response.tangents.iter().filter(|tangent| tangent.bins.len() == self.bins()).count();
        if found != expected || response.tangents.len() != expected {
            return Err(DynamicsError::Tangents { expected, found });
        }
        self.respond(&linearised.transfer_function, Some(linearised), delay_s, sampling, response)
    }

    /// `output` = the response to `input`, without the contribution of the level subtracted from the input:
    /// add G(0) · [`InputSpectrum::level`]. One inverse FFT; allocates nothing.
    ///
    /// # Errors
    /// [`DynamicsError::Length`] for what was made for another plan, [`DynamicsError::OutputNotFinite`].
    pub fn apply(
        &self,
        response: &Response,
        input: &InputSpectrum,
        workspace: &mut Workspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.apply_bins(&response.values, input, workspace, output)
    }

    /// [`SimulationPlan::apply`] for derivative `which` of the response: a parameter's, or the delay's, which
    /// is the last.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::apply`]; [`DynamicsError::NoTangent`] where there is no such derivative, or
    /// the response was last computed without.
    pub fn apply_tangent(
        &self,
        response: &Response,
        which: usize,
        input: &InputSpectrum,
        workspace: &mut Workspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        match response.tangents.get(which) {
            Some(tangent) if response.differentiated && tangent.zero => {
                check_length("output", output.len(), self.samples)?;
                output.fill(0.0);
                Ok(())
            }
            Some(tangent) if response.differentiated => {
                self.apply_bins(&tangent.bins, input, workspace, output)
            }
            _ => {
                let found = if response.differentiated { response.tangents.len() } else { 0 };
                Err(DynamicsError::NoTangent { which, found })
            }
        }
    }

    fn apply_bins(
        &self,
        bins: &[Complex64],
        input: &InputSpectrum,
        workspace: &mut Workspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        check_length("output", output.len(), self.samples)?;
        check_length("response", bins.len(), self.bins())?;
        check_length("input spectrum", input.bins.len(), self.bins())?;
        self.check_workspace(workspace)?;
        multiply(self.set, bins, &input.bins, &mut workspace.spectrum);
        self.invert(workspace, 0.0, output)
    }
}
