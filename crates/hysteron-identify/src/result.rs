//! Results of an identification.

use super::engine::Search;
use super::joint::{Covariance, InterSampleChoice, OutputUncertainty, PredictionBand, Smoothing};
use super::options::{Method, RecordRole};
use super::parameter::Parameter;
use super::searches::Searches;
use super::sines::SineResponse;
use super::structure::FamilySelection;
use hysteron_model::Finding;
use hysteron_model::Start;
use hysteron_model::dynamics::Creep;
use hysteron_model::hammerstein::Model;
use hysteron_model::model::{Score, Simulation};
use hysteron_model::record::{InputOutput, MeasurementRun, RunPart};
use hysteron_model::validate::{OffsetTreatment, ScoreError, Scores, Scoring, score};
use hysteron_optimize::Bounds;
use std::ops::Range;

/// An identified model and everything a report needs about it.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Method of the identification; a campaign without dynamics is one joint fit.
    pub method: Method,
    /// The model.
    pub model: Model,
    /// Its parameters by name, with standard errors.
    pub parameters: Vec<Parameter>,
    /// Correlations of the parameters of each step, except where the records do not determine them.
    pub correlations: Vec<Correlation>,
    /// The main searches, in order (the small fits that choose start and degree are not among them).
    pub searches: Vec<Search>,
    /// Search box of each of them.
    pub bounds: Vec<Bounds>,
    /// Fit of every record.
    pub records: Vec<RecordFit>,
    /// Each run as a whole where records continue one another; `records` are then its parts.
    pub runs: Vec<RecordFit>,
    /// Choice of the structure.
    pub structure: StructureChoice,
    /// Covariance of the parameters of a joint fit, in the article's symbols; `None` where the records do not
    /// determine them, and for two steps.
    pub covariance: Option<Covariance>,
    /// Covariance of the model's own numbers, named as a model file names them; `None` where the records do
    /// not determine them, and for two steps, which give no cross-covariance.
    pub of_numbers: Option<Covariance>,
    /// Bands of the output for any drive; `None` where `covariance` is.
    pub output_uncertainty: Option<OutputUncertainty>,
    /// Thinning while searching; `None` where every sample was used throughout.
    pub reduction: Option<Reduction>,
    /// Verdicts, warnings and advice in plain words.
    pub findings: Vec<Finding>,
    /// Treatment of the data, in plain words.
    pub treatment: Vec<String>,
    /// Lowest and highest frequency of the drives \[Hz\]; `None` where no record has a sample rate.
    pub excited_hz: Option<(f64, f64)>,
    /// The search was stopped early; the model is the best so far.
    pub cancelled: bool,
    /// State to resume from.
    pub resume: Searches,
}

/// Correlation of the estimates of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlation {
    /// Name of the step.
    pub step: String,
    /// Parameters, as on the command line.
    pub names: Vec<String>,
    /// Their correlation coefficients, row by row; 1 on the diagonal.
    pub matrix: Vec<Vec<f64>>,
    /// Largest over smallest eigenvalue of the matrix: 1 where every parameter is determined on its own.
    pub condition_number: f64,
}

/// Thinning of oversampled records while searching. The estimates returned come from all samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Samples of all records.
    pub samples: usize,
    /// Samples the search worked on.
    pub searched: usize,
    /// Samples of the last fit: fewer than all where a long record is far oversampled, low-passed and thinned to
    /// 60 or more a swing of the drive.
    pub fitted: usize,
    /// Largest change of a parameter from the reduced to the whole records, in standard errors.
    pub moved: f64,
}

impl Reduction {
    /// Changes up to this many standard errors are negligible.
    pub const SMALL: f64 = 0.1;

    /// Samples of the search and the change by the fit of all samples, in a sentence or two.
    pub fn describe(&self) -> String {
        let Self { samples, searched, fitted, moved } = self;
        let change = if *moved <= Self::SMALL {
            format!("moved no parameter by more than {moved:.2} standard errors.")
        } else {
            format!(
                "moved a parameter by {moved:.2} standard errors, because of data removed by thinning (fast \
                 motion, the ends of the records) or of the scheme. Profile intervals take location and \
                 scale from all samples, shape from the thinned ones."
            )
        };
        let thinned = if fitted < samples {
            format!(" (low-passed and thinned to {fitted}, at least 60 a swing of the drive)")
        } else {
            String::new()
        };
        format!(
            "The search worked on {searched} of {samples} samples, low-passed and thinned where a record was \
             oversampled. The estimates come from a last fit of all samples{thinned}, which {change}"
        )
    }
}

