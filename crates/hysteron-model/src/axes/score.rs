//! Scores of several outputs.

use super::{AxesError, AxesRecord, SteadyPeriod, remove_means};
use crate::record::InputOutput;
use crate::validate::{Scores, Scoring, score, scored_variance};

/// Agreement of a simulation with a record, output by output and pooled.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesScores {
    /// Scores of each output.
    pub outputs: Vec<Scores>,
    /// √(mean e²) over all samples of all outputs.
    pub rmse: f64,
    /// Largest \|e\| of all.
    pub max_abs_error: f64,
    /// 100 · (1 − ‖e‖/‖y − ȳ‖) over all outputs, each about its own mean \[%\]; `None` for a constant record.
    pub fit_percent: Option<f64>,
    /// √(mean e²) of the mean period against the first simulated one, means removed, where the record
    /// repeats.
    pub mean_period_rmse: Option<f64>,
}

impl AxesScores {
    /// Scores simulated outputs (one list per output) against a record; `period`: its mean period, where it
    /// repeats.
    ///
    /// # Errors
    /// [`AxesError`].
    pub fn new(
        record: &AxesRecord,
        simulated: &[Vec<f64>],
        scoring: &Scoring,
        period: Option<&SteadyPeriod>,
    ) -> Result<Self, AxesError> {
        if record.y.is_empty() || record.y.len() != simulated.len() {
            return Err(AxesError::Outputs { measured: record.y.len(), simulated: simulated.len() });
        }
        let mut outputs = Vec::with_capacity(simulated.len());
        let (mut squares, mut variance) = (0.0, 0.0);
        for (y, simulated) in record.y.iter().zip(simulated) {
            let u = record.u.first().cloned().unwrap_or_default();
            let mut data = InputOutput::new(&record.name, record.time.clone(), u, y.clone())?;
            data.valid = record.valid.clone();
            let scores = score(&data, simulated, scoring)?;
            squares += scores.rmse.powi(2);
            variance += scored_variance(&data, scoring)?;
            outputs.push(scores);
        }
        let count = outputs.len() as f64;
        let mean_period_rmse = period.map(|period| {
            let mut e: Vec<f64> = (0..period.samples())
                .flat_map(|k| simulated.iter().map(move |y| y.get(k).copied().unwrap_or(0.0)))
                .zip(&period.y)
                .map(|(simulated, y)| y - simulated)
                .collect();
            remove_means(&mut e, period.outputs);
            (e.iter().map(|e| e * e).sum::<f64>() / e.len().max(1) as f64).sqrt()
        });
        Ok(Self {
            rmse: (squares / count).sqrt(),
            max_abs_error: outputs.iter().fold(0.0, |most, s| most.max(s.max_abs_error)),
            fit_percent: (variance > 0.0).then(|| 100.0 * (1.0 - (squares / variance).sqrt())),
            mean_period_rmse,
            outputs,
        })
    }
}
