//! An identified model as a fixed number of real poles and pole pairs, to run sample by sample at a
//! controller's rate.
//!
//! [`realise`] makes a [`Realisation`] of any [`Model`]: poles of the transfer function on the main sheet
//! exactly, its branch cut by real poles, as many as bring the response within a specified accuracy of the
//! batch simulation's. The sections are stable and real by construction: every pole is placed before any
//! weight is fitted. Theory and limits: `docs/theory/realisation.md`.

mod cost;
mod error;
mod fit;
mod linear;
mod operator;
mod poles;
mod sections;
mod stream;
mod target;
mod verify;

pub use cost::{Cost, side_by_side};
pub use error::RealiseError;
pub use linear::{LinearRealisation, StateSpace};
pub use operator::TURNS;
pub use sections::Section;
pub(crate) use stream::LinearParts;
pub use stream::{Coefficients, RuntimeParts, Stream, StreamParts, nanoseconds_per_sample};
pub use verify::{Verification, sweep, verify};

use crate::dynamics::Dynamics;
use crate::fractional::Scheme;
use crate::hammerstein::{Model, joins_means};
use crate::record::InterSample;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of a realisation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RealiseOptions {
    /// Largest error of the response over the band, as a share of the gain at rest.
    pub accuracy: f64,
    /// Frequency \[Hz\] down to which unbounded creep is realised; below it the realisation stops creeping.
    pub lowest_frequency_hz: Option<f64>,
}

impl Default for RealiseOptions {
    /// 1e-5 of the range.
    fn default() -> Self {
        Self { accuracy: 1e-5, lowest_frequency_hz: None }
    }
}

/// A model that runs sample by sample at one rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Realisation {
    /// The model.
    pub model: Model,
    /// Its dynamic block, delay included.
    pub dynamics: LinearRealisation,
    /// The rate \[Hz\].
    pub sample_rate_hz: f64,
    /// True if moves are evaluated half-way, so that the hysteresis between samples enters with its mean:
    /// where the batch simulation does so (linear drive, scheme `band-limited`).
    pub joins_means: bool,
}

/// Realises a model at a sample rate.
///
/// # Errors
/// [`RealiseError`]: options out of range, a model that belongs to another rate, creep without a lowest
/// frequency, dynamics that are not stable, an accuracy out of reach.
pub fn realise(
    model: &Model,
    sample_rate_hz: f64,
    options: &RealiseOptions,
) -> Result<Realisation, RealiseError> {
    if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
        let (value, allowed) = (sample_rate_hz, "positive and finite");
        return Err(RealiseError::Option { name: "sample rate [Hz]", value, allowed });
    }
    if !(options.accuracy > 0.0 && options.accuracy < 1.0) {
        let (value, allowed) = (options.accuracy, "between 0 and 1");
        return Err(RealiseError::Option { name: "accuracy", value, allowed });
    }
    model.hysteresis.validate()?;
    let tied = match &model.dynamics {
        Dynamics::None => None,
        Dynamics::Arx(_) => Some("ARX"),
        Dynamics::Integer(_) | Dynamics::Fractional(_) => {
            model.scheme.parameters_belong_to_sample_rate().then_some(model.scheme.name())
        }
    };
    if let (Some(scheme), Some(model_hz)) = (tied, model.sample_rate_hz)
        && (model_hz - sample_rate_hz).abs() > 1e-6 * model_hz
    {
        return Err(RealiseError::SampleRate { scheme, model_hz, rate_hz: sample_rate_hz });
    }
    let dynamics = linear::realise(model, sample_rate_hz, options)?;
    let filtered = matches!(model.dynamics, Dynamics::Integer(_) | Dynamics::Fractional(_));
    let joins_means = filtered && joins_means(model.scheme, model.inter_sample);
    Ok(Realisation { model: model.clone(), dynamics, sample_rate_hz, joins_means })
}

/// The dynamic block, delay included, under a zero-order hold, whatever the inter-sample behaviour of the
/// identification.
pub(crate) fn held(
    model: &Model,
    sample_rate_hz: f64,
    options: &RealiseOptions,
) -> Result<LinearRealisation, RealiseError> {
    model.check_sample_rate(Some(sample_rate_hz))?;
    let held = Model { scheme: Scheme::BandLimited, inter_sample: InterSample::Hold, ..model.clone() };
    linear::realise(&held, sample_rate_hz, options)
}
