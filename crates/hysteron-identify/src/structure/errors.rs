//! Errors of fits: on the data that they were fitted to, and on those of a fold that was held out.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::super::uncertainty::correlation_time;
use super::candidate::Candidate;
use super::fit::{Campaign, NoFit, WholeFit};
use super::folds::Fold;
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{Scoring, choose_start, rmse};

/// Training error on the whole campaign.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Training {
    pub(super) rmse: f64,
    /// Mean square of residual over noise.
    pub(super) mean_square: f64,
    /// Effective number of independent samples of the residuals.
    pub(super) information: f64,
}

impl Training {
    /// N ln(Σ(e/σ)²/N) over N independent samples.
    pub(super) fn fit(&self, independent: f64) -> f64 {
        independent * self.mean_square.max(f64::MIN_POSITIVE).ln()
    }

    /// [`super::Entry::bic`].
    pub(super) fn bic(&self, independent: f64, parameters: usize) -> f64 {
        self.fit(independent) + parameters as f64 * independent.ln()
    }
}

/// Simulations of all records by a fit to all of them.
pub(super) struct Simulations(Vec<Vec<f64>>);

/// Sum of squares over several records.
#[derive(Default)]
struct Squares {
    sum: f64,
    samples: usize,
}

impl Squares {
    /// With the residuals of a record, its sensor's offset estimated.
    fn add(&mut self, data: &InputOutput, simulated: &[f64]) -> Result<(), NoFit> {
        let own = rmse(data, simulated, &Scoring::default())?;
        self.sum += own.rmse * own.rmse * own.samples as f64;
        self.samples += own.samples;
        Ok(())
    }

    fn rmse(&self) -> Result<f64, NoFit> {
        let error = (self.sum / self.samples.max(1) as f64).sqrt();
        if error.is_finite() {
            Ok(error)
        } else {
            Err(NoFit::Failed("the simulation does not stay finite".into()))
        }
    }
}

impl Campaign<'_> {
    /// Held-out rms error on `fold`, by a fit to the rest.
    pub(super) fn error_on(&self, candidate: Candidate, whole: &WholeFit, fold: &Fold) -> Result<f64, NoFit> {
        let (model, starts) = self.without(candidate, whole, fold)?;
        let mut squares = Squares::default();
        for (record, ranges) in &fold.held {
            let facts = &self.facts[*record];
            let data = left(&facts.data, ranges, false);
            let fitted = starts.iter().find(|(r, _)| r == record).map(|(_, start)| *start);
            let simulated = match fitted {
                Some(start) if !holds_the_start(ranges) => {
                    model.simulate_at_own_rate(&data.u, &data.time, &start)?
                }
                // Only the held-out data determine the memory.
                _ => {
                    let preferred = fitted.unwrap_or_else(|| self.members[*record].fresh_start());
                    let chosen = choose_start(&model, &data, preferred, None, &Scoring::default());
                    chosen.map_err(|e| NoFit::Failed(e.to_string()))?.1
                }
            };
            squares.add(&data, &simulated)?;
        }
        squares.rmse()
    }

    /// Simulates all records by a fit to all of them.
    pub(super) fn simulations(&self, fit: &WholeFit) -> Result<Simulations, NoFit> {
        let simulated = self
            .facts
            .iter()
            .zip(&fit.starts)
            .map(|(facts, start)| fit.model.simulate_at_own_rate(&facts.data.u, &facts.data.time, start));
        Ok(Simulations(simulated.collect::<Result<_, _>>()?))
    }

    /// Error on `fold` of the fit to all records: a fit without the fold can hardly do better.
    pub(super) fn error_within(&self, simulations: &Simulations, fold: &Fold) -> Result<f64, NoFit> {
        let mut squares = Squares::default();
        for (record, ranges) in &fold.held {
            squares.add(&left(&self.facts[*record].data, ranges, false), &simulations.0[*record])?;
        }
        squares.rmse()
    }

    /// Weighted residuals of the whole campaign: RMSE in the output's unit, sum of squares of the residuals
    /// over their noise, and their effective number of independent samples.
    pub(super) fn training(&self, simulations: &Simulations) -> Result<Training, NoFit> {
        let (mut square, mut weighted, mut samples, mut information) = (0.0, 0.0, 0usize, 0.0);
        for (index, (facts, simulated)) in self.facts.iter().zip(&simulations.0).enumerate() {
            let data = &facts.data;
            let offset = rmse(data, simulated, &Scoring::default())?.offset;
            let residual: Vec<f64> =
                facts.scored(0).into_iter().map(|k| data.y[k] - simulated[k] - offset).collect();
            let own = residual.iter().map(|e| e * e).sum::<f64>();
            let noise = self.members[index].noise;
            square += own;
            weighted += own / (noise * noise);
            samples += residual.len();
            information += residual.len() as f64 / correlation_time(&residual);
        }
        let count = samples.max(1) as f64;
        Ok(Training { rmse: (square / count).sqrt(), mean_square: weighted / count, information })
    }
}

/// True if the first sample of a record is held out.
fn holds_the_start(ranges: &[Range<usize>]) -> bool {
    ranges.iter().any(|range| range.start == 0)
}

/// The record with `ranges` masked, or with all but them masked.
pub(super) fn left(data: &InputOutput, ranges: &[Range<usize>], without: bool) -> InputOutput {
    let mut mask = vec![without; data.u.len()];
    for range in ranges {
        mask[range.clone()].fill(!without);
    }
    if let Some(valid) = &data.valid {
        mask.iter_mut().zip(valid).for_each(|(m, v)| *m &= *v);
    }
    InputOutput { valid: Some(mask), ..data.clone() }
}
