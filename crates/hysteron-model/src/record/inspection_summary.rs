//! An inspection as data: every key names its unit, null where the record does not determine it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Clipping, DelayFinding, InputOutput, Inspection, LoopSense, NoiseMethod, Segment, Unit};
use crate::finding::Finding;

/// Results of the inspection of one record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InspectionSummary {
    /// The record's file, or its name if it has none.
    pub record: String,
    /// Number of samples.
    pub samples: usize,
    /// Samples that the mask excludes.
    pub masked_samples: usize,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: Option<f64>,
    /// Largest deviation of a time stamp from the grid \[sample periods\].
    pub jitter_samples: Option<f64>,
    /// Last less first time \[s\].
    pub duration_s: Option<f64>,
    /// The input.
    pub input: ChannelSummary,
    /// The output.
    pub output: ChannelSummary,
    /// Kind and frequencies of the drive.
    pub drive: DriveSummary,
    /// Periods of the record, if it repeats.
    pub periods: Option<PeriodsSummary>,
    /// Noise floor of the output, rms in its unit.
    pub noise_floor_rms: Option<f64>,
    /// `period-repeats` or `fourth-differences`.
    pub noise_floor_method: Option<String>,
    /// Drift of the output over the settled periods \[its unit per second\].
    pub drift_per_s: Option<f64>,
    /// Loop of output over input.
    #[serde(rename = "loop")]
    pub loop_shape: Option<LoopSummary>,
    /// Delay identified from the record.
    pub delay: Option<DelaySummary>,
    /// Stretches of even sampling with their drives; empty where there is one only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub segments: Vec<Segment>,
    /// Conclusions, in order of weight.
    pub findings: Vec<InspectionFinding>,
}

/// A channel; range and step in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelSummary {
    /// Name of the column.
    pub name: String,
    /// Symbol of the unit.
    pub unit: String,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Samples held at the lower end of the range.
    pub saturated_low_samples: usize,
    /// Samples held at the upper end of the range.
    pub saturated_high_samples: usize,
    /// Converter step.
    pub step: Option<f64>,
}

/// Kind and frequencies of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DriveSummary {
    /// Name of its [kind](super::ExcitationKind::name).
    pub kind: String,
    /// Lowest frequency \[Hz\].
    pub low_hz: Option<f64>,
    /// Highest frequency \[Hz\].
    pub high_hz: Option<f64>,
}

/// Periods of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeriodsSummary {
    /// Whole periods.
    pub count: usize,
    /// Periods before the steady state.
    pub settling: usize,
    /// Length of a period \[samples\].
    pub period_samples: f64,
    /// Length of a period \[s\].
    pub period_s: Option<f64>,
    /// Rms change of the output from one settled period to the next, in its unit.
    pub change_rms: Option<f64>,
}

/// Loop of output over input; stroke and opening in the output's unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoopSummary {
    /// Largest less smallest output.
    pub stroke: f64,
    /// Opening of the loop.
    pub opening: f64,
    /// Opening in percent of the stroke.
    pub opening_percent_of_stroke: f64,
    /// `counter-clockwise`, `clockwise` or `closed`.
    pub sense: String,
    /// The loop crosses itself.
    pub butterfly: bool,
}

/// Delay identified from a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "from", rename_all = "kebab-case")]
pub enum DelaySummary {
    /// From a start out of rest.
    StartUp {
        /// Delay \[s\].
        delay_s: f64,
        /// Least delay that explains the start \[s\].
        low_s: f64,
        /// Greatest delay that explains the start \[s\].
        high_s: f64,
        /// Lag of first order beside the delay \[s\].
        lag_s: f64,
    },
    /// From the slope of the phase.
    Phase {
        /// Delay \[s\].
        delay_s: f64,
        /// Its standard error \[s\].
        std_error_s: f64,
        /// Lowest frequency used \[Hz\].
        low_hz: f64,
        /// Highest frequency used \[Hz\].
        high_hz: f64,
    },
    /// One frequency does not distinguish delay from loop width.
    OneFrequency {
        /// The frequency \[Hz\].
        frequency_hz: f64,
        /// Delay if the loop had no width \[s\].
        at_most_s: f64,
    },
    /// The record does not determine it.
    Nothing,
}

/// A finding about a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct InspectionFinding {
    /// True if it is a warning.
    pub warning: bool,
    /// The finding.
    #[serde(flatten)]
    pub finding: Finding,
}

