//! What is answered.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::stopwatch::Timing;

/// One line of JSON.
#[derive(Debug, Serialize)]
#[serde(tag = "answer", rename_all = "snake_case")]
pub enum Answer {
    /// Nothing to report.
    Done,
    /// A simulation is planned.
    Planned {
        /// Length of its transforms.
        transform_length: usize,
    },
    /// Something was repeated.
    Timed {
        /// Wall-clock time of each repetition \[s\].
        seconds: Vec<f64>,
        /// Allocations of all repetitions together.
        allocations: usize,
    },
    /// A model was identified.
    Identified {
        /// Wall-clock time \[s\].
        seconds: f64,
        /// The searches of the two steps.
        searches: Vec<Search>,
        /// Evaluations of every search, the small ones that choose a structure among them.
        evaluations: BTreeMap<String, usize>,
        /// RMSE of every record \[µm\].
        rmse_um: Vec<f64>,
        /// Search box of each step: name, low, high, whether logarithmic.
        boxes: Vec<Vec<(String, f64, f64, bool)>>,
        /// How each record was taken to start.
        starts: Vec<String>,
        /// Parameters by name.
        parameters: Vec<(String, f64)>,
    },
}

/// One search of an identification.
#[derive(Debug, Serialize)]
pub struct Search {
    /// What was searched.
    pub step: String,
    /// Algorithm.
    pub algorithm: String,
    /// Evaluations of the cost.
    pub evaluations: usize,
    /// Generations.
    pub generations: usize,
    /// Best cost \[µm\].
    pub cost: f64,
}

impl From<Timing> for Answer {
    fn from(timing: Timing) -> Self {
        Answer::Timed { seconds: timing.seconds, allocations: timing.allocations }
    }
}
