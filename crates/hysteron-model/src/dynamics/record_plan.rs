//! Simulation over a record of any time base: by FFT on a uniform one, step by step on time stamps.

use super::{
    DynamicsError, InputSpectrum, Linearised, Response, Sampling, SimulationPlan, StampedPlan,
    StampedResponse, StampedWorkspace, TransferFunction, Workspace,
};

/// A [`SimulationPlan`] or a [`StampedPlan`], with one set of calls. Data of another plan are refused with
/// [`DynamicsError::Length`].
#[derive(Debug)]
pub enum RecordPlan {
    /// Of a uniform record.
    Uniform(Box<SimulationPlan>),
    /// Of time stamps.
    Stamped(Box<StampedPlan>),
}

/// An input, prepared for many responses.
#[derive(Clone, Debug)]
pub enum PlanInput {
    /// Its spectrum.
    Spectrum(InputSpectrum),
    /// Its values at the knots.
    Knots(Vec<f64>),
}

impl PlanInput {
    /// Empty buffers, allocated when an input is prepared.
    pub const fn none() -> Self {
        Self::Knots(Vec::new())
    }

    fn is_none(&self) -> bool {
        matches!(self, Self::Knots(knots) if knots.is_empty())
    }
}

/// A transfer function with delay, prepared for many inputs.
#[derive(Clone, Debug)]
pub enum PlanResponse {
    /// On the frequencies of the plan.
    Uniform(Response),
    /// On the stamps of the plan.
    Stamped(StampedResponse),
}

/// Buffers of one thread.
#[derive(Clone, Debug)]
pub enum PlanWorkspace {
    /// Of a uniform record.
    Uniform(Workspace),
    /// Of time stamps.
    Stamped(Box<StampedWorkspace>),
}

const FOREIGN: DynamicsError = DynamicsError::Length { what: "plan", expected: 1, found: 0 };

impl RecordPlan {
    /// Samples of an input.
    pub fn inputs(&self) -> usize {
        match self {
            Self::Uniform(plan) => plan.samples(),
            Self::Stamped(plan) => plan.knots(),
        }
    }

    /// Buffers for one thread.
    pub fn workspace(&self) -> PlanWorkspace {
        match self {
            Self::Uniform(plan) => PlanWorkspace::Uniform(plan.workspace()),
            Self::Stamped(_) => PlanWorkspace::Stamped(Box::default()),
        }
    }

    /// An input of zeros.
    pub fn empty_input(&self) -> PlanInput {
        match self {
            Self::Uniform(plan) => PlanInput::Spectrum(plan.empty_spectrum()),
            Self::Stamped(plan) => PlanInput::Knots(vec![0.0; plan.knots()]),
        }
    }

    /// Room for the response of a form with `parameters` parameters and its derivatives.
    pub fn empty_response(&self, parameters: usize) -> PlanResponse {
        match self {
            Self::Uniform(plan) => PlanResponse::Uniform(plan.empty_response(parameters)),
            Self::Stamped(plan) => PlanResponse::Stamped(plan.empty_response()),
        }
    }

    /// Prepares an input; it starts from 0 (on a uniform record: as its plan says). Allocates empty buffers
    /// ([`PlanInput::none`]).
    ///
    /// # Errors
    /// Those of [`SimulationPlan::transform_into`].
    pub fn prepare_into(
        &self,
        input: &[f64],
        workspace: &mut PlanWorkspace,
        prepared: &mut PlanInput,
    ) -> Result<(), DynamicsError> {
        if prepared.is_none() {
            *prepared = self.empty_input();
        }
        match (self, workspace, prepared) {
            (Self::Uniform(plan), PlanWorkspace::Uniform(workspace), PlanInput::Spectrum(spectrum)) => {
                plan.transform_into(input, workspace, spectrum)
            }
            (Self::Stamped(plan), _, PlanInput::Knots(knots)) => {
                crate::dynamics_error::check_length("input", input.len(), plan.knots())?;
                crate::dynamics_error::check_finite("input", input)?;
                knots.copy_from_slice(input);
                Ok(())
            }
            _ => Err(FOREIGN),
        }
    }

    /// The response of `tf` behind a delay \[s\].
    ///
    /// # Errors
    /// Those of [`SimulationPlan::response`], [`StampedPlan::response`].
    pub fn response(
        &self,
        tf: &TransferFunction,
        delay_s: f64,
        sampling: Sampling,
        response: &mut PlanResponse,
    ) -> Result<(), DynamicsError> {
        match (self, response) {
            (Self::Uniform(plan), PlanResponse::Uniform(own)) => plan.response(tf, delay_s, sampling, own),
            (Self::Stamped(plan), PlanResponse::Stamped(own)) => plan.response(tf, None, delay_s, own),
            _ => Err(FOREIGN),
        }
    }