/// One record and the model's simulation of it.
#[derive(Clone, Debug)]
pub struct RecordFit {
    /// The record.
    pub data: InputOutput,
    /// Its use.
    pub role: RecordRole,
    /// Start assumed.
    pub start: Start,
    /// Scores (simulation, offset estimated).
    pub scores: Scores,
    /// Simulated output, with the model's own offset \[output unit\]; NaN where a stopped fit was not
    /// simulated.
    pub simulated: Vec<f64>,
    /// Uncertainty of the simulated output from that of the parameters; a joint fit only.
    pub band: Option<PredictionBand>,
    /// Gain and phase at its sine segments, if any; those of the model with standard errors in a joint fit.
    pub sines: Vec<SineResponse>,
}

impl RecordFit {
    /// Splits the fit of a run into those of its parts, with the offset of the run.
    pub(super) fn in_parts(&self, run: &MeasurementRun) -> Result<Vec<Self>, ScoreError> {
        let fixed = Scoring { offset: OffsetTreatment::Fixed, ..Scoring::default() };
        let part = |(index, part): (usize, &RunPart)| {
            let simulated: Vec<f64> =
                self.simulated[part.samples.clone()].iter().map(|y| y + self.scores.offset).collect();
            Ok(Self {
                role: self.role,
                start: if index == 0 { self.start } else { Start::AsIdentified },
                scores: score(&part.data, &simulated, &fixed)?,
                band: self.band.as_ref().map(|band| band.part(part.samples.clone())),
                sines: sines_in(&self.sines, &part.samples),
                data: part.data.clone(),
                simulated,
            })
        };
        run.parts.iter().enumerate().map(part).collect()
    }

    /// Scores of the record, simulated from the fitted start.
    pub fn score(&self) -> Score {
        let simulation = Simulation::of_single(self.simulated.clone(), self.start, self.data.u_unit.clone());
        Score::of_single(&self.data, self.data.y_unit.clone(), self.scores.clone(), simulation)
    }

    /// Fit \[%\]; 0 where it is not defined.
    pub(super) fn fit_percent(&self) -> f64 {
        self.scores.fit_percent.unwrap_or(0.0)
    }
}

/// Sines within a part of the record, with samples counted from its beginning.
fn sines_in(sines: &[SineResponse], part: &Range<usize>) -> Vec<SineResponse> {
    let within = |sine: &&SineResponse| part.start <= sine.samples.start && sine.samples.end <= part.end;
    let moved = |sine: &SineResponse| SineResponse {
        samples: sine.samples.start - part.start..sine.samples.end - part.start,
        ..sine.clone()
    };
    sines.iter().filter(within).map(moved).collect()
}

/// One polynomial degree that was fitted to choose among.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DegreeTried {
    /// Degree.
    pub degree: usize,
    /// RMSE of its fit \[output unit\].
    pub rmse: f64,
    /// Bayesian information criterion of its fit, over the independent samples.
    pub bic: f64,
    /// The options name one of its coefficients, so that no lower degree may be used.
    pub is_demanded: bool,
    /// Its hysteresis is bounded; one that is not takes no other's place.
    pub is_bounded: bool,
}

/// Record of the choice of structure.
#[derive(Clone, Debug, PartialEq)]
pub struct StructureChoice {
    /// Polynomial degrees tried, ascending; empty where the degree was given.
    pub degrees: Vec<DegreeTried>,
    /// Degree used.
    pub degree: usize,
    /// Creep factor of the dynamics.
    pub creep: Creep,
    /// Delay or lag were searched together with the hysteresis, from a start from rest.
    pub delay_and_lag_from_start: bool,
    /// Slow creep allowed for in each quasi-static record \[output unit per e-fold of 1 s + t\].
    pub creeps: Vec<f64>,
    /// Samples left out at the start of each quasi-static record.
    pub left_out: Vec<usize>,
    /// Roughness penalty on the weights of a plane.
    pub smoothing: Option<Smoothing>,
    /// Choice of the inter-sample rule, where the records discriminate.
    pub between: Option<InterSampleChoice>,
    /// Choice of the hysteresis family, where it was asked for.
    pub family: Option<FamilySelection>,
}
