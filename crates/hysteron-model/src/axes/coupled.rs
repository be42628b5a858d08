//! Sum of Hammerstein branches: hysteresis of each actuator, dynamics of each path from it to an output.

use super::AxesError;
use crate::dynamics::{Dynamics, Scheme, SecondOrder};
use crate::hammerstein::{Model, SimulationError};
use crate::hysteresis::{ArticleOperator, Hysteresis};
use crate::record::InterSample;
use crate::start::Start;

/// y_m = offset_m + Σ_n K_mn (G_mn ∗ v_n)(t − τ_mn), v_n = u_n − z\[u_n\]: v_n in the unit of the inputs,
/// G_mn a pair of poles of gain 1.
///
/// The hysteresis of an actuator depends on its drive alone and is shared by the paths from it; the motion of
/// the other actuators does not enter (for that see [`super::ScheduledModes`]).
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledHammerstein {
    /// One operator per input, with the polynomial u.
    pub actuators: Vec<ArticleOperator>,
    /// Outputs × inputs, row by row.
    pub paths: Vec<Path>,
    /// Offset of each output \[µm\].
    pub offsets: Vec<f64>,
    /// Sample rate the model was identified at \[Hz\].
    pub sample_rate_hz: f64,
}

/// Dynamics from an actuator to an output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// K, quasi-static gain of the output without hysteresis \[µm/V\].
    pub gain: f64,
    /// Natural frequency of the pair of poles \[Hz\].
    pub natural_frequency_hz: f64,
    /// Its damping ratio.
    pub damping: f64,
    /// Delay \[s\].
    pub delay_s: f64,
}

/// Standard errors of an identified model, in its order; `None` where the records do not determine them.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledErrors {
    /// α, β, γ of every actuator.
    pub actuators: Vec<[f64; 3]>,
    /// Gain, natural frequency, damping, delay of every path.
    pub paths: Vec<[f64; 4]>,
}

impl CoupledHammerstein {
    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.actuators.len()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.offsets.len()
    }

    /// The branch from input `n` to output `m`, without offset; `None` where there is no such path.
    ///
    /// # Errors
    /// [`SimulationError`] for parameters that are not allowed.
    pub fn branch(&self, m: usize, n: usize) -> Result<Option<Model>, SimulationError> {
        let (Some(actuator), Some(path)) = (self.actuators.get(n), self.paths.get(m * self.inputs() + n))
        else {
            return Ok(None);
        };
        branch(actuator, path).map(Some)
    }

    /// Outputs for the samples of each input, one list per output; every input rested at its first sample
    /// before, or the first `settled` samples repeated to the steady state.
    ///
    /// # Errors
    /// [`AxesError::Channels`]; [`AxesError::Branch`].
    pub fn simulate(
        &self,
        u: &[Vec<f64>],
        sample_rate_hz: f64,
        settled: Option<usize>,
    ) -> Result<Vec<Vec<f64>>, AxesError> {
        if u.len() != self.inputs() {
            return Err(AxesError::Channels { role: "input", model: self.inputs(), record: u.len() });
        }
        let failed = |e: SimulationError| AxesError::Branch { problem: e.to_string() };
        let mut outputs = Vec::with_capacity(self.outputs());
        for (m, offset) in self.offsets.iter().enumerate() {
            let mut y = vec![*offset; u.first().map_or(0, Vec::len)];
            for (n, u) in u.iter().enumerate() {
                let Some(branch) = self.branch(m, n).map_err(failed)? else { continue };
                let part = branch.simulate(u, Some(sample_rate_hz), &start(u, settled)).map_err(failed)?;
                y.iter_mut().zip(part).for_each(|(y, part)| *y += part);
            }
            outputs.push(y);
        }
        Ok(outputs)
    }
}

/// Start of a drive: settled on its period where one is given, else at rest at its first voltage.
#[doc(hidden)]
pub fn start(u: &[f64], settled: Option<usize>) -> Start {
    match settled {
        Some(period_samples) => Start::settled(period_samples),
        None => Start::Rest { voltage_v: u.first().copied().unwrap_or(0.0) },
    }
}

impl Path {
    /// Its pair of poles.
    pub(crate) fn pair(&self) -> SecondOrder {
        SecondOrder {
            gain: self.gain,
            natural_frequency_hz: self.natural_frequency_hz,
            damping: self.damping,
            alpha2: 2.0,
            alpha1: 1.0,
            alpha0: 0.0,
        }
    }
}

/// Hysteresis and dynamics of a path.
#[doc(hidden)]
pub fn branch(actuator: &ArticleOperator, path: &Path) -> Result<Model, SimulationError> {
    let pair = path.pair();
    Ok(Model {
        hysteresis: Hysteresis::from(actuator.clone()),
        dynamics: Dynamics::Integer(pair.to_transfer_function()?),
        offset: 0.0,
        delay_s: path.delay_s,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    })
}
