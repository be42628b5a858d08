//! Simulation of a transfer function on time stamps of any spacing.
//!
//! G as a sum of relaxations and resonances, G(s) = d + Σ wₖ λₖ/(s + λₖ) + Σ (Rᵢ/(s − pᵢ) + R̄ᵢ/(s − p̄ᵢ)): each is a first-order
//! differential equation, which is solved exactly over every step, whatever its length, for an input that goes along straight lines
//! (or is held) between its knots. The output is exact at any time, so that the delay needs no interpolation. The rates λₖ are fixed
//! by the record ([`relaxation_fit`]); wₖ follow from G on the imaginary axis by least squares, pᵢ and Rᵢ are those of G
//! ([`resonant_poles`]). Derivatives in the parameters and in the delay are those of the same sum.
//!
//! Error: below 1e-6 of the range against [`super::SimulationPlan`] on a fine common grid (`tests/stamps.rs`).

mod knots;
mod relaxation_fit;
mod resonant_poles;

use super::{DynamicsError, Linearised, Stability, TransferFunction, stability};
use crate::dynamics_error::{check_finite, check_length};
use hysteron_numeric::Complex64;
pub use knots::Knots;
use relaxation_fit::{RelaxationFit, Weights};
use resonant_poles::ResonantPole;

/// Derivatives of the terms of a transfer function, where they are asked for.
type Tangents<'a> = Option<&'a Linearised>;

/// Steps whose lengths differ by less than this share are taken to be equal: what rounding makes of equal ones.
const EQUAL: f64 = 1e-8;
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
    poles: Vec<Complex64>,
    value: Readout,
    /// One for each parameter, then that of the delay.
    tangents: Vec<Readout>,
}

/// Buffers of one thread.
#[derive(Clone, Debug, Default)]
pub struct StampedWorkspace {
    states: States,
    step: Step,
    reading: Reading,
}

/// An output as a linear function of the states and of the input.
#[derive(Clone, Debug, Default)]
struct Readout {
    relaxations: Vec<f64>,
    /// Factors of x, the response of 1/(s − p), and of ∂x/∂p; the real part of the sum counts.
    resonances: Vec<(Complex64, Complex64)>,
    /// Factor of the input.
    input: f64,
    /// Factor of its slope.
    slope: f64,
    is_zero: bool,
}

