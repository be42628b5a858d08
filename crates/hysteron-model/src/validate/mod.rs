//! Metrics and residual tests, defined once.
//!
//! [`score`] compares a measured record with a simulated output, sample by sample, and returns [`Scores`];
//! [`definitions`] is the table of definitions that reports print with the scores. Everything is meant for
//! *simulation* (infinite horizon), not one-step prediction.

mod loop_width;
mod memory;
mod residual_tests;
mod start;

pub use loop_width::loop_opening;
pub use residual_tests::{CorrelationTest, Correlogram, residual_input_correlation, residual_whiteness};
#[doc(hidden)]
pub use start::settling_samples;
pub use start::{
    choose_start, first_cycle, possible_starts, settled_period, settling_start, unfollowed_start,
};

use crate::hammerstein::SimulationError;
use crate::record::{InputOutput, TimeBase};
use hysteron_numeric::display::exact;
use serde::{Deserialize, Serialize};

/// Options of scoring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scoring {
    /// Seconds at the start of the record that are simulated but not scored \[s\], ≥ 0. `None`: only the part
    /// that a model without dynamics cannot follow ([`unfollowed_start`]), where a [`Model`](crate::Model) is
    /// scored.
    pub skip_s: Option<f64>,
    /// Treatment of the constant difference between the record and the simulation.
    pub offset: OffsetTreatment,
}

/// Treatment of the constant difference between a record and its simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OffsetTreatment {
    /// The sensor's zero is unknown: the mean residual over the scored samples is added to the simulation.
    #[default]
    Estimated,
    /// The simulation is compared unchanged; the offset in the model counts.
    Fixed,
}

/// Agreement of a simulation ŷ with a record y over the scored samples; definitions in `docs/metrics.md`.
///
/// e = y − ŷ − offset. A ratio is `None` where its denominator is zero (a constant record) and where the
/// record does not contain the data needed; no field is ever NaN or infinite. Output quantities are in the
/// record's output unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Scores {
    /// Samples that were scored.
    pub samples: usize,
    /// Samples that were not: skipped at the start, or masked as not valid.
    pub skipped_samples: usize,
    /// Constant added to the simulation before the comparison, on top of the model's own offset; 0 where
    /// fixed.
    pub offset: f64,
    /// True if `offset` was estimated from this record.
    pub offset_estimated: bool,
    /// max y − min y.
    pub stroke: f64,
    /// √(mean e²).
    pub rmse: f64,
    /// max |e|.
    pub max_abs_error: f64,
    /// 100 · RMSE / stroke \[%\].
    pub rmse_percent_of_stroke: Option<f64>,
    /// 100 · max |e| / stroke \[%\].
    pub max_percent_of_stroke: Option<f64>,
    /// 100 · (1 − ‖e‖₂ / ‖y − ȳ‖₂) \[%\]; negative where the mean of the record would be the better model.
    pub fit_percent: Option<f64>,
    /// RMSE / std(y), std with the divisor N.
    pub rmse_over_std: Option<f64>,
    /// ‖e‖₁ / ‖y − min y‖₁: the sensor's zero does not matter.
    pub relative_error: Option<f64>,
    /// 100 · (opening of the simulated − of the measured loop at mid-range input) / stroke \[%\].
    pub loop_width_error_percent: Option<f64>,
    /// Autocorrelation of e at lags 1 … 25 against 99 % bounds.
    pub whiteness: Option<CorrelationTest>,
    /// Correlation of e with the input at lags −25 … 25 against 99 % bounds.
    pub input_correlation: Option<CorrelationTest>,
}

