//! Normalised least mean squares.

use super::{SampleError, all_finite, check, clamp, dot};
use crate::ParameterError;
use crate::real::Real;

/// Start and tuning of the gradient correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NlmsSettings<T, const N: usize> {
    /// θ before the first sample.
    pub start: [T; N],
    /// Scales σᵢ of the parameters, in their units: how far each may move in comparison with the others.
    pub deviations: [T; N],
    /// Step μ, above 0 and below 2.
    pub step: T,
    /// Regulariser ε ≥ 0, in squared units of the output: samples with Σ σᵢ²φᵢ² far below it have no effect.
    /// The variance of the noise is a good choice.
    pub regulariser: T,
    /// Least and greatest value of each parameter; infinite where there is none.
    pub bounds: Option<[(T, T); N]>,
}

/// Normalised least mean squares for y = φᵀθ + noise: θᵢ ← θᵢ + μ σᵢ²φᵢ e / (ε + Σ σⱼ²φⱼ²), e = y − φᵀθ.
///
/// For 0 < μ < 2 no noise-free sample raises the distance Σ (θᵢ − θᵢ*)²/σᵢ² to the true θ*: it falls by
/// e²·(2μ(ε + q) − μ²q)/(ε + q)², q = Σ σⱼ²φⱼ², at least. It falls to zero where φ keeps exciting all
/// directions. With noise the distance settles; for white noise and regressors the parameters add μ/(2 − μ)
/// of the noise variance to the error of the prediction. N numbers of state, about 4N multiplications a
/// sample. A bound is met by the nearest point in the same distance, which raises it for no θ* within the
/// bounds.
///
/// Sources: J. Nagumo, A. Noda, *IEEE Trans. Automatic Control* 12 (1967) 282–287,
/// doi:10.1109/TAC.1967.1098599; D. T. M. Slock, *IEEE Trans. Signal Processing* 41 (1993) 2811–2825,
/// doi:10.1109/78.236504.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nlms<T, const N: usize> {
    settings: NlmsSettings<T, N>,
    parameters: [T; N],
}

impl<T: Real, const N: usize> Nlms<T, N> {
    /// Starts from these settings.
    ///
    /// # Errors
    /// [`ParameterError`]: a number that is not finite or out of its range, bounds that the start does not
    /// keep.
    pub fn new(settings: NlmsSettings<T, N>) -> Result<Self, ParameterError<T>> {
        let NlmsSettings { start, deviations, step, regulariser, bounds } = &settings;
        let zero = T::of(0.0);
        check(start, deviations, bounds.as_ref())?;
        if !(*step > zero && *step < T::of(2.0)) {
            return Err(ParameterError::Number {
                name: "the step",
                value: *step,
                must: "above 0 and below 2",
            });
        }
        if !(*regulariser >= zero && regulariser.is_finite()) {
            let must = "finite and not negative";
            return Err(ParameterError::Number { name: "the regulariser", value: *regulariser, must });
        }
        Ok(Self { settings, parameters: *start })
    }

    /// The settings it was made with.
    pub fn settings(&self) -> &NlmsSettings<T, N> {
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

    /// Updates by one sample: regressors φ and output y. Returns the a priori error e = y − φᵀθ.
    ///
    /// # Errors
    /// [`SampleError`]: the estimator is as it was.
    #[inline]
    pub fn step(&mut self, regressors: &[T; N], output: T) -> Result<T, SampleError> {
        if !(output.is_finite() && all_finite(regressors)) {
            return Err(SampleError::NotFinite);
        }
        let NlmsSettings { deviations, step, regulariser, bounds, .. } = &self.settings;
        let error = output - self.predict(regressors);
        let mut power = *regulariser;
        for (&deviation, &regressor) in deviations.iter().zip(regressors) {
            let scaled = deviation * regressor;
            power = power + scaled * scaled;
        }
        let mut parameters = self.parameters;
        // No update for φ = 0 without a regulariser.
        if power > T::of(0.0) {
            let rate = *step * error / power;
            for ((parameter, &deviation), &regressor) in parameters.iter_mut().zip(deviations).zip(regressors)
            {
                *parameter = *parameter + deviation * (deviation * regressor * rate);
            }
        }
        for (parameter, &bound) in parameters.iter_mut().zip(bounds.iter().flatten()) {
            *parameter = clamp(*parameter, bound);
        }
        if !(error.is_finite() && power.is_finite() && all_finite(&parameters)) {
            return Err(SampleError::Overflow);
        }
        self.parameters = parameters;
        Ok(error)
    }

    /// Back to the start values.
    pub fn reset(&mut self) {
        self.parameters = self.settings.start;
    }
}
