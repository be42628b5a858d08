//! The report of an identification of any kind.

use hysteron_identify::structure::{Neighbours, StructureError};
use hysteron_identify::{Fit, Found};
use hysteron_model::Model;
use hysteron_model::model_file::ModelFileError;

use crate::page::Page;
use crate::{identification, model};

/// The report of a fit: for a Hammerstein model with curves and, where they were fitted, the structures next to it (`others`); for the
/// other kinds numbers, errors, scores and findings.
///
/// # Errors
/// [`ModelFileError`] where the data of the model are not sound.
pub fn report(
    name: &str,
    fit: &Fit,
    others: Option<&Result<Neighbours, StructureError>>,
) -> Result<Page, ModelFileError> {
    match (&fit.found, &fit.model) {
        (Found::Hammerstein(found), Model::Hammerstein(body)) => {
            Ok(identification::report(name, found, body.data(), others))
        }
        _ => model::report(name, &fit.model, &fit.findings),
    }
}