/// Error of scoring a record.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScoreError {
    /// The simulation is not as long as the record.
    #[error("the record has {measured} samples but the simulation {simulated}")]
    LengthMismatch {
        /// Samples of the record.
        measured: usize,
        /// Samples of the simulation.
        simulated: usize,
    },
    /// Too few samples remain to be scored.
    #[error(
        "only {scored} of {total} samples are left to score ({masked} not valid, the rest skipped); need at \
         least {need}"
    )]
    TooFewSamples {
        /// Samples left.
        scored: usize,
        /// Samples of the record.
        total: usize,
        /// Samples masked as not valid.
        masked: usize,
        /// Samples needed.
        need: usize,
    },
    /// The time to skip is invalid.
    #[error(
        "the time to skip must be a finite number of seconds, not negative; found {skip_s}",
        skip_s = exact(*.skip_s)
    )]
    InvalidSkip {
        /// The value.
        skip_s: f64,
    },
    /// Seconds cannot be skipped without a time base.
    #[error(
        "cannot skip {skip_s} s: the record has neither a time column nor a sample rate",
        skip_s = exact(*.skip_s)
    )]
    SkipNeedsTime {
        /// Seconds requested.
        skip_s: f64,
    },
    /// A sample is NaN or infinite.
    #[error("{signal} is not finite at sample {index}: {value}", value = exact(*.value))]
    NotFinite {
        /// Which signal.
        signal: &'static str,
        /// Index of the sample, from 0.
        index: usize,
        /// The sample.
        value: f64,
    },
    /// The numbers are so large that their squares overflow.
    #[error("the score `{metric}` overflows: the samples reach {largest:e}; use a larger unit")]
    Overflow {
        /// Key of the metric.
        metric: &'static str,
        /// Largest magnitude among record and simulation.
        largest: f64,
    },
    /// The model cannot be simulated on the record from the start preferred.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

/// Fewest samples a score is given for.
const NEED_SAMPLES: usize = 2;

/// Scores the simulation `simulated` (same unit and length as the record's output) against `record`.
///
/// # Errors
/// [`ScoreError`] if lengths differ, a scored sample is not finite, or fewer than two samples remain to be
/// scored.
pub fn score(record: &InputOutput, simulated: &[f64], scoring: &Scoring) -> Result<Scores, ScoreError> {
    let Compared { scored, y, mut e } = compared(record, simulated, scoring.skip_s.unwrap_or(0.0))?;
    let (total, samples) = (record.y.len(), y.len());
    let offset_estimated = scoring.offset == OffsetTreatment::Estimated;
    let offset = if offset_estimated { mean(&e) } else { 0.0 };
    e.iter_mut().for_each(|e| *e -= offset);

    let (y_min, y_max) = range(&y);
    let stroke = y_max - y_min;
    let y_mean = mean(&y);
    let rmse = root_mean_square(e.iter().copied());
    let max_abs_error = e.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    let std = root_mean_square(y.iter().map(|y| y - y_mean));
    let distance = y.iter().map(|y| y - y_min).sum::<f64>();
    // A constant record has stroke exactly 0, but rounding of its mean can leave a tiny std.
    let ratio = |numerator: f64, denominator: f64| (stroke > 0.0).then(|| numerator / denominator);

    let mut residuals = vec![0.0; total];
    for ((slot, _), e) in residuals.iter_mut().zip(&scored).filter(|(_, s)| **s).zip(&e) {
        *slot = *e;
    }
    let opening = |output: &[f64]| loop_opening(&record.u, output, &scored);
    let width_error = opening(simulated).zip(opening(&record.y)).map(|(model, measured)| model - measured);

    Scores {
        samples,
        skipped_samples: total - samples,
        offset,
        offset_estimated,
        stroke,
        rmse,
        max_abs_error,
        rmse_percent_of_stroke: ratio(100.0 * rmse, stroke),
        max_percent_of_stroke: ratio(100.0 * max_abs_error, stroke),
        fit_percent: ratio(rmse, std).map(|r| 100.0 * (1.0 - r)),
        rmse_over_std: ratio(rmse, std),
        relative_error: ratio(e.iter().map(|e| e.abs()).sum(), distance),
        loop_width_error_percent: width_error.and_then(|w| ratio(100.0 * w, stroke)),
        whiteness: residual_whiteness(&residuals, &scored).map(|c| c.test()),
        input_correlation: residual_input_correlation(&residuals, &record.u, &scored).map(|c| c.test()),
    }
    .checked(&y, simulated)
}

/// Size of the error of a simulation: what [`Scores`] says of it first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimulationRmse {
    /// [`Scores::rmse`].
    pub rmse: f64,
    /// [`Scores::offset`].
    pub offset: f64,
    /// [`Scores::samples`].
    pub samples: usize,
}

