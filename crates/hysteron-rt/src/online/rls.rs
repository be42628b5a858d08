//! Recursive least squares with forgetting, in factors, with a bounded covariance.

use super::covariance::Covariance;
use super::{SampleError, all_finite, check, clamp, dot};
use crate::ParameterError;
use crate::real::Real;

/// Start and tuning of recursive least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RlsSettings<T, const N: usize> {
    /// θ before the first sample.
    pub start: [T; N],
    /// Standard deviations σᵢ of the start values, in units of the parameters: how far each may be off. They
    /// also bound how uncertain a parameter can become again.
    pub deviations: [T; N],
    /// Standard deviation s of the noise of one sample, in units of the output.
    pub noise: T,
    /// Forgetting factor λ, above 0 and up to 1. A sample k samples ago has the weight λᵏ: a memory of 1/(1 −
    /// λ) samples.
    pub forgetting: T,
    /// Treatment of parameters that the samples do not excite.
    pub unexcited: Unexcited,
    /// Least and greatest value of each parameter; infinite where there is none.
    pub bounds: Option<[(T, T); N]>,
}

/// Treatment of parameters that have not been excited for longer than the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Unexcited {
    /// They stay as they are.
    #[default]
    Hold,
    /// They return to their start values.
    Return,
}

/// A priori residual of a sample: before the update by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual<T> {
    /// y − φᵀθ, in units of the output.
    pub value: T,
    /// Standard deviation it was expected to have, √(s² + φᵀPφ/λ), in units of the output.
    pub deviation: T,
}

impl<T: Real> Residual<T> {
    /// value / deviation: about standard normal where the model fits.
    pub fn normalised(&self) -> T {
        self.value / self.deviation
    }
}

/// Recursive least squares with exponential forgetting for y = φᵀθ + noise.
///
/// With the information matrix H = P⁻¹, H₀ = diag(1/σᵢ²), sample k does
///
/// ```text
/// θ ← θ + K (y − φᵀθ),   K = Pφ/(λs² + φᵀPφ),   H ← λ H + φφᵀ/s²
/// ```
///
/// and then restores, for the one parameter i = k mod N, N(1 − λ) of its initial information: H ← H + N(1 −
/// λ)/σᵢ² eᵢeᵢᵀ. By this P ≤ λ¹⁻ᴺ diag(σ²) at all times in the sense of matrices: no unexcited direction
/// winds up, and none stops the forgetting of the others, as a bound on the trace would. A parameter in such
/// a direction holds its value or returns to its start value ([`Unexcited`]); under `Return` θ minimises,
/// exactly, Σ λᵏ⁻ʲ (y_j − φ_jᵀθ)²/s² plus the restored terms N(1 − λ) λᵏ⁻ʲ (θᵢ − θᵢ(0))²/σᵢ² plus the initial
/// one, λᵏ (…). With λ = 1 both are least squares with the prior N(θ(0), diag σ²), without approximation.
///
/// P is kept in Bierman's factors, so that it stays positive definite in `f32` for any number of samples. N²
/// numbers of state, about 3N² multiplications a sample.
///
/// A bound that a sample would pass is met by the least move in the metric of P (the other parameters move
/// along by their correlation); of several at once, one after the other.
///
/// Sources: G. J. Bierman, *Factorization Methods for Discrete Sequential Estimation*, Academic Press 1977;
/// M. E. Salgado, G. C. Goodwin, R. H. Middleton, *Int. J. Control* 47 (1988) 477–491,
/// doi:10.1080/00207178808906026 (forgetting with restored information).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rls<T, const N: usize> {
    settings: RlsSettings<T, N>,
    parameters: [T; N],
    covariance: Covariance<T, N>,
    /// Parameter whose information is restored next.
    next: usize,
}

