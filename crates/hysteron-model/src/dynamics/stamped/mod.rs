//! Simulation of a transfer function on time stamps of any spacing.
//!
//! G as a sum of relaxations and resonances, G(s) = d + Σ wₖ λₖ/(s + λₖ) + Σ (Rᵢ/(s − pᵢ) + R̄ᵢ/(s − p̄ᵢ)):
//! each is a first-order differential equation, which is solved exactly over every step, whatever its length,
//! for an input that goes along straight lines (or is held) between its knots. The output is exact at any
//! time, so that the delay needs no interpolation. The rates λₖ are fixed by the record ([`relaxation_fit`]);
//! wₖ follow from G on the imaginary axis by least squares, pᵢ and Rᵢ are those of G ([`resonant_poles`]).
//! Derivatives in the parameters and in the delay are those of the same sum.
//!
//! Error: below 1e-6 of the range against [`super::SimulationPlan`] on a fine common grid
//! (`tests/stamps.rs`).

mod knots;
#[cfg(test)]
mod oracle;
mod readout;
mod relaxation_fit;
mod resonances;
mod resonant_poles;

use super::{DynamicsError, Linearised, Stability, TransferFunction, stability};
use crate::dynamics_error::{check_finite, check_length};
use hysteron_numeric::{BankWeights, Complex64, InstructionSet, Line, RelaxationBank};
pub use knots::Knots;
use readout::Readout;
use relaxation_fit::RelaxationFit;
use resonances::Resonances;
use resonant_poles::ResonantPole;

/// Derivatives of the terms of a transfer function, where they are asked for.
type Tangents<'a> = Option<&'a Linearised>;

/// Share of the steps that may be shorter than the one that sets the fastest rate.
const SHORT_STEPS: f64 = 0.01;

/// What a simulation on stamps needs to know of the record: when its input and its output were sampled.
#[derive(Clone, Debug)]
pub struct StampedPlan {
    knots_s: Vec<f64>,
    outputs_s: Vec<f64>,
    held: bool,
    fit: RelaxationFit,
}

/// A transfer function with delay on the stamps of a plan, with its derivatives.
#[derive(Clone, Debug)]
pub struct StampedResponse {
    /// Knot before each output, and the time since then \[s\]; `None` before the first knot.
    places: Vec<Option<(usize, f64)>>,
    /// −p of the real poles \[rad/s\].
    own_rates: Vec<f64>,
    /// The other poles.
    poles: Vec<Complex64>,
    value: Readout,
    /// One for each parameter, then that of the delay.
    tangents: Vec<Readout>,
}

/// Buffers of one thread.
#[derive(Clone, Debug, Default)]
pub struct StampedWorkspace {
    /// At the rates of the fit, and at those of real poles.
    banks: [RelaxationBank; 2],
    /// Of each output that is read.
    weights: [Vec<BankWeights>; 2],
    resonances: Resonances,
    sums: Vec<f64>,
}

impl StampedPlan {
    /// A plan for an input given at `knots_s` (held between them, or on straight lines) and an output at
    /// `outputs_s` \[s\], increasing. Before its first knot the input is 0. Two knots at one time are a jump,
    /// before which an output of that time is read.
    ///
    /// # Errors
    /// [`DynamicsError::TooFewSamples`] below two knots or for a single time.
    pub fn new(knots_s: Vec<f64>, outputs_s: Vec<f64>, held: bool) -> Result<Self, DynamicsError> {
        let mut steps: Vec<f64> =
            knots_s.windows(2).map(|two| two[1] - two[0]).filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        let duration: f64 = steps.iter().sum();
        let shortest = steps.get((SHORT_STEPS * steps.len() as f64) as usize).copied();
        let Some(shortest) = shortest.filter(|step| step.is_finite() && duration.is_finite()) else {
            return Err(DynamicsError::TooFewSamples { need: 2, found: knots_s.len() });
        };
        let fit = RelaxationFit::new(duration, shortest)?;
        Ok(Self { knots_s, outputs_s, held, fit })
    }

    /// Knots of the input.
    pub fn knots(&self) -> usize {
        self.knots_s.len()
    }

