//! What was found, as JSON: every key names its unit; null where the record does not tell.

use hysteron_model::record::{
    Clipping, DelayFinding, ExcitationKind, LoopSense, NoiseMethod, Unit, WaveShape,
};
use serde::Serialize;

use super::Inspected;

/// One record.
#[derive(Serialize)]
pub struct Entry<'a> {
    record: &'a str,
    samples: usize,
    masked_samples: usize,
    sample_rate_hz: Option<f64>,
    jitter_samples: Option<f64>,
    duration_s: Option<f64>,
    input: Signal<'a>,
    output: Signal<'a>,
    drive: Drive,
    periods: Option<Periods>,
    noise_floor_rms: Option<f64>,
    noise_floor_method: Option<&'static str>,
    drift_per_s: Option<f64>,
    #[serde(rename = "loop")]
    shape: Option<Loop>,
    delay: Option<Delay>,
    findings: Vec<Finding<'a>>,
}

/// A channel; range and step in its unit.
#[derive(Serialize)]
struct Signal<'a> {
    name: &'a str,
    unit: &'a str,
    low: f64,
    high: f64,
    saturated_low_samples: usize,
    saturated_high_samples: usize,
    step: Option<f64>,
}

#[derive(Serialize)]
struct Drive {
    kind: &'static str,
    low_hz: Option<f64>,
    high_hz: Option<f64>,
}

#[derive(Serialize)]
struct Periods {
    count: usize,
    settling: usize,
    period_samples: f64,
    period_s: Option<f64>,
    change_rms: Option<f64>,
}

/// Loop of output over input; stroke and opening in the output's unit.
#[derive(Serialize)]
struct Loop {
    stroke: f64,
    opening: f64,
    opening_percent_of_stroke: f64,
    sense: &'static str,
    butterfly: bool,
}

/// What the record says about the delay.
#[derive(Serialize)]
#[serde(tag = "from", rename_all = "kebab-case")]
enum Delay {
    StartUp { delay_s: f64, low_s: f64, high_s: f64, lag_s: f64 },
    Phase { delay_s: f64, std_error_s: f64, low_hz: f64, high_hz: f64 },
    OneFrequency { frequency_hz: f64, at_most_s: f64 },
    Nothing,
}

#[derive(Serialize)]
struct Finding<'a> {
    warning: bool,
    text: &'a str,
}

impl<'a> Entry<'a> {
    pub fn new(inspected: &'a Inspected) -> Self {
        let Inspected { data, found } = inspected;
        let signal = |name: &'a str, unit: &'a Unit, (low, high), clipping: Clipping, step| Signal {
            name,
            unit: unit.symbol(),
            low,
            high,
            saturated_low_samples: clipping.at_low,
            saturated_high_samples: clipping.at_high,
            step,
        };
        Entry {
            record: data.source.as_ref().map_or(&data.name, |s| &s.path),
            samples: found.samples,
            masked_samples: found.masked_samples,
            sample_rate_hz: found.sample_rate_hz,
            jitter_samples: found.jitter_samples,
            duration_s: found.duration_s,
            input: signal(&data.input, &data.u_unit, found.input_range, found.input_clipping, None),
            output: signal(
                &data.output,
                &data.y_unit,
                found.output_range,
                found.output_clipping,
                found.output_step,
            ),
            drive: Drive {
                kind: kind(&found.kind),
                low_hz: found.frequency_span_hz.map(|span| span.0),
                high_hz: found.frequency_span_hz.map(|span| span.1),
            },
            periods: found.periods.map(|p| Periods {
                count: p.count,
                settling: p.settling,
                period_samples: p.period_samples,
                period_s: found.sample_rate_hz.map(|rate| p.period_samples / rate),
                change_rms: found.period_change_rms,
            }),
            noise_floor_rms: found.noise_floor.map(|n| n.rms),
            noise_floor_method: found.noise_floor.map(|n| match n.method {
                NoiseMethod::PeriodRepeats { .. } => "period-repeats",
                NoiseMethod::FourthDifferences => "fourth-differences",
            }),
            drift_per_s: found.drift.map(|d| d.per_second),
            shape: found.loop_shape.map(|l| Loop {
                stroke: l.stroke,
                opening: l.opening,
                opening_percent_of_stroke: l.opening_percent,
                sense: match l.sense {
                    Some(LoopSense::CounterClockwise) => "counter-clockwise",
                    Some(LoopSense::Clockwise) => "clockwise",
                    None => "closed",
                },
                butterfly: l.butterfly,
            }),
            delay: found.delay.map(delay),
            findings: found
                .findings
                .iter()
                .map(|f| Finding { warning: f.is_warning(), text: &f.text })
                .collect(),
        }
    }
}

/// Name of a kind of drive.
pub fn kind(kind: &ExcitationKind) -> &'static str {
    match kind {
        ExcitationKind::Constant => "constant",
        ExcitationKind::Steps { .. } => "steps",
        ExcitationKind::Ramps { .. } => "ramps",
        ExcitationKind::Wave { shape: WaveShape::Sine, .. } => "sine",
        ExcitationKind::Wave { shape: WaveShape::Triangle, .. } => "triangle",
        ExcitationKind::Wave { shape: WaveShape::Other, .. } => "wave",
        ExcitationKind::Sweep { .. } => "sweep",
        ExcitationKind::Broadband { .. } => "broadband",
    }
}

fn delay(finding: DelayFinding) -> Delay {
    match finding {
        DelayFinding::FromStartUp(s) => Delay::StartUp {
            delay_s: s.delay_s,
            low_s: s.delay_range_s.0,
            high_s: s.delay_range_s.1,
            lag_s: s.lag_s,
        },
        DelayFinding::FromPhase { delay_s, std_error_s, band_hz, .. } => {
            Delay::Phase { delay_s, std_error_s, low_hz: band_hz.0, high_hz: band_hz.1 }
        }
        DelayFinding::Inseparable { frequency_hz, at_most_s } => {
            Delay::OneFrequency { frequency_hz, at_most_s }
        }
        DelayFinding::Unknown => Delay::Nothing,
    }
}
