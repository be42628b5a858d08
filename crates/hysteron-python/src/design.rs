//! Design of the next drive.

use hysteron_identify::design::{DesignBasis, DesignOptions, design as designed};
use hysteron_identify::{FitRecords, IdentifyError, Listener, Task, Watch, fit};
use hysteron_model::model::Capability;
use hysteron_model::model_file::Kind;
use hysteron_model::record::ChannelChoice;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::errors::{from_json, raised, to_json};
use crate::fit::campaign;
use crate::model::{Model, maker};
use crate::record::Record;
use crate::signals::Samples;
use crate::work;

/// Drive, motion to predict and summary of a design as JSON, and the exception that stopped it, if any; from
/// a model, or from records, which are identified first.
#[pyfunction]
#[pyo3(signature = (options, model=None, records=Vec::new(), input=None, output=None, progress=None))]
pub fn design<'py>(
    py: Python<'py>,
    options: &str,
    model: Option<PyRef<'_, Model>>,
    records: Vec<PyRef<'_, Record>>,
    input: Option<String>,
    output: Option<String>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Samples<'py>, Samples<'py>, String)> {
    let options: DesignOptions = from_json(options)?;
    let basis = match &model {
        Some(model) => {
            Some(DesignBasis::from(model.core().hammerstein(Capability::Design).map_err(raised)?.data()))
        }
        None => None,
    };
    let records = campaign(&records, &ChannelChoice { input, output })?;
    let work = |watch: &Watch<'_>| {
        let basis = match basis {
            Some(basis) => basis,
            None => {
                let task = Task::of(Kind::Hammerstein);
                let fit = fit(&FitRecords::Single(records), &task, watch, None, &maker())?;
                if fit.interrupted {
                    return Err(IdentifyError::Stopped);
                }
                DesignBasis::of_fit(&fit)?
            }
        };
        designed(&basis, &options, Listener::new(&watch.teller()))
    };
    let (found, interruption) = work::watched(py, None, progress.as_ref(), work)?;
    if let Some(interruption) = interruption {
        return Err(interruption);
    }
    let summary = to_json(&found.summary())?;
    Ok((PyArray1::from_vec(py, found.drive), PyArray1::from_vec(py, found.motion), summary))
}
