//! Simulation of a transfer function on time stamps of any spacing.
//!
//! G as a sum of relaxations and resonances, G(s) = d + Σ wₖ λₖ/(s + λₖ) + Σ (Rᵢ/(s − pᵢ) + R̄ᵢ/(s − p̄ᵢ)):
//! each is a first-order differential equation, which is solved exactly over every step, whatever its length,
//! for an input that is linear (or held) between its knots; where an arc has knots inside, for the parabola
//! through its ends with the mean of the input over the arc. The output is exact at any time, so that the
//! delay needs no interpolation. The rates λₖ are fixed by the record ([`relaxation_fit`]); wₖ follow from G
//! on the imaginary axis by least squares, pᵢ and Rᵢ are those of G ([`resonant_poles`]). Derivatives in the
//! parameters and in the delay are those of the same sum.
//!
//! Error: below 1e-6 of the range against [`super::SimulationPlan`] on a fine common grid
//! (`tests/stamps.rs`).

mod knots;
#[cfg(test)]
mod oracle;
mod readings;
mod readout;
mod relaxation_fit;
mod resonant_poles;

use super::{DynamicsError, Linearised, Stability, TransferFunction, stability};
use crate::dynamics_error::{check_finite, check_length};
use hysteron_numeric::{
    ABREAST, Abreast, BankWeights, Complex64, InstructionSet, Parabolas, Propagated, RelaxationBank,
    ResonanceBank,
};
pub use knots::{KnotTimes, Knots};
pub use readings::Readings;
use readout::Readout;
use relaxation_fit::RelaxationFit;
use resonant_poles::ResonantPole;

/// Derivatives of the terms of a transfer function, where they are requested.
type Tangents<'a> = Option<&'a Linearised>;

/// Share of the steps that may be shorter than the one that sets the fastest rate.
const SHORT_STEPS: f64 = 0.01;

/// Simulation plan on time stamps: when input and output of the record were sampled.
#[derive(Clone, Debug)]
pub struct StampedPlan {
    knots: usize,
    /// Knots at which arcs begin or end.
    corners: Vec<usize>,
    /// Their times \[s\].
    corners_s: Vec<f64>,
    outputs_s: Vec<f64>,
    held: bool,
    fit: RelaxationFit,
}

/// A transfer function with delay on the stamps of a plan, with its derivatives.
#[derive(Clone, Debug)]
pub struct StampedResponse {
    /// Arc of each output, and the time since it began \[s\]; `None` before the first one.
    places: Vec<Option<(usize, f64)>>,
    /// \[rad/s\].
    poles: Vec<Complex64>,
    value: Readout,
    /// One for each parameter, then that of the delay.
    tangents: Vec<Readout>,
}

/// Buffers of one thread.
#[derive(Clone, Debug, Default)]
pub struct StampedWorkspace {
    relaxations: RelaxationBank,
    /// Of each output that is read.
    weights: Vec<BankWeights>,
    resonances: ResonanceBank,
    parabolas: Parabolas,
    /// Inputs at the end of the arc.
    next: Vec<Abreast>,
    sums: Vec<Abreast>,
}

impl StampedPlan {
    /// A plan for an input given at `knots` (held, or a parabola over each arc) and an output at `outputs_s`
    /// \[s\], increasing. Before its first knot the input is 0. Two knots at one time are a jump, before
    /// which an output of that time is read.
    ///
    /// # Errors
    /// [`DynamicsError::TooFewSamples`] below two knots or for a single time.
    pub fn new(knots: impl Into<KnotTimes>, outputs_s: Vec<f64>, held: bool) -> Result<Self, DynamicsError> {
        let KnotTimes { times_s, arcs } = knots.into();
        let knots = times_s.len();
        debug_assert!(arcs.is_sorted() && arcs.last().is_none_or(|last| last + 1 == knots));
        let corners: Vec<usize> = std::iter::once(0).chain(arcs).filter(|knot| *knot < knots).collect();
        let corners_s: Vec<f64> = corners.iter().map(|knot| times_s[*knot]).collect();
        let mut steps: Vec<f64> =
            corners_s.windows(2).map(|two| two[1] - two[0]).filter(|step| *step > 0.0).collect();
        let duration: f64 = steps.iter().sum();
        let rank = (SHORT_STEPS * steps.len() as f64) as usize;
        let shortest = (rank < steps.len()).then(|| *steps.select_nth_unstable_by(rank, f64::total_cmp).1);
        let Some(shortest) = shortest.filter(|step| step.is_finite() && duration.is_finite()) else {
            return Err(DynamicsError::TooFewSamples { need: 2, found: knots });
        };
        let fit = RelaxationFit::new(duration, shortest)?;
        Ok(Self { knots, corners, corners_s, outputs_s, held, fit })
    }

    /// Knots of the input.
    pub fn knots(&self) -> usize {
        self.knots
    }

