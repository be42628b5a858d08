//! Inspection of a record, in numbers and in plain words.

use crate::Advice;
use crate::finding::{Finding, FindingKind};
use hysteron_numeric::display::{short, short_to};

use super::turning_points::{median, range_of};
use super::{
    Clipping, DelayFinding, ExcitationKind, InputOutput, LinearDrift, LoopSense, LoopShape, NoiseFloor,
    NoiseMethod, Periods, Quantity, Segment, Servo, StartUp, TimeBase, WaveShape, clipping, excitation_kind,
    find_delay, find_periods, implausible_units, linear_drift, loop_shape, noise_floor, quantisation_step,
    servo,
};

/// Result of [`inspect`]. Frequencies in Hz where there is a uniform time base, else `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Number of samples.
    pub samples: usize,
    /// Samples that the mask excludes.
    pub masked_samples: usize,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: Option<f64>,
    /// Largest deviation of a time stamp from the grid \[sample periods\]; `None` without a uniform time
    /// base.
    pub jitter_samples: Option<f64>,
    /// Last less first time \[s\].
    pub duration_s: Option<f64>,
    /// Longest distance of two neighbouring stamps over the median one; `None` without non-uniform stamps.
    pub largest_gap: Option<f64>,
    /// Smallest and largest input.
    pub input_range: (f64, f64),
    /// Smallest and largest output.
    pub output_range: (f64, f64),
    /// Kind of drive, frequencies per sample.
    pub kind: ExcitationKind,
    /// Lowest and highest frequency of the drive \[Hz\], the same for one frequency.
    pub frequency_span_hz: Option<(f64, f64)>,
    /// Periods of the record, if it repeats.
    pub periods: Option<Periods>,
    /// Rms change of the output from one settled period to the next, in its unit.
    pub period_change_rms: Option<f64>,
    /// Noise floor of the output.
    pub noise_floor: Option<NoiseFloor>,
    /// Drift of the output over the settled periods.
    pub drift: Option<LinearDrift>,
    /// Delay of the output.
    pub delay: Option<DelayFinding>,
    /// Loop of output over input, over the settled periods; `None` for a drive that makes no loop (broadband,
    /// steps).
    pub loop_shape: Option<LoopShape>,
    /// Samples of the input held at an end of its range.
    pub input_clipping: Clipping,
    /// Samples of the output held at an end of its range.
    pub output_clipping: Clipping,
    /// Converter step of the output.
    pub output_step: Option<f64>,
    /// Stretches of even sampling with their drives; empty where there is one only.
    pub segments: Vec<Segment>,
    /// Start out of rest, if the record has one.
    pub start_up: Option<StartUp>,
    /// Conclusions, in order of weight.
    pub findings: Vec<Finding>,
}

