//! Adaptive feedforward weights beside the inverse, designed from the model, with their largest stable step.

use std::f64::consts::{PI, TAU};

use hysteron_rt::{FilteredLms, LmsFilter, LmsMemory, LmsSettings};
use nalgebra::{DMatrix, DVector};

use super::strategy::SLOW;
use super::{ControlError, RequiredMargins};
use hysteron_numeric::Complex64;

/// Samples of the impulse response computed, and relative size of the tail at which it is truncated.
const TRANSFORM: usize = 4096;
const TAIL: f64 = 1e-3;
/// Weights per period of the highest frequency.
const PER_PERIOD: f64 = 8.0;
/// Lines of the flat spectrum used to whiten the weights, and the noise power added to it (1 % rms). Less
/// noise gives faster learning, but weights so large that they respond to the out-of-band content of a
/// reference.
const LINES: usize = 400;
const NOISE: f64 = 1e-4;
/// Frequencies, besides 0, at which the limit of the step is evaluated.
const LOOKS: usize = 30;
/// Largest step, whatever the limit.
const LARGEST_STEP: f64 = 0.5;
/// Share of its mean power at which a filtered reference counts as silence.
const SILENCE: f64 = 1e-2;
/// Largest number of samples used to compute the optimal weights.
const MOST_SAMPLES: usize = 20_000;

/// Specification of adaptive feedforward weights; see [`hysteron_rt::FilteredLms`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adaptive {
    /// Highest frequency of the reference \[Hz\].
    pub highest_hz: f64,
    /// Number of weights, an eighth of a period of the highest frequency apart.
    pub weights: usize,
    /// Leakage: share of the weights lost per second.
    pub leak_per_s: f64,
}

impl Adaptive {
    /// 12 weights, which span one and a half periods of the highest frequency.
    pub fn up_to(highest_hz: f64) -> Self {
        Self { highest_hz, weights: 12, leak_per_s: 0.0 }
    }
}

/// Adaptive filter for one model and rate.
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptiveFilter {
    /// Specification of the weights.
    pub adaptive: Adaptive,
    /// Samples from one weight to the next.
    pub stride: usize,
    /// Secondary path: impulse response of the model's displacement to a correction.
    pub secondary: Vec<f64>,
    /// Inverse covariance of a reference of flat spectrum filtered by it, row by row.
    pub whitening: Vec<f64>,
    /// Step size: share of the error removed per step.
    pub rate: f64,
    /// Step size above which a constant or a single sine up to the highest frequency makes the weights
    /// oscillate, the model assumed exact.
    pub limit: f64,
    /// Frequency of this limit \[Hz\]; 0: a constant.
    pub limit_at_hz: f64,
    /// The rate \[Hz\].
    pub sample_rate_hz: f64,
}

impl AdaptiveFilter {
    /// From `path`, the response of the displacement to a correction at rising frequencies \[Hz\] up to half
    /// the sample rate, and `correction`, the same at any frequency.
    ///
    /// The step is the share of its limit that keeps the required gain margin and, for a loop of an integral
    /// and a delay, the phase margin.
    ///
    /// # Errors
    /// [`ControlError::Number`], [`ControlError::NoGain`] where no step is stable.
    pub fn new(
        path: &[(f64, Complex64)],
        correction: &dyn Fn(f64) -> Complex64,
        sample_rate_hz: f64,
        adaptive: Adaptive,
        wanted: &RequiredMargins,
    ) -> Result<Self, ControlError> {
        let Adaptive { highest_hz, weights, leak_per_s } = adaptive;
        for (name, value, sound) in [
            (
                "highest frequency of the reference [Hz]",
                highest_hz,
                highest_hz > 0.0 && highest_hz <= 0.5 * sample_rate_hz,
            ),
            ("number of weights", weights as f64, (1..=TRANSFORM).contains(&weights)),
            (
                "share of the weights that a second forgets",
                leak_per_s,
                (0.0..sample_rate_hz).contains(&leak_per_s),
            ),
        ] {
            if !sound {
                return Err(ControlError::Number { name, value });
            }
        }
        let stride = ((sample_rate_hz / (PER_PERIOD * highest_hz)) as usize).max(1);
        let mut found = Self {
            adaptive,
            stride,
            secondary: answer(correction, sample_rate_hz),
            whitening: Vec::new(),
            rate: 0.0,
            limit: 0.0,
            limit_at_hz: 0.0,
            sample_rate_hz,
        };
        found.whitening = found.whitened().ok_or(ControlError::NoGain)?;
        (found.limit, found.limit_at_hz) = found.limit_on(path);
        found.rate = (found.limit * (1.0 / wanted.gain).min(1.0 - wanted.phase_deg / 90.0)).min(LARGEST_STEP);
        if found.rate > 0.0 { Ok(found) } else { Err(ControlError::NoGain) }
    }

