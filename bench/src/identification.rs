//! The article's identification on records of the simulated bench.

use std::path::{Path, PathBuf};
use std::time::Instant;

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, Method, Options, RecordRole, Watch, identify,
};
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_optimize::{Algorithm, DeAbcOptions, DeOptions};
use hysteron_rig::{CampaignPlan, Role, Truth, run_campaign};
use serde::Deserialize;

use crate::answer::{Answer, Search};
use crate::error::BenchError;
use crate::signal_file;

/// Both records, and what each is for.
const RECORDS: [(&str, RecordRole); 2] = [("loop", RecordRole::QuasiStatic), ("sweep", RecordRole::Dynamic)];

/// An identification of both blocks from the records in a directory.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    directory: PathBuf,
    /// `de-abc`, `de`, or `auto`: the default engine, least squares.
    algorithm: String,
    generations: usize,
    threads: usize,
    seed: u64,
}

/// Plays the quasi-static loop and the sweep on the default bench and writes `loop_u`, `loop_y`, `sweep_u`,
/// `sweep_y`.
pub fn write_campaign(directory: &Path, seed: u64) -> Result<Answer, BenchError> {
    let plan = CampaignPlan { validation_hz: Vec::new(), ..CampaignPlan::default() };
    let runs = run_campaign(&Truth::default(), &plan, seed)?;
    for (name, role) in [("loop", Role::QuasiStatic), ("sweep", Role::Sweep)] {
        let run = runs.iter().find(|run| run.role == role).ok_or(BenchError::NoRecord(name))?;
        for channel in &run.run.record.channels {
            signal_file::write(&directory.join(format!("{name}_{}", channel.name)), &channel.samples)?;
        }
    }
    Ok(Answer::Done)
}

impl Request {
    /// Identifies: degree 2 and n = 1 as in the article, no delay, orders and coefficients at once.
    pub fn run(&self) -> Result<Answer, BenchError> {
        let rate_hz = CampaignPlan::default().sample_rate_hz;
        let mut campaign = Vec::new();
        for (name, role) in RECORDS {
            let read = |channel: &str| signal_file::read(&self.directory.join(format!("{name}_{channel}")));
            let data = InputOutput::new(name, TimeBase::uniform(rate_hz), read("u")?, read("y")?)?;
            campaign.push(CampaignRecord { data, role: Some(role) });
        }
        let algorithm = match self.algorithm.as_str() {
            "de-abc" => Some(Algorithm::DeAbc(DeAbcOptions::default())),
            "de" => Some(Algorithm::De(DeOptions::default())),
            "auto" => None,
            other => return Err(BenchError::Algorithm(other.to_owned())),
        };
        let options = Options {
            method: Method::TwoStep,
            dynamics: DynamicsChoice::Fractional,
            algorithm,
            generations: self.generations,
            threads: Some(self.threads),
            seed: self.seed,
            degree: Choice::Given(2),
            delay_s: Choice::Given(0.0),
            least_fit_percent: 0.0,
            ..Options::default()
        };
        let start = Instant::now();
        let found = identify(&campaign, &options, &Watch::silent(), None)?;
        let seconds = start.elapsed().as_secs_f64();
        let searches = found.searches.iter().map(|search| Search {
            step: search.step.clone(),
            algorithm: search.algorithm.to_owned(),
            evaluations: search.outcome.evaluations,
            generations: search.outcome.generations,
            cost: search.outcome.cost,
        });
        Ok(Answer::Identified {
            seconds,
            searches: searches.collect(),
            // Of every search, the small ones that choose a structure among them.
            evaluations: found
                .resume
                .searches
                .iter()
                .map(|(step, s)| (step.clone(), s.evaluations()))
                .collect(),
            rmse_um: found.records.iter().map(|record| record.scores.rmse).collect(),
            boxes: found
                .bounds
                .iter()
                .map(|b| b.ranges.iter().map(|r| (r.name.clone(), r.low, r.high, r.logarithmic)).collect())
                .collect(),
            starts: found.records.iter().map(|record| format!("{:?}", record.start)).collect(),
            parameters: found.parameters.into_iter().map(|p| (p.name, p.value)).collect(),
        })
    }
}
