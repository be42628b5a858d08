//! Frequency response, noise and distortion from records of periodic multisines.
//!
//! Whole periods in steady state are transformed, so there is no leakage. The records' excited lines give the
//! response, the scatter between periods its noise, the scatter between realisations (records with other
//! random phases on the same lines) noise and stochastic nonlinear distortion together, and lines in the band
//! that are not excited the distortion of odd and of even order. This is the robust method of R. Pintelon and
//! J. Schoukens, *System Identification: A Frequency Domain Approach*, 2nd ed., Wiley 2012,
//! doi:10.1002/9781118287422, chapter 4.

use super::FrequencyResponse;
use crate::IdentifyError;
use hysteron_model::Advice;
use hysteron_model::record::{InputOutput, find_periods};
use hysteron_numeric::Complex64;
use hysteron_numeric::fft::RealFft;
use serde::{Deserialize, Serialize};

/// A line is excited where its input exceeds this share of the largest line of the input.
const EXCITED: f64 = 0.03;
/// Largest deviation of a period from a whole number of samples, over the whole record \[samples\].
const WHOLE: f64 = 0.1;

/// Options of the estimate from records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EmpiricalOptions {
    /// Length of a period \[s\]; `None`: found from the input.
    pub period_s: Option<f64>,
    /// Periods omitted at the start of each record; `None`: those before steady state.
    pub settling_periods: Option<usize>,
}

/// Response, noise and distortion at the excited lines, and distortion at the detection lines.
#[derive(Clone, Debug, PartialEq)]
pub struct EmpiricalResponse {
    /// Mean response over the realisations. Its `std_dev` is the total uncertainty: between realisations
    /// where there are at least two, else between periods where there are at least two.
    pub response: FrequencyResponse,
    /// Standard deviation of the mean response by noise alone; `None` with one period a record.
    pub noise_std: Option<Vec<f64>>,
    /// Standard deviation of the response of one realisation by stochastic nonlinear distortion: √(M (total²
    /// − noise²)), 0 where the total does not exceed the noise. `None` with one realisation.
    pub distortion_std: Option<Vec<f64>>,
    /// Output at odd detection lines: unexcited odd multiples of 1/period in the band.
    pub odd_detection: DetectionLines,
    /// Output at even detection lines.
    pub even_detection: DetectionLines,
    /// Records used.
    pub realisations: usize,
    /// Periods used of each record.
    pub periods: Vec<usize>,
    /// Length of a period \[samples\].
    pub period_samples: usize,
}

/// rms over the realisations of the output's amplitude at unexcited lines, in the output's unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DetectionLines {
    /// Frequencies \[Hz\].
    pub frequency_hz: Vec<f64>,
    /// Amplitude of the mean period: distortion and residual noise.
    pub amplitude: Vec<f64>,
    /// Its noise level, from the scatter between periods; 0 with one period.
    pub noise: Vec<f64>,
}

/// Mean spectra of one record and the scatter of the means between periods.
struct Realisation {
    input: Vec<Complex64>,
    output: Vec<Complex64>,
    /// Variances of the means and their covariance E[δY δU*]; `None` with one period.
    scatter: Option<Vec<(f64, f64, Complex64)>>,
    periods: usize,
}

/// Estimates the response from one or more records of the same multisine lines.
///
/// # Errors
/// [`IdentifyError::NoResponse`]: no record; no uniform sample rate; a period that is not a whole number of
/// samples, or not repeated where it has to be detected; masked samples; records of different rates, periods
/// or lines. [`IdentifyError::Record`]: no period found.
pub fn empirical_response(
    records: &[InputOutput],
    options: &EmpiricalOptions,
) -> Result<EmpiricalResponse, IdentifyError> {
    let Some(first) = records.first() else { return Err(bad("(none)", "there is no record")) };
    let sample_rate_hz = rate(first)?;
    let mut realisations = Vec::with_capacity(records.len());
    let mut period_samples = None;
    for record in records {
        if (rate(record)? / sample_rate_hz - 1.0).abs() > 1e-9 {
            return Err(bad(&record.name, "its sample rate is not that of the first record"));
        }
        let (samples, range) = steady_part(record, options)?;
        if *period_samples.get_or_insert(samples) != samples {
            return Err(bad(&record.name, "its period is not that of the first record"));
        }
        realisations.push(spectra(record, samples, range));
    }
    let period_samples = period_samples.unwrap_or(1);
    let lines = excited(&realisations[0].input);
    if lines.is_empty() {
        return Err(bad(&first.name, "its input has no line that is excited"));
    }
    for (record, realisation) in records.iter().zip(&realisations) {
        if excited(&realisation.input) != lines {
            return Err(bad(
                &record.name,
                "it does not excite the lines of the first record; realisations differ in their phases alone",
            ));
        }
    }
    let resolution = sample_rate_hz / period_samples as f64;
    assemble(records, &realisations, &lines, resolution, period_samples)
}