    /// The model of the secondary path at a frequency \[Hz\].
    pub fn response(&self, frequency_hz: f64) -> Complex64 {
        let theta = TAU * frequency_hz / self.sample_rate_hz;
        self.secondary
            .iter()
            .enumerate()
            .map(|(k, s)| *s * Complex64::from_polar(1.0, -theta * k as f64))
            .sum()
    }

    /// The least [`step_limit`] up to the highest frequency for the correction path `path`, and its frequency
    /// \[Hz\].
    pub fn limit_on(&self, path: &[(f64, Complex64)]) -> (f64, f64) {
        let low = SLOW * self.sample_rate_hz;
        let ratio = (self.adaptive.highest_hz / low).max(1.0);
        let looks = (0..=LOOKS).map(|k| low * ratio.powf(k as f64 / LOOKS as f64));
        std::iter::once(0.0)
            .chain(looks)
            .map(|f| (step_limit(path, self.response(f), f, self.sample_rate_hz), f))
            .fold((f64::INFINITY, 0.0), |least, next| if next.0 < least.0 { next } else { least })
    }

    /// R⁻¹ for a reference of flat spectrum up to the highest frequency, scaled so that x'ᵀ R⁻¹ x' has the
    /// mean of |x|² of as many samples.
    fn whitened(&self) -> Option<Vec<f64>> {
        let count = self.adaptive.weights;
        let line = |k: usize| self.adaptive.highest_hz * (k as f64 + 0.5) / LINES as f64;
        let powers: Vec<(f64, f64)> = (0..LINES)
            .map(line)
            .map(|f| (TAU * f / self.sample_rate_hz, self.response(f).norm_sqr()))
            .collect();
        let lag = |samples: usize| -> f64 {
            powers.iter().map(|(theta, p)| p * (theta * samples as f64).cos()).sum::<f64>() / LINES as f64
        };
        let lags: Vec<f64> = (0..count).map(|l| lag(l * self.stride)).collect();
        let covariance = DMatrix::from_fn(count, count, |i, j| lags[i.abs_diff(j)]);
        let noise = DMatrix::identity(count, count) * (NOISE * lags[0]);
        let inverse = (&covariance + noise).cholesky()?.inverse();
        let scale = count as f64 / inverse.component_mul(&covariance).sum();
        scale.is_finite().then(|| (inverse * scale).iter().copied().collect())
    }

    /// Residual rms of `error` from sample `from` on, mean removed, with the best constant weights on
    /// `known`: the Wiener optimum of this filter for this reference, with the model's response to
    /// corrections.
    pub fn optimum(&self, known: &[f64], error: &[f64], from: usize) -> f64 {
        let filtered: Vec<f64> = (0..known.len())
            .map(|k| {
                let past = known[..=k].iter().rev();
                self.secondary.iter().zip(past).map(|(s, x)| s * x).sum()
            })
            .collect();
        let end = known.len().min(error.len());
        let rows: Vec<usize> =
            (from..end).step_by((end.saturating_sub(from) / MOST_SAMPLES).max(1)).collect();
        let columns = self.adaptive.weights + 1;
        if rows.len() < columns {
            return f64::NAN;
        }
        let seen = DMatrix::from_fn(rows.len(), columns, |row, i| match i.checked_sub(1) {
            None => 1.0,
            Some(weight) => rows[row].checked_sub(weight * self.stride).map_or(0.0, |k| filtered[k]),
        });
        let error = DVector::from_fn(rows.len(), |row, _| error[rows[row]]);
        // An orthogonal projection, so the rank of 2 that a sine gives the columns does no harm.
        let basis = seen.qr().q();
        let left = &error - &basis * (basis.transpose() * &error);
        (left.norm_squared() / rows.len() as f64).sqrt()
    }
}

