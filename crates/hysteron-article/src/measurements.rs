//! The article's experiments, measured on the simulated bench.

use super::plan::{SLOW_HZ, TABLE3_HZ};
use super::progress::{Stage, Stages};
use super::{ArticleError, Plan};
use hysteron_model::record::{ChannelChoice, InputOutput, TimeBase};
use hysteron_rig::{CampaignRun, RigRun, Role, Truth, run_campaign};

/// The records of the campaign.
pub(super) struct Measurements {
    /// One-line description of the plant.
    pub(super) plant: String,
    /// 1 Hz loop at the full rate.
    pub(super) slowest: InputOutput,
    /// 1 Hz loop, every [`Plan::loop_decimation`]-th sample, for identification of the static block.
    pub(super) loop_1hz: InputOutput,
    /// 1–100 Hz sweep.
    pub(super) sweep: InputOutput,
    /// Sines: frequency \[Hz\] and record.
    pub(super) sines: Vec<(f64, InputOutput)>,
}

impl Measurements {
    pub(super) fn take(plan: &Plan, stages: &Stages<'_, '_>) -> Result<Self, ArticleError> {
        stages.check(Stage::Bench, 0.0, "")?;
        let truth = Truth::default();
        let runs = run_campaign(&truth, &plan.campaign(), plan.seed)?;
        let mut sines = Vec::new();
        let (mut slowest, mut sweep) = (None, None);
        for CampaignRun { role, run } in &runs {
            match role {
                Role::QuasiStatic => slowest = Some(record(run, 1)?),
                Role::Sweep => sweep = Some(record(run, 1)?),
                Role::Validation { frequency_hz } => sines.push((*frequency_hz, record(run, 1)?)),
                Role::Tracking | Role::NestedLoops => {}
            }
        }
        let missing = || ArticleError::Plan {
            setting: "campaign",
            value: runs.len() as f64,
            wanted: "a loop and a sweep",
        };
        let (slowest, sweep) = (slowest.ok_or_else(missing)?, sweep.ok_or_else(missing)?);
        let loop_1hz = every(&slowest, plan.loop_decimation)?;
        stages.check(Stage::Bench, 1.0, "")?;
        Ok(Self { plant: truth.describe(), slowest, loop_1hz, sweep, sines })
    }

    /// Sines of Table 3.
    pub(super) fn table3(&self) -> impl Iterator<Item = &(f64, InputOutput)> {
        self.sines.iter().filter(|(f, _)| TABLE3_HZ.contains(f))
    }

    /// Frequency and record of every loop, 1 Hz first.
    pub(super) fn loops(&self) -> impl Iterator<Item = (f64, &InputOutput)> {
        debug_assert!(SLOW_HZ.iter().all(|f| self.sines.iter().any(|(g, _)| f == g)));
        std::iter::once((1.0, &self.slowest)).chain(self.sines.iter().map(|(f, record)| (*f, record)))
    }
}

/// A run of the bench as input and output, every `step`-th sample (picked, not filtered: the noise stays
/// white).
pub(super) fn record(run: &RigRun, step: usize) -> Result<InputOutput, ArticleError> {
    every(&run.record.input_output(&ChannelChoice::default())?, step)
}

fn every(record: &InputOutput, step: usize) -> Result<InputOutput, ArticleError> {
    let rate = record.require_sample_rate_hz("the reproduction of the article")?;
    let pick = |x: &[f64]| x.iter().step_by(step).copied().collect::<Vec<f64>>();
    Ok(InputOutput::new(
        &record.name,
        TimeBase::uniform(rate / step as f64),
        pick(&record.u),
        pick(&record.y),
    )?)
}
