//! Starts: linear estimates of the core over a coarse grid of orders, power law and delay.

use std::f64::consts::TAU;

use super::levy::levy;
use super::problem::ResponseProblem;
use super::relocation::{Relocation, parameters, spread};
use super::{Core, FrequencyResponse};
use crate::IdentifyError;
use hysteron_numeric::Complex64;
use hysteron_optimize::{Bounds, Problem};

/// Grid of exponents of the power law, and of delays in units of 1/f_high.
const EXPONENTS: [f64; 5] = [0.0, 0.03, 0.1, 0.3, 0.8];
const DELAYS: [f64; 5] = [0.0, 0.05, 0.15, 0.4, 1.0];
/// Orders of a fractional lag, and the lower and the higher order of a fractional oscillator.
const LAG_ORDERS: [f64; 9] = [0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 1.1, 1.4, 1.8];
const LOWER_ORDERS: [f64; 5] = [0.3, 0.6, 0.9, 1.1, 1.4];
const HIGHER_ORDERS: [f64; 5] = [1.0, 1.4, 1.7, 1.95, 2.1];
/// Sanathanan–Koerner iterations, and pole relocations.
const PASSES: usize = 6;
const RELOCATIONS: usize = 20;
/// Number of starts returned.
const KEPT: usize = 4;

/// The best few starts by cost, best first, one for each exponent and delay to keep them different.
pub(super) fn starts(response: &FrequencyResponse, problem: &ResponseProblem) -> Vec<Vec<f64>> {
    let structure = problem.structure;
    let (_, high) = response.range_hz();
    let exponents = if structure.power_law { &EXPONENTS[..] } else { &[0.0] };
    let delays = if structure.delay { &DELAYS[..] } else { &[0.0] };
    let mut ws = problem.workspace();
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for &exponent in exponents {
        for &turns in delays {
            let delay = turns / high;
            let rest = without_factors(response, exponent, delay);
            let mut of_these: Vec<(f64, Vec<f64>)> = Vec::new();
            for mut x in core_starts(&rest, structure.core) {
                for (there, value) in
                    [(structure.power_law, exponent), (structure.loss_angle, 0.0), (structure.delay, delay)]
                {
                    if there {
                        x.push(value);
                    }
                }
                clip(problem.bounds(), &mut x);
                let cost = problem.cost(&x, &mut ws);
                if cost.is_finite() {
                    of_these.push((cost, x));
                }
            }
            of_these.sort_by(|a, b| a.0.total_cmp(&b.0));
            of_these.truncate(KEPT.div_ceil(exponents.len() * delays.len()));
            found.append(&mut of_these);
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(KEPT);
    found.into_iter().map(|(_, x)| x).collect()
}

/// Number of frequencies at which a further mode is tried.
const PLACES: usize = 40;
/// Its damping.
const LIGHT: f64 = 0.02;

/// Starts that add a mode to a fit with `modes` modes and parameters `before`, at its best two frequencies.
pub(super) fn one_mode_more(
    response: &FrequencyResponse,
    problem: &ResponseProblem,
    before: &[f64],
    modes: usize,
) -> Vec<Vec<f64>> {
    let (low, high) = response.range_hz();
    let mut ws = problem.workspace();
    let (old, factors) = before.split_at((2 * modes).min(before.len()));
    let place = |k: usize| low * (high / low).powf((k as f64 + 0.5) / PLACES as f64);
    let mut found: Vec<(f64, Vec<f64>)> = (0..PLACES)
        .map(|k| [old, &[place(k), LIGHT], factors].concat())
        .map(|x| (problem.cost(&x, &mut ws), x))
        .filter(|(cost, _)| cost.is_finite())
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(2);
    found.into_iter().map(|(_, x)| x).collect()
}

fn clip(bounds: &Bounds, x: &mut [f64]) {
    for (x, range) in x.iter_mut().zip(&bounds.ranges) {
        *x = x.clamp(range.low, range.high);
    }
}

/// G / (s^{−μ} e^{−sτ}).
fn without_factors(response: &FrequencyResponse, exponent: f64, delay: f64) -> FrequencyResponse {
    let mut rest = response.clone();
    for (i, &f) in response.frequency_hz.iter().enumerate() {
        let s = Complex64::new(0.0, TAU * f);
        let inverse = (s.ln() * exponent + s * delay).exp();
        rest.values[i] *= inverse;
        if let Some(std_dev) = &mut rest.std_dev {
            std_dev[i] *= inverse.norm();
        }
    }
    rest
}

fn core_starts(response: &FrequencyResponse, core: Core) -> Vec<Vec<f64>> {
    match core {
        Core::Constant => vec![Vec::new()],
        Core::FractionalLag => LAG_ORDERS.iter().map(|&order| lag(response, order)).collect(),
        Core::FractionalOscillator => {
            let pairs =
                LOWER_ORDERS.iter().flat_map(|&low| HIGHER_ORDERS.iter().map(move |&high| (low, high)));
            pairs
                .filter(|(low, high)| low < high)
                .filter_map(|(low, high)| oscillator(response, low, high).ok())
                .collect()
        }
        Core::Rational { poles, direct } => relocated(response, poles, direct),
        Core::Modes { count } => relocated(response, 2 * count, true),
    }
}

/// Corner a^(−1/α) of 1 + a s^α; the middle of the band where the linear estimate gives none.
fn lag(response: &FrequencyResponse, order: f64) -> Vec<f64> {
    let (low, high) = response.range_hz();
    let corner = levy(response, &[0.0], &[0.0, order], PASSES)
        .ok()
        .and_then(|g| g.denominator.last().map(|term| term.coefficient.powf(-1.0 / order) / TAU))
        .filter(|f| f.is_finite() && *f > 0.0);
    vec![corner.unwrap_or((low * high).sqrt()), order]
}

fn oscillator(response: &FrequencyResponse, order1: f64, order2: f64) -> Result<Vec<f64>, IdentifyError> {
    let g = levy(response, &[0.0], &[0.0, order1, order2], PASSES)?;
    let (low, high) = response.range_hz();
    let [_, one, two] = g.denominator.as_slice() else { return Ok(vec![high, 1.0, order1, order2]) };
    let omega = two.coefficient.powf(-1.0 / order2);
    if !(omega.is_finite() && omega > 0.0) {
        return Ok(vec![(low * high).sqrt(), 0.5, order1, order2]);
    }
    Ok(vec![omega / TAU, 0.5 * one.coefficient * omega.powf(order1), order1, order2])
}

/// The poles of every relocation pass: the last is not always the best.
fn relocated(response: &FrequencyResponse, count: usize, direct: bool) -> Vec<Vec<f64>> {
    let omega: Vec<f64> = response.frequency_hz.iter().map(|f| TAU * f).collect();
    let relocation = Relocation { omega: &omega, values: &response.values, direct };
    let (low, high) = response.range_hz();
    let mut poles = spread(count, low, high);
    let mut found = vec![parameters(&poles)];
    for pass in 0..RELOCATIONS {
        match relocation.pass(&poles) {
            Some(next) => poles = next,
            None => break,
        }
        if pass >= RELOCATIONS / 2 {
            found.push(parameters(&poles));
        }
    }
    found
}