impl StampedPlan {
    /// A plan for an input given at `knots_s` (held between them, or on straight lines) and an output at `outputs_s` \[s\], both
    /// increasing. Before its first knot the input is 0.
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
            poles: Vec::new(),
            value: Readout::default(),
            tangents: Vec::new(),
        }
    }

    /// `tf` behind a delay \[s\], with its derivatives where a linearised form is given.
    ///
    /// # Errors
    /// What [`TransferFunction::validate`] refuses; [`DynamicsError::Unstable`], [`DynamicsError::Improper`],
    /// [`DynamicsError::Parameter`] for a delay that is negative or not finite; [`DynamicsError::OutputNotFinite`] where G is no sum
    /// of relaxations and resonances.
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
        response.poles = resonances.iter().map(|pole| pole.place).collect();
        response.value = Readout::of_value(value, &resonances);
        response.tangents.clear();
        if let Some(linearised) = linearised {
            response.tangents.extend(tangents.into_iter().enumerate().map(|(which, weights)| {
                let mut readout = Readout::of_tangent(weights, &resonances, which);
                readout.is_zero = linearised.is_still(which);
                readout
            }));
            response.tangents.push(response.value.delayed(&self.fit.rates, &response.poles));
        }
        Ok(())
    }

    /// Where each output reads the input's time.
    fn locate(&self, delay_s: f64, places: &mut Vec<Option<(usize, f64)>>) {
        places.clear();
        let mut knot = 0;
        places.extend(self.outputs_s.iter().map(|output_s| {
            let time = output_s - delay_s;
            while self.knots_s.get(knot + 1).is_some_and(|next| *next <= time) {
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
        self.read(response, &response.value, input, workspace, output)
    }

    /// As [`Self::apply`] for derivative `which` of the response: a parameter's, or the delay's, which is the last.
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
        let found = response.tangents.len();
        let readout = response.tangents.get(which).ok_or(DynamicsError::NoTangent { which, found })?;
        if readout.is_zero {
            check_length("output", output.len(), self.samples())?;
            output.fill(0.0);
            return Ok(());
        }
        self.read(response, readout, input, workspace, output)
    }

    fn read(
        &self,
        response: &StampedResponse,
        readout: &Readout,
        input: &[f64],
        workspace: &mut StampedWorkspace,
        output: &mut [f64],
    ) -> Result<(), DynamicsError> {
        check_length("input", input.len(), self.knots())?;
        check_length("output", output.len(), self.samples())?;
        check_length("response", response.places.len(), self.samples())?;
        check_finite("input", input)?;
        let StampedWorkspace { states, step, reading } = workspace;
        states.reset(self.fit.rates.len(), response.poles.len());
        // The poles may be others than last time.
        (step.is_set, reading.is_set) = (false, false);
        let slope_behind = |knot: usize| match (input.get(knot + 1), self.knots_s.get(knot + 1)) {
            (Some(next), Some(until)) if !self.held && *until > self.knots_s[knot] => {
                (next - input[knot]) / (until - self.knots_s[knot])
            }
            _ => 0.0,
        };
        let (mut at, mut slope) = (0, slope_behind(0));
        let mut finite = true;
        for (place, out) in response.places.iter().zip(output) {
            let Some((knot, since)) = *place else {
                *out = 0.0;
                continue;
            };
            while at < knot {
                step.set(self.knots_s[at + 1] - self.knots_s[at], &self.fit.rates, &response.poles);
                states.advance(step, input[at], slope);
                at += 1;
                slope = slope_behind(at);
            }
            reading.set(since, &self.fit.rates, &response.poles, readout);
            *out = states.read(reading, input[at], slope);
            finite &= out.is_finite();
        }
        if finite { Ok(()) } else { Err(DynamicsError::OutputNotFinite) }
    }
}

impl StampedResponse {
    /// Whether derivative `which` is zero everywhere (or not there).
    pub fn tangent_is_zero(&self, which: usize) -> bool {
        self.tangents.get(which).is_none_or(|tangent| tangent.is_zero)
    }
}

impl Readout {
    fn of_value(weights: Weights, resonances: &[ResonantPole]) -> Self {
        let of = |pole: &ResonantPole| (2.0 * pole.residue, Complex64::ZERO);
        let Weights { relaxations, direct } = weights;
        let resonances = resonances.iter().map(of).collect();
        Self { relaxations, resonances, input: direct, slope: 0.0, is_zero: false }
    }

    fn of_tangent(weights: Weights, resonances: &[ResonantPole], which: usize) -> Self {
        let of = |pole: &ResonantPole| {
            let (place, residue) = pole.tangents[which];
            (2.0 * residue, 2.0 * pole.residue * place)
        };
        let Weights { relaxations, direct } = weights;
        let resonances = resonances.iter().map(of).collect();
        Self { relaxations, resonances, input: direct, slope: 0.0, is_zero: false }
    }

    /// Derivative in the delay: less the rate of the output, which follows from λ (u − ξ) and p x + u.
    fn delayed(&self, rates: &[f64], poles: &[Complex64]) -> Self {
        let relaxations: Vec<f64> =
            self.relaxations.iter().zip(rates).map(|(weight, rate)| weight * rate).collect();
        let resonances = self.resonances.iter().zip(poles);
        let residues: f64 = self.resonances.iter().map(|(residue, _)| residue.re).sum();
        Self {
            input: -relaxations.iter().sum::<f64>() - residues,
            slope: -self.input,
            resonances: resonances.map(|((residue, _), pole)| (-residue * pole, Complex64::ZERO)).collect(),
            relaxations,
            is_zero: false,
        }
    }
}

/// Of the response of 1/(s − p) after a time t from x, to the input u + u' t: x e^(pt) + u first + u' second; then the same of the
/// derivative in p.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    decay: Complex64,
    first: Complex64,
    second: Complex64,
    first_tangent: Complex64,
    second_tangent: Complex64,
}

impl Stretch {
    fn new(pole: Complex64, time: f64) -> Self {
        let x = pole * time;
        let decay = x.exp();
        // φₖ(x) = Σ xʲ/(j + k)!, first = t φ₁, second = t² φ₂, and t dφₖ/dx in p.
        let [phi1, phi2, slope1, slope2] = if x.norm() < 0.5 {
            phi_series(x)
        } else {
            let phi1 = (decay - 1.0) / x;
            let phi2 = (phi1 - 1.0) / x;
            let slope1 = (decay - phi1) / x;
            [phi1, phi2, slope1, (slope1 - phi2) / x]
        };
        Self {
            decay,
            first: phi1 * time,
            second: phi2 * time * time,
            first_tangent: slope1 * time * time,
            second_tangent: slope2 * time * time * time,
        }
    }
}

/// φ₁, φ₂ and their derivatives for |x| < 0.5; what is left out is below 0.5¹⁶/17!.
fn phi_series(x: Complex64) -> [Complex64; 4] {
    let mut sums = [Complex64::ZERO; 4];
    let mut power = Complex64::ONE;
    let mut factorial = 1.0;
    for j in 0..16 {
        factorial *= f64::from((j + 1).max(1));
        let (first, second) = (1.0 / factorial, 1.0 / (factorial * f64::from(j + 2)));
        sums[0] += power * first;
        sums[1] += power * second;
        // Of the next term, whose derivative has this power.
        let next = f64::from(j + 1) / f64::from(j + 2);
        sums[2] += power * (first * next);
        sums[3] += power * (second * f64::from(j + 1) / f64::from(j + 3));
        power *= x;
    }
    sums
}

/// States of all relaxations and resonances.
#[derive(Clone, Debug, Default)]
struct States {
    /// ξ of ξ' = λ (u − ξ).
    relaxations: Vec<f64>,
    /// x of x' = p x + u, and ∂x/∂p.
    resonances: Vec<(Complex64, Complex64)>,
}

/// What a step of one length does to the states.
#[derive(Clone, Debug, Default)]
struct Step {
    is_set: bool,
    length_s: f64,
    /// 1 − e^(−λt), and t − (1 − e^(−λt))/λ for the slope.
    gains: Vec<f64>,
    slopes: Vec<f64>,
    stretches: Vec<Stretch>,
}

/// An output a time after a knot, as a function of the states and the input there.
#[derive(Clone, Debug, Default)]
struct Reading {
    is_set: bool,
    since_s: f64,
    relaxations: Vec<f64>,
    resonances: Vec<(Complex64, Complex64)>,
    input: f64,
    slope: f64,
}

impl States {
    fn reset(&mut self, relaxations: usize, resonances: usize) {
        self.relaxations.clear();
        self.relaxations.resize(relaxations, 0.0);
        self.resonances.clear();
        self.resonances.resize(resonances, (Complex64::ZERO, Complex64::ZERO));
    }

    fn advance(&mut self, step: &Step, input: f64, slope: f64) {
        let gains = step.gains.iter().zip(&step.slopes);
        for (state, (gain, rise)) in self.relaxations.iter_mut().zip(gains) {
            *state += gain * (input - *state) + rise * slope;
        }
        for ((x, tangent), stretch) in self.resonances.iter_mut().zip(&step.stretches) {
            *tangent = stretch.decay * (*tangent + *x * step.length_s)
                + stretch.first_tangent * input
                + stretch.second_tangent * slope;
            *x = stretch.decay * *x + stretch.first * input + stretch.second * slope;
        }
    }

    fn read(&self, reading: &Reading, input: f64, slope: f64) -> f64 {
        let resonances = self.resonances.iter().zip(&reading.resonances);
        let resonant: f64 =
            resonances.map(|((x, tangent), (of_x, of_tangent))| (x * of_x + tangent * of_tangent).re).sum();
        hysteron_numeric::dot(&self.relaxations, &reading.relaxations)
            + resonant
            + reading.input * input
            + reading.slope * slope
    }
}

impl Step {
    fn set(&mut self, length_s: f64, rates: &[f64], poles: &[Complex64]) {
        if self.is_set && (length_s - self.length_s).abs() <= EQUAL * self.length_s {
            return;
        }
        (self.is_set, self.length_s) = (true, length_s);
        self.gains.clear();
        self.gains.extend(rates.iter().map(|rate| -(-rate * length_s).exp_m1()));
        self.slopes.clear();
        self.slopes.extend(self.gains.iter().zip(rates).map(|(gain, rate)| length_s - gain / rate));
        self.stretches.clear();
        self.stretches.extend(poles.iter().map(|&pole| Stretch::new(pole, length_s)));
    }
}

impl Reading {
    fn set(&mut self, since_s: f64, rates: &[f64], poles: &[Complex64], readout: &Readout) {
        if self.is_set && (since_s - self.since_s).abs() <= EQUAL * self.since_s {
            return;
        }
        (self.is_set, self.since_s) = (true, since_s);
        self.relaxations.clear();
        (self.input, self.slope) = (readout.input, readout.slope + readout.input * since_s);
        for (weight, rate) in readout.relaxations.iter().zip(rates) {
            let gain = -(-rate * since_s).exp_m1();
            self.relaxations.push(weight * (1.0 - gain));
            self.input += weight * gain;
            self.slope += weight * (since_s - gain / rate);
        }
        self.resonances.clear();
        for (&(of_x, of_tangent), &pole) in readout.resonances.iter().zip(poles) {
            let stretch = Stretch::new(pole, since_s);
            self.resonances.push(((of_x + of_tangent * since_s) * stretch.decay, of_tangent * stretch.decay));
            self.input += (of_x * stretch.first + of_tangent * stretch.first_tangent).re;
            self.slope += (of_x * stretch.second + of_tangent * stretch.second_tangent).re;
        }
    }
}