/// Inspects a record. Masked samples are left out of the output's range, loop, noise floor and clipping.
pub fn inspect(data: &InputOutput) -> Inspection {
    let rate = data.sample_rate_hz();
    let valid_output: Vec<f64> = match &data.valid {
        Some(valid) => data.y.iter().zip(valid).filter(|(_, v)| **v).map(|(y, _)| *y).collect(),
        None => data.y.clone(),
    };
    let ((kind, output_step), periods) = rayon::join(
        || (excitation_kind(&data.u), quantisation_step(&valid_output)),
        || find_periods(data).ok(),
    );
    let (delay, noise_floor) =
        rayon::join(|| find_delay(data, &kind, periods.as_ref()), || noise_floor(data, periods.as_ref()));
    // Quantisation hides smaller noise and adds its own rounding.
    let rounding = output_step.map_or(0.0, |step| step / 12f64.sqrt());
    let noise_floor = noise_floor.map(|floor| {
        let hidden = floor.rms < rounding;
        if hidden { NoiseFloor { rms: rounding, method: NoiseMethod::Quantisation } } else { floor }
    });
    let segments = data.segments();
    let settled = periods.map_or(0, |p| p.steady_start());
    let makes_loop = matches!(kind, ExcitationKind::Wave { .. } | ExcitationKind::Ramps { .. });
    let held = matches!(kind, ExcitationKind::Steps { .. } | ExcitationKind::Constant);
    let mut found = Inspection {
        samples: data.len(),
        masked_samples: data.len() - valid_output.len(),
        sample_rate_hz: rate,
        jitter_samples: match data.time {
            TimeBase::Uniform { jitter_samples, .. } => Some(jitter_samples),
            _ => None,
        },
        duration_s: data.time.extent_s(data.len()).map(|(first, last)| last - first),
        largest_gap: largest_gap(&data.time),
        input_range: range_of(&data.u),
        output_range: range_of(&valid_output),
        frequency_span_hz: rate
            .and_then(|rate| kind.span().map(|(a, b)| (a * rate, b * rate)))
            .or_else(|| span_of(&segments)),
        period_change_rms: periods.as_ref().and_then(|p| period_change(data, p)),
        noise_floor,
        drift: periods.as_ref().and_then(|p| linear_drift(data, Some(p)).ok()),
        loop_shape: if makes_loop { settled_loop(data, settled) } else { None },
        // A drive may rest at any level; held for less than half a period it was clipped.
        input_clipping: kind
            .span()
            .map_or(Clipping::default(), |(lowest, _)| clipping(&data.u, (0.5 / lowest.max(1e-9)) as usize)),
        output_clipping: if held { Clipping::default() } else { clipping(&valid_output, usize::MAX) },
        output_step,
        segments,
        start_up: match delay {
            Some(DelayFinding::FromStartUp(start_up)) => Some(start_up),
            _ => None,
        },
        kind,
        periods,
        delay,
        findings: Vec::new(),
    };
    found.findings = found.in_words(data);
    found
}

fn warning(text: String) -> Finding {
    Finding::new(FindingKind::Warning, "record", text)
}

/// Ratio above which amplitudes of oscillation count as different.
const TWO_AMPLITUDES: f64 = 1.5;
/// Shortest rest of the drive that shows creep \[s\].
const SHOWS_CREEP_S: f64 = 5.0;

impl Inspection {
    /// Amplitudes, frequencies and rests of the drive over all segments.
    fn segments_in_words(&self, data: &InputOutput) -> Vec<String> {
        let unit = data.u_unit.spaced();
        let whole = 0.5 * (self.input_range.1 - self.input_range.0);
        let mut said = Vec::new();
        let waves: Vec<&Segment> = self.segments.iter().filter(|s| s.gain.is_some()).collect();
        if let Some((low, high)) = span_of(&self.segments) {
            let smallest = waves.iter().map(|s| s.amplitude).fold(f64::INFINITY, f64::min);
            let beside = if smallest.is_finite() && whole > TWO_AMPLITUDES * smallest {
                format!(" beside a motion of {}{unit}: two amplitudes or more", short(whole))
            } else {
                String::new()
            };
            let of = if smallest.is_finite() {
                format!(" of {}{unit} amplitude and more", short(smallest))
            } else {
                String::new()
            };
            said.push(format!("The drive oscillates at {low:.4} to {high:.4} Hz{of}{beside}."));
        }
        let hold = data.longest_hold_s();
        if hold >= SHOWS_CREEP_S {
            said.push(format!("It rests at a level for up to {} s: creep shows.", short(hold)));
        }
        said
    }

    fn in_words(&self, data: &InputOutput) -> Vec<Finding> {
        let mut findings = Vec::new();
        self.warnings(data, &mut findings);
        self.notes(data, &mut findings);
        findings
    }

