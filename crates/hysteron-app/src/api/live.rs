//! A fit while it runs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Axis, Curve, Job};

/// State of a running fit, for the first paint of a page; [`LiveUpdate`] events continue it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Live {
    /// The job.
    pub job: Job,
    /// Best cost against time, so far.
    pub costs: Vec<CostPoint>,
    /// The loop that is drawn: measured.
    pub measured: Option<Curve>,
    /// The best model so far on the same samples.
    pub latest: Option<LiveLoop>,
}

/// A point of the curve of costs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CostPoint {
    /// Time since the job began \[s\].
    pub time_s: f64,
    /// Best cost.
    pub cost: f64,
    /// Index of the stage.
    pub stage: usize,
}

/// Event `live`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveUpdate {
    /// Number of the job.
    pub job: i64,
    /// Share done.
    pub fraction: f64,
    /// Estimated time left \[s\].
    pub left_s: Option<f64>,
    /// Name of the stage.
    pub stage: String,
    /// New point of the curve of costs.
    pub cost: Option<CostPoint>,
    /// The best model so far; `null` where it has not changed.
    pub latest: Option<LiveLoop>,
}

/// Event `progress`: how far the computation of a request is that named itself by the header `x-request`. It
/// ends where the client closes the connection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RequestProgress {
    /// Name of the request.
    pub request: String,
    /// Name of the stage.
    pub stage: String,
    /// Share done.
    pub fraction: f64,
    /// Estimated time left \[s\].
    pub left_s: Option<f64>,
}

/// The best model so far on one record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LiveLoop {
    /// Identifier of the record.
    pub record: String,
    /// Index of the stage; axes change only with it.
    pub stage: usize,
    /// Loop of the model.
    pub model: Curve,
    /// Measured − model over time.
    pub residual: Curve,
    /// Root mean square of exactly these residuals, in the unit of the output.
    pub rmse: f64,
    /// Axis of the residual for this stage, symmetric about 0.
    pub residual_axis: Axis,
}
