//! What a user can ask of an identification.

use super::IdentifyError;
use super::layout::Demands;
use crate::dynamics::Scheme;
use crate::hammerstein::Model;
use crate::optimize::Algorithm;
use crate::record::InputOutput;

/// A record of the campaign and what it is for.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignRecord {
    /// Input and output.
    pub data: InputOutput,
    /// Role, if the user gave one; otherwise it is recognised.
    pub role: Option<RecordRole>,
}

/// What a record is used for in the two-step identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordRole {
    /// Step 1: hysteresis block.
    QuasiStatic,
    /// Step 2: dynamic block.
    Dynamic,
}

/// Dynamic block asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum DynamicsChoice {
    /// What the records support: fractional with a dynamic record, a first-order lag with a start from rest, else none.
    #[default]
    Auto,
    /// Static model.
    None,
    /// Orders 2, 1, 0.
    Integer,
    /// Autoregressive.
    Arx,
    /// Real orders, Eq. 13.
    Fractional,
}

/// A value that is given or chosen from the data.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Choice<T> {
    /// Chosen from the data.
    #[default]
    Auto,
    /// Given.
    Given(T),
}

/// Options of an identification; the defaults are meant to be right.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Dynamic block.
    pub dynamics: DynamicsChoice,
    /// Optimiser; `None`: least squares from data-driven starts, with the linear parameters eliminated.
    pub algorithm: Option<Algorithm>,
    /// Generations of a population method.
    pub generations: usize,
    /// Seed of every random number.
    pub seed: u64,
    /// Threads; `None`: all cores. The result does not depend on it.
    pub threads: Option<usize>,
    /// Polynomial degree of l\[u\].
    pub degree: Choice<usize>,
    /// Bouc–Wen exponent n; `Auto` searches it (`--n free`).
    pub n: Choice<f64>,
    /// Delay \[s\]. A given delay is taken as the whole time shift between input and output: unless dynamics are asked
    /// for, no lag is fitted beside it to a quasi-static record.
    pub delay_s: Choice<f64>,
    /// Single parameters fixed or bounded.
    pub demands: Demands,
    /// Model whose parameters are the first start of every search.
    pub start: Option<Model>,
    /// Simulation scheme of the dynamic block.
    pub scheme: Scheme,
    /// Least fit \[%\] for which a model is handed out at all.
    pub least_fit_percent: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            dynamics: DynamicsChoice::Auto,
            algorithm: None,
            generations: 150,
            seed: 1,
            threads: None,
            degree: Choice::Auto,
            n: Choice::Given(1.0),
            delay_s: Choice::Auto,
            demands: Demands::default(),
            start: None,
            scheme: Scheme::Tustin,
            least_fit_percent: 75.0,
        }
    }
}

/// Highest polynomial degree offered.
pub const HIGHEST_DEGREE: usize = 9;

impl Options {
    pub(super) fn validate(&self) -> Result<(), IdentifyError> {
        let refuse = |option, value, wanted| Err(IdentifyError::Option { option, value, wanted });
        if let Choice::Given(degree) = self.degree
            && !(1..=HIGHEST_DEGREE).contains(&degree)
        {
            return refuse("degree", degree as f64, "a whole number from 1 to 9");
        }
        if let Choice::Given(n) = self.n
            && !(1.0..=10.0).contains(&n)
        {
            return refuse("n", n, "1 ≤ n ≤ 10");
        }
        if let Choice::Given(delay) = self.delay_s
            && !(0.0..=10.0).contains(&delay)
        {
            return refuse("delay", delay, "0 to 10 seconds");
        }
        Ok(())
    }
}
