//! Records of a campaign: checks, runs and roles.

use super::options::{CampaignRecord, DynamicsChoice, Options, RecordRole};
use super::{IdentifyError, RecordFacts};
use hysteron_model::record::Unit;
use hysteron_model::record::{InputOutput, MeasurementRun};
use rayon::prelude::*;

/// Fewest valid samples of a usable record.
const FEWEST_SAMPLES: usize = 20;

/// The facts of every record.
///
/// # Errors
/// For the first unusable record: another unit, too few samples, a constant signal.
pub(super) fn usable(campaign: &[CampaignRecord]) -> Result<Vec<RecordFacts>, IdentifyError> {
    let first = campaign.first().ok_or(IdentifyError::NoRecords)?;
    let unit = |unit: &Unit| if unit.symbol().is_empty() { "no unit".to_owned() } else { unit.to_string() };
    let units = |r: &CampaignRecord| format!("{} → {}", unit(&r.data.u_unit), unit(&r.data.y_unit));
    let facts: Vec<_> = campaign
        .par_iter()
        .map(|record| {
            if units(record) != units(first) {
                return Err(IdentifyError::Units {
                    record: record.data.name.clone(),
                    found: units(record),
                    expected: units(first),
                });
            }
            let facts = RecordFacts::new(record.data.clone());
            let valid = facts.scored(0).len();
            if valid < FEWEST_SAMPLES {
                let record = record.data.name.clone();
                return Err(IdentifyError::TooFewSamples { record, need: FEWEST_SAMPLES, found: valid });
            }
            for (signal, samples) in [("input", &record.data.u), ("output", &record.data.y)] {
                if samples.iter().all(|&x| x == samples[0]) {
                    let record = record.data.name.clone();
                    return Err(IdentifyError::Constant { record, signal, value: samples[0] });
                }
            }
            Ok(facts)
        })
        .collect();
    // The first error in the order of the records, independently of the threads.
    facts.into_iter().collect()
}

/// The records as runs.
pub(super) fn runs(records: &[CampaignRecord]) -> Result<Vec<MeasurementRun>, IdentifyError> {
    let data: Vec<_> = records.iter().map(|record| record.data.clone()).collect();
    Ok(MeasurementRun::of(&data)?)
}

/// The runs as records; each has the role of its first part.
pub(super) fn of_runs(records: &[CampaignRecord], runs: &[MeasurementRun]) -> Vec<CampaignRecord> {
    let mut first = 0;
    runs.iter()
        .map(|run| {
            let role = records.get(first).and_then(|record| record.role);
            first += run.parts.len();
            CampaignRecord { data: run.data.clone(), role }
        })
        .collect()
}

/// Roles as given, else by excitation: the slowest records are quasi-static unless broadband, the others
/// dynamic.
pub(super) fn roles(campaign: &[CampaignRecord], facts: &[RecordFacts]) -> Vec<RecordRole> {
    let slowest = facts.iter().map(RecordFacts::highest_frequency_hz).fold(f64::INFINITY, f64::min);
    campaign
        .iter()
        .zip(facts)
        .map(|(record, facts)| {
            record.role.unwrap_or(if facts.is_dynamic(slowest) || facts.is_broad() {
                RecordRole::Dynamic
            } else {
                RecordRole::QuasiStatic
            })
        })
        .collect()
}

/// Roles of records in an identification, recognised by their drives: the slowest records are quasi-static
/// unless broadband, the others carry dynamics.
pub fn recognised_roles(records: &[InputOutput]) -> Vec<RecordRole> {
    let campaign: Vec<CampaignRecord> =
        records.iter().map(|data| CampaignRecord { data: data.clone(), role: None }).collect();
    let facts: Vec<RecordFacts> = records.iter().map(|data| RecordFacts::new(data.clone())).collect();
    roles(&campaign, &facts)
}

/// The records of one role.
pub(super) fn of_role<'a>(
    facts: &'a [RecordFacts],
    roles: &[RecordRole],
    wanted: RecordRole,
) -> Vec<&'a RecordFacts> {
    facts.iter().zip(roles).filter(|(_, role)| **role == wanted).map(|(facts, _)| facts).collect()
}

/// True if there is a dynamic block to identify from dynamic records.
pub(super) fn has_second_step(roles: &[RecordRole], options: &Options) -> bool {
    roles.contains(&RecordRole::Dynamic) && options.dynamics != DynamicsChoice::None
}

/// Lowest and highest frequency of the drives \[Hz\].
pub(super) fn excited(facts: &[RecordFacts]) -> Option<(f64, f64)> {
    let timed = facts.iter().filter(|f| f.data.sample_rate_hz().is_some() || f.swings.is_some());
    let low = timed.clone().map(|f| f.period_s().recip()).fold(f64::INFINITY, f64::min);
    let high = timed.map(RecordFacts::highest_frequency_hz).fold(0.0, f64::max);
    (low <= high).then_some((low, high))
}
