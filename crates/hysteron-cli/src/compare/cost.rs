//! What each candidate costs a controller, and whether its hysteresis has an inverse.

use hysteron_identify::CampaignRecord;
use hysteron_identify::structure::Comparison;
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{Invertibility, TimedDrive};
use hysteron_model::realise::{Cost, RealiseOptions, side_by_side};

/// Samples of the drive that is timed, and passes of the clock over all candidates.
const SAMPLES: usize = 10_000;
const ROUNDS: usize = 15;

/// Of one candidate; `None` where it was not fitted.
#[derive(Clone, Debug, Default)]
pub struct CandidateCost {
    pub cost: Option<Cost>,
    /// Why there is none.
    pub why_not: Option<String>,
    pub inverse: Option<Invertibility>,
}

/// Costs and inverses in the order of the entries.
pub fn costs(comparison: &Comparison, campaign: &[CampaignRecord]) -> Vec<CandidateCost> {
    let models: Vec<Option<&Model>> = comparison.entries.iter().map(|e| e.model.as_ref()).collect();
    let fitted: Vec<&Model> = models.iter().copied().flatten().collect();
    let rate = |record: &CampaignRecord| record.data.sample_rate_hz();
    // The fastest record is timed: the one that a controller at its rate would see.
    let record = campaign.iter().max_by(|a, b| rate(a).unwrap_or(0.0).total_cmp(&rate(b).unwrap_or(0.0)));
    let Some(record) = record else { return vec![CandidateCost::default(); models.len()] };
    let sample_rate_hz = rate(record).unwrap_or(1.0);
    let drive = record.data.u.get(..SAMPLES).unwrap_or(&record.data.u);
    // What creeps for ever is realised down to a hundredth of the frequency whose period is the longest record.
    let seconds = campaign.iter().filter_map(|r| Some(r.data.u.len() as f64 / rate(r)?)).fold(0.0, f64::max);
    let lowest_frequency_hz = (seconds > 0.0).then(|| 0.01 / seconds);
    let options = RealiseOptions { lowest_frequency_hz, ..RealiseOptions::default() };
    let mut costs = side_by_side(&fitted, sample_rate_hz, &options, drive, ROUNDS).into_iter();
    let drives: Vec<TimedDrive<'_>> =
        campaign.iter().map(|r| (r.data.u.as_slice(), rate(r).map(|rate| 1.0 / rate))).collect();
    models
        .into_iter()
        .map(|model| {
            let Some(model) = model else { return CandidateCost::default() };
            let (cost, why_not) = match costs.next() {
                Some(Ok(cost)) => (Some(cost), None),
                Some(Err(error)) => (None, Some(error.to_string())),
                None => (None, None),
            };
            CandidateCost { cost, why_not, inverse: model.hysteresis.invertibility(&drives).ok() }
        })
        .collect()
}
