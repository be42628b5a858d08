//! Orders of polynomial and continuous-time models by BIC.

use super::polynomial::{PolynomialFit, PolynomialOrders, fit_polynomial};
use super::srivc::{SrivcFit, SrivcOrders, fit_srivc};
use hysteron_model::dynamics::DynamicsError;
use hysteron_model::dynamics::arx::ArxRecord;
use hysteron_model::record::InterSample;

/// Number of poles for choosing the delay before other orders are tried.
const POLES_OF_DELAY: usize = 2;

/// A fitted model in the order selection.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected<F> {
    /// The fit.
    pub fit: F,
    /// M ln V + p ln M with the mean square V of the simulation error, p coefficients and M the effective
    /// number of independent samples of the best fit's residual.
    pub bic: f64,
}

/// Fits output-error models with 1 to `most_poles` poles and as many or one more coefficients of B, each with
/// its best delay of 0 to `longest_delay` samples, and returns them by BIC, the best first; with `noise` =
/// (nc, nd) the best one has a Box–Jenkins noise model.
///
/// # Errors
/// Those of [`fit_polynomial`], where none can be fitted.
pub fn select_polynomial(
    records: &[ArxRecord<'_>],
    most_poles: usize,
    longest_delay: usize,
    (nc, nd): (usize, usize),
) -> Result<Vec<Selected<PolynomialFit>>, DynamicsError> {
    let fit = |nf: usize, nb: usize, nk: usize| {
        let fit = fit_polynomial(records, PolynomialOrders::output_error(nb, nf, nk))?;
        Ok((nf + nb, fit.simulated_rmse, fit.independent_samples, fit))
    };
    let shapes: Vec<(usize, usize)> = (1..=most_poles).flat_map(|nf| [(nf, nf), (nf, nf + 1)]).collect();
    let mut list = ranked(&shapes, longest_delay, fit)?;
    if let Some(best) = list.first_mut().filter(|_| nc + nd > 0) {
        let model = &best.fit.model;
        let orders = PolynomialOrders { nb: model.b.len(), nf: model.f.len(), nk: model.nk, nc, nd };
        best.fit = fit_polynomial(records, orders)?;
    }
    Ok(list)
}

/// Fits continuous-time models with 1 to `most_poles` poles and one or two zeros less, each with its best
/// delay of 0 to `longest_delay` samples, and returns them by BIC, the best first.
///
/// # Errors
/// Those of [`fit_srivc`], where none can be fitted.
pub fn select_srivc(
    records: &[ArxRecord<'_>],
    most_poles: usize,
    longest_delay: usize,
    sample_rate_hz: f64,
    between: InterSample,
) -> Result<Vec<Selected<SrivcFit>>, DynamicsError> {
    let fit = |poles: usize, zeros: usize, delay: usize| {
        let fit = fit_srivc(records, SrivcOrders { zeros, poles, delay }, sample_rate_hz, between)?;
        Ok((poles + zeros + 1, fit.rmse, fit.independent_samples, fit))
    };
    let shapes: Vec<(usize, usize)> = (1..=most_poles)
        .flat_map(|poles| (poles.saturating_sub(2)..poles).map(move |zeros| (poles, zeros)))
        .collect();
    ranked(&shapes, longest_delay, fit)
}

/// Number of coefficients, simulation error, independent samples, and the fit.
type Judged<F> = (usize, f64, f64, F);

/// Every order with the delay of least simulation error: all delays for the first order with two poles, the
/// neighbours of its best delay for the others.
fn ranked<F>(
    shapes: &[(usize, usize)],
    longest_delay: usize,
    fit: impl Fn(usize, usize, usize) -> Result<Judged<F>, DynamicsError>,
) -> Result<Vec<Selected<F>>, DynamicsError> {
    let best_of = |(poles, others): (usize, usize), delays: std::ops::RangeInclusive<usize>| {
        let mut best: Result<(usize, Judged<F>), DynamicsError> = Err(DynamicsError::NoInputCoefficients);
        for delay in delays {
            match (fit(poles, others, delay), &best) {
                (Ok(found), Ok((_, before))) if found.1 >= before.1 => {}
                (Ok(found), _) => best = Ok((delay, found)),
                (Err(error), Err(_)) => best = Err(error),
                (Err(_), Ok(_)) => {}
            }
        }
        best
    };
    let first = shapes.iter().position(|(poles, _)| *poles == POLES_OF_DELAY).unwrap_or(0);
    let Some(&shape) = shapes.get(first) else { return Err(DynamicsError::NoInputCoefficients) };
    let of_delay = best_of(shape, 0..=longest_delay);
    let place = of_delay.as_ref().map_or(0, |(delay, _)| *delay);
    let near = place.saturating_sub(1)..=(place + 1).min(longest_delay);
    let mut refused = None;
    let mut found = Vec::new();
    let mut settled = Some(of_delay);
    for (index, &shape) in shapes.iter().enumerate() {
        let own = if index == first { settled.take() } else { None };
        match own.unwrap_or_else(|| best_of(shape, near.clone())) {
            Ok((_, judged)) => found.push(judged),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    let closest = found.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let Some(independent) = closest.map(|(_, _, samples, _)| *samples) else {
        return Err(refused.unwrap_or(DynamicsError::NoInputCoefficients));
    };
    let mut list: Vec<Selected<F>> = found
        .into_iter()
        .map(|(count, rmse, _, fit)| {
            let square = (rmse * rmse).max(f64::MIN_POSITIVE);
            Selected { fit, bic: independent * square.ln() + count as f64 * independent.ln() }
        })
        .collect();
    list.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    Ok(list)
}
