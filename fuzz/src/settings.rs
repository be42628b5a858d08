//! Files of settings: truth and plan of the bench, a drive, the searches of an interrupted fit.

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, Options, Searches, Watch, identify};
use hysteron_model::record::{InputOutput, TimeBase, Unit};
use hysteron_optimize::{Algorithm, DeAbcOptions};
use hysteron_rig::excitation::ExcitationSpec;
use hysteron_rig::{CampaignPlan, Truth, measure};

/// Longest drive that is played \[samples\].
const PLAYED: usize = 400;

/// A truth, then, after a byte 0, a plan.
pub fn truth_and_plan(data: &[u8]) {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (first, second) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let truth = serde_json::from_slice::<Truth>(first).unwrap_or_default();
    let plan = serde_json::from_slice::<CampaignPlan>(second).unwrap_or(CampaignPlan {
        sample_rate_hz: 1e3,
        loop_hz: 50.0,
        loop_periods: 1.0,
        sweep_s: 0.05,
        sweep_start_hz: 20.0,
        sweep_end_hz: 100.0,
        validation_hz: Vec::new(),
        ..CampaignPlan::default()
    });
    let longest = (plan.loop_periods / plan.loop_hz).max(plan.sweep_s) * plan.sample_rate_hz;
    // What is long takes its time, as asked.
    if longest > 1e5 || plan.validation_hz.len() > 3 {
        return;
    }
    let Ok(drives) = plan.drives(1) else { return };
    for (_, drive) in drives.iter().filter(|(_, drive)| drive.samples_v.len() <= PLAYED).take(3) {
        if let Ok(run) = measure(&truth, drive, 1, 0) {
            let samples = run.record.channels.iter().flat_map(|channel| &channel.samples);
            assert!(samples.chain(&run.y_true_um).all(|y| y.is_finite()), "a record that is not finite");
        }
    }
}

pub fn drive(data: &[u8]) {
    if let Ok(drive) = serde_json::from_slice::<ExcitationSpec>(data)
        && drive.waveform.duration_s() * drive.sample_rate_hz < 1e5
        && (drive.soft_start_s + drive.soft_end_s) * drive.sample_rate_hz < 1e5
        && let Ok(made) = drive.generate()
    {
        assert!(made.samples_v.iter().all(|u| u.is_finite()), "a drive that is not finite");
        let (low, high) = made.range_v();
        assert!(low >= drive.low_v && high <= drive.high_v, "beyond the amplifier: {low} to {high} V");
    }
}

/// The searches of a fit that is small enough to be done again and again.
pub fn checkpoint(data: &[u8]) {
    let Ok(searches) = serde_json::from_slice::<Searches>(data) else { return };
    let text = serde_json::to_string(&searches).expect("what was read is written");
    assert!(serde_json::from_str::<Searches>(&text).is_ok(), "what was written is refused");
    let options = Options {
        dynamics: DynamicsChoice::None,
        degree: Choice::Given(1),
        algorithm: Some(Algorithm::DeAbc(DeAbcOptions::default())),
        generations: 2,
        threads: Some(1),
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