    /// [`Self::response`] with its derivative in each parameter, and in the delay as the last.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::response_with_tangents`], [`StampedPlan::response`].
    pub fn response_with_tangents(
        &self,
        linearised: &Linearised,
        delay_s: f64,
        sampling: Sampling,
        response: &mut PlanResponse,
    ) -> Result<(), DynamicsError> {
        match (self, response) {
            (Self::Uniform(plan), PlanResponse::Uniform(own)) => {
                plan.response_with_tangents(linearised, delay_s, sampling, own)
            }
            (Self::Stamped(plan), PlanResponse::Stamped(own)) => {
                plan.response(&linearised.transfer_function, Some(linearised), delay_s, own)
            }
            _ => Err(FOREIGN),
        }
    }

    /// `output` = the response to `input`.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::apply`], [`StampedPlan::apply`].
    pub fn apply(
        &self,
        response: &PlanResponse,
        input: &PlanInput,
        workspace: &mut PlanWorkspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        match (self, response, input, workspace) {
            (
                Self::Uniform(plan),
                PlanResponse::Uniform(response),
                PlanInput::Spectrum(input),
                PlanWorkspace::Uniform(workspace),
            ) => plan.apply(response, input, workspace, output),
            (
                Self::Stamped(plan),
                PlanResponse::Stamped(response),
                PlanInput::Knots(input),
                PlanWorkspace::Stamped(workspace),
            ) => plan.apply(response, input, workspace, output),
            _ => Err(FOREIGN),
        }
    }

    /// [`Self::apply`] to several inputs, one output for each: on time stamps in one pass.
    ///
    /// # Errors
    /// Those of [`Self::apply`].
    pub fn apply_each(
        &self,
        response: &PlanResponse,
        inputs: &[&PlanInput],
        workspace: &mut PlanWorkspace,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), DynamicsError> {
        if let (Self::Stamped(plan), PlanResponse::Stamped(response), PlanWorkspace::Stamped(workspace)) =
            (self, response, &mut *workspace)
        {
            let inputs = inputs.iter().map(|input| input.knots()).collect::<Result<Vec<_>, _>>()?;
            return plan.apply_each(response, &inputs, workspace, outputs);
        }
        let mut each = inputs.iter().zip(outputs);
        each.try_for_each(|(input, output)| self.apply(response, input, workspace, output))
    }

    /// [`Self::apply`] for derivative `which` of the response.
    ///
    /// # Errors
    /// Those of [`SimulationPlan::apply_tangent`], [`StampedPlan::apply_tangent`].
    pub fn apply_tangent(
        &self,
        response: &PlanResponse,
        which: usize,
        input: &PlanInput,
        workspace: &mut PlanWorkspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        match (self, response, input, workspace) {
            (
                Self::Uniform(plan),
                PlanResponse::Uniform(response),
                PlanInput::Spectrum(input),
                PlanWorkspace::Uniform(workspace),
            ) => plan.apply_tangent(response, which, input, workspace, output),
            (
                Self::Stamped(plan),
                PlanResponse::Stamped(response),
                PlanInput::Knots(input),
                PlanWorkspace::Stamped(workspace),
            ) => plan.apply_tangent(response, which, input, workspace, output),
            _ => Err(FOREIGN),
        }
    }

    /// [`Self::apply_tangent`] of several derivatives, one output for each: on time stamps in one pass.
    ///
    /// # Errors
    /// Those of [`Self::apply_tangent`].
    pub fn apply_tangents(
        &self,
        response: &PlanResponse,
        wanted: &mut [(usize, &mut [f64])],
        input: &PlanInput,
        workspace: &mut PlanWorkspace,
    ) -> Result<(), DynamicsError> {
        if let (
            Self::Stamped(plan),
            PlanResponse::Stamped(response),
            PlanInput::Knots(input),
            PlanWorkspace::Stamped(workspace),
        ) = (self, response, input, &mut *workspace)
        {
            return plan.apply_tangents(response, wanted, input, workspace);
        }
        wanted
            .iter_mut()
            .try_for_each(|(which, output)| self.apply_tangent(response, *which, input, workspace, output))
    }
}

impl PlanInput {
    /// Makes it a weighted sum of inputs of the same plan: 0 where there is none.
    pub fn set_sum<'a>(&mut self, terms: impl IntoIterator<Item = (f64, &'a Self)>) {
        match self {
            Self::Spectrum(own) => own.set_sum(terms.into_iter().filter_map(|(factor, term)| match term {
                Self::Spectrum(term) => Some((factor, term)),
                Self::Knots(_) => None,
            })),
            Self::Knots(own) => {
                own.fill(0.0);
                for (factor, term) in terms {
                    if let Self::Knots(term) = term {
                        own.iter_mut().zip(term).for_each(|(x, y)| *x += factor * y);
                    }
                }
            }
        }
    }

    fn knots(&self) -> Result<&[f64], DynamicsError> {
        match self {
            Self::Knots(knots) => Ok(knots),
            Self::Spectrum(_) => Err(FOREIGN),
        }
    }
}

impl PlanResponse {
    /// True if derivative `which` is zero everywhere (or not there).
    pub fn tangent_is_zero(&self, which: usize) -> bool {
        match self {
            Self::Uniform(response) => response.tangent_is_zero(which),
            Self::Stamped(response) => response.tangent_is_zero(which),
        }
    }
}
