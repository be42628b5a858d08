//! Delay between drive and output, distinguished from the lag of the hysteresis loop.
//!
//! A hysteresis loop lags by the same *angle* at every frequency, a delay by the same *time*. One steady
//! frequency cannot distinguish them; a start from rest, or several frequencies, can.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use super::start_up::{StartUp, fit_start_up};
use super::{ExcitationKind, InputOutput, Periods};
use hysteron_numeric::fft::RealFft;

/// Gains within this factor of that at the lowest frequency: below the flank of a resonance.
const SPREAD: f64 = 1.4;
/// Fewest spectral lines of one record for a line through their phases.
const FEWEST_RESPONSES: usize = 8;

/// Delay identified from a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DelayFinding {
    /// From a jump out of rest: pure dead time plus a first-order lag.
    FromStartUp(StartUp),
    /// From the phase over frequency: φ(f) = −φ₀ − 2π f τ.
    FromPhase {
        /// τ \[s\]: dead time together with every lag that grows with frequency (amplifier, mechanics well
        /// below resonance).
        delay_s: f64,
        /// Its standard error \[s\].
        std_error_s: f64,
        /// φ₀ \[rad\], the part that does not grow with frequency: hysteresis, creep.
        constant_lag_rad: f64,
        /// Lowest and highest frequency used \[Hz\].
        band_hz: (f64, f64),
    },
    /// One frequency in steady state: only the sum of delay and loop lag is known.
    Inseparable {
        /// The frequency \[Hz\].
        frequency_hz: f64,
        /// Lag of the output's fundamental \[s\]: the delay if there were no hysteresis.
        at_most_s: f64,
    },
    /// The record does not determine it.
    Unknown,
}

/// Estimates the delay of the output behind the drive: from a start-up out of rest where there is one, else
/// from the phase over at least a factor of three in frequency, else an upper bound from the only frequency.
/// `None` without a uniform time base.
pub fn find_delay(
    data: &InputOutput,
    kind: &ExcitationKind,
    periods: Option<&Periods>,
) -> Option<DelayFinding> {
    data.sample_rate_hz()?;
    if let Some(start_up) = fit_start_up(data, periods) {
        return Some(DelayFinding::FromStartUp(start_up));
    }
    let phase = match kind {
        ExcitationKind::Sweep { .. } | ExcitationKind::Broadband { .. } => {
            let responses = low_frequency_responses(data, periods, SPREAD);
            if responses.len() < FEWEST_RESPONSES { None } else { delay_from_phase(&responses) }
        }
        _ => None,
    };
    Some(phase.or_else(|| inseparable(data, kind, periods)).unwrap_or(DelayFinding::Unknown))
}

/// Output over input at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Gain \[output unit per input unit\].
    pub gain: f64,
    /// Phase \[rad\], −π … π; π is added where the characteristic falls.
    pub phase_rad: f64,
    /// Weight of the phase, the reciprocal of its variance up to a common factor.
    pub weight: f64,
}

/// Lag of the fundamental over the settled periods.
fn inseparable(data: &InputOutput, kind: &ExcitationKind, periods: Option<&Periods>) -> Option<DelayFinding> {
    let ExcitationKind::Wave { frequency, .. } = kind else { return None };
    let Response { frequency_hz, phase_rad, .. } = fundamental_response(data, *frequency, periods)?;
    Some(DelayFinding::Inseparable { frequency_hz, at_most_s: (-phase_rad / (TAU * frequency_hz)).max(0.0) })
}

/// Response at the one frequency of a record's drive (`frequency`, per sample), over its settled periods.
/// `None` without a uniform time base.
pub fn fundamental_response(
    data: &InputOutput,
    frequency: f64,
    periods: Option<&Periods>,
) -> Option<Response> {
    let rate = data.sample_rate_hz()?;
    let (from, length) = match periods {
        Some(p) => (p.steady_start(), (p.count - p.settling) as f64 * p.period_samples),
        None => (0, data.len() as f64),
    };
    let fundamental = |x: &[f64]| {
        let part = x.get(from..(from + length as usize).min(x.len())).unwrap_or_default();
        let mean = part.iter().sum::<f64>() / part.len().max(1) as f64;
        part.iter()
            .enumerate()
            .map(|(k, x)| Complex::from_polar(x - mean, -TAU * frequency * k as f64))
            .sum::<Complex<f64>>()
    };
    let ratio = fundamental(&data.y) / fundamental(&data.u);
    let phase = ratio.arg();
    // A falling characteristic is a rising one with the sign turned.
    let phase_rad = if phase.abs() > 0.25 * TAU { principal(phase + 0.5 * TAU) } else { phase };
    let found = Response { frequency_hz: frequency * rate, gain: ratio.norm(), phase_rad, weight: 1.0 };
    found.gain.is_finite().then_some(found)
}

