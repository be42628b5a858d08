//! Results are data: what is read back from their JSON gives the same JSON.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_export::ExportSummary;
use hysteron_identify::frequency_response::ExplainedSummary;
use hysteron_identify::online::FollowedSummary;
use hysteron_identify::recalibrate::RecalibrationSummary;
use hysteron_identify::{
    CampaignRecord, ComparisonSummary, FitRecords, FitSummary, Method, Options, Task, Watch, fit,
};
use hysteron_model::model::{InverseSummary, RealisationSummary};
use hysteron_model::model_file::Maker;
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_model::tracking::TrackingSummary;
use hysteron_optimize::Outcome;
use serde::Serialize;
use serde::de::DeserializeOwned;

fn is_kept<T: Serialize + DeserializeOwned>(text: &str) {
    let value: T = serde_json::from_str(text).unwrap();
    let text: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(serde_json::to_value(value).unwrap(), text);
}

fn comes_back<T: Serialize + DeserializeOwned>(value: &T) {
    is_kept::<T>(&serde_json::to_string(value).unwrap());
}

#[test]
fn what_a_fit_finds_comes_back() {
    let u: Vec<f64> = (0..400).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.0314).cos()).collect();
    let y = u.iter().map(|u| 2.0 * u + 0.03 * u * u).collect();
    let time = TimeBase::Uniform { start_s: 0.0, sample_rate_hz: 100.0, jitter_samples: 0.0 };
    let data = InputOutput::new("loop", time, u, y).unwrap();
    let records = FitRecords::Single(vec![CampaignRecord { data, role: None }]);
    let task = Task::Hammerstein(Box::new(Options { method: Method::TwoStep, ..Options::default() }));
    let found = fit(&records, &task, &Watch::silent(), None, &Maker::default()).unwrap();
    let text = serde_json::to_string(&found).unwrap();
    is_kept::<FitSummary>(&text);
    assert_eq!(serde_json::from_str::<FitSummary>(&text).unwrap(), found.summary());
    let hysteron_identify::FitDetails::Hammerstein(found) = &found.found else { panic!("another kind") };
    found.searches.iter().for_each(|search| comes_back::<Outcome>(&search.outcome));
}

#[test]
fn summaries_come_back() {
    is_kept::<FollowedSummary>(include_str!("results/followed.json"));
    is_kept::<RecalibrationSummary>(include_str!("results/recalibration.json"));
    is_kept::<ExportSummary>(include_str!("results/export.json"));
    is_kept::<InverseSummary>(include_str!("results/inverse.json"));
    is_kept::<TrackingSummary>(include_str!("results/tracking.json"));
    is_kept::<RealisationSummary>(include_str!("results/realisation.json"));
    is_kept::<ComparisonSummary>(include_str!("results/comparison.json"));
    is_kept::<ExplainedSummary>(include_str!("results/explained.json"));
}