    /// Samples of the output.
    pub fn samples(&self) -> usize {
        self.outputs_s.len()
    }

    /// An empty response.
    pub fn empty_response(&self) -> StampedResponse {
        StampedResponse {
            places: Vec::new(),
            own_rates: Vec::new(),
            poles: Vec::new(),
            value: Readout::default(),
            tangents: Vec::new(),
        }
    }

    /// `tf` behind a delay \[s\], with its derivatives where a linearised form is given.
    ///
    /// # Errors
    /// What [`TransferFunction::validate`] refuses; [`DynamicsError::Unstable`], [`DynamicsError::Improper`],
    /// [`DynamicsError::Parameter`] for a delay that is negative or not finite;
    /// [`DynamicsError::OutputNotFinite`] where G is no sum of relaxations and resonances.
    pub fn response(
        &self,
        tf: &TransferFunction,
        linearised: Option<&Linearised>,
        delay_s: f64,
        response: &mut StampedResponse,
    ) -> Result<(), DynamicsError> {
        tf.validate()?;
        tf.require_proper()?;
        if !(delay_s >= 0.0 && delay_s.is_finite()) {
            let allowed = "a finite number ≥ 0";
            return Err(DynamicsError::Parameter { name: "delay", value: delay_s, allowed });
        }
        match stability(tf) {
            Stability::Unstable { poles } => return Err(DynamicsError::Unstable { poles }),
            Stability::Marginal { .. } | Stability::Integrating { .. } | Stability::Stable => {}
        }
        let resonances = ResonantPole::of(tf, linearised)?;
        let (value, tangents) = self.fit.weights(tf, linearised, &resonances)?;
        self.locate(delay_s, &mut response.places);
        (response.own_rates, response.poles) = readout::places(&resonances);
        response.value = Readout::of_value(value, &resonances);
        response.tangents.clear();
        if let Some(linearised) = linearised {
            response.tangents.extend(tangents.into_iter().enumerate().map(|(which, weights)| {
                let mut readout = Readout::of_tangent(weights, &resonances, which);
                readout.is_zero = linearised.is_still(which);
                readout
            }));
            let delayed = response.value.delayed(&self.fit.rates, &response.own_rates, &response.poles);
            response.tangents.push(delayed);
        }
        Ok(())
    }

    /// Where each output reads the input's time.
    fn locate(&self, delay_s: f64, places: &mut Vec<Option<(usize, f64)>>) {
        places.clear();
        let mut knot = 0;
        places.extend(self.outputs_s.iter().map(|output_s| {
            let time = output_s - delay_s;
            while knot_follows(&self.knots_s, knot, time) {
                knot += 1;
            }
            let since = time - self.knots_s.get(knot)?;
            (since >= 0.0).then_some((knot, since))
        }));
    }

