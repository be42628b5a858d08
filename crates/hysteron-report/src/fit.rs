//! The report of an identification of any kind.

use hysteron_identify::structure::Neighbours;
use hysteron_identify::{Fit, FitDetails, IdentifyError};
use hysteron_model::Model;
use hysteron_model::model_file::ModelFileError;

use crate::page::{Page, Section};
use crate::record_curves::RecordCurves;
use crate::{identification, model, modes};

/// The report of a fit: for a Hammerstein model with curves and, where they were fitted, the neighbouring
/// structures (`others`); for the other kinds numbers, errors, scores and findings, for an oscillator and
/// a force also curves, for modes frequency responses and spectra.
///
/// # Errors
/// [`ModelFileError`] where the data of the model are not sound.
pub fn report(
    name: &str,
    fit: &Fit,
    others: Option<&Result<Neighbours, IdentifyError>>,
) -> Result<Page, ModelFileError> {
    match (&fit.found, &fit.model) {
        (FitDetails::Hammerstein(found), Model::Hammerstein(body)) => {
            Ok(identification::report(name, found, body.data(), others))
        }
        (FitDetails::Oscillator(found), _) => {
            let figures = found.records.iter().flat_map(|record| {
                RecordCurves::new(&record.data, &record.simulated, record.scores.offset, 0).figures()
            });
            let curves = Section::new("Measured and model").blocks(figures);
            Ok(model::report(name, &fit.model, &fit.findings)?.section(curves))
        }
        (FitDetails::Force(found), _) => {
            let figures = found.records.iter().flat_map(|record| {
                RecordCurves::new(&record.data, &record.simulated, record.scores.offset, 0).figures()
            });
            let curves = Section::new("Measured and model").blocks(figures);
            Ok(model::report(name, &fit.model, &fit.findings)?.section(curves))
        }
        (FitDetails::Modes(found), _) => {
            model::report_with(name, &fit.model, &fit.findings, modes::sections(found, &fit.model))
        }
        _ => model::report(name, &fit.model, &fit.findings),
    }
}
