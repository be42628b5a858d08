//! Dead band of an amplifier.

use crate::finding::{Finding, FindingKind};

/// Sets a drive to 0 where it is smaller than `threshold`, in its unit; returns a finding with the count.
pub fn beyond_dead_band(u: &mut [f64], threshold: f64) -> Finding {
    let within = u.iter_mut().filter(|u| u.abs() < threshold);
    let count = within.map(|u| *u = 0.0).count();
    let text = format!("the drive of {count} samples is below {threshold} and counts as 0");
    Finding::new(FindingKind::Advice, "dead band", text)
}
