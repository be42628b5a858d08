//! Results are data: what is read back from their JSON gives the same JSON.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use hysteron_export::ExportSummary;
use hysteron_identify::online::FollowedSummary;
use hysteron_identify::recalibrate::RecalibrationSummary;
use hysteron_identify::{CampaignRecord, FitParameter, FitRecords, Method, Options, Task, Watch, fit};
use hysteron_model::Finding;
use hysteron_model::model_file::Maker;
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_optimize::Outcome;
use serde::Serialize;
use serde::de::DeserializeOwned;

fn is_kept<T: Serialize + DeserializeOwned>(text: &str) {
    assert_eq!(serde_json::to_string(&serde_json::from_str::<T>(text).unwrap()).unwrap(), text);
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
    comes_back::<Vec<FitParameter>>(&found.parameters);
    comes_back::<Vec<Finding>>(&found.findings);
    let hysteron_identify::Found::Hammerstein(found) = &found.found else { panic!("another kind") };
    found.searches.iter().for_each(|search| comes_back::<Outcome>(&search.outcome));
}

#[test]
fn summaries_come_back() {
    is_kept::<FollowedSummary>(
        r#"{"record":"a.csv","unit":"um","method":"kalman","memory_s":null,"every":1,"noise":0.01,"coefficients":[{"term":"offset","before":0.0,"after":0.5,"std_error":0.1,"least":0.0,"greatest":0.5}],"rmse_before":1.0,"rmse_before_offset_estimated":0.5,"rmse_predicted":0.2,"rmse_last_coefficients":0.1,"fits":false,"alarms":[{"time_s":1.5,"sample":3,"misfit":"above"}]}"#,
    );
    is_kept::<RecalibrationSummary>(
        r#"{"gain":{"old":1.0,"old_std_error":null,"measured":1.1,"measured_std_error":0.01,"value":1.1,"std_error":0.01,"changed":true},"delay_s":{"old":0.0,"old_std_error":null,"measured":0.0,"measured_std_error":null,"value":0.0,"std_error":null,"changed":false},"offset":0.5,"offset_unit":"um","changed":true,"records":[{"record":"a.csv","samples":9,"unit":"um","rmse_before":1.0,"rmse_after":0.1,"fit_percent":99.0,"start":"rest"}]}"#,
    );
    is_kept::<ExportSummary>(
        r#"{"name":"stage","float":"f32","sample_rate_hz":10000.0,"states":4,"taps":1,"delay_samples":0,"frequency_error":0.001,"input_unit":"V","output_unit":"um","files":[{"path":"firmware/stage.h","bytes":10}]}"#,
    );
}
