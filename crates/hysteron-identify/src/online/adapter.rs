//! Updates the coefficients of a correction sample by sample and monitors the residuals.

use super::correction::{Regressors, Row};
use crate::IdentifyError;
use hysteron_model::record::InputOutput;
use hysteron_rt::{FitMonitor, Misfit, Nlms, Rls, SampleError};

/// Estimator of the coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Estimator<const N: usize> {
    /// Recursive least squares with forgetting.
    LeastSquares(Rls<f64, N>),
    /// Normalised least mean squares.
    Gradient {
        /// The estimator.
        nlms: Nlms<f64, N>,
        /// Standard deviation of a residual where the model fits \[µm\], which normalises the monitor's
        /// residuals.
        deviation_um: f64,
    },
}

/// An estimator and its monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adapter<const N: usize> {
    estimator: Estimator<N>,
    monitor: FitMonitor<f64>,
    reopen: bool,
}

/// Result of one update.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adapted {
    /// One-step prediction of the corrected model \[µm\].
    pub predicted: f64,
    /// Residual in units of its expected deviation.
    pub normalised: f64,
    /// Kind of misfit, on an alarm.
    pub misfit: Option<Misfit>,
}

/// The first sample of an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alarm {
    /// Index of the sample, from 0.
    pub sample: usize,
    /// Kind of misfit.
    pub misfit: Misfit,
}

/// Trajectory of an adapter over a record.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace<const N: usize> {
    /// One-step predictions \[µm\].
    pub predicted: Vec<f64>,
    /// Coefficients after every sample.
    pub parameters: Vec<[f64; N]>,
    /// Alarms.
    pub alarms: Vec<Alarm>,
}

impl<const N: usize> Adapter<N> {
    /// An estimator and the monitor of its residuals. With `reopen` an alarm resets the covariance of least
    /// squares, so that a jump is tracked at once, and the sums of the monitor: repeated alarms then mean
    /// that no coefficients fit.
    pub fn new(estimator: Estimator<N>, monitor: FitMonitor<f64>, reopen: bool) -> Self {
        Self { estimator, monitor, reopen }
    }

    /// Coefficients θ.
    pub fn parameters(&self) -> &[f64; N] {
        match &self.estimator {
            Estimator::LeastSquares(rls) => rls.parameters(),
            Estimator::Gradient { nlms, .. } => nlms.parameters(),
        }
    }

    /// The estimator.
    pub fn estimator(&self) -> &Estimator<N> {
        &self.estimator
    }

    /// The monitor.
    pub fn monitor(&self) -> &FitMonitor<f64> {
        &self.monitor
    }

    /// Updates with one sample: its regressors and the displacement \[µm\]. Allocates nothing.
    ///
    /// # Errors
    /// [`SampleError`]: estimator and monitor are unchanged.
    pub fn step(&mut self, row: &Row<N>, displacement_um: f64) -> Result<Adapted, SampleError> {
        let predicted = row.output(self.parameters());
        let output = displacement_um - row.fixed;
        let mut estimator = self.estimator;
        let normalised = match &mut estimator {
            Estimator::LeastSquares(rls) => rls.step(&row.regressors, output)?.normalised(),
            Estimator::Gradient { nlms, deviation_um } => nlms.step(&row.regressors, output)? / *deviation_um,
        };
        let misfit = self.monitor.step(normalised)?;
        self.estimator = estimator;
        if misfit.is_some() && self.reopen {
            self.monitor.reset();
            if let Estimator::LeastSquares(rls) = &mut self.estimator {
                rls.reopen();
            }
        }
        Ok(Adapted { predicted, normalised, misfit })
    }

    /// Processes a record sample by sample. Samples marked invalid are only predicted.
    ///
    /// # Errors
    /// [`IdentifyError::CorrectionLengths`], [`IdentifyError::OnlineSample`].
    pub fn run(
        &mut self,
        regressors: &Regressors<N>,
        record: &InputOutput,
    ) -> Result<Trace<N>, IdentifyError> {
        let samples = record.y.len();
        if regressors.len() != samples {
            return Err(IdentifyError::CorrectionLengths { expected: regressors.len(), found: samples });
        }
        let mut trace = Trace {
            predicted: Vec::with_capacity(samples),
            parameters: Vec::with_capacity(samples),
            alarms: Vec::new(),
        };
        let mut alarmed = false;
        for (index, (row, &y)) in regressors.rows().zip(&record.y).enumerate() {
            let valid = record.is_valid(index);
            if valid {
                let adapted =
                    self.step(&row, y).map_err(|cause| IdentifyError::OnlineSample { index, cause })?;
                trace.predicted.push(adapted.predicted);
                if let Some(misfit) = adapted.misfit.filter(|_| self.reopen || !alarmed) {
                    trace.alarms.push(Alarm { sample: index, misfit });
                }
                alarmed = adapted.misfit.is_some();
            } else {
                trace.predicted.push(row.output(self.parameters()));
            }
            trace.parameters.push(*self.parameters());
        }
        Ok(trace)
    }
}
