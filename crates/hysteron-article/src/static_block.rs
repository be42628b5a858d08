//! Table 2 and Figure 7: the improved Bouc–Wen block identified from the 1 Hz loop.

use super::printed::Table2;
use super::{ArticleError, Plan};
use hysteron_identify::{Choice, Demands, DynamicsChoice, Identification, Method, Options};
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_optimize::{Algorithm, DeAbcOptions};
use serde::{Deserialize, Serialize};

/// Options of the article's identification: quadratic (improved) Bouc–Wen with n = 1 and no offset (Eq. 1 has
/// none), no delay, DE-ABC.
pub(super) fn article_options(plan: &Plan) -> Options {
    Options {
        method: Method::TwoStep,
        dynamics: DynamicsChoice::Fractional,
        algorithm: Some(Algorithm::DeAbc(DeAbcOptions::default())),
        generations: plan.generations,
        seed: plan.seed,
        degree: Choice::Given(2),
        n: Choice::Given(1.0),
        delay_s: Choice::Given(0.0),
        demands: Demands { fixed: vec![("offset".into(), 0.0)], bounded: Vec::new() },
        // A bad fit is a valid result here.
        least_fit_percent: f64::NEG_INFINITY,
        ..Options::default()
    }
}

/// Parameters of Eq. 1 in the article's symbols.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticParameters {
    /// x, factor of u² \[µm/V²\].
    pub x: f64,
    /// y, factor of u \[µm/V\].
    pub y: f64,
    /// α \[µm/V\].
    pub alpha: f64,
    /// β \[1/V\].
    pub beta: f64,
    /// γ \[1/V\].
    pub gamma: f64,
}

impl StaticParameters {
    pub(super) fn of(hysteresis: &Hysteresis) -> Self {
        let coefficient = |i: usize| hysteresis.polynomial().get(i).copied().unwrap_or(0.0);
        let number = |name: &str| hysteresis.number(name).unwrap_or(0.0);
        let [alpha, beta, gamma] = ["alpha", "beta", "gamma"].map(number);
        Self { x: coefficient(1), y: coefficient(0), alpha, beta, gamma }
    }

    /// The article's Table 2.
    pub fn printed(table: &Table2) -> Self {
        Self { x: table.x, y: table.y, alpha: table.alpha, beta: table.beta, gamma: table.gamma }
    }

    /// The block itself, n = 1.
    ///
    /// # Errors
    /// [`ArticleError::Hysteresis`] for parameters that are not finite.
    pub fn block(&self) -> Result<BoucWen, ArticleError> {
        Ok(BoucWen::new(vec![self.y, self.x], self.alpha, self.beta, self.gamma, 1.0)?)
    }
}

/// Table 2 and Figure 7.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StaticStudy {
    /// Parameters found by DE-ABC.
    pub parameters: StaticParameters,
    /// RMSE on the 1 Hz loop \[µm\].
    pub rmse_um: f64,
    /// RMSE in % of stroke.
    pub rmse_percent: f64,
    /// Relative error ‖y − ŷ‖₁ / ‖y − min y‖₁.
    pub re: f64,
    /// Stroke of the record \[µm\].
    pub stroke_um: f64,
    /// Drive \[V\].
    pub u_v: Vec<f64>,
    /// Measured displacement \[µm\].
    pub measured_um: Vec<f64>,
    /// The block's displacement \[µm\].
    pub model_um: Vec<f64>,
    /// Sample rate of the three \[Hz\].
    pub sample_rate_hz: f64,
}

impl StaticStudy {
    /// From the identification of a static model on the 1 Hz loop alone.
    pub(super) fn of(found: &Identification) -> Option<Self> {
        let fit = found.records.first()?;
        Some(Self {
            parameters: StaticParameters::of(&found.model.hysteresis),
            rmse_um: rmse(&fit.data.y, &fit.simulated),
            rmse_percent: 100.0 * rmse(&fit.data.y, &fit.simulated) / fit.scores.stroke,
            re: relative_error(&fit.data.y, &fit.simulated),
            stroke_um: fit.scores.stroke,
            u_v: fit.data.u.clone(),
            measured_um: fit.data.y.clone(),
            model_um: fit.simulated.clone(),
            sample_rate_hz: fit.data.sample_rate_hz()?,
        })
    }
}

/// √(mean (y − ŷ)²), Eq. 7.
pub(super) fn rmse(y: &[f64], simulated: &[f64]) -> f64 {
    let residuals: Vec<f64> = y.iter().zip(simulated).map(|(y, s)| y - s).collect();
    hysteron_optimize::root_mean_square(&residuals)
}

fn relative_error(y: &[f64], simulated: &[f64]) -> f64 {
    let lowest = y.iter().copied().fold(f64::INFINITY, f64::min);
    let distance: f64 = y.iter().map(|y| y - lowest).sum();
    y.iter().zip(simulated).map(|(y, s)| (y - s).abs()).sum::<f64>() / distance
}
