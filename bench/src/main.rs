//! The Rust side of `make bench`: does what `bench/bench.py` asks for on standard input, one line of JSON a
//! request, and answers with one line of JSON. That way both sides take turns on the same inputs within one
//! run.

mod allocations;
mod answer;
mod bouc_wen;
mod columns;
mod error;
mod fractional;
mod identification;
mod joint;
mod signal_file;
mod stopwatch;
mod synthetic;

use std::io::{BufRead, Write, stdin, stdout};
use std::path::PathBuf;
use std::process::ExitCode;

use answer::Answer;
use error::BenchError;
use fractional::Fractional;
use serde::Deserialize;

/// What can be asked for.
#[derive(Debug, Deserialize)]
#[serde(tag = "task", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Plans the simulation of Eq. 13 over the input in a file.
    PlanFractional { input: PathBuf, scheme: String },
    /// Simulates: both transforms.
    Simulate { repetitions: usize },
    /// Simulates with the input transformed before.
    Candidate { repetitions: usize },
    /// Writes the output of the last simulation.
    WriteOutput { path: PathBuf },
    /// Works out columns of a fit and their derivatives.
    Columns(columns::Request),
    /// Simulates the Bouc–Wen operator.
    BoucWen(bouc_wen::Request),
    /// Plays the article's campaign on the simulated bench and writes its records.
    Campaign { directory: PathBuf, seed: u64 },
    /// Identifies from the records of a campaign.
    Identify(identification::Request),
    /// Describes the problem of a joint fit.
    JointProblem(joint::ProblemRequest),
    /// Its cost at a point.
    JointCost(joint::CostRequest),
    /// Times evaluations of joint fits of any size.
    JointTimes(joint::TimesRequest),
}

fn serve(request: Request, fractional: &mut Option<Fractional>) -> Result<Answer, BenchError> {
    match request {
        Request::PlanFractional { input, scheme } => {
            let plan = Fractional::new(signal_file::read(&input)?, &scheme)?;
            let answer = plan.answer();
            *fractional = Some(plan);
            Ok(answer)
        }
        Request::Simulate { repetitions } => planned(fractional)?.simulate(repetitions),
        Request::Candidate { repetitions } => planned(fractional)?.candidate(repetitions),
        Request::WriteOutput { path } => {
            signal_file::write(&path, planned(fractional)?.output())?;
            Ok(Answer::Done)
        }
        Request::Columns(request) => request.run(),
        Request::BoucWen(request) => request.run(),
        Request::Campaign { directory, seed } => identification::write_campaign(&directory, seed),
        Request::Identify(request) => request.run(),
        Request::JointProblem(request) => request.describe(),
        Request::JointCost(request) => request.run(),
        Request::JointTimes(request) => request.run(),
    }
}

fn planned(fractional: &mut Option<Fractional>) -> Result<&mut Fractional, BenchError> {
    fractional.as_mut().ok_or(BenchError::NotPlanned)
}

fn run() -> Result<(), BenchError> {
    let mut fractional = None;
    for line in stdin().lock().lines() {
        let answer = serve(serde_json::from_str(&line?)?, &mut fractional)?;
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer)?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "error: hysteron-bench: {error}");
            ExitCode::FAILURE
        }
    }
}