    fn warnings(&self, data: &InputOutput, findings: &mut Vec<Finding>) {
        let (u_low, u_high) = self.input_range;
        let (y_low, y_high) = self.output_range;
        let stroke = y_high - y_low;
        let unit = data.y_unit.spaced();
        if u_low == u_high {
            findings.push(warning(format!(
                "The input `{}` is constant ({}{}): nothing can be identified. Was the drive connected, the \
                 right column chosen?",
                data.input,
                short(u_low),
                data.u_unit.spaced()
            )));
        }
        if y_low == y_high {
            findings.push(warning(format!(
                "The output `{}` is constant ({}{unit}): the sensor was off, or this is the wrong column.",
                data.output,
                short(y_low)
            )));
        }
        for (what, name, clipped) in
            [("output", &data.output, self.output_clipping), ("input", &data.input, self.input_clipping)]
        {
            if clipped.total() > 0 {
                let ends = match (clipped.at_low, clipped.at_high) {
                    (0, high) => format!("{high} samples at its largest value"),
                    (low, 0) => format!("{low} samples at its smallest value"),
                    (low, high) => format!("{low} samples at its smallest and {high} at its largest value"),
                };
                findings.push(warning(format!(
                    "The {what} `{name}` looks saturated: {ends}, entered and left steeply. Mark them 0 in a \
                     `valid` column, or record again within the range."
                )));
            }
        }
        let fastest_hz = self.frequency_span_hz.map(|(_, highest)| highest);
        implausible_units(data, fastest_hz).into_iter().for_each(|text| findings.push(warning(text)));
        match &data.time {
            TimeBase::Unknown => findings.push(warning(
                "There is no time column and no sample rate: a static fit is possible, dynamics are not. \
                 Give the sample rate if it is known."
                    .to_string(),
            ).with_advice(Advice::GiveSampleRate)),
            TimeBase::NonUniform { .. } if !self.segments.is_empty() => {
                let text = format!(
                    "{} segments at rates of their own: a Hammerstein model is fitted to and simulated on \
                     them as they are; what needs one rate takes the record resampled.",
                    self.segments.len()
                );
                findings.push(
                    Finding::new(FindingKind::Verdict, "record", text).with_advice(Advice::Resample),
                );
            }
            TimeBase::NonUniform { .. } => findings.push(warning(format!(
                "The time stamps are not uniform (longest distance {} times the median): a Hammerstein model \
                 is fitted to and simulated on them as they are; what needs one rate takes the record \
                 resampled, or the rate if the stamps are only written coarsely.{}",
                self.largest_gap.map_or("unknown".to_string(), |g| format!("{g:.3}")),
                repeated(&data.time)
            )).with_advice(Advice::Resample)),
            TimeBase::Uniform { jitter_samples, .. } if *jitter_samples > 0.01 => {
                findings.push(warning(format!(
                    "The time stamps scatter by up to {jitter_samples:.3} of a sample about a uniform grid."
                )));
            }
            TimeBase::Uniform { .. } => {}
        }
        if let Some(shape) = &self.loop_shape {
            if shape.butterfly {
                findings.push(warning(
                    "The output turns twice as often as the input: a butterfly loop (polarisation reversal). \
                     No hysteresis model of an actuator can follow it."
                        .to_string(),
                ));
            } else if shape.sense == Some(LoopSense::Clockwise)
                && shape.gain > 0.0
                && matches!(data.y_unit.base().0, Quantity::Length | Quantity::Angle)
            {
                findings.push(warning(format!(
                    "The loop runs clockwise: the output leads the input by {:.1} % of the stroke at \
                     mid-range. A piezo stack lags; are input and output swapped, or is the input measured \
                     behind the actuator?",
                    shape.opening_percent
                )));
            }
        }
        if let Some(Servo { output, input }) = servo(data) {
            findings.push(warning(format!(
                "The output moves along straight lines (to {} % of a move), the drive does not ({} %): this \
                 was taken under servo. The drive carries the hysteresis and answers the sensor, so that a \
                 model of the stage from it is one of the closed loop; record it open loop.",
                short_to(100.0 * output, 2),
                short_to(100.0 * input, 2)
            )));
        }
        if let Some(step) = self.output_step
            && step > 1e-3 * stroke
        {
            findings.push(warning(format!(
                "The output is quantised in steps of {step:.4}{unit}, {:.2} % of its range: no model can be \
                 verified below that.",
                100.0 * step / stroke
            )));
        }
        if let (Some(rate), Some((_, highest))) = (self.sample_rate_hz, self.frequency_span_hz)
            && highest > 0.0
            && rate / highest < 10.0
        {
            findings.push(warning(format!(
                "Only {:.1} samples a period at {highest:.4} Hz: what happens between samples matters; \
                 prefer the band-limited rule or sample faster.",
                rate / highest
            )));
        }
        if self.masked_samples > 0 {
            findings.push(warning(format!(
                "{} of {} samples are marked invalid and are not scored.",
                self.masked_samples, self.samples
            )));
        }
    }

