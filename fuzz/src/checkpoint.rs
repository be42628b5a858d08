//! The searches of an interrupted fit.

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, Options, Searches, Watch, identify};
use hysteron_model::record::{InputOutput, TimeBase, Unit};
use hysteron_optimize::{Algorithm, DeAbcOptions};

/// The searches of a fit that is small enough to be done again and again.
pub fn searches(data: &[u8]) {
    let Ok(searches) = serde_json::from_slice::<Searches>(data) else { return };
    let text = serde_json::to_string(&searches).expect("what was read is written");
    assert!(serde_json::from_str::<Searches>(&text).is_ok(), "what was written is refused");
    let options = Options {
        dynamics: DynamicsChoice::None,
        degree: Choice::Given(1),
        algorithm: Some(Algorithm::DeAbc(DeAbcOptions::default())),
        generations: 2,
        ..Options::default()
    };
    let u: Vec<f64> = (0..80).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.157).cos()).collect();
    let y: Vec<f64> = u.iter().enumerate().map(|(k, u)| 1.5 * u + 0.3 * (k as f64 * 0.157).sin()).collect();
    let data = InputOutput {
        name: "loop".into(),
        time: TimeBase::uniform(80.0),
        u,
        y,
        rate: None,
        valid: None,
        input: "u".into(),
        output: "y".into(),
        u_unit: Unit::new("V"),
        y_unit: Unit::new("um"),
        source: None,
    };
    let _ = identify(&[CampaignRecord { data, role: None }], &options, &Watch::default(), Some(searches));
}