impl Inspection {
    /// The inspection of `data` as data.
    pub fn summary(&self, data: &InputOutput) -> InspectionSummary {
        let channel = |name: &str, unit: &Unit, (low, high), clipping: Clipping, step| ChannelSummary {
            name: name.to_owned(),
            unit: unit.symbol().to_owned(),
            low,
            high,
            saturated_low_samples: clipping.at_low,
            saturated_high_samples: clipping.at_high,
            step,
        };
        InspectionSummary {
            record: data.source.as_ref().map_or(&data.name, |s| &s.path).clone(),
            samples: self.samples,
            masked_samples: self.masked_samples,
            sample_rate_hz: self.sample_rate_hz,
            jitter_samples: self.jitter_samples,
            duration_s: self.duration_s,
            input: channel(&data.input, &data.u_unit, self.input_range, self.input_clipping, None),
            output: channel(
                &data.output,
                &data.y_unit,
                self.output_range,
                self.output_clipping,
                self.output_step,
            ),
            drive: DriveSummary {
                kind: self.kind.name().to_owned(),
                low_hz: self.frequency_span_hz.map(|span| span.0),
                high_hz: self.frequency_span_hz.map(|span| span.1),
            },
            periods: self.periods.map(|p| PeriodsSummary {
                count: p.count,
                settling: p.settling,
                period_samples: p.period_samples,
                period_s: self.sample_rate_hz.map(|rate| p.period_samples / rate),
                change_rms: self.period_change_rms,
            }),
            noise_floor_rms: self.noise_floor.map(|n| n.rms),
            noise_floor_method: self.noise_floor.map(|n| {
                match n.method {
                    NoiseMethod::PeriodRepeats { .. } => "period-repeats",
                    NoiseMethod::FourthDifferences => "fourth-differences",
                    NoiseMethod::Quantisation => "quantisation",
                }
                .to_owned()
            }),
            drift_per_s: self.drift.map(|d| d.per_second),
            loop_shape: self.loop_shape.map(|l| LoopSummary {
                stroke: l.stroke,
                opening: l.opening,
                opening_percent_of_stroke: l.opening_percent,
                sense: match l.sense {
                    Some(LoopSense::CounterClockwise) => "counter-clockwise",
                    Some(LoopSense::Clockwise) => "clockwise",
                    None => "closed",
                }
                .to_owned(),
                butterfly: l.butterfly,
            }),
            delay: self.delay.map(DelaySummary::from),
            segments: self.segments.clone(),
            findings: self
                .findings
                .iter()
                .map(|f| InspectionFinding { warning: f.is_warning(), finding: f.clone() })
                .collect(),
        }
    }
}

impl From<DelayFinding> for DelaySummary {
    fn from(finding: DelayFinding) -> Self {
        match finding {
            DelayFinding::FromStartUp(s) => Self::StartUp {
                delay_s: s.delay_s,
                low_s: s.delay_range_s.0,
                high_s: s.delay_range_s.1,
                lag_s: s.lag_s,
            },
            DelayFinding::FromPhase { delay_s, std_error_s, band_hz, .. } => {
                Self::Phase { delay_s, std_error_s, low_hz: band_hz.0, high_hz: band_hz.1 }
            }
            DelayFinding::Inseparable { frequency_hz, at_most_s } => {
                Self::OneFrequency { frequency_hz, at_most_s }
            }
            DelayFinding::Unknown => Self::Nothing,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::super::{TimeBase, inspect};
    use super::*;

    #[test]
    fn a_summary_is_read_back() {
        let drive = |k: usize| (std::f64::consts::TAU * k as f64 / 100.0).sin();
        let u: Vec<f64> = (0..500).map(drive).collect();
        let y: Vec<f64> = u.iter().map(|u| 0.5 * u).collect();
        let data = InputOutput::new("r", TimeBase::uniform(1000.0), u, y).unwrap();
        let summary = inspect(&data).summary(&data);
        let json = serde_json::to_string(&summary).unwrap();
        assert_eq!(serde_json::from_str::<InspectionSummary>(&json).unwrap(), summary, "{json}");
        assert_eq!(summary.drive.kind, "sine");
        assert_eq!(summary.periods.unwrap().period_s, Some(0.1));
    }
}
