//! Segments of a record: uniformly sampled stretches, separated into wide motion and rest at a level, with
//! the drive and the response of the output in each.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::ops::Range;

use realfft::num_complex::Complex;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::inspection_summary::DriveSummary;
use super::{ExcitationKind, InputOutput, TimeBase, excitation_kind, range_of, span};

/// More segments than this are irregular stamps rather than segments.
const MOST: usize = 1000;
/// A drive that moves by less than this share of the range of the record is held.
const HELD: f64 = 1e-3;
/// Share of a held segment over which its first and its last output are averaged.
const END: f64 = 0.05;
/// Range of the drive over which it counts as resting at a level, small oscillations included, as a share of
/// that of the record.
const LEVEL: f64 = 0.02;
/// Fewest samples of a rest at a level that is a separate segment, and its least share of those at one rate.
const REST_SAMPLES: usize = 40;
const REST_SHARE: f64 = 0.2;
/// Frequencies on either side of a sine at which its scatter is estimated, in lines of the whole periods, and
/// fewest of them.
const NEIGHBOURS: usize = 6;
const FEWEST_NEIGHBOURS: usize = 2;
/// Lines beyond which the window suppresses a sine, and most of a drift besides its linear trend.
const SINE_LINES: f64 = 2.0;
const DRIFT_LINES: f64 = 3.0;

/// A uniformly sampled stretch with one regime of the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Segment {
    /// Samples of the record.
    pub samples: Range<usize>,
    /// Time of the first one \[s\].
    pub start_s: f64,
    /// Time from the first to the last one \[s\].
    pub duration_s: f64,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// The drive: `held`, or the name of its [kind](ExcitationKind::name), and its frequencies.
    pub drive: DriveSummary,
    /// Middle of the range of the input, in its unit.
    pub level: f64,
    /// Half of the range of the input, in its unit.
    pub amplitude: f64,
    /// Gain at the frequency of a sine or wave \[output unit per input unit\].
    pub gain: Option<f64>,
    /// Phase there \[°\].
    pub phase_deg: Option<f64>,
    /// Standard error of the gain from the output beside the sine, at neighbouring frequencies \[output unit
    /// per input unit\]; `None` where harmonics and drift leave too few of them.
    #[serde(default)]
    pub gain_std_error: Option<f64>,
    /// Standard error of the phase, likewise \[°\].
    #[serde(default)]
    pub phase_std_error_deg: Option<f64>,
    /// Change of the output while the drive is held, in the unit of the output.
    pub creep: Option<f64>,
}

impl InputOutput {
    /// The uniformly sampled stretches of the record, each a record with a uniform time base: the record
    /// itself where its base is uniform or unknown. Stamps that belong to none are left out.
    pub fn in_segments(&self) -> Vec<InputOutput> {
        let mut segments: Vec<InputOutput> = self.parts().into_iter().map(|(_, part)| part).collect();
        if segments.is_empty() {
            segments.push(self.clone());
        }
        segments
    }

    /// The segments with their samples; none where the time base is uniform or unknown, or its stamps are
    /// irregular.
    fn parts(&self) -> Vec<(Range<usize>, InputOutput)> {
        if !matches!(self.time, TimeBase::NonUniform { .. }) {
            return Vec::new();
        }
        let most = LEVEL * span(&self.u);
        let mut parts = Vec::new();
        for piece in self.time.pieces(self.len()) {
            let Some(sample_rate_hz) = piece.sample_rate_hz() else { continue };
            for samples in regimes(&self.u, piece.samples.clone(), most) {
                let start_s = piece.start_s + (samples.start - piece.samples.start) as f64 * piece.period_s;
                let Ok(part) = self.cropped(samples.clone()) else { continue };
                let time = TimeBase::Uniform { start_s, sample_rate_hz, jitter_samples: 0.0 };
                parts.push((samples, InputOutput { time, ..part }));
            }
            if parts.len() > MOST {
                return Vec::new();
            }
        }
        parts
    }

    /// [`Self::in_segments`] without those in which the drive is held.
    pub fn in_moving_segments(&self) -> Vec<InputOutput> {
        let least = HELD * span(&self.u);
        let mut parts = self.in_segments();
        if parts.len() > 1 {
            parts.retain(|part| span(&part.u) > least);
        }
        parts
    }

