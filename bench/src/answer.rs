//! Answers of the benchmarks.

use std::collections::BTreeMap;

use hysteron_optimize::Range;
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
    /// Columns of a fit were worked out.
    Columns(ColumnTimes),
    /// The problem of a joint fit.
    JointProblem(JointProblem),
    /// A cost.
    Cost {
        /// Root mean square of the weighted residuals.
        cost: f64,
    },
    /// Evaluations of joint fits were timed.
    JointTimes {
        /// For each number of threads.
        times: Vec<JointTimes>,
        /// The pass of the hysteresis over one record \[s\].
        hysteresis_s: f64,
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

/// Shortest wall-clock times \[s\] of columns of a fit and of their parts.
#[derive(Debug, Serialize)]
pub struct ColumnTimes {
    /// Length of the transforms.
    pub transform_length: usize,
    /// One forward and one inverse FFT.
    pub fft_pair_s: f64,
    /// G on every frequency.
    pub response_s: f64,
    /// G and its five derivatives.
    pub response_with_tangents_s: f64,
    /// G, a forward and an inverse FFT.
    pub column_s: f64,
    /// G, a forward and three inverse FFTs.
    pub objective_s: f64,
    /// G and its five derivatives, a forward and eight inverse FFTs.
    pub jacobian_s: f64,
    /// Allocations of all repetitions together.
    pub allocations: usize,
}

impl ColumnTimes {
    /// Nothing measured yet.
    pub fn starting(transform_length: usize) -> Self {
        Self {
            transform_length,
            fft_pair_s: f64::INFINITY,
            response_s: f64::INFINITY,
            response_with_tangents_s: f64::INFINITY,
            column_s: f64::INFINITY,
            objective_s: f64::INFINITY,
            jacobian_s: f64::INFINITY,
            allocations: 0,
        }
    }
}

/// Problem as a peer needs it.
#[derive(Debug, Serialize)]
pub struct JointProblem {
    /// The box.
    pub ranges: Vec<Range>,
    /// Starts read off the data.
    pub starts: Vec<Vec<f64>>,
    /// Samples of each record.
    pub samples: Vec<usize>,
    /// Weight of every sample of each record \[1/µm of all records alike\].
    pub weights: Vec<f64>,
}

/// Shortest wall-clock times \[s\] of an evaluation of a joint fit.
#[derive(Debug, Serialize)]
pub struct JointTimes {
    /// Threads.
    pub threads: usize,
    /// Cost.
    pub objective_s: f64,
    /// Residuals and their derivatives, if asked for.
    pub jacobian_s: Option<f64>,
    /// Allocations of the objective, all repetitions together.
    pub allocations: usize,
}

/// One search of an identification.
#[derive(Debug, Serialize)]
pub struct Search {
    /// Step whose numbers were searched.
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
