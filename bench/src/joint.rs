//! The joint fit's problem on records from files, for a peer that solves the same, and timed on records of
//! many lengths.

use std::hint::black_box;
use std::path::PathBuf;

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, JointObjective, Options, RecordRole};
use hysteron_model::Start;
use hysteron_model::hysteresis::{Sensitivities, UnitShape};
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_optimize::{LeastSquaresProblem, Problem};
use rayon::ThreadPoolBuilder;
use serde::Deserialize;

use crate::answer::{Answer, JointProblem, JointTimes};
use crate::error::BenchError;
use crate::stopwatch::time;
use crate::{signal_file, synthetic};

/// The problem of the records in a directory: `loop_u`, `loop_y`, `sweep_u`, `sweep_y`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProblemRequest {
    directory: PathBuf,
    sample_rate_hz: f64,
    degree: usize,
    /// On thinned records.
    reduced: bool,
}

impl ProblemRequest {
    fn objective(&self) -> Result<JointObjective, BenchError> {
        let mut campaign = Vec::new();
        for (name, role) in [("loop", RecordRole::QuasiStatic), ("sweep", RecordRole::Dynamic)] {
            let read = |channel: &str| signal_file::read(&self.directory.join(format!("{name}_{channel}")));
            let data =
                InputOutput::new(name, TimeBase::uniform(self.sample_rate_hz), read("u")?, read("y")?)?;
            campaign.push(CampaignRecord { data, role: Some(role) });
        }
        let options = Options {
            dynamics: DynamicsChoice::Fractional,
            degree: Choice::Given(self.degree),
            ..Options::default()
        };
        Ok(JointObjective::new(&campaign, &options, self.reduced)?)
    }

    /// Box, starts and weights.
    pub fn describe(&self) -> Result<Answer, BenchError> {
        let objective = self.objective()?;
        let weights: Vec<&[f64]> =
            (0..).map(|r| objective.weights(r)).take_while(|w| !w.is_empty()).collect();
        Ok(Answer::JointProblem(JointProblem {
            ranges: objective.bounds().ranges.clone(),
            starts: objective.starts().to_vec(),
            samples: weights.iter().map(|w| w.len()).collect(),
            // A reduced record begins and ends with samples that do not count.
            weights: weights.iter().map(|w| w.iter().copied().fold(0.0, f64::max)).collect(),
        }))
    }
}

/// Cost at a point.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CostRequest {
    problem: ProblemRequest,
    x: Vec<f64>,
}

impl CostRequest {
    /// Root mean square of the weighted residuals.
    pub fn run(&self) -> Result<Answer, BenchError> {
        let objective = self.problem.objective()?;
        Ok(Answer::Cost { cost: objective.cost(&self.x, &mut objective.workspace()) })
    }
}

/// Evaluations on made records.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimesRequest {
    /// Samples of each record.
    samples: usize,
    records: usize,
    threads: Vec<usize>,
    repetitions: usize,
    /// Whether the Jacobian is worked out, which needs a dozen numbers a sample.
    jacobian: bool,
}

impl TimesRequest {
    /// Takes turns on objective and Jacobian for each number of threads.
    pub fn run(&self) -> Result<Answer, BenchError> {
        let (objective, mut x) =
            synthetic::objective(self.samples, self.records).map_err(BenchError::Synthetic)?;
        let count = objective.residual_count();
        let mut ws = objective.workspace();
        let mut columns = vec![0.0; if self.jacobian { count * x.len() } else { 0 }];
        let mut answer = Vec::new();
        for &threads in &self.threads {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
            let (mut seconds, mut jacobian_s) = (f64::INFINITY, f64::INFINITY);
            let mut allocations = 0;
            for _ in 0..self.repetitions {
                synthetic::move_on(&mut x);
                let timing = pool.install(|| {
                    time::<BenchError>(1, || {
                        black_box(objective.cost(black_box(&x), &mut ws));
                        Ok(())
                    })
                })?;
                seconds = timing.seconds.iter().copied().fold(seconds, f64::min);
                allocations += timing.allocations;
                if self.jacobian {
                    synthetic::move_on(&mut x);
                    let timing = pool.install(|| {
                        time::<BenchError>(1, || {
                            black_box(objective.jacobian(black_box(&x), &mut ws, &mut columns));
                            Ok(())
                        })
                    })?;
                    jacobian_s = timing.seconds.iter().copied().fold(jacobian_s, f64::min);
                }
            }
            let jacobian_s = self.jacobian.then_some(jacobian_s);
            answer.push(JointTimes { threads, objective_s: seconds, jacobian_s, allocations });
        }
        Ok(Answer::JointTimes { times: answer, hysteresis_s: self.hysteresis()? })
    }

    /// The pass of the hysteresis with its derivatives over one record at its own rate.
    fn hysteresis(&self) -> Result<f64, BenchError> {
        let u = synthetic::drive(self.samples, 0);
        let shape = UnitShape { beta: synthetic::BETA, gamma: synthetic::GAMMA, n: 1.0 };
        let mut out = Sensitivities::default();
        let timing = time(self.repetitions.max(2), || {
            let start = Start::Rest { voltage_v: 0.0 };
            black_box(shape).simulate_with_sensitivities(1, &u, start, false, &mut out).map(|_| ())
        })?;
        Ok(timing.seconds.into_iter().fold(f64::INFINITY, f64::min))
    }
}
