//! Simulation of article Eq. 13 over one input, the plan reused.

use hysteron_model::Start;
use std::hint::black_box;

use hysteron_model::dynamics::{InputSpectrum, Scheme, SimulationPlan, TransferFunction, Workspace};

use crate::answer::Answer;
use crate::error::BenchError;
use crate::stopwatch::time;

/// The article's sample rate is not printed; this is ours \[Hz\].
pub const SAMPLE_RATE_HZ: f64 = 10_000.0;

/// Everything that is made before the clock runs.
pub struct Fractional {
    plan: SimulationPlan,
    transfer_function: TransferFunction,
    input: Vec<f64>,
    spectrum: InputSpectrum,
    workspace: Workspace,
    output: Vec<f64>,
}

impl Fractional {
    /// Plans the simulation from zero with the scheme of this name.
    pub fn new(input: Vec<f64>, scheme: &str) -> Result<Self, BenchError> {
        let scheme = Scheme::ALL.into_iter().find(|s| s.name() == scheme);
        let scheme = scheme.ok_or(BenchError::Scheme)?;
        let plan = SimulationPlan::new(input.len(), SAMPLE_RATE_HZ, scheme, Start::ZERO)?;
        let spectrum = plan.transform(&input)?;
        let (workspace, output) = (plan.workspace(), vec![0.0; input.len()]);
        let transfer_function = TransferFunction::article_eq13();
        Ok(Self { plan, transfer_function, input, spectrum, workspace, output })
    }

    /// Description of the plan.
    pub fn answer(&self) -> Answer {
        Answer::Planned { transform_length: self.plan.transform_length() }
    }

    /// Samples of the last simulation.
    pub fn output(&self) -> &[f64] {
        &self.output
    }

    /// One FFT pair a simulation.
    pub fn simulate(&mut self, repetitions: usize) -> Result<Answer, BenchError> {
        let Self { plan, transfer_function, input, workspace, output, .. } = self;
        let timing =
            time(repetitions, || plan.simulate(black_box(transfer_function), input, workspace, output))?;
        Ok(timing.into())
    }

    /// One inverse FFT a simulation: the input's transform is kept, as a search does.
    pub fn candidate(&mut self, repetitions: usize) -> Result<Answer, BenchError> {
        let Self { plan, transfer_function, spectrum, workspace, output, .. } = self;
        let timing = time(repetitions, || {
            plan.simulate_spectrum(black_box(transfer_function), spectrum, workspace, output)
        })?;
        Ok(timing.into())
    }
}