/// The RMSE of [`score`] alone, which takes a small part of its time.
///
/// # Errors
/// Those of [`score`].
pub fn rmse(
    record: &InputOutput,
    simulated: &[f64],
    scoring: &Scoring,
) -> Result<SimulationRmse, ScoreError> {
    let Compared { y, e, .. } = compared(record, simulated, scoring.skip_s.unwrap_or(0.0))?;
    let offset = if scoring.offset == OffsetTreatment::Estimated { mean(&e) } else { 0.0 };
    let rmse = root_mean_square(e.iter().map(|e| e - offset));
    if !rmse.is_finite() {
        return Err(overflow("rmse", &y, simulated));
    }
    Ok(SimulationRmse { rmse, offset, samples: e.len() })
}

/// Mean square of the record's output about its mean, over the samples that [`score`] scores.
///
/// # Errors
/// Those of [`score`].
pub(crate) fn scored_variance(record: &InputOutput, scoring: &Scoring) -> Result<f64, ScoreError> {
    let scored = scored_samples(record, scoring.skip_s.unwrap_or(0.0))?;
    let y: Vec<f64> = record.y.iter().zip(&scored).filter(|(_, scored)| **scored).map(|(y, _)| *y).collect();
    let mean = mean(&y);
    Ok(root_mean_square(y.iter().map(|y| y - mean)).powi(2))
}

/// The mean residual y − ŷ over all valid samples: the offset that [`score`] estimates.
///
/// # Errors
/// Those of [`score`].
#[doc(hidden)]
pub fn mean_residual(record: &InputOutput, simulated: &[f64]) -> Result<f64, ScoreError> {
    Ok(mean(&compared(record, simulated, 0.0)?.e))
}

/// Scored samples of a record.
struct Compared {
    /// Mask of the scored samples.
    scored: Vec<bool>,
    /// Measured output at the scored samples.
    y: Vec<f64>,
    /// Measured minus simulated output at the scored samples.
    e: Vec<f64>,
}

fn compared(record: &InputOutput, simulated: &[f64], skip_s: f64) -> Result<Compared, ScoreError> {
    let total = record.y.len();
    for length in [simulated.len(), record.u.len()] {
        if length != total {
            return Err(ScoreError::LengthMismatch { measured: total, simulated: length });
        }
    }
    let scored = scored_samples(record, skip_s)?;
    let samples = scored.iter().filter(|&&s| s).count();
    if samples < NEED_SAMPLES {
        let masked = record.valid.as_ref().map_or(0, |v| v.iter().filter(|&&ok| !ok).count());
        return Err(ScoreError::TooFewSamples { scored: samples, total, masked, need: NEED_SAMPLES });
    }
    finite("the input", &record.u, &scored)?;
    finite("the measured output", &record.y, &scored)?;
    finite("the simulated output", simulated, &scored)?;

    let pick =
        |x: &[f64]| -> Vec<f64> { x.iter().zip(&scored).filter(|(_, s)| **s).map(|(x, _)| *x).collect() };
    let y = pick(&record.y);
    let e = y.iter().zip(pick(simulated)).map(|(y, s)| y - s).collect();
    Ok(Compared { scored, y, e })
}

impl Scores {
    /// Refuses results that overflowed.
    fn checked(self, y: &[f64], simulated: &[f64]) -> Result<Scores, ScoreError> {
        let metrics = [
            ("offset", Some(self.offset)),
            ("stroke", Some(self.stroke)),
            ("rmse", Some(self.rmse)),
            ("max_abs_error", Some(self.max_abs_error)),
            ("rmse_percent_of_stroke", self.rmse_percent_of_stroke),
            ("max_percent_of_stroke", self.max_percent_of_stroke),
            ("fit_percent", self.fit_percent),
            ("rmse_over_std", self.rmse_over_std),
            ("relative_error", self.relative_error),
            ("loop_width_error_percent", self.loop_width_error_percent),
        ];
        match metrics.iter().find(|(_, value)| value.is_some_and(|v| !v.is_finite())) {
            None => Ok(self),
            Some((metric, _)) => Err(overflow(metric, y, simulated)),
        }
    }
}

fn overflow(metric: &'static str, y: &[f64], simulated: &[f64]) -> ScoreError {
    let largest = y.iter().chain(simulated).filter(|x| x.is_finite()).fold(0.0_f64, |m, x| m.max(x.abs()));
    ScoreError::Overflow { metric, largest }
}