    fn notes(&self, data: &InputOutput, findings: &mut Vec<Finding>) {
        let mut note = |text: String| findings.push(Finding::new(FindingKind::Verdict, "record", text));
        let unit = data.y_unit.spaced();
        let span = self.frequency_span_hz;
        let hz = |f: f64| format!("{f:.4} Hz");
        match (&self.kind, span) {
            _ if !self.segments.is_empty() => self.segments_in_words(data).into_iter().for_each(&mut note),
            (ExcitationKind::Wave { shape, turning_levels, .. }, span) => {
                let shape = match shape {
                    WaveShape::Sine => "sine",
                    WaveShape::Triangle => "triangle wave",
                    WaveShape::Other => "repeating wave",
                };
                let frequency = span.map_or("unknown frequency".to_string(), |(f, _)| hz(f));
                let loops = if *turning_levels > 2 {
                    "its amplitude changes, so minor loops are in the record"
                } else {
                    "one amplitude: minor loops and the dependence on amplitude are not in the record"
                };
                note(format!("The drive is a {shape} of {frequency}; {loops}."));
                note(
                    "One frequency only: how the loop changes with frequency cannot be determined from this \
                     record; add a sweep."
                        .to_string(),
                );
            }
            (ExcitationKind::Sweep { .. }, Some((a, b))) => {
                note(format!("The drive is a sweep from {} to {}.", hz(a), hz(b)));
            }
            (ExcitationKind::Broadband { .. }, Some((a, b))) => {
                note(format!("The drive has many frequencies at once, {} to {}.", hz(a), hz(b)));
            }
            (ExcitationKind::Steps { levels }, _) => {
                note(format!("The drive is held at {levels} levels, with jumps between them."))
            }
            (ExcitationKind::Ramps { reversals }, _) => note(format!(
                "The drive goes through a few strokes ({reversals} {}): good for the static loop, silent on \
                 dynamics.",
                if *reversals == 1 { "reversal" } else { "reversals" }
            )),
            _ => {}
        }
        if let Some(p) = &self.periods {
            let change = self
                .period_change_rms
                .map_or(String::new(), |c| format!("; it changes from one to the next by {c:.3}{unit} rms"));
            note(format!(
                "{} whole periods of {:.3} samples, {}{change}.",
                p.count,
                p.period_samples,
                match p.settling {
                    0 => "repeating from the start".to_string(),
                    n => format!("the output repeating after the first {n}"),
                }
            ));
        }
        if let Some(floor) = &self.noise_floor {
            let how = match floor.method {
                NoiseMethod::PeriodRepeats { pairs } => format!("from {pairs} pairs of periods"),
                NoiseMethod::FourthDifferences => "from fourth differences, an upper bound".to_string(),
                NoiseMethod::Quantisation => {
                    "the rounding of the converter's steps, which hide it".to_string()
                }
            };
            note(format!("Noise floor of the output {}{unit} rms ({how}).", short_to(floor.rms, 3)));
        }
        if let Some(shape) = &self.loop_shape {
            let once = if shape.taken_to_repeat {
                " It was run through once and is taken to repeat: a first loop out of rest would not."
            } else {
                ""
            };
            let sense = match shape.sense {
                Some(LoopSense::CounterClockwise) => "counter-clockwise",
                Some(LoopSense::Clockwise) => "clockwise",
                None => "closed to 0.1 %",
            };
            note(format!(
                "The loop is open by {:.3}{unit} at mid-range, {:.1} % of the {:.3}{unit} stroke, \
                 {sense}.{once}",
                shape.opening.abs(),
                shape.opening_percent,
                shape.stroke
            ));
        }
        match &self.delay {
            Some(DelayFinding::FromStartUp(s)) => note(format!(
                "{} the output starts {:.2} ms late ({:.2} to {:.2} ms fit as well) and follows with a lag \
                 of {:.2} ms{}.",
                if s.rest_recorded {
                    "After the drive jumps out of rest"
                } else {
                    "The first output lies outside the settled loop, as if the drive had jumped to its first \
                     value from rest;"
                },
                1e3 * s.delay_s,
                1e3 * s.delay_range_s.0,
                1e3 * s.delay_range_s.1,
                1e3 * s.lag_s,
                if s.misfit_percent > 2.0 {
                    ", roughly: a first-order lag does not describe it well"
                } else {
                    ""
                }
            )),
            Some(DelayFinding::FromPhase { delay_s, std_error_s, constant_lag_rad, band_hz }) => {
                note(format!(
                    "Delay {:.3} ± {:.3} ms (dead time and every lag that grows with frequency) beside a \
                     constant lag of {:.1}° (hysteresis, creep), from the phase between {} and {}.",
                    1e3 * delay_s,
                    1e3 * std_error_s,
                    constant_lag_rad.to_degrees(),
                    hz(band_hz.0),
                    hz(band_hz.1)
                ))
            }
            Some(DelayFinding::Inseparable { frequency_hz, at_most_s }) => note(format!(
                "The delay cannot be distinguished from loop width: at one steady frequency ({}) both only \
                 shift the output, together by {:.3} ms, so the delay is at most that. A sweep, or a start \
                 from rest that a first-order lag describes, would separate them.",
                hz(*frequency_hz),
                1e3 * at_most_s
            )),
            Some(DelayFinding::Unknown) => {
                note("The record does not determine the delay.".to_string());
            }
            None => {}
        }
    }
}

