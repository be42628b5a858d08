//! Simulation of the Bouc–Wen operator over one drive.

use std::hint::black_box;
use std::path::PathBuf;

use hysteron_model::Start;
use hysteron_model::hysteresis::BoucWen;
use serde::Deserialize;

use crate::answer::Answer;
use crate::error::BenchError;
use crate::signal_file;
use crate::stopwatch::time;

/// v = linear·u − z from rest at 0 V, article Eq. 1.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    input: PathBuf,
    output: PathBuf,
    linear: f64,
    alpha: f64,
    beta: f64,
    gamma: f64,
    n: f64,
    repetitions: usize,
}

impl Request {
    /// Simulates so many times and writes the output.
    pub fn run(&self) -> Result<Answer, BenchError> {
        let u = signal_file::read(&self.input)?;
        let operator = BoucWen::new(vec![self.linear], self.alpha, self.beta, self.gamma, self.n)?;
        let mut v = vec![0.0; u.len()];
        let timing = time(self.repetitions, || {
            black_box(&operator).simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut v).map(|_| ())
        })?;
        signal_file::write(&self.output, &v)?;
        Ok(timing.into())
    }
}
