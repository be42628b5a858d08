//! Files of settings of the bench: its truth and plan, a drive.

use hysteron_rig::excitation::ExcitationSpec;
use hysteron_rig::{CampaignPlan, Truth, measure};

/// Longest drive that is played \[samples\].
const PLAYED: usize = 100;
/// Longest part of a plan, or drive, that is generated \[samples\].
const GENERATED: f64 = 2e3;

/// A truth, then, after a byte 0, a plan; nothing stands for one that is as it is unless said.
pub fn truth_and_plan(data: &[u8]) {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (first, second) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    // What is refused is not played.
    let truth = if first.is_empty() { Ok(Truth::default()) } else { serde_json::from_slice(first) };
    let plan = if second.is_empty() { Ok(short()) } else { serde_json::from_slice(second) };
    let (Ok(truth), Ok(plan)) = (truth, plan) else { return };
    let longest = (plan.loop_periods / plan.loop_hz).max(plan.sweep_s) * plan.sample_rate_hz;
    // What is long takes its time, as asked.
    if longest > GENERATED || plan.validation_hz.len() > 3 {
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

/// A plan that is soon played.
fn short() -> CampaignPlan {
    CampaignPlan {
        sample_rate_hz: 1e3,
        loop_hz: 50.0,
        loop_periods: 1.0,
        sweep_s: 0.05,
        sweep_start_hz: 20.0,
        sweep_end_hz: 100.0,
        validation_hz: Vec::new(),
        ..CampaignPlan::default()
    }
}

pub fn drive(data: &[u8]) {
    if let Ok(drive) = serde_json::from_slice::<ExcitationSpec>(data)
        && drive.waveform.duration_s() * drive.sample_rate_hz < GENERATED
        && (drive.soft_start_s + drive.soft_end_s) * drive.sample_rate_hz < GENERATED
        && let Ok(made) = drive.generate()
    {
        assert!(made.samples_v.iter().all(|u| u.is_finite()), "a drive that is not finite");
        let (low, high) = made.range_v();
        assert!(low >= drive.low_v && high <= drive.high_v, "beyond the amplifier: {low} to {high} V");
    }
}
