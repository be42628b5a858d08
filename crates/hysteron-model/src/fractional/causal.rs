//! The recursion of article Eq. 4 by divide and conquer.

use super::recursion::kernels;
use super::{Scheme, Term};
use crate::dynamics_error::{DynamicsError, check_result};
use hysteron_numeric::convolution::{CausalConvolver, causal_convolution};

/// Ranges up to this length are solved by the plain recursion.
const DIRECT: usize = 128;

/// [`super::simulate_recursion`] in O(N log² N), same arguments and errors: the past's contribution to the
/// second half of a range is one FFT convolution with its first half, recursively (Hairer, Lubich, Schlichte
/// 1985, doi:10.1137/0906037).
///
/// Unlike the one-transform simulation of [`crate::dynamics::SimulationPlan`] it makes no assumption of
/// stability: the error grows no faster than the response. Agrees with the plain recursion within 1e-12 of
/// the largest value on article Eq. 13.
///
/// # Errors
/// Those of [`super::simulate_recursion`].
pub fn simulate_causal(
    numerator: &[Term],
    denominator: &[Term],
    input: &[f64],
    sample_rate_hz: f64,
    scheme: Scheme,
) -> Result<Vec<f64>, DynamicsError> {
    let (n, d) = kernels(numerator, denominator, input.len(), sample_rate_hz, scheme)?;
    // Forcing first; each solved sample then subtracts itself from the samples after it.
    let mut output = match n.as_slice() {
        [constant] => input.iter().map(|u| constant * u).collect(),
        _ => causal_convolution(&n, input),
    };
    let mut blocks = Vec::new();
    let mut length = DIRECT;
    while length < output.len() {
        // Range of 2·length: its first half acts on its second half through d₁ … d_{2·length − 1}.
        let reach = d.get(..(2 * length).min(d.len())).unwrap_or(&d);
        blocks.push(CausalConvolver::new(reach, 2 * length));
        length *= 2;
    }
    solve(&d, &mut blocks, &mut output);
    check_result(output)
}

/// Solves for a range whose samples hold the forcing minus the contribution of everything before the range.
fn solve(d: &[f64], blocks: &mut [CausalConvolver], range: &mut [f64]) {
    match blocks.split_last_mut() {
        Some((block, inner)) => {
            let half = DIRECT << inner.len();
            if range.len() <= half {
                return solve(d, inner, range);
            }
            let (first, second) = range.split_at_mut(half);
            solve(d, inner, first);
            let past = block.convolve(first);
            for (x, past) in second.iter_mut().zip(&past[half..]) {
                *x -= past;
            }
            solve(d, inner, second);
        }
        None => {
            for k in 0..range.len() {
                let (before, rest) = range.split_at_mut(k);
                let past: f64 = before.iter().rev().zip(&d[1..]).map(|(x, w)| x * w).sum();
                if let Some(x) = rest.first_mut() {
                    *x = (*x - past) / d[0];
                }
            }
        }
    }
}