/// Lowest and highest frequency of the drives of segments \[Hz\].
fn span_of(segments: &[Segment]) -> Option<(f64, f64)> {
    let all = segments.iter().filter_map(|s| s.drive.low_hz.zip(s.drive.high_hz));
    all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Loop of the valid samples from this one on.
fn settled_loop(data: &InputOutput, from: usize) -> Option<LoopShape> {
    let valid = |k: &usize| data.is_valid(*k);
    let (u, y): (Vec<f64>, Vec<f64>) =
        (from..data.len()).filter(valid).filter_map(|k| Some((*data.u.get(k)?, *data.y.get(k)?))).unzip();
    loop_shape(&u, &y)
}

fn largest_gap(time: &TimeBase) -> Option<f64> {
    let TimeBase::NonUniform { times_s } = time else { return None };
    let gaps: Vec<f64> = times_s.windows(2).map(|w| w[1] - w[0]).collect();
    let largest = gaps.iter().copied().fold(0.0, f64::max);
    let positive: Vec<f64> = gaps.into_iter().filter(|g| *g > 0.0).collect();
    Some(largest / median(positive))
}

/// Rms over all pairs of successive settled periods.
fn period_change(data: &InputOutput, periods: &Periods) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for m in periods.settling + 1..periods.count {
        for (a, b) in periods.one(&data.y, m - 1).iter().zip(periods.one(&data.y, m)) {
            sum += (a - b) * (a - b);
            count += 1;
        }
    }
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

/// How many time stamps repeat the one before, and which is the first; empty where none does.
fn repeated(time: &TimeBase) -> String {
    let TimeBase::NonUniform { times_s } = time else { return String::new() };
    let mut repeats = times_s.windows(2).enumerate().filter(|(_, pair)| pair[0] == pair[1]);
    let Some((index, pair)) = repeats.next() else { return String::new() };
    format!(
        " {} of {} stamps repeat the one before, first that of sample {} ({} s).",
        1 + repeats.count(),
        times_s.len(),
        index + 2,
        short(pair[1])
    )
}

#[cfg(test)]
mod tests;