    /// Samples of the output.
    pub fn samples(&self) -> usize {
        self.outputs_s.len()
    }

    /// An empty response.
    pub fn empty_response(&self) -> StampedResponse {
        StampedResponse {
            places: Vec::new(),
            poles: Vec::new(),
            value: Readout::default(),
            tangents: Vec::new(),
        }
    }

    /// `tf` behind a delay \[s\], with its derivatives where a linearised form is given.
    ///
    /// # Errors
    /// Those of [`TransferFunction::validate`]; [`DynamicsError::Unstable`], [`DynamicsError::Improper`],
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
        match linearised.map_or_else(|| stability(tf), Linearised::stability) {
            Stability::Unstable { poles } => return Err(DynamicsError::Unstable { poles }),
            Stability::Marginal { .. } | Stability::Integrating { .. } | Stability::Stable => {}
        }
        let resonances = ResonantPole::of(tf, linearised)?;
        let (value, tangents) = self.fit.weights(tf, linearised, &resonances)?;
        self.locate(delay_s, &mut response.places);
        response.poles.clear();
        response.poles.extend(resonances.iter().map(|pole| pole.place));
        response.value = Readout::of_value(value, &resonances);
        response.tangents.clear();
        if let Some(linearised) = linearised {
            response.tangents.extend(tangents.into_iter().enumerate().map(|(which, weights)| {
                let mut readout = Readout::of_tangent(weights, &resonances, which);
                readout.is_zero = linearised.is_still(which);
                readout
            }));
            let delayed = response.value.delayed(&self.fit.rates, &response.poles);
            response.tangents.push(delayed);
        }
        Ok(())
    }

    /// Arcs of the delayed output times.
    fn locate(&self, delay_s: f64, places: &mut Vec<Option<(usize, f64)>>) {
        places.clear();
        let mut arc = 0;
        places.extend(self.outputs_s.iter().map(|output_s| {
            let time = output_s - delay_s;
            while knot_follows(&self.corners_s, arc, time) {
                arc += 1;
            }
            let since = time - self.corners_s.get(arc)?;
            (since >= 0.0).then_some((arc, since))
        }));
    }

    /// Duration of an arc \[s\]; 0 after the last one.
    fn length_s(&self, arc: usize) -> f64 {
        match (self.corners_s.get(arc), self.corners_s.get(arc + 1)) {
            (Some(from), Some(to)) => to - from,
            _ => 0.0,
        }
    }

    /// The inputs over an arc, `next` being their values at its beginning, then at its end. Returns its
    /// duration \[s\].
    fn begin_arc(
        &self,
        arc: usize,
        inputs: &[&[f64]],
        parabolas: &mut Parabolas,
        next: &mut [Abreast],
    ) -> f64 {
        let length_s = self.length_s(arc);
        parabolas.begin_at(next);
        let (Some(&first), Some(&last)) = (self.corners.get(arc), self.corners.get(arc + 1)) else {
            parabolas.slope.fill([0.0; ABREAST]);
            parabolas.bend.fill([0.0; ABREAST]);
            parabolas.to.copy_from_slice(next);
            parabolas.straight = true;
            return length_s;
        };
        let per_s = if !self.held && length_s > 0.0 { 1.0 / length_s } else { 0.0 };
        parabolas.straight = last == first + 1 || per_s == 0.0;
        let ends = next.as_flattened_mut().iter_mut();
        let per_part = 1.0 / (last - first) as f64;
        let slopes = parabolas.slope.as_flattened_mut().iter_mut();
        let bends = parabolas.bend.as_flattened_mut().iter_mut();
        for (((next, slope), bend), input) in ends.zip(slopes).zip(bends).zip(inputs) {
            let from = std::mem::replace(next, input[last]);
            *slope = (*next - from) * per_s;
            *bend = 0.0;
            if !parabolas.straight {
                let middle = 0.5 * (from + *next);
                let between: f64 = input[first + 1..last].iter().sum();
                let excess = (between + middle) * per_part - middle;
                *slope += 6.0 * excess * per_s;
                *bend = -6.0 * excess * per_s * per_s;
            }
        }
        parabolas.to.copy_from_slice(if self.held { &parabolas.from } else { next });
        length_s
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
        self.apply_each(response, &[input], workspace, &mut [output])
    }

    /// [`Self::apply`] to several inputs in one pass: an output for each. An output does not depend on the
    /// others in the pass.
    ///
    /// # Errors
    /// Those of [`Self::apply`].
    pub fn apply_each(
        &self,
        response: &StampedResponse,
        inputs: &[&[f64]],
        workspace: &mut StampedWorkspace,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), DynamicsError> {
        self.read(response, &[&response.value], inputs, workspace, outputs)
    }

    /// [`Self::apply`] for derivative `which` of the response: a parameter's, or the delay's, which is the
    /// last.
    ///
    /// # Errors
    /// Those of [`Self::apply`]; [`DynamicsError::NoTangent`].
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

    /// [`Self::apply_tangent`] of several derivatives in one pass: one output for each.
    ///
    /// # Errors
    /// Those of [`Self::apply_tangent`].
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
        self.read(response, &readouts, &[input], workspace, &mut outputs)
    }

    /// The outputs of the first readout for every input, then those of the next.
    fn read(
        &self,
        response: &StampedResponse,
        readouts: &[&Readout],
        inputs: &[&[f64]],
        workspace: &mut StampedWorkspace,
        outputs: &mut [&mut [f64]],
    ) -> Result<(), DynamicsError> {
        if outputs.is_empty() {
            return Ok(());
        }
        for input in inputs {
            check_length("input", input.len(), self.knots())?;
            check_finite("input", input)?;
        }
        check_length("outputs", outputs.len(), inputs.len() * readouts.len())?;
        for output in &*outputs {
            check_length("output", output.len(), self.samples())?;
        }
        check_length("response", response.places.len(), self.samples())?;
        let StampedWorkspace { relaxations, weights, resonances, parabolas, next, sums } = workspace;
        weights.resize_with(readouts.len(), BankWeights::default);
        for (readout, weights) in readouts.iter().zip(&mut *weights) {
            weights.set(&readout.relaxations);
        }
        let rates = if weights.iter().all(BankWeights::is_zero) { &[] } else { &self.fit.rates[..] };
        relaxations.reset(rates.first().copied().unwrap_or(1.0), rates.len(), inputs.len());
        let of_poles: Vec<&[_]> = readouts.iter().map(|readout| &readout.resonances[..]).collect();
        let propagated = Propagated {
            derivatives: of_poles.iter().copied().flatten().any(|(_, of_moved)| *of_moved != Complex64::ZERO),
            bends: self.corners.len() < self.knots,
        };
        resonances.reset(&response.poles, inputs.len(), propagated);
        let width = inputs.len().div_ceil(ABREAST);
        parabolas.reset(inputs.len());
        next.clear();
        next.resize(width, [0.0; ABREAST]);
        next.as_flattened_mut().iter_mut().zip(inputs).for_each(|(next, input)| *next = input[0]);
        sums.resize(width * readouts.len(), [0.0; ABREAST]);
        let set = InstructionSet::detected();
        let since_s = |output: usize| response.places.get(output).copied().flatten().map_or(0.0, |(_, s)| s);
        let remembers = !rates.is_empty() || !response.poles.is_empty();
        let (mut at, mut along_s) = (0, self.begin_arc(0, inputs, parabolas, next));
        relaxations.begin(parabolas);
        let mut finite = true;
        for (index, place) in response.places.iter().enumerate() {
            let Some((arc, since)) = *place else {
                outputs.iter_mut().for_each(|output| output[index] = 0.0);
                continue;
            };
            while at < arc {
                if along_s > 0.0 && remembers {
                    relaxations.advance(set, parabolas, along_s);
                    resonances.advance(set, parabolas, at, |arc| self.length_s(arc));
                }
                at += 1;
                along_s = self.begin_arc(at, inputs, parabolas, next);
                relaxations.begin(parabolas);
            }
            for (sums, readout) in sums.chunks_exact_mut(width).zip(readouts) {
                for (row, sum) in sums.iter_mut().enumerate() {
                    let (from, slope) = (&parabolas.from[row], &parabolas.slope[row]);
                    *sum = std::array::from_fn(|i| {
                        readout.input * (from[i] + slope[i] * since) + readout.slope * slope[i]
                    });
                    if !parabolas.straight {
                        let bend = &parabolas.bend[row];
                        let (of_input, of_slope) =
                            (readout.input * since * since, 2.0 * readout.slope * since);
                        (0..ABREAST).for_each(|i| sum[i] += (of_input + of_slope) * bend[i]);
                    }
                }
            }
            relaxations.read(set, parabolas, since, weights, sums);
            resonances.read(set, parabolas, (index, since_s), &of_poles, sums);
            let sums = sums.chunks_exact(width).flat_map(|sums| &sums.as_flattened()[..inputs.len()]);
            for (output, sum) in outputs.iter_mut().zip(sums) {
                output[index] = *sum;
                finite &= sum.is_finite();
            }
        }
        if finite { Ok(()) } else { Err(DynamicsError::OutputNotFinite) }
    }
}

/// True if a time is read from a knot after this one: up to a jump at that time, not beyond it.
fn knot_follows(knots_s: &[f64], knot: usize, time_s: f64) -> bool {
    match (knots_s.get(knot), knots_s.get(knot + 1)) {
        (Some(this), Some(next)) => *next < time_s || (*next == time_s && next > this),
        _ => false,
    }
}

impl StampedResponse {
    /// True if derivative `which` is zero everywhere (or not there).
    pub fn tangent_is_zero(&self, which: usize) -> bool {
        self.tangents.get(which).is_none_or(|tangent| tangent.is_zero)
    }
}
