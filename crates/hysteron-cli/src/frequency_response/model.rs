//! A fitted structure as a model file.

use std::collections::BTreeMap;
use std::path::Path;

use hysteron_identify::frequency_response::Candidate;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::model_file::{ModelFile, Provenance, SignalUnits};
use hysteron_model::record::InterSample;

use super::Found;
use crate::failure::Failure;
use crate::maker::maker;

/// Writes the candidate of the lowest AIC that a model file can hold; says which, and what the file lacks.
pub fn write(path: &Path, found: &Found) -> Result<String, Failure> {
    let failure = || Failure::new(format!("cannot write the model {}", path.display()));
    let mut order: Vec<&Candidate> = found.candidates.iter().collect();
    order.sort_by(|a, b| a.fit.aic.total_cmp(&b.fit.aic));
    let mut refused = None;
    for candidate in order {
        match candidate.fit.to_transfer_function(&found.response) {
            Ok((tf, delay_s)) => {
                let infinite = tf.dc_gain().is_infinite();
                let dynamics =
                    if tf.is_integer_order() { Dynamics::Integer(tf) } else { Dynamics::Fractional(tf) };
                let file =
                    model_file(dynamics, delay_s, candidate, found).map_err(|e| failure().because(e))?;
                crate::model::write(path, file)?;
                let start = if infinite {
                    " Its gain at zero frequency is infinite (a power law): simulate it from 0 V (--rest-voltage 0)."
                } else {
                    ""
                };
                return Ok(format!(
                    "wrote {}: {}; the file format asks for a hysteresis block, which is v = u without hysteresis here.{start}",
                    path.display(),
                    candidate.name
                ));
            }
            Err(reason) => refused = refused.or(Some(reason)),
        }
    }
    let failure = failure().hint("fit another structure, e.g. --structure fractional");
    Err(match refused {
        Some(reason) => failure.because(reason),
        None => failure,
    })
}

fn model_file(
    dynamics: Dynamics,
    delay_s: f64,
    candidate: &Candidate,
    found: &Found,
) -> Result<ModelFile, hysteron_model::hysteresis::HysteresisError> {
    let response = &found.response;
    let (output, input) = response.unit.split_once("_per_").unwrap_or(("", ""));
    let model = Model {
        hysteresis: Hysteresis::BoucWen(BoucWen::new(vec![1.0], 0.0, 0.0, 0.0, 1.0)?),
        dynamics,
        offset: 0.0,
        delay_s,
        scheme: Scheme::Tustin,
        sample_rate_hz: None,
        inter_sample: InterSample::Linear,
    };
    // v = u carries the input's unit into the dynamic block, whose gain carries the rest.
    let units = SignalUnits { input: input.to_owned(), output: output.to_owned() };
    let mut file = ModelFile::from_model(&model, units);
    if let Ok((names, covariance)) = candidate.fit.covariance_of_numbers() {
        file.set_covariance(&names, &covariance);
    }
    let (low, high) = response.range_hz();
    let options = BTreeMap::from([
        ("method".to_owned(), "frequency-response".to_owned()),
        ("structure".to_owned(), candidate.fit.structure.to_string()),
        ("response".to_owned(), response.name.clone()),
        ("band".to_owned(), format!("{low}:{high} Hz")),
        ("relative rms error".to_owned(), format!("{:.4} %", 100.0 * candidate.fit.relative_rms)),
    ]);
    file.provenance = Some(Provenance::new(&maker(), Vec::new(), options, None));
    Ok(file)
}
