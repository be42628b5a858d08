//! Segments of a record: its stretches of even sampling, wide motion and rest at a level apart, what the drive does in each, and
//! what the output answers.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::ops::Range;

use realfft::num_complex::Complex;

use serde::{Deserialize, Serialize};

use super::inspection_summary::DriveSummary;
use super::{ExcitationKind, InputOutput, TimeBase, excitation_kind, range_of, span};

/// More segments than this are irregular stamps rather than segments.
const MOST: usize = 1000;
/// A drive that moves by less than this share of the range of the record is held.
const HELD: f64 = 1e-3;
/// Share of a held segment over which its first and its last output are averaged.
const END: f64 = 0.05;
/// Range of the drive over which it counts as resting at a level, small oscillations included, as a share of that of the record.
const LEVEL: f64 = 0.02;
/// Rest at a level that is a segment of its own: so many samples and such a share of those at one rate, at least.
const REST_SAMPLES: usize = 40;
const REST_SHARE: f64 = 0.2;

/// A stretch of even sampling and one regime of the drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Change of the output while the drive is held, in the unit of the output.
    pub creep: Option<f64>,
}

impl InputOutput {
    /// The record in stretches of even sampling, each a record with a uniform time base: the record itself where its own base is
    /// uniform or unknown. Stamps that belong to none are left out.
    pub fn in_segments(&self) -> Vec<InputOutput> {
        let mut segments: Vec<InputOutput> = self.parts().into_iter().map(|(_, part)| part).collect();
        if segments.is_empty() {
            segments.push(self.clone());
        }
        segments
    }

    /// The segments with their samples; none where the time base is uniform or unknown, or its stamps are irregular.
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

    /// What the drive does in each stretch of even sampling and what the output answers; empty where there is one only.
    pub fn segments(&self) -> Vec<Segment> {
        let range = span(&self.u);
        let parts = self.parts();
        if parts.len() < 2 {
            return Vec::new();
        }
        parts.into_iter().filter_map(|(samples, part)| segment(&part, samples, range)).collect()
    }

    /// Longest time over which the drive rests at a level, small oscillations about it included \[s\]; 0 without a time base.
    pub fn longest_hold_s(&self) -> f64 {
        let at = |k: usize| self.time.time_s(k).unwrap_or(0.0);
        let mut longest = 0f64;
        rests(&self.u, LEVEL * span(&self.u), |rest| {
            longest = longest.max(at(rest.end - 1) - at(rest.start))
        });
        longest
    }
}

/// Calls `found` with the longest stretch over which `u` stays within a range of `most`, for each end of such a stretch.
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

/// The samples of a piece, long rests at a level apart from what is before and after them.
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
    // What is left beside a rest and too short for a regime belongs to it.
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

/// Output over input at a frequency (per sample), over whole periods under a Hann window, which suppresses creep and drift.
fn response(part: &InputOutput, frequency: f64) -> Option<Complex<f64>> {
    let periods = (part.len() as f64 * frequency).floor();
    let samples = (periods / frequency).round();
    let count = samples as usize;
    if periods < 3.0 || count > part.len() {
        return None;
    }
    let component = |x: &[f64]| {
        let mean = x[..count].iter().sum::<f64>() / samples;
        let weighted = x[..count].iter().enumerate().map(|(k, x)| {
            let window = 1.0 - (TAU * (k as f64 + 0.5) / samples).cos();
            Complex::from_polar((x - mean) * window, -TAU * frequency * k as f64)
        });
        weighted.sum::<Complex<f64>>()
    };
    let ratio = component(&part.y) / component(&part.u);
    ratio.norm().is_finite().then_some(ratio)
}

fn segment(part: &InputOutput, samples: Range<usize>, range: f64) -> Option<Segment> {
    let sample_rate_hz = part.sample_rate_hz()?;
    let (start_s, last_s) = part.time.extent_s(part.len())?;
    let (low, high) = range_of(&part.u);
    let held = high - low <= HELD * range;
    let kind = if held { ExcitationKind::Constant } else { excitation_kind(&part.u) };
    let hz = kind.span().map(|(low, high)| (low * sample_rate_hz, high * sample_rate_hz));
    let response = match kind {
        ExcitationKind::Wave { frequency, .. } => response(part, frequency),
        _ => None,
    };
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
        creep: held.then(creep),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A ramp at 1 kHz, a hold at 100 Hz with an output that creeps by 0.2, a sine of 200 Hz at 10 kHz whose output lags by 30°.
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
        assert!(sine.samples.len().abs_diff(1000) < 60, "{sine:?}");
        assert_eq!(record.in_moving_segments().len(), 3);
        // The sine stays within a few hundredths of the range: creep goes on through it.
        assert!(record.longest_hold_s() > 12.0, "{}", record.longest_hold_s());
    }

    #[test]
    fn an_even_record_is_one_segment() {
        let u: Vec<f64> = (0..100).map(|k| (0.2 * f64::from(k)).sin()).collect();
        let record = InputOutput::new("r", TimeBase::uniform(10.0), u.clone(), u).unwrap();
        assert!(record.segments().is_empty());
        assert_eq!(record.in_segments(), [record]);
    }
}
