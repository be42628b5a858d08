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
    let text = serde_json::to_string(&found).unwrap();
    is_kept::<FitSummary>(&text);
    assert_eq!(serde_json::from_str::<FitSummary>(&text).unwrap(), found.summary());
    let hysteron_identify::FitDetails::Hammerstein(found) = &found.found else { panic!("another kind") };
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
    is_kept::<InverseSummary>(
        r#"{"samples":9,"sample_rate_hz":100.0,"rest_V":null,"drive_low_V":0.0,"drive_high_V":9.0,"fastest_drive_V_per_s":90.0,"samples_at_range":0,"samples_at_slew":1,"bandwidth_hz":30.0,"error_at_bandwidth":0.01,"noise_gain":2.0,"predicted_rms_error_urad":0.1,"predicted_max_error_urad":0.2,"predicted_rms_percent_of_stroke":1.0,"band_urad":null}"#,
    );
    is_kept::<TrackingSummary>(
        r#"{"simulated":true,"plant":"rig","samples":200,"sample_rate_hz":1000.0,"scored_from_s":0.1,"scored_to_s":0.2,"range_V":[0.0,10.0],"slew_V_per_s":null,"sines":{"level_um":5.0,"amplitude_um":2.5,"lowest_hz":1.0,"highest_hz":100.0},"controllers":[{"controller":"causal-lms","rms_um":0.1,"max_um":0.2,"mean_um":-0.1,"rms_percent_of_stroke":1.0,"max_percent_of_stroke":null,"runs_away":false,"drive_low_V":0.5,"drive_high_V":9.5,"samples_at_range":1,"samples_at_slew":2,"minus_3_db_formula_hz":50.0,"minus_3_db_played_hz":null,"one_percent_error_formula_hz":5.0,"one_percent_error_played_hz":5.5,"bandwidths_differ":true,"sines":[{"frequency_hz":1.0,"error_percent_of_stroke":0.5,"gain":1.0,"phase_deg":-0.25,"samples_held_back":0}],"law":"30/s","gain_margin":null,"phase_margin_deg":60.0,"modulus_margin":0.5,"crossover_hz":4.5,"adaptation":{"weights":8,"stride_samples":2,"step":0.01,"step_limit":0.1,"step_limit_at_hz":0.0,"step_margin":10.0,"phase_error_deg":12.5,"phase_error_at_hz":80.0,"phase_margin_deg":77.5,"best_weights_rms_percent_of_stroke":0.9}}],"reach":[{"amplitude_um":0.5,"drive_amplitude_V":0.25,"highest_hz":500.0}]}"#,
    );
    is_kept::<RealisationSummary>(
        r#"{"sample_rate_hz":10000.0,"accuracy":0.001,"states":1,"delay_samples":0,"taps":[0.1],"sections":[{"kind":"real","rate_rad_per_s":10.0,"gain":[0.9,0.0],"weight":[0.1,0.0]}],"rest_gain":1.0,"offset":0.0,"moves_half_way":false,"band_hz":[0.1,1000.0],"frequency_error":0.0005,"reference_gain":1.0,"weights_over_gain":1.2,"batch_difference_largest":0.001,"batch_difference_rms":0.0002,"range":10.0,"output_unit":"um","nanoseconds_per_sample":20.0}"#,
    );
    is_kept::<ComparisonSummary>(
        r#"{"records":["a.csv"],"output_unit":"um","preferred":"bouc-wen / none","best":"bouc-wen / none","noise_floor":0.01,"samples":900,"independent_samples":30.0,"folds":[{"left_out":"a.csv","content":"1 Hz","whole_records":true}],"candidates":[{"name":"bouc-wen / none","parameters":4,"error":0.1,"error_std_error":0.01,"above_best":0.0,"above_best_std_error":0.0,"as_good_as_best":true,"training_rmse":0.1,"aic":1.0,"bic":2.0,"nanoseconds_per_sample":10.0,"states":0,"not_realised_because":null,"invertible":"yes","fold_errors":[0.1,null],"failures":["why"]}],"baselines":[{"name":"narx","parameters":9,"lag_interval_s":0.01,"output_lags":2,"input_lags":2,"error":0.2,"error_std_error":null,"training_rmse":0.1,"fold_errors":[0.2],"failures":[],"seconds":1.5}],"notes":["a note"],"interrupted":false,"out_of_time":false}"#,
    );
    is_kept::<ExplainedSummary>(
        r#"{"response":"g","unit":"um/V","points":20,"band_hz":[1.0,100.0],"weighting":"relative","empirical":{"realisations":2,"periods":[3,3],"period_samples":100,"lines":20,"noise_percent":0.1,"distortion_percent":null,"odd_detection":{"lines":3,"amplitude_rms":0.1,"noise_rms":0.01},"even_detection":null},"structures":[{"name":"first order","formula":"k/(1 + s T)","rms_error_percent":1.0,"largest_error_percent":2.0,"largest_error_at_hz":90.0,"aic":-10.0,"starts":9,"starts_in_best_optimum":7,"explanation":"a lag","parameters":[{"name":"k","value":1.0,"unit":"um/V","std_error":null,"on_edge":false}]}]}"#,
    );
}
