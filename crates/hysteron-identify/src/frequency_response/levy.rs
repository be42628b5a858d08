//! Linear estimate of a transfer function of given orders: Levy's method and its iteration.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::super::projection::Projection;
use super::FrequencyResponse;
use crate::IdentifyError;
use hysteron_model::dynamics::{Term, TransferFunction};
use hysteron_numeric::Complex64;

/// Coefficients b, a of G(s) = Σ b s^β / (s^α₀ + Σ a s^α) at given orders, ascending, the lowest denominator
/// coefficient 1.
///
/// One pass minimises Σ |w_i (N(s_i) − G_i D(s_i))/D'(s_i)|² with D' the denominator of the pass before. The
/// first, with D' = 1, is Levy's (1959, doi:10.1109/TAC.1959.6429401); the further ones are Sanathanan and
/// Koerner's (1963, doi:10.1109/TAC.1963.1105517), which remove the bias of Levy's equations towards high
/// frequencies. w_i is 1/σ_i where the response has an uncertainty, else 1/|G_i|. The iteration converges to
/// the least-squares estimate only as the noise vanishes: it is a starting value. Solved in s/ω₀, ω₀ in the
/// middle of the band.
///
/// # Errors
/// [`IdentifyError::Undetermined`] for fewer equations than coefficients, or without a finite solution;
/// [`IdentifyError::Dynamics`] for orders that are not allowed.
pub fn levy(
    response: &FrequencyResponse,
    numerator_orders: &[f64],
    denominator_orders: &[f64],
    passes: usize,
) -> Result<TransferFunction, IdentifyError> {
    let (points, numerators) = (response.len(), numerator_orders.len());
    let coefficients = (numerators + denominator_orders.len()).saturating_sub(1);
    let undetermined = || IdentifyError::Undetermined { points, coefficients };
    let Some((&lowest, others)) = denominator_orders.split_first() else { return Err(undetermined()) };
    if 2 * points < coefficients || numerators == 0 {
        return Err(undetermined());
    }
    let (low, high) = response.range_hz();
    let middle = TAU * (low * high).sqrt();
    let power = |f: f64, order: f64| Complex64::from_polar((TAU * f / middle).powf(order), FRAC_PI_2 * order);
    let weight = |i: usize| match &response.std_dev {
        Some(std_dev) => 1.0 / std_dev[i],
        None => 1.0 / response.values[i].norm(),
    };
    let rows = 2 * points;
    let mut projection = Projection::new(rows, coefficients);
    let mut matrix = vec![0.0; rows * coefficients];
    let mut target = vec![0.0; rows];
    let mut solution = vec![0.0; coefficients];
    let mut before = vec![Complex64::ONE; points];
    for _ in 0..passes.max(1) {
        for (i, (&f, &g)) in response.frequency_hz.iter().zip(&response.values).enumerate() {
            let scale = weight(i) / before[i].norm();
            let unknowns = numerator_orders
                .iter()
                .map(|&order| power(f, order))
                .chain(others.iter().map(|&order| -g * power(f, order)));
            for (k, unknown) in unknowns.enumerate() {
                matrix[k * rows + i] = scale * unknown.re;
                matrix[k * rows + points + i] = scale * unknown.im;
            }
            let known = scale * g * power(f, lowest);
            (target[i], target[points + i]) = (known.re, known.im);
        }
        projection.decompose(&matrix);
        projection.coefficients_into(&target, &mut solution);
        if !solution.iter().all(|c| c.is_finite()) {
            return Err(undetermined());
        }
        for (d, &f) in before.iter_mut().zip(&response.frequency_hz) {
            let terms = others.iter().zip(&solution[numerators..]);
            *d = power(f, lowest) + terms.map(|(&order, a)| a * power(f, order)).sum::<Complex64>();
        }
        if before.contains(&Complex64::ZERO) {
            break;
        }
    }
    // Σ ĉ (s/ω₀)^order, rescaled to a lowest denominator coefficient of 1.
    let term = |(&order, &c): (&f64, &f64)| Term::new(c * middle.powf(lowest - order), order);
    let numerator = numerator_orders.iter().zip(&solution).map(term).collect();
    let mut denominator = vec![Term::new(1.0, lowest)];
    denominator.extend(others.iter().zip(&solution[numerators..]).map(term));
    Ok(TransferFunction::new(numerator, denominator)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(tf: &TransferFunction, frequency_hz: Vec<f64>) -> FrequencyResponse {
        let values = tf.frequency_response(&frequency_hz, 0.0);
        FrequencyResponse::new("exact", frequency_hz, values).unwrap()
    }

    fn terms(list: &[(f64, f64)]) -> Vec<Term> {
        list.iter().map(|&(c, order)| Term::new(c, order)).collect()
    }

    fn worst(found: &[Term], expected: &[Term]) -> f64 {
        let pairs = found.iter().zip(expected);
        pairs.map(|(a, b)| (a.coefficient / b.coefficient - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn one_pass_on_exact_data_returns_the_coefficients() {
        let rational = TransferFunction::new(
            terms(&[(3.0, 0.0), (0.02, 1.0)]),
            terms(&[(1.0, 0.0), (2e-3, 1.0), (4e-6, 2.0)]),
        )
        .unwrap();
        let fractional =
            TransferFunction::new(terms(&[(0.9, 0.0)]), terms(&[(1.0, 0.3), (5e-3, 1.1), (2e-6, 2.04)]))
                .unwrap();
        for tf in [rational, fractional] {
            let response = sampled(&tf, (1..=40).map(|k| 5.0 * f64::from(k)).collect());
            let orders = |terms: &[Term]| terms.iter().map(|t| t.order).collect::<Vec<_>>();
            let found = levy(&response, &orders(&tf.numerator), &orders(&tf.denominator), 1).unwrap();
            let error =
                worst(&found.numerator, &tf.numerator).max(worst(&found.denominator, &tf.denominator));
            assert!(error < 1e-10, "{found}: {error}");
        }
    }

    #[test]
    fn the_iteration_takes_away_most_of_the_bias_that_noise_gives_levys_equations() {
        // Noise of constant size on a response that falls by 1000: Levy's equations fit the noisy end.
        let tf = TransferFunction::new(terms(&[(1.0, 0.0)]), terms(&[(1.0, 0.0), (1e-3, 1.0), (1e-5, 2.0)]))
            .unwrap();
        let mut response = sampled(&tf, (0..200).map(|k| 1.04f64.powi(k)).collect());
        let mut state = 1u64;
        for value in &mut response.values {
            let mut uniform = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            };
            *value += Complex64::new(uniform(), uniform()) * 0.01;
        }
        response.std_dev = Some(vec![0.01 / 6f64.sqrt(); response.len()]);
        let error = |passes| {
            let found = levy(&response, &[0.0], &[0.0, 1.0, 2.0], passes).unwrap();
            worst(&found.denominator, &tf.denominator)
        };
        let (once, iterated) = (error(1), error(15));
        assert!(iterated < 0.03 && iterated < 0.1 * once, "Levy {once}, iterated {iterated}");
    }

    #[test]
    fn fewer_equations_than_coefficients_are_refused() {
        let response = FrequencyResponse::new("one", vec![1.0], vec![Complex64::ONE]).unwrap();
        let refused = levy(&response, &[0.0, 1.0], &[0.0, 1.0, 2.0], 1);
        assert!(matches!(refused, Err(IdentifyError::Undetermined { points: 1, coefficients: 4 })));
        assert!(levy(&response, &[0.0], &[], 1).is_err());
    }
}