impl<T: Real, const N: usize> Rls<T, N> {
    /// Starts from these settings.
    ///
    /// # Errors
    /// [`ParameterError`]: a number that is not finite or out of its range, bounds that the start does not
    /// keep.
    pub fn new(settings: RlsSettings<T, N>) -> Result<Self, ParameterError<T>> {
        let RlsSettings { start, deviations, noise, forgetting, bounds, .. } = &settings;
        let (zero, one) = (T::of(0.0), T::of(1.0));
        check(start, deviations, bounds.as_ref())?;
        if !(*forgetting > zero && *forgetting <= one) {
            let must = "above 0 and at most 1";
            return Err(ParameterError::Number { name: "the forgetting factor", value: *forgetting, must });
        }
        let variance = *noise * *noise * *forgetting;
        if !(*noise > zero && variance > zero && variance.is_finite()) {
            let must = "positive and finite, its square too";
            return Err(ParameterError::Number { name: "the noise", value: *noise, must });
        }
        let covariance = Covariance::independent(deviations);
        Ok(Self { settings, parameters: *start, covariance, next: 0 })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &RlsSettings<T, N> {
        &self.settings
    }

    /// θ.
    pub fn parameters(&self) -> &[T; N] {
        &self.parameters
    }

    /// φᵀθ.
    #[inline]
    pub fn predict(&self, regressors: &[T; N]) -> T {
        dot(&self.parameters, regressors)
    }

    /// Row `index` of P, the covariance of θ as far as the noise is white and the parameters constant over
    /// the memory; `None` beyond the last parameter.
    pub fn covariance(&self, index: usize) -> Option<[T; N]> {
        (index < N).then(|| self.covariance.column(index))
    }

    /// Standard deviation of φᵀθ by P, in units of the output.
    pub fn deviation(&self, regressors: &[T; N]) -> T {
        self.covariance.variance_of(regressors).sqrt()
    }

    /// Updates by one sample: regressors φ and output y. Returns the a priori residual.
    ///
    /// # Errors
    /// [`SampleError`]: the estimator is as it was.
    #[inline]
    pub fn step(&mut self, regressors: &[T; N], output: T) -> Result<Residual<T>, SampleError> {
        if !(output.is_finite() && all_finite(regressors)) {
            return Err(SampleError::NotFinite);
        }
        let RlsSettings { noise, forgetting, .. } = self.settings;
        let value = output - self.predict(regressors);
        let update = self.covariance.update(regressors, forgetting * noise * noise, forgetting);
        let mut parameters = moved(&self.parameters, &update.gain, value);
        let mut covariance = update.covariance;
        self.restore(&mut parameters, &mut covariance);
        self.keep_bounds(&mut parameters, &covariance);
        let residual = Residual { value, deviation: (update.variance / forgetting).sqrt() };
        let finite = residual.value.is_finite() && residual.deviation.is_finite();
        if !(finite && all_finite(&parameters) && covariance.is_finite()) {
            return Err(SampleError::Overflow);
        }
        (self.parameters, self.covariance) = (parameters, covariance);
        self.next = if self.next + 1 < N { self.next + 1 } else { 0 };
        Ok(residual)
    }

    /// Resets the covariance and keeps the parameters, to track a jump of the device at once.
    pub fn reopen(&mut self) {
        self.covariance = Covariance::independent(&self.settings.deviations);
    }

    /// Resets parameters and covariance to the settings.
    pub fn reset(&mut self) {
        self.reopen();
        (self.parameters, self.next) = (self.settings.start, 0);
    }

    /// Restores N(1 − λ) of the initial information of the next parameter.
    #[inline]
    fn restore(&self, parameters: &mut [T; N], covariance: &mut Covariance<T, N>) {
        let RlsSettings { start, deviations, forgetting, unexcited, .. } = &self.settings;
        let share = (T::of(1.0) - *forgetting) * T::of(N as f64);
        let of_next = deviations.get(self.next).zip(start.get(self.next)).zip(parameters.get(self.next));
        let Some(((&deviation, &start), &parameter)) = of_next.filter(|_| share > T::of(0.0)) else { return };
        let mut unit = [T::of(0.0); N];
        if let Some(entry) = unit.get_mut(self.next) {
            *entry = T::of(1.0);
        }
        let update = covariance.update(&unit, deviation * deviation / share, T::of(1.0));
        *covariance = update.covariance;
        if *unexcited == Unexcited::Return {
            *parameters = moved(parameters, &update.gain, start - parameter);
        }
    }

    #[inline]
    fn keep_bounds(&self, parameters: &mut [T; N], covariance: &Covariance<T, N>) {
        let Some(bounds) = &self.settings.bounds else { return };
        for (index, &bound) in bounds.iter().enumerate() {
            let Some(&value) = parameters.get(index) else { continue };
            let excess = clamp(value, bound) - value;
            let column = covariance.column(index);
            let Some(&variance) = column.get(index) else { continue };
            if excess != T::of(0.0) && variance > T::of(0.0) {
                *parameters = moved(parameters, &column.map(|c| c / variance), excess);
            }
        }
        // A later bound may have moved an earlier parameter, and rounding any.
        for (parameter, &bound) in parameters.iter_mut().zip(bounds) {
            *parameter = clamp(*parameter, bound);
        }
    }
}

/// θ + K·e.
#[inline(always)]
fn moved<T: Real, const N: usize>(parameters: &[T; N], gain: &[T; N], error: T) -> [T; N] {
    let mut out = *parameters;
    for (parameter, &gain) in out.iter_mut().zip(gain) {
        *parameter = *parameter + gain * error;
    }
    out
}
