//! Intermediate model of a running search.

use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};
use hysteron_model::model_file::{ModelFile, SignalUnits};

use super::RecordFacts;
use super::options::Options;

/// The intermediate model, without standard errors and scores.
pub(super) fn shown(
    hysteresis: &ArticleOperator,
    dynamics: Dynamics,
    delay_s: f64,
    options: &Options,
    first: &RecordFacts,
) -> Option<hysteron_model::Model> {
    let law = Model {
        hysteresis: Hysteresis::from(hysteresis.clone()),
        dynamics,
        offset: 0.0,
        delay_s,
        scheme: options.scheme(),
        inter_sample: options.inter_sample(),
        sample_rate_hz: first.data.sample_rate_hz(),
    };
    let units = SignalUnits::of(&first.data.u_unit, &first.data.y_unit);
    hysteron_model::Model::try_from(ModelFile::from_model(&law, units)).ok()
}