/// Meaning of one score, for reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Key in JSON and field of [`Scores`].
    pub key: &'static str,
    /// Name for readers.
    pub name: &'static str,
    /// Unit; `output` stands for the unit of the record's output.
    pub unit: &'static str,
    /// The quantity computed.
    pub meaning: &'static str,
}

/// The table of definitions, in the order of [`Scores`].
pub fn definitions() -> &'static [Definition] {
    const fn row(
        key: &'static str,
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
    ) -> Definition {
        Definition { key, name, unit, meaning }
    }
    const TABLE: &[Definition] = &[
        row("samples", "samples", "1", "samples that were scored"),
        row(
            "skipped_samples",
            "skipped samples",
            "1",
            "samples not scored: skipped at the start, or masked as not valid",
        ),
        row(
            "offset",
            "offset",
            "output",
            "constant added to the simulation before the comparison (mean residual; 0 where fixed), on top \
             of the model's own",
        ),
        row("stroke", "stroke", "output", "max y − min y over the scored samples"),
        row(
            "rmse",
            "RMSE",
            "output",
            "root mean square of e = y − simulation − offset; simulation from the start, not one-step \
             prediction",
        ),
        row("max_abs_error", "max error", "output", "largest |e|"),
        row("rmse_percent_of_stroke", "RMSE / stroke", "%", "100 · RMSE / stroke"),
        row("max_percent_of_stroke", "max error / stroke", "%", "100 · max |e| / stroke"),
        row(
            "fit_percent",
            "fit",
            "%",
            "100 · (1 − ‖e‖₂ / ‖y − mean y‖₂); 100 is perfect, 0 as good as a constant",
        ),
        row("rmse_over_std", "RMSE / std", "1", "RMSE / standard deviation of y"),
        row("relative_error", "RE", "1", "‖e‖₁ / ‖y − min y‖₁"),
        row(
            "loop_width_error_percent",
            "loop width error",
            "%",
            "opening of the simulated loop minus that of the measured loop at mid-range input, 100 · \
             difference / stroke",
        ),
        row(
            "whiteness",
            "residual whiteness",
            "1",
            "autocorrelation of e at lags 1 … 25; a white residual stays within ±2.576/√N at 99 % of the \
             lags",
        ),
        row(
            "input_correlation",
            "residual–input correlation",
            "1",
            "correlation of e with the input at lags −25 … 25; 99 % within ±2.576/√N for a white e \
             independent of the input",
        ),
    ];
    TABLE
}

/// Mask of the samples that count: after the skipped seconds, and valid.
///
/// # Errors
/// [`ScoreError`] if the time to skip is not a time, or the record has no time base.
pub fn scored_samples(record: &InputOutput, skip_s: f64) -> Result<Vec<bool>, ScoreError> {
    if !skip_s.is_finite() || skip_s < 0.0 {
        return Err(ScoreError::InvalidSkip { skip_s });
    }
    let total = record.y.len();
    let mut scored = vec![true; total];
    if skip_s > 0.0 {
        match &record.time {
            TimeBase::Uniform { sample_rate_hz, .. } => {
                // Half a ppm of a sample of slack: 0.1 s at 1 kHz skips 100 samples, whatever 0.1 rounds to.
                let first = skip_s * sample_rate_hz - 5e-7;
                for (k, s) in scored.iter_mut().enumerate() {
                    *s = k as f64 >= first;
                }
            }
            TimeBase::NonUniform { times_s } => {
                let start = times_s.first().copied().unwrap_or(0.0);
                for (s, t) in scored.iter_mut().zip(times_s) {
                    *s = t - start >= skip_s;
                }
            }
            TimeBase::Unknown => return Err(ScoreError::SkipNeedsTime { skip_s }),
        }
    }
    if let Some(valid) = &record.valid {
        for (s, valid) in scored.iter_mut().zip(valid) {
            *s &= *valid;
        }
    }
    Ok(scored)
}

fn finite(signal: &'static str, x: &[f64], scored: &[bool]) -> Result<(), ScoreError> {
    match x.iter().zip(scored).position(|(x, s)| *s && !x.is_finite()) {
        None => Ok(()),
        Some(index) => Err(ScoreError::NotFinite { signal, index, value: x[index] }),
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

fn range(x: &[f64]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

fn root_mean_square(x: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = x.len() as f64;
    (x.map(|x| x * x).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests;