fn bad(record: &str, problem: &str) -> IdentifyError {
    refused(record, problem, None)
}

fn refused(record: &str, problem: &str, advice: Option<Advice>) -> IdentifyError {
    IdentifyError::NoResponse { record: record.to_owned(), problem: problem.to_owned(), advice }
}

fn rate(record: &InputOutput) -> Result<f64, IdentifyError> {
    record.sample_rate_hz().ok_or_else(|| {
        let problem = "it has no uniform sample rate; resample it, or give the rate";
        refused(&record.name, problem, Some(Advice::Resample))
    })
}

/// Samples of a period, and the range of samples used: whole periods in steady state.
fn steady_part(
    record: &InputOutput,
    options: &EmpiricalOptions,
) -> Result<(usize, std::ops::Range<usize>), IdentifyError> {
    let (period, start, count, settling) = match options.period_s {
        Some(period_s) => {
            let period = period_s * rate(record)?;
            (period, 0, (record.len() as f64 / period + 1e-9).floor() as usize, 0)
        }
        None => {
            let found = find_periods(record)?;
            (found.period_samples, found.start, found.count, found.settling)
        }
    };
    let whole = period.round();
    if !(whole >= 2.0 && (period - whole).abs() * count.max(1) as f64 <= WHOLE) {
        return Err(refused(
            &record.name,
            &format!(
                "its period of {period:.4} samples is not a whole number of them, so its lines leak into one \
                 another; play a multisine whose period is a whole number of samples, or give the period"
            ),
            Some(Advice::GivePeriod),
        ));
    }
    let samples = whole as usize;
    let settling = options.settling_periods.unwrap_or(settling);
    let from = start + settling * samples;
    let periods = (start + count * samples).min(record.len()).saturating_sub(from) / samples;
    if periods == 0 {
        return Err(bad(
            &record.name,
            &format!(
                "of its {count} whole period(s) {settling} are left out while the output settles, and none \
                 is left"
            ),
        ));
    }
    let range = from..from + periods * samples;
    let masked = record.valid.as_ref().and_then(|valid| range.clone().find(|&k| !valid[k]));
    if let Some(k) = masked {
        return Err(bad(
            &record.name,
            &format!("sample {k} is marked invalid; leave its periods out, every sample of a period counts"),
        ));
    }
    Ok((samples, range))
}

/// Half-spectra of a period, scaled so that a cosine of amplitude 1 has a line of 1.
fn spectra(record: &InputOutput, samples: usize, range: std::ops::Range<usize>) -> Realisation {
    let fft = RealFft::new(samples);
    let transform = |x: &[f64]| -> Vec<Vec<Complex64>> {
        x[range.clone()]
            .chunks_exact(samples)
            .map(|period| {
                let mut spectrum = fft.forward.make_output_vec();
                // The lengths are those of the plan.
                fft.transform(&mut period.to_vec(), &mut spectrum);
                spectrum.iter_mut().for_each(|z| *z *= 2.0 / samples as f64);
                spectrum
            })
            .collect()
    };
    let (inputs, outputs) = (transform(&record.u), transform(&record.y));
    let periods = inputs.len();
    let mean = |list: &[Vec<Complex64>]| -> Vec<Complex64> {
        let sum = |k: usize| list.iter().map(|spectrum| spectrum[k]).sum::<Complex64>();
        (0..samples / 2 + 1).map(|k| sum(k) / periods as f64).collect()
    };
    let (input, output) = (mean(&inputs), mean(&outputs));
    let scatter = (periods > 1).then(|| {
        let scale = 1.0 / (periods as f64 * (periods - 1) as f64);
        let at = |k: usize| {
            let mut sums = (0.0, 0.0, Complex64::ZERO);
            for (u, y) in inputs.iter().zip(&outputs) {
                let (du, dy) = (u[k] - input[k], y[k] - output[k]);
                sums.0 += du.norm_sqr();
                sums.1 += dy.norm_sqr();
                sums.2 += dy * du.conj();
            }
            (sums.0 * scale, sums.1 * scale, sums.2 * scale)
        };
        (0..input.len()).map(at).collect()
    });
    Realisation { input, output, scatter, periods }
}