/// Angle brought to (−π, π].
fn principal(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// Responses at the driven frequencies of a record of several, from the averaged cross spectrum: from the
/// lowest up to where the gain leaves 1/`spread` … `spread` of its value there, or half the Nyquist
/// frequency; those with a coherence above 0.8.
pub fn low_frequency_responses(data: &InputOutput, periods: Option<&Periods>, spread: f64) -> Vec<Response> {
    driven_responses(data, periods, spread).unwrap_or_default()
}

fn driven_responses(data: &InputOutput, periods: Option<&Periods>, spread: f64) -> Option<Vec<Response>> {
    let rate = data.sample_rate_hz()?;
    let (length, hop, start) = match periods {
        // Whole periods need no window.
        Some(p) if p.period_samples == p.period_samples.round() && p.count - p.settling >= 2 => {
            (p.period_samples as usize, p.period_samples as usize, p.steady_start())
        }
        _ => {
            let length = (data.len() / 4).max(64);
            (length, length / 2, 0)
        }
    };
    let windowed = hop != length;
    let spectra = CrossSpectra::average(data.u.get(start..)?, data.y.get(start..)?, length, hop, windowed)?;
    let strongest = spectra.input.iter().skip(1).copied().fold(0.0, f64::max);
    let driven: Vec<usize> = (if windowed { 3 } else { 1 }..spectra.input.len() / 2)
        .filter(|&i| spectra.input[i] > 1e-3 * strongest)
        .collect();
    let few = driven.len().min(5);
    if few < 5 {
        return None;
    }
    let gain = |i: usize| (spectra.cross[i] / spectra.input[i]).norm();
    let low_gain = super::turning_points::median(driven[..few].iter().map(|&i| gain(i)).collect());
    // A falling characteristic is a rising one with the sign turned.
    let turn = if spectra.cross[driven[0]].arg().abs() > 0.25 * TAU { 0.5 * TAU } else { 0.0 };
    let used = driven
        .iter()
        .copied()
        .take_while(|&i| (1.0 / spread..spread).contains(&(gain(i) / low_gain)))
        .filter(|&i| spectra.coherence(i) > 0.8);
    let response = |i: usize| {
        let coherence = spectra.coherence(i).min(0.9999);
        Response {
            frequency_hz: i as f64 * rate / length as f64,
            gain: gain(i),
            phase_rad: principal(spectra.cross[i].arg() + turn),
            weight: coherence / (1.0 - coherence),
        }
    };
    Some(used.map(response).collect())
}

/// Delay by a straight line through the phases φ(f) = −φ₀ − 2π f τ, in ascending frequency: up to where the
/// gain leaves 0.7 … 1.4 of that of the lowest. `None` below three frequencies or a factor of three between
/// the lowest and the highest.
pub fn delay_from_phase(responses: &[Response]) -> Option<DelayFinding> {
    let first = responses.first()?;
    let level = |r: &&Response| (1.0 / SPREAD..SPREAD).contains(&(r.gain / first.gain));
    let used: Vec<&Response> = responses.iter().take_while(level).collect();
    let last = used.last()?;
    if used.len() < 3 || last.frequency_hz < 3.0 * first.frequency_hz {
        return None;
    }
    // Unwrapped upwards in frequency.
    let mut phase = 0.0;
    let points: Vec<(f64, f64, f64)> = used
        .iter()
        .map(|r| {
            phase += principal(r.phase_rad - phase);
            (r.frequency_hz, phase, r.weight)
        })
        .collect();
    let weight: f64 = points.iter().map(|p| p.2).sum();
    let f_mean = points.iter().map(|p| p.2 * p.0).sum::<f64>() / weight;
    let phase_mean = points.iter().map(|p| p.2 * p.1).sum::<f64>() / weight;
    let (mut cross, mut square) = (0.0, 0.0);
    for (f, phase, w) in &points {
        cross += w * (f - f_mean) * (phase - phase_mean);
        square += w * (f - f_mean).powi(2);
    }
    let slope = cross / square;
    let scatter: f64 =
        points.iter().map(|(f, phase, w)| w * (phase - phase_mean - slope * (f - f_mean)).powi(2)).sum();
    Some(DelayFinding::FromPhase {
        delay_s: -slope / TAU,
        std_error_s: (scatter / (points.len() as f64 - 2.0) / square).sqrt() / TAU,
        constant_lag_rad: -(phase_mean - slope * f_mean),
        band_hz: (first.frequency_hz, last.frequency_hz),
    })
}

/// Averaged auto and cross spectra of pieces of a record.
struct CrossSpectra {
    input: Vec<f64>,
    output: Vec<f64>,
    cross: Vec<Complex<f64>>,
}

impl CrossSpectra {
    fn average(u: &[f64], y: &[f64], length: usize, hop: usize, windowed: bool) -> Option<Self> {
        let plan = RealFft::new(length).forward;
        let hann = |k: usize| (0.5 * TAU * k as f64 / length as f64).sin().powi(2);
        let window: Vec<f64> = (0..length).map(|k| if windowed { hann(k) } else { 1.0 }).collect();
        let transform = |x: &[f64]| -> Option<Vec<Complex<f64>>> {
            let mean = x.iter().sum::<f64>() / length as f64;
            let mut centred: Vec<f64> = x.iter().zip(&window).map(|(x, w)| (x - mean) * w).collect();
            let mut spectrum = plan.make_output_vec();
            plan.process(&mut centred, &mut spectrum).ok()?;
            Some(spectrum)
        };
        let bins = length / 2 + 1;
        let mut spectra = CrossSpectra {
            input: vec![0.0; bins],
            output: vec![0.0; bins],
            cross: vec![Complex::default(); bins],
        };
        let mut from = 0;
        while let (Some(u), Some(y)) = (u.get(from..from + length), y.get(from..from + length)) {
            let (u, y) = (transform(u)?, transform(y)?);
            for i in 0..bins {
                spectra.input[i] += u[i].norm_sqr();
                spectra.output[i] += y[i].norm_sqr();
                spectra.cross[i] += y[i] * u[i].conj();
            }
            from += hop;
        }
        (from > 0).then_some(spectra)
    }

    fn coherence(&self, i: usize) -> f64 {
        let power = self.input[i] * self.output[i];
        if power > 0.0 { self.cross[i].norm_sqr() / power } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TimeBase, excitation_kind, find_periods};
    use super::*;

    /// Sum of play operators (half-widths 0.1 … 0.8), started from rest, with dead time; the drive given as a
    /// function of time.
    fn bench(rate: f64, n: usize, delay_s: f64, gain: f64, drive: impl Fn(f64) -> f64) -> InputOutput {
        let mut plays = [0.0f64; 8];
        let mut output = |u: f64| {
            for (i, p) in plays.iter_mut().enumerate() {
                let r = 0.1 * (i + 1) as f64;
                *p = p.clamp(u - r, u + r);
            }
            gain * (3.0 * u + 0.3 * plays.iter().sum::<f64>())
        };
        let (u, y) = (0..n)
            .map(|k| k as f64 / rate)
            .map(|t| (drive(t), output(if t < delay_s { drive(0.0) } else { drive(t - delay_s) })))
            .unzip();
        InputOutput::new("r", TimeBase::uniform(rate), u, y).unwrap()
    }

    fn found(data: &InputOutput) -> DelayFinding {
        let periods = find_periods(data).ok();
        find_delay(data, &excitation_kind(&data.u), periods.as_ref()).unwrap()
    }

    #[test]
    fn a_sweep_separates_the_delay_from_the_loop() {
        for gain in [1.0, -1.0] {
            let data =
                bench(5000.0, 20_000, 1.7e-3, gain, |t| (TAU * (1.0 * t + 0.5 * 60.0 / 4.0 * t * t)).sin());
            let DelayFinding::FromPhase { delay_s, std_error_s, constant_lag_rad, band_hz } = found(&data)
            else {
                panic!("{:?}", found(&data))
            };
            assert!((delay_s - 1.7e-3).abs() < 0.1e-3, "{delay_s} ± {std_error_s}");
            // The plays' own lag is an angle of several degrees, which must not pass for a delay.
            assert!(constant_lag_rad > 0.03 && constant_lag_rad < 0.4, "{constant_lag_rad}");
            assert!(band_hz.0 < 10.0 && band_hz.1 > 30.0, "{band_hz:?}");
        }
    }

    #[test]
    fn a_repeating_multisine_without_hysteresis_gives_its_delay_closely() {
        let wave = |t: f64| (1..=40).map(|h| (TAU * f64::from(h) * t + f64::from(h * h)).cos()).sum::<f64>();
        let rate = 1000.0;
        let u: Vec<f64> = (0..3000).map(|k| wave(k as f64 / rate)).collect();
        let y: Vec<f64> = (0..3000).map(|k| 2.0 * wave(k as f64 / rate - 2.25e-3)).collect();
        let data = InputOutput::new("r", TimeBase::uniform(rate), u, y).unwrap();
        let DelayFinding::FromPhase { delay_s, constant_lag_rad, .. } = found(&data) else {
            panic!("{:?}", found(&data))
        };
        assert!((delay_s - 2.25e-3).abs() < 1e-9, "{delay_s}");
        assert!(constant_lag_rad.abs() < 1e-6);
    }

    #[test]
    fn one_steady_sine_gives_a_bound_only() {
        let data = bench(1000.0, 5000, 4e-3, 1.0, |t| (TAU * 2.0 * t).sin());
        let DelayFinding::Inseparable { frequency_hz, at_most_s } = found(&data) else {
            panic!("{:?}", found(&data))
        };
        assert!((frequency_hz - 2.0).abs() < 1e-3);
        assert!(at_most_s > 4e-3 && at_most_s < 40e-3, "{at_most_s}");
    }
}
