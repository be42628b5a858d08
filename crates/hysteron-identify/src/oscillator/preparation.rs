//! Preparation of the records for the fit: one period in steady state, or the record as it is.

use super::super::RecordFacts;
use super::super::campaign::usable;
use super::super::options::{CampaignRecord, Initial};
use super::Options;
use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::hysteresis::RecordEnds;
use hysteron_model::record::{InputOutput, Periods};

/// Largest deviation of all periods together from whole numbers of samples \[samples\].
const WHOLE: f64 = 0.1;

/// A record as the fit uses it.
#[derive(Clone, Debug)]
pub(super) struct PreparedRecord {
    pub name: String,
    pub u: Vec<f64>,
    /// Measured output; of a periodic record the mean over the settled periods.
    pub y: Vec<f64>,
    /// True for scored samples.
    pub scored: Vec<bool>,
    pub rate: f64,
    /// Assumed start; with `Remembering` the state at the first sample is searched.
    pub start: Start<()>,
    /// Periods averaged.
    pub periods: usize,
    /// Samples before those, in which the displacement still settles.
    pub settling: usize,
}

impl PreparedRecord {
    pub(super) fn start_is_free(&self) -> bool {
        matches!(self.start, Start::Remembering { .. })
    }

    pub(super) fn ends(&self) -> RecordEnds {
        match self.start {
            Start::Settled { .. } => RecordEnds::Periodic,
            Start::AsIdentified | Start::Rest { .. } | Start::Remembering { .. } => RecordEnds::Open,
        }
    }
}

/// The prepared records, in their order.
pub(super) fn pieces(
    records: &[InputOutput],
    options: &Options,
) -> Result<Vec<PreparedRecord>, IdentifyError> {
    let campaign: Vec<CampaignRecord> =
        records.iter().map(|data| CampaignRecord { data: data.clone(), role: None }).collect();
    usable(&campaign)?.iter().map(|facts| piece(facts, options.initial)).collect()
}

fn piece(facts: &RecordFacts, initial: Initial) -> Result<PreparedRecord, IdentifyError> {
    let data = &facts.data;
    let rate = data
        .sample_rate_hz()
        .ok_or_else(|| IdentifyError::OscillatorNotUniform { record: data.name.clone() })?;
    let whole = |start: Start<()>| PreparedRecord {
        name: data.name.clone(),
        u: data.u.clone(),
        y: data.y.clone(),
        scored: data.valid.clone().unwrap_or_else(|| vec![true; data.len()]),
        rate,
        start,
        periods: 1,
        settling: 0,
    };
    Ok(match (initial, repeating(facts.periods, &data.y)) {
        (Initial::Rest | Initial::Zero, _) | (Initial::Auto, None) => whole(Start::AsIdentified),
        (Initial::Free, _) => whole(Start::Remembering { voltage_v: 0.0, memory: () }),
        (Initial::Periodic, None) => whole(Start::PERIODIC),
        (Initial::Auto | Initial::Periodic, Some((samples, settling, count))) => {
            mean_period(data, rate, samples, settling, count)
        }
    })
}

/// Samples of a period, number of settling periods and of all periods, for a record that repeats from its
/// first sample on.
fn repeating(periods: Option<Periods>, y: &[f64]) -> Option<(usize, usize, usize)> {
    let p = periods.filter(|p| p.start == 0 && p.count >= 2)?;
    let samples = p.period_samples.round();
    let off = (p.period_samples - samples).abs() * p.count as f64;
    (off <= WHOLE).then_some((samples as usize, p.settling_before_mean(y), p.count))
}

/// The mean over the settled periods, a sufficient statistic for a steady state under white noise.
fn mean_period(
    data: &InputOutput,
    rate: f64,
    samples: usize,
    settling: usize,
    count: usize,
) -> PreparedRecord {
    let valid = |k: usize| data.is_valid(k);
    let mut piece = PreparedRecord {
        name: data.name.clone(),
        u: data.u.iter().take(samples).copied().collect(),
        y: Vec::with_capacity(samples),
        scored: Vec::with_capacity(samples),
        rate,
        start: Start::PERIODIC,
        periods: count - settling,
        settling: settling * samples,
    };
    for k in 0..samples {
        let places = (settling..count).map(|p| p * samples + k).filter(|&i| i < data.len());
        let all: Vec<usize> = places.clone().filter(|&i| valid(i)).collect();
        let shown = if all.is_empty() { places.collect() } else { all.clone() };
        piece.y.push(shown.iter().map(|&i| data.y[i]).sum::<f64>() / shown.len().max(1) as f64);
        piece.scored.push(!all.is_empty());
    }
    piece
}
