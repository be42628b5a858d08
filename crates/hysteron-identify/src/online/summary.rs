//! A model corrected over a record, for programs.

use std::borrow::Cow;

use hysteron_model::record::InputOutput;
use hysteron_rt::Misfit;
use serde::{Deserialize, Serialize};

use super::{FollowOptions, Followed};

/// Result of the correction over a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FollowedSummary {
    record: String,
    unit: String,
    method: Cow<'static, str>,
    memory_s: Option<f64>,
    every: usize,
    noise: f64,
    coefficients: Vec<CoefficientSummary>,
    rmse_before: f64,
    rmse_before_offset_estimated: f64,
    rmse_predicted: f64,
    rmse_last_coefficients: f64,
    fits: bool,
    alarms: Vec<AlarmSummary>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CoefficientSummary {
    term: String,
    before: f64,
    after: f64,
    std_error: Option<f64>,
    least: f64,
    greatest: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AlarmSummary {
    time_s: f64,
    sample: usize,
    misfit: Cow<'static, str>,
}

impl Followed {
    /// The result for programs: of this record, with these options.
    pub fn summary(&self, data: &InputOutput, options: &FollowOptions) -> FollowedSummary {
        let first = data.time.time_s(0).unwrap_or(0.0);
        FollowedSummary {
            record: data.label().to_owned(),
            unit: data.y_unit.symbol().to_owned(),
            method: options.method.name().into(),
            memory_s: self.memory_s,
            every: self.every,
            noise: options.noise,
            coefficients: self
                .paths
                .iter()
                .map(|p| CoefficientSummary {
                    term: p.term.to_string(),
                    before: p.start,
                    after: p.end,
                    std_error: p.std_error,
                    least: p.least,
                    greatest: p.greatest,
                })
                .collect(),
            rmse_before: self.before.rmse,
            rmse_before_offset_estimated: self.before_offset_estimated.rmse,
            rmse_predicted: self.predicted.rmse,
            rmse_last_coefficients: self.last.rmse,
            fits: self.alarms.is_empty(),
            alarms: self
                .alarms
                .iter()
                .map(|a| AlarmSummary {
                    time_s: data.time.time_s(a.sample).unwrap_or(first),
                    sample: a.sample,
                    misfit: match a.misfit {
                        Misfit::Above => "above",
                        Misfit::Below => "below",
                        Misfit::Spread => "spread",
                    }
                    .into(),
                })
                .collect(),
        }
    }
}