    /// Drive and response of the output in each uniformly sampled stretch; empty where there is only one.
    pub fn segments(&self) -> Vec<Segment> {
        let range = span(&self.u);
        let parts = self.parts();
        if parts.len() < 2 {
            return Vec::new();
        }
        parts.into_iter().filter_map(|(samples, part)| segment(&part, samples, range)).collect()
    }

    /// Longest time over which the drive rests at a level, small oscillations about it included \[s\]; 0
    /// without a time base.
    pub fn longest_hold_s(&self) -> f64 {
        let at = |k: usize| self.time.time_s(k).unwrap_or(0.0);
        let mut longest = 0f64;
        rests(&self.u, LEVEL * span(&self.u), |rest| {
            longest = longest.max(at(rest.end - 1) - at(rest.start))
        });
        longest
    }
}

impl Segment {
    /// Output over input at this segment's sine, of the input `u` and an output `y` of the whole record:
    /// linear in `y`. `None` where the segment is not a sine or wave.
    pub fn response(&self, u: &[f64], y: &[f64]) -> Option<Complex<f64>> {
        let frequency = self.gain.and(self.drive.high_hz)? / self.sample_rate_hz;
        response(u.get(self.samples.clone())?, y.get(self.samples.clone())?, frequency)
    }
}

/// Calls `found` with the longest stretch over which `u` stays within a range of `most`, for each end of such
/// a stretch.
fn rests(u: &[f64], most: f64, mut found: impl FnMut(Range<usize>)) {
    // Places of the largest values so far, each larger than those after it, and of the smallest.
    let (mut highs, mut lows) = (VecDeque::new(), VecDeque::new());
    let mut from = 0;
    for (k, x) in u.iter().enumerate() {
        while highs.back().is_some_and(|&at: &usize| u[at] <= *x) {
            highs.pop_back();
        }
        while lows.back().is_some_and(|&at: &usize| u[at] >= *x) {
            lows.pop_back();
        }
        highs.push_back(k);
        lows.push_back(k);
        while u[highs[0]] - u[lows[0]] > most {
            from += 1;
            if highs[0] < from {
                highs.pop_front();
            }
            if lows[0] < from {
                lows.pop_front();
            }
        }
        found(from..k + 1);
    }
}

/// The samples of a piece, with long rests at a level separated from what is before and after.
fn regimes(u: &[f64], samples: Range<usize>, most: f64) -> Vec<Range<usize>> {
    let mut longest = 0..0;
    rests(&u[samples.clone()], most, |rest| {
        if rest.len() > longest.len() {
            longest = rest;
        }
    });
    let least = REST_SAMPLES.max((REST_SHARE * samples.len() as f64) as usize);
    if longest.len() < least {
        return vec![samples];
    }
    // A remainder beside a rest that is too short for a regime belongs to the rest.
    let mut rest = samples.start + longest.start..samples.start + longest.end;
    if rest.start - samples.start < REST_SAMPLES {
        rest.start = samples.start;
    }
    if samples.end - rest.end < REST_SAMPLES {
        rest.end = samples.end;
    }
    let mut found = Vec::new();
    if rest.start > samples.start {
        found.extend(regimes(u, samples.start..rest.start, most));
    }
    found.push(rest.clone());
    if rest.end < samples.end {
        found.extend(regimes(u, rest.end..samples.end, most));
    }
    found
}

/// Samples of the whole periods of a frequency (per sample), at least three of them.
fn whole_periods(samples: usize, frequency: f64) -> Option<usize> {
    let periods = (samples as f64 * frequency).floor();
    let count = (periods / frequency).round() as usize;
    (periods >= 3.0 && count <= samples).then_some(count)
}

/// Component of all of `x` about its mean at a frequency (per sample) under a Hann window, which suppresses
/// creep and drift.
fn component(x: &[f64], frequency: f64) -> Complex<f64> {
    let samples = x.len() as f64;
    let mean = x.iter().sum::<f64>() / samples;
    let weighted = x.iter().enumerate().map(|(k, x)| {
        let window = 1.0 - (TAU * (k as f64 + 0.5) / samples).cos();
        Complex::from_polar((x - mean) * window, -TAU * frequency * k as f64)
    });
    weighted.sum()
}

