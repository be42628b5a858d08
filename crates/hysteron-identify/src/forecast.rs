//! The drive for a reference, and the error to expect when it is played on the device.

use hysteron_model::Start;
use hysteron_model::invert::{InverseDrive, InversionError, LastRun};
use hysteron_model::misfit::MisfitPrediction;
use hysteron_model::model::{ErrorForecast, Hammerstein, InverseRequest, InverseSummary, ends_apart};
use hysteron_model::model_file::ModelFile;
use hysteron_model::record::Unit;
use hysteron_model::{Advice, Finding, FindingKind};
use hysteron_numeric::Listener;
use hysteron_numeric::display::short;

use crate::{IdentifyError, PredictionBand};

/// Share of the time that the drive takes; the rest is its uncertainty.
const SHARE_OF_DRIVE: f64 = 0.5;

/// A drive for a reference, with the error to expect on the device.
#[derive(Clone, Debug, PartialEq)]
pub struct ForecastDrive {
    /// The drive.
    pub drive: InverseDrive,
    /// Its figures, with findings about it.
    pub summary: InverseSummary,
}

/// The drive for a reference \[output unit\] at a controller's rate \[Hz\], as it is asked for, corrected by
/// the error of the `last` run where there is one ([`Hammerstein::drive_for`]), and the error to expect when
/// it is played on the device.
///
/// # Errors
/// [`InversionError`]; [`InversionError::Stopped`] where the listener ends it.
pub fn drive_for(
    model: &Hammerstein,
    reference: &[f64],
    sample_rate_hz: f64,
    request: &InverseRequest,
    last: Option<LastRun<'_>>,
    listener: Listener<'_>,
) -> Result<ForecastDrive, InversionError> {
    let told = listener.part(0.0, SHARE_OF_DRIVE);
    let (drive, preview) = model.drive_for(reference, sample_rate_hz, request, last, told)?;
    let told = listener.part(SHARE_OF_DRIVE, 1.0);
    let forecast =
        PredictionBand::forecast(model.data(), reference, (&drive, request.correct), sample_rate_hz, told)
            .map_err(|_| InversionError::Stopped)?;
    let limits = request.limits(model)?;
    let mut findings = model.findings_on_drive(&drive, [limits.low, limits.high]);
    findings.extend(correction_offered(model, request, preview.is_some() || last.is_some()));
    if request.periodic {
        findings.extend(ends_apart(reference, None, &Unit::new(&model.data().units.output)));
    }
    findings.extend(preview.and_then(|preview| preview.finding(request.preview)));
    let units = &model.data().units;
    let summary =
        InverseSummary::new(reference, (&drive, preview), sample_rate_hz, forecast, findings, units);
    Ok(ForecastDrive { drive, summary })
}

/// That a corrected drive is to be had, where it is and was not asked for.
fn correction_offered(model: &Hammerstein, request: &InverseRequest, otherwise: bool) -> Option<Finding> {
    if request.correct || otherwise {
        return None;
    }
    let left = model.correction().ok()?.left_out?;
    let text = format!(
        "What the device does beside the model can be predicted: on left-out parts of the training records the \
         error is {} times that of the model alone. A drive that is corrected by it follows better.",
        short((100.0 * left).round() / 100.0)
    );
    Some(Finding::new(FindingKind::Advice, "correction", text).with_advice(Advice::CorrectDrive))
}

impl PredictionBand {
    /// Forecast of the error of the drive `found` for a reference \[output unit\], with whether its
    /// prediction is corrected by the misfit; `None` for a file without correlation, and where the band
    /// cannot be computed.
    ///
    /// # Errors
    /// [`IdentifyError::Stopped`] where the listener ends it.
    pub fn forecast(
        file: &ModelFile,
        reference: &[f64],
        (found, corrected): (&InverseDrive, bool),
        sample_rate_hz: f64,
        listener: Listener<'_>,
    ) -> Result<Option<ErrorForecast>, IdentifyError> {
        let start = found.rest.unwrap_or(Start::settled(found.drive.len()));
        let band = match Self::of_file_told(file, &found.drive, Some(sample_rate_hz), &start, listener) {
            Ok(band) if corrected => remaining(band),
            Ok(band) => band,
            Err(IdentifyError::Stopped) => return Err(IdentifyError::Stopped),
            Err(_) => return Ok(None),
        };
        let largest = |half: Vec<f64>| half.into_iter().fold(0.0, f64::max);
        let has_scores = band.noise > 0.0;
        Ok(Some(ErrorForecast {
            band_of_model: largest(band.of_output()),
            band_of_measurement: has_scores.then(|| largest(band.of_measurement())),
            expected_rms: has_scores.then(|| band.expected_rms(reference, &found.predicted)),
            findings: band.findings,
        }))
    }

    /// Root of the expected mean square of `reference` − measurement, where the model's output is
    /// `predicted`: with the discrepancy μ, its variance and that of the noise where the device is outside
    /// the class, else with the variances of the model's output and of the residual.
    fn expected_rms(&self, reference: &[f64], predicted: &[f64]) -> f64 {
        let errors = reference.iter().zip(predicted).map(|(r, y)| r - y);
        let total: f64 = match &self.misfit {
            Some(misfit) => {
                let own = misfit.discrepancy.iter().zip(&misfit.std_dev);
                errors.zip(own).map(|(e, (mean, sd))| (e - mean).powi(2) + sd * sd).sum::<f64>()
                    + misfit.noise.powi(2) * reference.len() as f64
            }
            None => errors.zip(&self.std_dev).map(|(e, sd)| e * e + sd * sd + self.noise.powi(2)).sum(),
        };
        (total / reference.len().max(1) as f64).sqrt()
    }
}

/// The band of a prediction that is corrected by the misfit.
fn remaining(band: PredictionBand) -> PredictionBand {
    PredictionBand { misfit: band.misfit.map(MisfitPrediction::remaining), ..band }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::misfit::ColumnGroup;

    #[test]
    fn the_expected_error_adds_the_squares_of_its_parts() {
        let class = PredictionBand { std_dev: vec![0.3, 0.4], noise: 0.5, ..PredictionBand::default() };
        // ((1² + 0.3² + 0.5²) + (0² + 0.4² + 0.5²))/2 = 0.875.
        let found = class.expected_rms(&[2.0, 3.0], &[1.0, 3.0]);
        assert!((found - 0.875_f64.sqrt()).abs() < 1e-15, "{found}");
        let misfit = MisfitPrediction {
            discrepancy: vec![1.0, -1.0],
            std_dev: vec![0.0, 2.0],
            noise: 0.5,
            unexcited: 0.0,
            unexcited_group: ColumnGroup::Memory,
            one_amplitude: false,
            left_out: 0.5,
        };
        // The first error is what the discrepancy makes up for: ((0 + 0) + (1 + 4))/2 + 0.25.
        let outside = PredictionBand { misfit: Some(misfit), ..class };
        let found = outside.expected_rms(&[2.0, 3.0], &[1.0, 3.0]);
        assert!((found - 2.75_f64.sqrt()).abs() < 1e-15, "{found}");
        // A corrected prediction has made up for it: ((1 + 0) + (0 + 4))/2 + 0.25.
        let found = remaining(outside).expected_rms(&[2.0, 3.0], &[1.0, 3.0]);
        assert!((found - 2.75_f64.sqrt()).abs() < 1e-15, "{found}");
    }
}
