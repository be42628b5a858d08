//! Step 2 by polynomial models and refined instrumental variables, from the hysteresis output to the
//! displacement.

use super::IdentifyError;
use super::dynamic_step::HysteresisOutput;
use super::linear::{PolynomialFit, SrivcFit, select_polynomial, select_srivc};
use super::options::{DynamicsChoice, Options};
use super::parameter::{LinearPart, Parameter, ParameterRole};
use super::result::Correlation;
use super::uncertainty::correlation;
use hysteron_model::dynamics::arx::ArxRecord;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::record::InterSample;
use hysteron_numeric::display::short;
use nalgebra::DMatrix;

/// Poles tried.
const MOST_POLES: usize = 4;
/// Delays tried \[samples\].
const LONGEST_DELAY: usize = 5;
/// Coefficients of numerator and denominator of a Box–Jenkins noise model.
const NOISE: (usize, usize) = (2, 2);

/// Result of the linear step.
pub(super) struct LinearStep {
    pub(super) dynamics: Dynamics,
    /// Delay in addition to that of the hysteresis block \[s\].
    pub(super) delay_s: f64,
    pub(super) parameters: Vec<Parameter>,
    pub(super) correlation: Option<Correlation>,
    /// In a sentence.
    pub(super) verdict: String,
}

impl LinearStep {
    /// Fits the block that `options` ask for to all records, orders and delay by BIC.
    pub(super) fn fit(
        outputs: &[HysteresisOutput<'_>],
        delay_s: f64,
        options: &Options,
    ) -> Result<Self, IdentifyError> {
        let wanted = options.dynamics.in_words();
        let refuse = |because: String| IdentifyError::NoDynamicInformation { wanted, because };
        let rate_hz = outputs.first().map_or(1.0, HysteresisOutput::rate_hz);
        if outputs.iter().any(|o| (o.rate_hz() / rate_hz - 1.0).abs() > 1e-9) {
            return Err(refuse("the dynamic records have different sample rates".into()));
        }
        let signals: Vec<_> = outputs.iter().map(|output| output.with_what_ran_before(delay_s)).collect();
        let records: Vec<ArxRecord<'_>> = signals
            .iter()
            .map(|(input, output, valid)| ArxRecord { input, output, valid: Some(valid) })
            .collect();
        if options.dynamics == DynamicsChoice::Srivc {
            let between = match options.inter_sample() {
                InterSample::Hold => InterSample::Hold,
                InterSample::Linear | InterSample::BandLimited => InterSample::Linear,
            };
            let list = select_srivc(&records, MOST_POLES, LONGEST_DELAY, rate_hz, between)?;
            let tried = list.len();
            let best = list.into_iter().next().ok_or_else(|| refuse("no model fits".into()))?;
            return Ok(Self::of_srivc(&best.fit, rate_hz, tried));
        }
        let noise = if options.dynamics == DynamicsChoice::BoxJenkins { NOISE } else { (0, 0) };
        let list = select_polynomial(&records, MOST_POLES, LONGEST_DELAY, noise)?;
        let tried = list.len();
        let best = list.into_iter().next().ok_or_else(|| refuse("no model fits".into()))?;
        Ok(Self::of_polynomial(&best.fit, wanted, tried))
    }

    /// Default scheme of the block: continuous time for a continuous-time model.
    pub(super) fn scheme(&self) -> Scheme {
        match self.dynamics {
            Dynamics::Integer(_) => Scheme::BandLimited,
            _ => Scheme::Tustin,
        }
    }

    fn of_polynomial(fit: &PolynomialFit, wanted: &'static str, tried: usize) -> Self {
        let m = &fit.model;
        let values = [
            coefficients(LinearPart::Numerator, "b", m.nk, &m.b),
            coefficients(LinearPart::Denominator, "f", 1, &m.f),
            coefficients(LinearPart::Noise, "noise_c", 1, &m.c),
            coefficients(LinearPart::Noise, "noise_d", 1, &m.d),
        ]
        .concat();
        let noise = if m.c.is_empty() && m.d.is_empty() {
            String::new()
        } else {
            format!(
                " with a noise model C/D of {} and {} coefficients, prediction error {} rms",
                m.c.len(),
                m.d.len(),
                short(fit.rmse)
            )
        };
        let verdict = format!(
            "Dynamic block by {wanted}: B/F with {} and {} coefficients, {} sample(s) of delay, best of \
             {tried} orders by BIC{noise}; simulation error {} rms on the dynamic records{}.",
            m.b.len(),
            m.f.len(),
            m.nk,
            short(fit.simulated_rmse),
            unfinished(fit.converged)
        );
        let dynamics = Dynamics::Arx(m.deterministic());
        Self::new(dynamics, 0.0, values, (wanted, fit.covariance.as_ref()), verdict)
    }

    fn of_srivc(fit: &SrivcFit, rate_hz: f64, tried: usize) -> Self {
        let own = fit.denominator.len() - 1;
        let values = [
            coefficients(LinearPart::Numerator, "b", 0, &fit.numerator),
            coefficients(LinearPart::Denominator, "a", 0, &fit.denominator[..own]),
        ]
        .concat();
        let verdict = format!(
            "Dynamic block by SRIVC: {} pole(s) and {} zero(s) in continuous time, {} sample(s) of delay, \
             best of {tried} orders by BIC; simulation error {} rms on the dynamic records{}.",
            fit.orders.poles,
            fit.orders.zeros,
            fit.orders.delay,
            short(fit.rmse),
            unfinished(fit.converged)
        );
        let dynamics = Dynamics::Integer(fit.transfer_function());
        let delay_s = fit.orders.delay as f64 / rate_hz;
        Self::new(dynamics, delay_s, values, ("SRIVC", fit.covariance.as_ref()), verdict)
    }

    fn new(
        dynamics: Dynamics,
        delay_s: f64,
        mut parameters: Vec<Parameter>,
        (step, covariance): (&str, Option<&DMatrix<f64>>),
        verdict: String,
    ) -> Self {
        let names: Vec<String> = parameters.iter().map(|p| p.name.clone()).collect();
        for (i, parameter) in parameters.iter_mut().enumerate() {
            parameter.std_error = covariance.map(|c| c[(i, i)].max(0.0).sqrt());
        }
        let correlation = covariance.map(|c| correlation(&format!("dynamic block, {step}"), names, c));
        Self { dynamics, delay_s, parameters, correlation, verdict }
    }
}

/// The coefficients of a polynomial, named from `first` on, without standard errors.
fn coefficients(part: LinearPart, name: &str, first: usize, values: &[f64]) -> Vec<Parameter> {
    let named = |(k, value): (usize, &f64)| {
        Parameter::new(ParameterRole::Linear(part), &format!("{name}{}", k + first), *value, None)
    };
    values.iter().enumerate().map(named).collect()
}

fn unfinished(converged: bool) -> &'static str {
    if converged { "" } else { "; the iterations did not converge" }
}
