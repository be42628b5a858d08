//! Choosing the orders of an ARX model.

use super::fit::{ArxFit, ArxOrders, ArxRecord, fit_after};
use crate::dynamics::DynamicsError;
use crate::start::Start;

/// Criterion for the orders; with M equations, p unknowns and the mean squared prediction error V.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum OrderCriterion {
    /// M ln V + 2p (Akaike 1974, doi:10.1109/TAC.1974.1100705).
    Aic,
    /// M ln V + p ln M (Schwarz 1978, doi:10.1214/aos/1176344136).
    Bic,
    /// Root mean square error of the simulation from rest, offsets removed: what the model is for.
    #[default]
    SimulatedError,
}

/// Orders to try: every combination up to the maxima.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArxSearch {
    /// Output coefficients, 0 … `max_na`.
    pub max_na: usize,
    /// Input coefficients, 1 … `max_nb`.
    pub max_nb: usize,
    /// Delays in samples, 0 … `max_nk`.
    pub max_nk: usize,
    /// Criterion of the choice.
    pub criterion: OrderCriterion,
}

/// One row of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ArxCandidate {
    /// Its orders.
    pub orders: ArxOrders,
    /// The fit.
    pub fit: ArxFit,
    /// Value of the criterion; smaller is better.
    pub score: f64,
    /// True if it is stable; the others come last.
    pub stable: bool,
}

/// Fits every combination of orders on the same equations and returns those that can be fitted, best first:
/// stable before unstable, then by the criterion, then fewer coefficients. Unstable candidates have an
/// infinite score under `SimulatedError`.
///
/// # Errors
/// The error of the smallest candidate where none can be fitted; see [`super::fit`].
pub fn select_orders(
    records: &[ArxRecord<'_>],
    search: &ArxSearch,
) -> Result<Vec<ArxCandidate>, DynamicsError> {
    let largest = ArxOrders { na: search.max_na, nb: search.max_nb, nk: search.max_nk };
    let skip = largest.past();
    let mut candidates = Vec::new();
    let mut refused = None;
    for na in 0..=search.max_na {
        for nb in 1..=search.max_nb {
            for nk in 0..=search.max_nk {
                let orders = ArxOrders { na, nb, nk };
                match fit_after(records, orders, skip) {
                    Ok(fit) => candidates.push(judge(records, orders, fit, search.criterion)?),
                    Err(error) => refused = refused.or(Some(error)),
                }
            }
        }
    }
    if candidates.is_empty() {
        return Err(refused.unwrap_or(DynamicsError::NoInputCoefficients));
    }
    candidates.sort_by(|x, y| {
        let size = |c: &ArxCandidate| c.orders.na + c.orders.nb;
        y.stable.cmp(&x.stable).then(x.score.total_cmp(&y.score)).then(size(x).cmp(&size(y)))
    });
    Ok(candidates)
}

fn judge(
    records: &[ArxRecord<'_>],
    orders: ArxOrders,
    fit: ArxFit,
    criterion: OrderCriterion,
) -> Result<ArxCandidate, DynamicsError> {
    let stable = fit.model.is_stable();
    let m = fit.equations as f64;
    let unknowns = (orders.na + orders.nb + records.len()) as f64;
    let log_likelihood = 2.0 * m * fit.prediction_rmse.ln();
    let score = match criterion {
        OrderCriterion::Aic => log_likelihood + 2.0 * unknowns,
        OrderCriterion::Bic => log_likelihood + unknowns * m.ln(),
        OrderCriterion::SimulatedError if stable => simulated_rmse(records, &fit)?,
        OrderCriterion::SimulatedError => f64::INFINITY,
    };
    Ok(ArxCandidate { orders, fit, score, stable })
}

/// Over the valid samples of all records, each record's mean error removed.
fn simulated_rmse(records: &[ArxRecord<'_>], fit: &ArxFit) -> Result<f64, DynamicsError> {
    let (mut squares, mut count) = (0.0, 0.0);
    for record in records {
        let mut simulated = vec![0.0; record.input.len()];
        fit.model.simulate(record.input, Start::AsIdentified, &mut simulated)?;
        let valid = |k: usize| record.valid.is_none_or(|valid| valid[k]);
        let errors: Vec<f64> = record.output.iter().zip(&simulated).map(|(y, x)| y - x).collect();
        let used: Vec<f64> =
            errors.into_iter().enumerate().filter(|(k, _)| valid(*k)).map(|(_, e)| e).collect();
        let mean = used.iter().sum::<f64>() / used.len().max(1) as f64;
        squares += used.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        count += used.len() as f64;
    }
    Ok((squares / count).sqrt())
}