/// The largest stable step of filtered-x LMS for a single sine \[Hz\] (0: for a constant), with the secondary
/// path `path` (at rising frequencies \[Hz\] from near 0 to half the sample rate) and the model's response
/// `modelled` at that frequency.
///
/// With the step divided by the filtered reference's power and weights over whole half periods, the map from
/// error to correction is linear and time-invariant (J. R. Glover, *IEEE Trans. Acoust. Speech Signal
/// Process.* 25 (1977) 484–491, doi:10.1109/TASSP.1977.1162997): with ŝ e^{jφ} the model's response, q the
/// delay of one sample,
///
/// H = rate/ŝ · (cos(ω − φ) q − cos φ q²)/(1 − 2 cos ω q + q²),
///
/// a resonator at ω around which the path closes the loop. For a small step it is stable where path and model
/// differ by less than 90° at ω (S. D. Snyder, C. H. Hansen, *IEEE Trans. Signal Process.* 42 (1994) 950–953,
/// doi:10.1109/78.285659), else at no step: 0. As the step grows, instability sets in where path · H = −1.
pub fn step_limit(
    path: &[(f64, Complex64)],
    modelled: Complex64,
    frequency_hz: f64,
    sample_rate_hz: f64,
) -> f64 {
    let after =
        path.partition_point(|(f, _)| *f < frequency_hz).clamp(1, path.len().saturating_sub(1).max(1));
    let (Some((low, a)), Some((high, b))) = (path.get(after - 1), path.get(after)) else { return 0.0 };
    let share = ((frequency_hz - low) / (high - low)).clamp(0.0, 1.0);
    let there = a + share * (b - a);
    if (there * modelled.conj()).re <= 0.0 {
        return 0.0;
    }
    let (omega, phi) = (TAU * frequency_hz / sample_rate_hz, modelled.arg());
    // Reciprocal of the loop at a step of 1: finite at the resonance, where it is 0.
    let reciprocal = |(f, path): &(f64, Complex64)| {
        let late = Complex64::from_polar(1.0, -TAU * f / sample_rate_hz);
        let resonator = if frequency_hz > 0.0 {
            (1.0 - 2.0 * omega.cos() * late + late * late)
                / ((omega - phi).cos() * late - phi.cos() * late * late)
        } else {
            (1.0 - late) / (phi.cos() * late)
        };
        modelled.norm() * resonator / path
    };
    let mut least = f64::INFINITY;
    let points: Vec<(f64, Complex64)> = path.iter().map(|p| (p.0, reciprocal(p))).collect();
    for pair in points.windows(2) {
        let [(f, a), (g, b)] = [pair[0], pair[1]];
        // At the resonance itself it is 0 whatever the step.
        if (f..=g).contains(&frequency_hz) || (a.im < 0.0) == (b.im < 0.0) {
            continue;
        }
        let crossing = a.re + a.im / (a.im - b.im) * (b.re - a.re);
        if crossing < 0.0 {
            least = least.min(-crossing);
        }
    }
    // At 0 Hz and at half the sample rate the loop is real.
    let ends = [points.first().filter(|_| frequency_hz > 0.0), points.last()];
    for (_, end) in ends.into_iter().flatten().filter(|(_, end)| end.re < 0.0) {
        least = least.min(-end.re);
    }
    least
}

/// Impulse response from the frequency response by the inverse discrete Fourier transform, truncated at a
/// negligible tail.
fn answer(response: &dyn Fn(f64) -> Complex64, sample_rate_hz: f64) -> Vec<f64> {
    let half: Vec<Complex64> = (0..=TRANSFORM / 2)
        .map(|k| response((k as f64).max(1e-9) / TRANSFORM as f64 * sample_rate_hz))
        .collect();
    let turns: Vec<Complex64> =
        (0..TRANSFORM).map(|k| Complex64::from_polar(1.0, 2.0 * PI * k as f64 / TRANSFORM as f64)).collect();
    let at = |j: usize| {
        let twice: f64 = (1..TRANSFORM / 2).map(|k| 2.0 * (half[k] * turns[k * j % TRANSFORM]).re).sum();
        (half[0].re + twice + (half[TRANSFORM / 2] * turns[TRANSFORM / 2 * j % TRANSFORM]).re)
            / TRANSFORM as f64
    };
    let mut samples: Vec<f64> = (0..TRANSFORM / 2).map(at).collect();
    let all: f64 = samples.iter().map(|s| s.abs()).sum();
    let mut left = 0.0;
    let tail = samples.iter().rev().take_while(|s| {
        left += s.abs();
        left <= TAIL * all
    });
    samples.truncate(samples.len() - tail.count());
    samples
}

/// Coefficients and memory of an adaptive filter.
#[derive(Clone, Debug)]
pub struct AdaptiveParts {
    weights: Vec<f64>,
    secondary: Vec<f64>,
    whitening: Vec<f64>,
    stride: usize,
    rings: [Vec<f64>; 2],
    turned: Vec<f64>,
    settings: LmsSettings<f64>,
}

impl AdaptiveParts {
    /// The parts, for a reference of this mean square.
    pub fn new(made: &AdaptiveFilter, mean_square: f64) -> Self {
        let count = made.adaptive.weights;
        let ring = vec![0.0; (count * made.stride).max(made.secondary.len()).max(1)];
        Self {
            weights: vec![0.0; count],
            secondary: made.secondary.clone(),
            whitening: made.whitening.clone(),
            stride: made.stride,
            rings: [ring.clone(), ring],
            turned: vec![0.0; count],
            settings: LmsSettings {
                rate: made.rate,
                leak: made.adaptive.leak_per_s / made.sample_rate_hz,
                floor: (SILENCE * mean_square * count as f64).max(f64::MIN_POSITIVE),
            },
        }
    }

    /// The filter, its past 0.
    ///
    /// # Errors
    /// [`ControlError::Runtime`] for a coefficient that is not finite.
    pub fn lms(&mut self) -> Result<FilteredLms<'_, f64>, ControlError> {
        let [references, filtered] = &mut self.rings;
        let filter = LmsFilter {
            weights: &mut self.weights,
            secondary: &self.secondary,
            whitening: &self.whitening,
            stride: self.stride,
        };
        let memory = LmsMemory { references, filtered, turned: &mut self.turned };
        Ok(FilteredLms::new(filter, memory, self.settings)?)
    }
}
