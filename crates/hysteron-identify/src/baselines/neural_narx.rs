//! NARX models with one hidden layer.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::BaselineError;
use super::free_run::{Differentiable, OneStep, simulated_error};
use super::kernel_narx::least_squares;
use super::regressors::{Lags, Regressors};
use super::simulation_error::{Feedback, refine};
use super::training_set::{Rows, TrainingSet};

/// Hidden units.
const HIDDEN: usize = 6;
/// Random starts.
const SEEDS: std::ops::Range<u64> = 0..2;
/// Rows for the initial fit of the output layer.
const ROWS: usize = 6000;
/// Iterations on the one-step error, then on the simulated error; largest change of a parameter in each.
const ITERATIONS: [usize; 2] = [30, 40];
const REACH: f64 = 20.0;

/// y_k = b + wᵀx + Σ aⱼ tanh(cⱼ + vⱼᵀx).
#[derive(Clone, Debug, PartialEq)]
pub struct NeuralNarx {
    /// Number of regressors.
    inputs: usize,
    /// b, w; then aⱼ, cⱼ, vⱼ of every hidden unit.
    parameters: Vec<f64>,
}

impl NeuralNarx {
    /// A network of `inputs` regressors; parameters b, w, then a, c, v of every hidden unit.
    pub(super) fn new(inputs: usize, parameters: Vec<f64>) -> Self {
        Self { inputs, parameters }
    }
}

impl OneStep for NeuralNarx {
    fn next(&self, x: &[f64]) -> f64 {
        let (linear, hidden) = self.parameters.split_at(1 + self.inputs);
        let units = hidden.chunks_exact(2 + self.inputs);
        linear[0] + inner(&linear[1..], x) + units.map(|u| u[0] * activation(u, x)).sum::<f64>()
    }

    fn parameters(&self) -> usize {
        self.parameters.len()
    }
}

impl Differentiable for NeuralNarx {
    fn coefficients(&self) -> &[f64] {
        &self.parameters
    }

    fn set_coefficients(&mut self, coefficients: &[f64]) {
        self.parameters = coefficients.to_vec();
    }

    fn derivatives(&self, x: &[f64], by_x: &mut [f64], by_parameter: &mut [f64]) -> f64 {
        let (linear, hidden) = self.parameters.split_at(1 + self.inputs);
        let (by_linear, by_hidden) = by_parameter.split_at_mut(1 + self.inputs);
        by_linear[0] = 1.0;
        by_linear[1..].copy_from_slice(x);
        by_x.copy_from_slice(&linear[1..]);
        let mut output = linear[0] + inner(&linear[1..], x);
        let width = 2 + self.inputs;
        for (unit, by_unit) in hidden.chunks_exact(width).zip(by_hidden.chunks_exact_mut(width)) {
            let value = activation(unit, x);
            output += unit[0] * value;
            let slope = unit[0] * (1.0 - value * value);
            (by_unit[0], by_unit[1]) = (value, slope);
            for i in 0..self.inputs {
                by_unit[2 + i] = slope * x[i];
                by_x[i] += slope * unit[2 + i];
            }
        }
        output
    }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// tanh(c + vᵀx) of a hidden unit (a, c, v).
fn activation(unit: &[f64], x: &[f64]) -> f64 {
    (unit[1] + inner(&unit[2..], x)).tanh()
}

/// Trains on sets of the same records with different lag intervals; returns the index of the best set first.
///
/// Random hidden units with the output layer by least squares; then all parameters on the one-step error,
/// then on the simulated error of three quarters of the records. The network that simulates the held-out
/// quarter best is refined on all.
pub(super) fn train(
    sets: &[TrainingSet],
    lags: &[Lags],
) -> Result<(usize, Regressors, NeuralNarx), BaselineError> {
    let mut best: Option<(f64, usize, Regressors, NeuralNarx)> = None;
    let mut refused = BaselineError::NoStableModel;
    for (number, set) in sets.iter().enumerate() {
        for (&lags, seed) in lags.iter().flat_map(|l| SEEDS.map(move |seed| (l, seed))) {
            let regressors = Regressors::scaled(lags, &set.fitted);
            let start = match Rows::new(&regressors, &set.fitted, ROWS) {
                Ok(rows) => begin(&rows, seed),
                Err(error) => {
                    refused = error;
                    continue;
                }
            };
            let [one_step, simulated] = ITERATIONS;
            let refined = |model: &NeuralNarx, feedback, iterations| {
                refine(model, &regressors, &set.fitted, feedback, REACH, iterations)
            };
            // A network whose simulation diverges is discarded.
            let found = refined(&start, Feedback::Measured, one_step)
                .and_then(|model| refined(&model, Feedback::Simulated, simulated));
            let Ok(model) = found else { continue };
            let error = simulated_error(&model, &regressors, &set.series, &set.held_back);
            if let Some(error) = error.filter(|e| best.as_ref().is_none_or(|b| *e < b.0)) {
                best = Some((error, number, regressors, model));
            }
        }
    }
    let (_, number, regressors, model) = best.ok_or(refused)?;
    let all = &sets[number].series;
    let model = refine(&model, &regressors, all, Feedback::Simulated, REACH, ITERATIONS[1])?;
    Ok((number, regressors, model))
}

/// Random hidden units (normal weights, so that units are nonlinear within the range of the regressors), the
/// output layer by least squares.
fn begin(rows: &Rows, seed: u64) -> NeuralNarx {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || {
        let (a, b): (f64, f64) = (random.random(), random.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
    };
    let inputs = rows.width;
    let units: Vec<Vec<f64>> = (0..HIDDEN).map(|_| (0..2 + inputs).map(|_| normal()).collect()).collect();
    let ones = std::iter::once(vec![1.0; rows.len()]);
    let linear = (0..inputs).map(|j| rows.iter().map(|x| x[j]).collect());
    let bent = units.iter().map(|unit| rows.iter().map(|x| activation(unit, x)).collect());
    let columns: Vec<Vec<f64>> = ones.chain(linear).chain(bent).collect();
    let outer = least_squares(&columns, &rows.target);
    let mut parameters = outer[..1 + inputs].to_vec();
    for (unit, amplitude) in units.iter().zip(&outer[1 + inputs..]) {
        parameters.push(*amplitude);
        parameters.extend(&unit[1..]);
    }
    NeuralNarx::new(inputs, parameters)
}