/// Output over input at a frequency (per sample), over whole periods.
fn response(u: &[f64], y: &[f64], frequency: f64) -> Option<Complex<f64>> {
    let count = whole_periods(u.len().min(y.len()), frequency)?;
    let ratio = component(&y[..count], frequency) / component(&u[..count], frequency);
    ratio.norm().is_finite().then_some(ratio)
}

/// Whole periods less the straight line from the mean of their first half to that of their second.
fn without_drift(y: &[f64], frequency: f64) -> Vec<f64> {
    let half = ((0.5 * y.len() as f64 * frequency).floor() / frequency).round().max(1.0) as usize;
    let mean = |y: &[f64]| y.iter().sum::<f64>() / y.len() as f64;
    let rest = y.len() - half;
    let slope = (mean(&y[rest..]) - mean(&y[..half])) / rest as f64;
    y.iter().enumerate().map(|(k, y)| y - slope * k as f64).collect()
}

/// Standard error of the real and of the imaginary part of a `response`: from the output at neighbouring
/// frequencies, where the window suppresses the sine, away from drift and harmonics.
fn response_error(u: &[f64], y: &[f64], frequency: f64, response: Complex<f64>) -> Option<f64> {
    let count = whole_periods(u.len().min(y.len()), frequency)?;
    let (u, y) = (&u[..count], without_drift(&y[..count], frequency));
    let line = 1.0 / count as f64;
    let clear = |f: &f64| {
        let harmonic = (f / frequency).round().max(1.0) * frequency;
        (DRIFT_LINES - 0.5) * line < *f && *f < 0.5 && (f - harmonic).abs() > (SINE_LINES - 0.5) * line
    };
    let beside = (2..=NEIGHBOURS).flat_map(|m| [-(m as f64), m as f64]).map(|m| frequency + m * line);
    let left = |f: f64| component(&y, f) - response * component(u, f);
    let powers: Vec<f64> = beside.filter(clear).map(|f| left(f).norm_sqr()).collect();
    if powers.len() < FEWEST_NEIGHBOURS {
        return None;
    }
    let mean = powers.iter().sum::<f64>() / powers.len() as f64;
    let error = (0.5 * mean).sqrt() / component(u, frequency).norm();
    error.is_finite().then_some(error)
}

