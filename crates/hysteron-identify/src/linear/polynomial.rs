//! Output error and Box–Jenkins models.

use nalgebra::DMatrix;

use super::check;
use super::covariance::covariance;
use super::filter::filter;
use super::gauss_newton::minimise;
use super::prediction_error::PredictionError;
use super::steiglitz_mcbride::{noise_start, steiglitz_mcbride};
use hysteron_model::dynamics::arx::ArxRecord;
use hysteron_model::dynamics::{Arx, DynamicsError};

/// Orders of a polynomial model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PolynomialOrders {
    /// Coefficients of B, at least 1.
    pub nb: usize,
    /// Coefficients of F: poles.
    pub nf: usize,
    /// Delay: B starts at v_{k − nk}.
    pub nk: usize,
    /// Coefficients of the noise model's numerator C; with `nd` = 0 too an output-error model.
    pub nc: usize,
    /// Coefficients of the noise model's denominator D.
    pub nd: usize,
}

impl PolynomialOrders {
    /// An output-error model.
    pub const fn output_error(nb: usize, nf: usize, nk: usize) -> Self {
        Self { nb, nf, nk, nc: 0, nd: 0 }
    }

    /// Number of coefficients.
    pub fn count(self) -> usize {
        self.nb + self.nf + self.nc + self.nd
    }
}

/// y_k = B(z)/F(z) v_{k−nk} + C(z)/D(z) e_k with B = b₀ + b₁ z⁻¹ + …, the other polynomials 1 + c₁ z⁻¹ + …, e
/// white. Zero before the first sample: v is counted from rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialModel {
    /// b₀ ….
    pub b: Vec<f64>,
    /// f₁ ….
    pub f: Vec<f64>,
    /// Delay \[samples\].
    pub nk: usize,
    /// c₁ … of the noise model.
    pub c: Vec<f64>,
    /// d₁ … of the noise model.
    pub d: Vec<f64>,
}

impl PolynomialModel {
    /// The deterministic part as a difference equation, for simulation and saving.
    pub fn deterministic(&self) -> Arx {
        Arx { a: self.f.clone(), b: [vec![0.0; self.nk], self.b.clone()].concat() }
    }

    /// B/F v from zero.
    pub fn simulate(&self, input: &[f64]) -> Vec<f64> {
        let mut output = vec![0.0; input.len()];
        filter(&self.b, self.nk, &self.f, input, &mut output);
        output
    }
}

/// Result of [`fit_polynomial`].
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialFit {
    /// The model.
    pub model: PolynomialModel,
    /// Output offset of each record: measured = simulated + offset + noise.
    pub offsets: Vec<f64>,
    /// Covariance of b₀ …, f₁ …, c₁ …, d₁ …; `None` where the data do not determine them all. Without a noise
    /// model the residual may be coloured: (JᵀJ)⁻¹ (Σ ρ_k Σ_t J_t J_{t+k}ᵀ) (JᵀJ)⁻¹ with its autocovariance
    /// ρ; with one it is assumed white.
    pub covariance: Option<DMatrix<f64>>,
    /// Root mean square of the minimised error: the simulation error, or with a noise model the one-step
    /// prediction error.
    pub rmse: f64,
    /// Root mean square of the simulation error y − B/F v − offset.
    pub simulated_rmse: f64,
    /// Effective number of independent samples of the residuals: all where they are white.
    pub independent_samples: f64,
    /// Iterations.
    pub iterations: usize,
    /// The search converged.
    pub converged: bool,
}

impl PolynomialFit {
    /// Standard errors in the order of the covariance.
    pub fn std_error(&self) -> Option<Vec<f64>> {
        self.covariance.as_ref().map(|c| c.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect())
    }
}

/// Fits an output-error or Box–Jenkins model to records of one sample rate.
///
/// Starts from ARX refined by Steiglitz–McBride iterations (doi:10.1109/TAC.1965.1098181), with a noise model
/// of their residual by a long autoregression (Hannan, Rissanen, doi:10.1093/biomet/69.1.81); then
/// Levenberg–Marquardt on the prediction error e = D/C (y − B/F v − offset) with exact derivatives, which are
/// filtered signals (Ljung 1999, §10.3). F, C and D stay stable. Samples that are not valid have no error:
/// the noise there is its prediction.
///
/// # Errors
/// [`DynamicsError::NoInputCoefficients`] for nb = 0, [`DynamicsError::Length`],
/// [`DynamicsError::InputNotFinite`], [`DynamicsError::TooFewSamples`], [`DynamicsError::Dependent`] where
/// the data do not determine a start.
pub fn fit_polynomial(
    records: &[ArxRecord<'_>],
    orders: PolynomialOrders,
) -> Result<PolynomialFit, DynamicsError> {
    if orders.nb == 0 {
        return Err(DynamicsError::NoInputCoefficients);
    }
    check(records, orders.count())?;
    let start = steiglitz_mcbride(records, orders)?;
    polish(records, orders, start)
}

/// Prediction-error search from B and F, with the offsets of the records.
pub(super) fn polish(
    records: &[ArxRecord<'_>],
    orders: PolynomialOrders,
    start: (Vec<f64>, Vec<f64>),
) -> Result<PolynomialFit, DynamicsError> {
    let (b, f) = start;
    let plain = PolynomialOrders { nc: 0, nd: 0, ..orders };
    let mut x = [b, f].concat();
    x.extend(std::iter::repeat_n(0.0, records.len()));
    let columns = x.len();
    let dependent = || DynamicsError::Dependent { column: columns.saturating_sub(1), columns };
    let error = PredictionError::new(records, plain);
    let mut found = minimise(x, |x| error.at(x)).ok_or_else(dependent)?;
    let mut iterations = found.iterations;
    if orders.nc + orders.nd > 0 {
        let (c, d) = noise_start(records, &found.at.residual, orders);
        let coefficients = orders.nb + orders.nf;
        let mut x = found.x[..coefficients].to_vec();
        x.extend(c.into_iter().chain(d));
        x.extend(&found.x[coefficients..]);
        let error = PredictionError::new(records, orders);
        found = minimise(x, |x| error.at(x)).ok_or_else(dependent)?;
        iterations += found.iterations;
    }
    let error = PredictionError::new(records, orders);
    let (model, offsets) = (error.model(&found.x), error.offsets(&found.x).to_vec());
    let (rows, residual) = (error.rows(), &found.at.residual);
    let (covariance, independent_samples) =
        covariance(&error.segments(), &found.at, orders.count(), orders.nc + orders.nd > 0);
    let (mut squares, mut count) = (0.0, 0.0);
    for (record, offset) in records.iter().zip(&offsets) {
        let simulated = model.simulate(record.input);
        for k in (0..simulated.len()).filter(|&k| super::is_valid(record, k)) {
            squares += (record.output[k] - simulated[k] - offset).powi(2);
            count += 1.0;
        }
    }
    Ok(PolynomialFit {
        model,
        offsets,
        covariance,
        rmse: (residual.norm_squared() / rows as f64).sqrt(),
        simulated_rmse: f64::sqrt(squares / count),
        independent_samples,
        iterations,
        converged: found.converged,
    })
}