    /// `output` = the response to `input`, at rest at 0 before.
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::OutputNotFinite`].
    pub fn apply(
        &self,
        response: &StampedResponse,
        input: &[f64],
        workspace: &mut StampedWorkspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.read(response, &[&response.value], input, workspace, &mut [output])
    }

    /// As [`Self::apply`] for derivative `which` of the response: a parameter's, or the delay's, which is the
    /// last.
    ///
    /// # Errors
    /// As [`Self::apply`]; [`DynamicsError::NoTangent`].
    pub fn apply_tangent(
        &self,
        response: &StampedResponse,
        which: usize,
        input: &[f64],
        workspace: &mut StampedWorkspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.apply_tangents(response, &mut [(which, output)], input, workspace)
    }

    /// [`Self::apply_tangent`] of several derivatives in one pass: one output beside each.
    ///
    /// # Errors
    /// As [`Self::apply_tangent`].
    pub fn apply_tangents(
        &self,
        response: &StampedResponse,
        wanted: &mut [(usize, &mut [f64])],
        input: &[f64],
        workspace: &mut StampedWorkspace,
    ) -> Result<(), DynamicsError> {
        let found = response.tangents.len();
        let (mut readouts, mut outputs) = (Vec::new(), Vec::new());
        for (which, output) in wanted {
            let which = *which;
            let readout = response.tangents.get(which).ok_or(DynamicsError::NoTangent { which, found })?;
            if readout.is_zero {
                check_length("output", output.len(), self.samples())?;
                output.fill(0.0);
            } else {
                readouts.push(readout);
                outputs.push(&mut **output);
            }
        }
        if readouts.is_empty() {
            return Ok(());
        }
        self.read(response, &readouts, input, workspace, &mut outputs)
    }

    fn read(
        &self,
        response: &StampedResponse,
        readouts: &[&Readout],
        input: &[f64],
        workspace: &mut StampedWorkspace,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), DynamicsError> {
        check_length("input", input.len(), self.knots())?;
        for output in &*outputs {
            check_length("output", output.len(), self.samples())?;
        }
        check_length("response", response.places.len(), self.samples())?;
        check_finite("input", input)?;
        let StampedWorkspace { banks, weights, resonances, sums } = workspace;
        sums.resize(readouts.len(), 0.0);
        weights.iter_mut().for_each(|weights| weights.resize_with(readouts.len(), BankWeights::default));
        let [fitted, own] = &mut *weights;
        for ((readout, fitted), own) in readouts.iter().zip(fitted).zip(own) {
            readout.weigh(fitted, own);
        }
        let rates = [&self.fit.rates, &response.own_rates];
        for ((bank, rates), weights) in banks.iter_mut().zip(rates).zip(&*weights) {
            let rates = if weights.iter().all(BankWeights::is_zero) { &[] } else { &rates[..] };
            bank.reset(rates, weights.iter().any(BankWeights::asks_for_derivatives));
        }
        resonances.reset(&response.poles, readouts);
        let set = InstructionSet::detected();
        let length_s = |knot: usize| match (self.knots_s.get(knot), self.knots_s.get(knot + 1)) {
            (Some(from), Some(to)) => to - from,
            _ => 0.0,
        };
        let line = |knot: usize| {
            let length_s = length_s(knot);
            let slope = match input.get(knot + 1) {
                Some(next) if !self.held && length_s > 0.0 => (next - input[knot]) / length_s,
                _ => 0.0,
            };
            Line { from: input[knot], slope, length_s }
        };
        let since_s = |output: usize| response.places.get(output).copied().flatten().map_or(0.0, |(_, s)| s);
        let (mut at, mut along) = (0, line(0));
        let mut finite = true;
        for (index, place) in response.places.iter().enumerate() {
            let Some((knot, since)) = *place else {
                outputs.iter_mut().for_each(|output| output[index] = 0.0);
                continue;
            };
            while at < knot {
                if along.length_s > 0.0 {
                    banks.iter_mut().for_each(|bank| bank.advance(set, along));
                    resonances.advance(set, along, at, length_s);
                }
                at += 1;
                along = line(at);
            }
            let part = Line { length_s: since, ..along };
            let input = part.from + part.slope * since;
            for (sum, readout) in sums.iter_mut().zip(readouts) {
                *sum = readout.input * input + readout.slope * part.slope;
            }
            for (bank, weights) in banks.iter_mut().zip(&*weights) {
                bank.read(set, part, weights, sums);
            }
            resonances.read(set, part, readouts, (index, since_s), sums);
            for (output, sum) in outputs.iter_mut().zip(&*sums) {
                output[index] = *sum;
                finite &= sum.is_finite();
            }
        }
        if finite { Ok(()) } else { Err(DynamicsError::OutputNotFinite) }
    }
}

/// Whether the knot behind this one is what a time is read from: up to a jump at that time, not behind it.
#[doc(hidden)]
pub fn knot_follows(knots_s: &[f64], knot: usize, time_s: f64) -> bool {
    match (knots_s.get(knot), knots_s.get(knot + 1)) {
        (Some(this), Some(next)) => *next < time_s || (*next == time_s && next > this),
        _ => false,
    }
}

impl StampedResponse {
    /// Whether derivative `which` is zero everywhere (or not there).
    pub fn tangent_is_zero(&self, which: usize) -> bool {
        self.tangents.get(which).is_none_or(|tangent| tangent.is_zero)
    }
}