/// Lines above zero whose input stands out.
fn excited(input: &[Complex64]) -> Vec<usize> {
    let largest = input.iter().skip(1).map(|u| u.norm()).fold(0.0, f64::max);
    let stands_out = |k: &usize| largest > 0.0 && input[*k].norm() > EXCITED * largest;
    (1..input.len()).filter(stands_out).collect()
}

fn assemble(
    records: &[InputOutput],
    realisations: &[Realisation],
    lines: &[usize],
    resolution: f64,
    period_samples: usize,
) -> Result<EmpiricalResponse, IdentifyError> {
    let count = realisations.len() as f64;
    let gain = |r: &Realisation, k: usize| r.output[k] / r.input[k];
    let values: Vec<Complex64> =
        lines.iter().map(|&k| realisations.iter().map(|r| gain(r, k)).sum::<Complex64>() / count).collect();
    // var G = |G|² (var Y/|Y|² + var U/|U|² − 2 Re(cov/(Y U*))), written without dividing by Y.
    let noise_of = |r: &Realisation, k: usize| -> Option<f64> {
        let (u, y, cross) = *r.scatter.as_ref()?.get(k)?;
        let g = gain(r, k);
        let variance = (y + g.norm_sqr() * u - 2.0 * (cross * g.conj()).re) / r.input[k].norm_sqr();
        Some(variance.max(0.0))
    };
    let noise: Option<Vec<f64>> = lines
        .iter()
        .map(|&k| {
            let sum: Option<f64> = realisations.iter().map(|r| noise_of(r, k)).sum();
            sum.map(|variance| variance.sqrt() / count)
        })
        .collect();
    let total: Option<Vec<f64>> = (realisations.len() > 1).then(|| {
        let at = |(&k, mean): (&usize, &Complex64)| {
            let sum: f64 = realisations.iter().map(|r| (gain(r, k) - mean).norm_sqr()).sum();
            (sum / (count * (count - 1.0))).sqrt()
        };
        lines.iter().zip(&values).map(at).collect()
    });
    let distortion = total.as_ref().zip(noise.as_ref()).map(|(total, noise)| {
        let at = |(t, n): (&f64, &f64)| (count * (t * t - n * n).max(0.0)).sqrt();
        total.iter().zip(noise).map(at).collect()
    });
    let first = &records[0];
    let (input, output) = (first.u_unit.symbol(), first.y_unit.symbol());
    let response = FrequencyResponse {
        name: first.name.clone(),
        frequency_hz: lines.iter().map(|&k| k as f64 * resolution).collect(),
        values,
        // Zero noise (a simulation) cannot weight residuals.
        std_dev: total.or_else(|| noise.clone()).filter(|s| s.iter().all(|s| *s > 0.0)),
        unit: if output.is_empty() && input.is_empty() {
            String::new()
        } else {
            format!("{output}_per_{input}")
        },
        source: first.source.clone(),
    };
    response.check()?;
    let detection = |parity: usize| detection_lines(realisations, lines, parity, resolution);
    Ok(EmpiricalResponse {
        response,
        noise_std: noise,
        distortion_std: distortion,
        odd_detection: detection(1),
        even_detection: detection(0),
        realisations: realisations.len(),
        periods: realisations.iter().map(|r| r.periods).collect(),
        period_samples,
    })
}

fn detection_lines(
    realisations: &[Realisation],
    lines: &[usize],
    parity: usize,
    resolution: f64,
) -> DetectionLines {
    let (first, last) = (lines[0], lines[lines.len() - 1]);
    let mut found = DetectionLines::default();
    for k in (first..=last).filter(|k| k % 2 == parity && lines.binary_search(k).is_err()) {
        let count = realisations.len() as f64;
        let power: f64 = realisations.iter().map(|r| r.output[k].norm_sqr()).sum();
        let noise: f64 = realisations.iter().filter_map(|r| Some(r.scatter.as_ref()?[k].1)).sum();
        found.frequency_hz.push(k as f64 * resolution);
        found.amplitude.push((power / count).sqrt());
        found.noise.push((noise / count).sqrt());
    }
    found
}

#[cfg(test)]
mod tests;
