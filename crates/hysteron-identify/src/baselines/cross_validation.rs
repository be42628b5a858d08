//! Baselines on the folds of a comparison of structures.

use std::ops::Range;
use std::time::Duration;

use rayon::prelude::*;

use super::{Baseline, BaselineError, Trained, lag_intervals, train};
use crate::structure::Fold;
use crate::watch::{Event, Watch};
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{Scoring, score};
use hysteron_optimize::Stop;

/// Cross-validation of a baseline.
#[derive(Clone, Debug)]
pub struct CrossValidated {
    /// Kind of baseline.
    pub kind: Baseline,
    /// Trained on all records; `None` where that failed.
    pub model: Option<Trained>,
    /// RMSE of the simulation of all records, each with its offset \[output unit\].
    pub training_rmse: Option<f64>,
    /// Held-out simulation RMSE of each fold, trained on the rest \[output unit\].
    pub fold_rmse: Vec<Option<f64>>,
    /// Why an error is missing.
    pub failures: Vec<String>,
    /// Time of all trainings and simulations \[s\], where measured.
    pub seconds: Option<f64>,
}

impl CrossValidated {
    /// Mean of the errors over the folds and its standard error, where there is an error on every fold.
    pub fn error(&self) -> Option<(f64, f64)> {
        let errors: Vec<f64> = self.fold_rmse.iter().copied().collect::<Option<_>>()?;
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let square: f64 = errors.iter().map(|e| (e - mean).powi(2)).sum();
        let std_error = if errors.len() > 1 { (square / (count - 1.0) / count).sqrt() } else { 0.0 };
        Some((mean, std_error))
    }
}

/// Trains `kind` on all `records` and on the training data of every fold, and scores its simulations like
/// candidates of [`crate::structure::compare`]: RMSE with the offset estimated, at the rate of the record.
/// The samples that start a simulation are not scored. The lag intervals tried are set by the drives of all
/// records; everything else by the training data.
///
/// `stop` is checked between trainings; `None` after a stop.
pub fn cross_validate(
    kind: Baseline,
    records: &[InputOutput],
    folds: &[Fold],
    stop: &Stop,
) -> Option<CrossValidated> {
    let mut found = CrossValidated {
        kind,
        model: None,
        training_rmse: None,
        fold_rmse: vec![None; folds.len()],
        failures: Vec::new(),
        seconds: None,
    };
    match lag_intervals(records) {
        Ok(intervals) => {
            let whole = || {
                let trained = train(kind, records, &intervals)?;
                let everything = records.iter().map(|r| (r, std::iter::once(0..r.len()).collect()));
                let rmse = error_on(&trained, everything)?;
                Ok::<_, BaselineFailure>((trained, rmse))
            };
            // Training on all records is one more job in addition to the folds.
            let on_fold = |fold: &Fold| {
                let trained = train(kind, &rest(records, fold), &intervals)?;
                let held = fold.held.iter().map(|(r, ranges)| (&records[*r], ranges.clone()));
                error_on(&trained, held)
            };
            let (whole, errors) = rayon::join(
                || (!stop.is_requested()).then(whole),
                || folds.par_iter().map(|f| (!stop.is_requested()).then(|| on_fold(f))).collect::<Vec<_>>(),
            );
            match whole? {
                Ok((model, rmse)) => (found.model, found.training_rmse) = (Some(model), Some(rmse)),
                Err(why) => found.failures.push(format!("all records: {why}")),
            }
            for (index, error) in errors.into_iter().enumerate() {
                match error? {
                    Ok(error) => found.fold_rmse[index] = Some(error),
                    Err(why) => found.failures.push(format!("without {}: {why}", folds[index].label)),
                }
            }
        }
        Err(why) => found.failures.push(why.to_string()),
    }
    Some(found)
}

/// [`cross_validate`] of every baseline, timed by the clock `now`; those finished before a stop.
pub fn cross_validate_all(
    records: &[InputOutput],
    folds: &[Fold],
    watch: &Watch<'_>,
    now: &dyn Fn() -> Duration,
) -> Vec<CrossValidated> {
    let trained = |(index, kind): (usize, Baseline)| {
        let stage = format!("training {}", kind.name());
        let fraction = index as f64 / Baseline::ALL.len() as f64;
        watch.tell(Event::new(&stage, fraction, None)).is_continue().then_some(())?;
        let began = now();
        let found = cross_validate(kind, records, folds, watch.stop())?;
        Some(CrossValidated { seconds: Some((now() - began).as_secs_f64()), ..found })
    };
    Baseline::ALL.into_iter().enumerate().map_while(trained).collect()
}

/// Reason for a missing error.
#[derive(Debug, thiserror::Error)]
enum BaselineFailure {
    #[error(transparent)]
    Baseline(#[from] BaselineError),
    #[error(transparent)]
    Score(#[from] hysteron_model::validate::ScoreError),
}

/// Root of the mean squared simulated error over these ranges of the records.
fn error_on<'a>(
    trained: &Trained,
    of: impl Iterator<Item = (&'a InputOutput, Vec<Range<usize>>)>,
) -> Result<f64, BaselineFailure> {
    let (mut square, mut samples) = (0.0, 0usize);
    for (record, ranges) in of {
        let simulated = trained.simulate(record)?;
        let scored = masked(record, &ranges, false).without_first(trained.start_samples(record)?);
        let scores = score(&scored, &simulated, &Scoring::default())?;
        square += scores.rmse * scores.rmse * scores.samples as f64;
        samples += scores.samples;
    }
    Ok((square / samples.max(1) as f64).sqrt())
}

/// Training records of a fold: held-out records omitted, held-out parts masked.
fn rest(records: &[InputOutput], fold: &Fold) -> Vec<InputOutput> {
    let left = records.iter().enumerate().filter_map(|(index, record)| {
        match fold.held.iter().find(|(held, _)| *held == index) {
            Some(_) if fold.whole => None,
            Some((_, ranges)) => Some(masked(record, ranges, true)),
            None => Some(record.clone()),
        }
    });
    left.collect()
}

/// The record without the samples in `ranges`, or with them alone.
fn masked(record: &InputOutput, ranges: &[Range<usize>], without: bool) -> InputOutput {
    let mut mask = vec![without; record.len()];
    ranges.iter().for_each(|range| mask[range.clone()].fill(!without));
    if let Some(valid) = &record.valid {
        mask.iter_mut().zip(valid).for_each(|(m, v)| *m &= *v);
    }
    InputOutput { valid: Some(mask), ..record.clone() }
}
