//! A designed drive and what it makes certain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Purpose;
use hysteron_model::Finding;
use hysteron_model::record::{Channel, Record, TimeBase, Unit};

/// A standard error or a standard deviation of the output before the drive and after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Expected {
    /// Quantity or motion.
    pub name: String,
    /// Unit, empty for a ratio.
    pub unit: String,
    /// Present estimate; `None` for the output along a motion.
    pub value: Option<f64>,
    /// Standard error now.
    pub now: f64,
    /// After the designed drive.
    pub designed: f64,
    /// After a loop and a sweep of the same length.
    pub usual: f64,
    /// The drive is for this.
    pub aim: bool,
}

/// The next drive.
#[derive(Clone, Debug)]
pub struct Design {
    /// What it is for.
    pub purpose: Purpose,
    /// The drive, from rest and back to it \[input unit\].
    pub drive: Vec<f64>,
    /// Loop and sweep of the same length, for comparison.
    pub usual: Vec<f64>,
    /// Motion from rest along which the output is to be predicted; empty for the other purposes.
    pub motion: Vec<f64>,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Highest frequency excited \[Hz\].
    pub highest_hz: f64,
    /// Unit of the drive, as in a column header.
    pub unit: String,
    /// Its segments in words, in order.
    pub segments: Vec<String>,
    /// What becomes how certain.
    pub expected: Vec<Expected>,
    /// Range of the output that the model predicts for the drive \[output unit\].
    pub stroke: f64,
    /// Standard deviation of the noise \[output unit\].
    pub noise: f64,
    /// Times that loop and sweep must be repeated to reach the same; `None` where they cannot. Longer ones may
    /// need less time.
    pub usual_repetitions: Option<f64>,
    /// What the design rests on.
    pub findings: Vec<Finding>,
}

/// A design without its samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DesignSummary {
    /// What it is for.
    pub purpose: Purpose,
    /// Number of samples.
    pub samples: usize,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Length \[s\].
    pub time_s: f64,
    /// Lowest and highest value of the drive.
    pub range: [f64; 2],
    /// Largest slew rate \[per second\].
    pub slew_per_s: f64,
    /// Highest frequency excited \[Hz\].
    pub highest_hz: f64,
    /// Its segments in words.
    pub segments: Vec<String>,
    /// What becomes how certain.
    pub expected: Vec<Expected>,
    /// Range of the output that the model predicts for the drive \[output unit\].
    pub stroke: f64,
    /// Standard deviation of the noise \[output unit\].
    pub noise: f64,
    /// Times that loop and sweep must be repeated to reach the same; longer ones may need less time.
    pub usual_repetitions: Option<f64>,
    /// What the design rests on.
    pub findings: Vec<Finding>,
}

impl Design {
    /// The drive as a record of one channel from t = 0, ready to be written for a DAQ.
    pub fn record(&self) -> Record {
        Record {
            name: format!("for {}", self.purpose.name()),
            time: TimeBase::uniform(self.sample_rate_hz),
            channels: vec![Channel {
                name: "u".into(),
                unit: Unit::new(&self.unit),
                samples: self.drive.clone(),
            }],
            valid: None,
            source: None,
        }
    }

    /// The design without its samples.
    pub fn summary(&self) -> DesignSummary {
        let ends = self
            .drive
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &u| [low.min(u), high.max(u)]);
        let step = self.drive.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        DesignSummary {
            purpose: self.purpose,
            samples: self.drive.len(),
            sample_rate_hz: self.sample_rate_hz,
            time_s: self.drive.len() as f64 / self.sample_rate_hz,
            range: ends,
            slew_per_s: step * self.sample_rate_hz,
            highest_hz: self.highest_hz,
            segments: self.segments.clone(),
            expected: self.expected.clone(),
            stroke: self.stroke,
            noise: self.noise,
            usual_repetitions: self.usual_repetitions,
            findings: self.findings.clone(),
        }
    }
}