fn segment(part: &InputOutput, samples: Range<usize>, range: f64) -> Option<Segment> {
    let sample_rate_hz = part.sample_rate_hz()?;
    let (start_s, last_s) = part.time.extent_s(part.len())?;
    let (low, high) = range_of(&part.u);
    let held = high - low <= HELD * range;
    let kind = if held { ExcitationKind::Constant } else { excitation_kind(&part.u) };
    let hz = kind.span().map(|(low, high)| (low * sample_rate_hz, high * sample_rate_hz));
    let found = match kind {
        ExcitationKind::Wave { frequency, .. } => response(&part.u, &part.y, frequency)
            .map(|found| (found, response_error(&part.u, &part.y, frequency, found))),
        _ => None,
    };
    let (response, error) = found.map_or((None, None), |(response, error)| (Some(response), error));
    let ends = ((END * part.len() as f64) as usize).max(1);
    let mean = |y: &[f64]| y.iter().sum::<f64>() / y.len() as f64;
    let creep = || mean(&part.y[part.len() - ends..]) - mean(&part.y[..ends]);
    Some(Segment {
        samples,
        start_s,
        duration_s: last_s - start_s,
        sample_rate_hz,
        drive: DriveSummary {
            kind: if held { "held" } else { kind.name() }.to_owned(),
            low_hz: hz.map(|(low, _)| low),
            high_hz: hz.map(|(_, high)| high),
        },
        level: 0.5 * (low + high),
        amplitude: 0.5 * (high - low),
        gain: response.map(|r| r.norm()),
        phase_deg: response.map(|r| r.arg().to_degrees()),
        gain_std_error: error,
        phase_std_error_deg: response.zip(error).map(|(r, error)| (error / r.norm()).to_degrees()),
        creep: held.then(creep),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A ramp at 1 kHz, a hold at 100 Hz with an output that creeps by 0.2, a sine of 200 Hz at 10 kHz whose
    /// output lags by 30°.
    fn record() -> InputOutput {
        let (mut times, mut u, mut y) = (Vec::new(), Vec::new(), Vec::new());
        let mut push = |t: f64, drive: f64, output: f64| {
            times.push(t);
            u.push(drive);
            y.push(output);
        };
        for k in 0..1000 {
            push(f64::from(k) * 1e-3, 0.02 * f64::from(k), 0.002 * f64::from(k));
        }
        for k in 0..1200 {
            push(1.0 + f64::from(k) * 0.01, 20.0, 2.0 + 0.2 * f64::from(k) / 1199.0);
        }
        for k in 0..1000 {
            let t = f64::from(k) * 1e-4;
            let phase = TAU * 200.0 * t;
            push(13.0 + t, 20.0 + 0.05 * phase.sin(), 2.2 + 0.05 * t + 0.005 * (phase - TAU / 12.0).sin());
        }
        for k in 0..1000 {
            let t = f64::from(k) * 1e-4;
            push(13.1 + t, 20.0 - 100.0 * t, 2.2 - 10.0 * t);
        }
        InputOutput::new("r", TimeBase::NonUniform { times_s: times }, u, y).unwrap()
    }

    #[test]
    fn every_segment_is_described_by_itself() {
        let record = record();
        let found = record.segments();
        assert_eq!(
            found.iter().map(|s| s.drive.kind.as_str()).collect::<Vec<_>>(),
            ["ramps", "held", "sine", "ramps"]
        );
        assert!((found[1].creep.unwrap() - 0.19).abs() < 1e-3, "{:?}", found[1]);
        let sine = &found[2];
        assert!((sine.drive.high_hz.unwrap() - 200.0).abs() < 0.01, "{sine:?}");
        assert!((sine.gain.unwrap() - 0.1).abs() < 2e-4, "{sine:?}");
        assert!((sine.phase_deg.unwrap() + 30.0).abs() < 0.1, "{sine:?}");
        let again = sine.response(&record.u, &record.y).unwrap();
        assert!((again.norm() - sine.gain.unwrap()).abs() < 1e-9, "{again}");
        assert!(sine.samples.len().abs_diff(1000) < 60, "{sine:?}");
        assert_eq!(record.in_moving_segments().len(), 3);
        // The sine stays within a few hundredths of the range: creep goes on through it.
        assert!(record.longest_hold_s() > 12.0, "{}", record.longest_hold_s());
    }

    #[test]
    fn the_error_of_a_response_is_its_scatter() {
        // 8 cycles of 50 samples, creep, a second harmonic, and noise that remembers half of itself.
        let (frequency, samples) = (0.02, 400);
        let u: Vec<f64> = (0..samples).map(|k| (TAU * frequency * f64::from(k)).sin()).collect();
        let clean = |k: usize| {
            let phase = TAU * frequency * k as f64;
            0.2 * (phase - 0.3).sin() + 0.01 * (2.0 * phase).sin() + 0.02 * (1.0 + 0.02 * k as f64).ln()
        };
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let (mut found, mut said) = (Vec::new(), Vec::new());
        for _ in 0..400 {
            let mut noise = 0.0;
            let y: Vec<f64> = (0..u.len())
                .map(|k| {
                    noise = 0.5 * noise + 0.01 * uniform();
                    clean(k) + noise
                })
                .collect();
            let h = response(&u, &y, frequency).unwrap();
            found.push(h.norm());
            said.push(response_error(&u, &y, frequency, h).unwrap());
        }
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let (centre, squares) = (mean(&found), said.iter().map(|s| s * s).collect::<Vec<_>>());
        let scatter = mean(&found.iter().map(|g| (g - centre).powi(2)).collect::<Vec<_>>()).sqrt();
        let ratio = mean(&squares).sqrt() / scatter;
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
        assert!((centre - 0.2).abs() < 1e-3, "{centre}");
    }

    #[test]
    fn an_even_record_is_one_segment() {
        let u: Vec<f64> = (0..100).map(|k| (0.2 * f64::from(k)).sin()).collect();
        let record = InputOutput::new("r", TimeBase::uniform(10.0), u.clone(), u).unwrap();
        assert!(record.segments().is_empty());
        assert_eq!(record.in_segments(), [record]);
    }
}
