//! A controller of `track`: the inverse with a feedback law, or with an observer of the disturbance, around
//! it.
//!
//! The poles of the law and the model of the observer are exports of their own, run by the controller:
//! `NAME_law`, `NAME_observed`, `NAME_inverse`, and `NAME_controller` over them.

mod files;
mod golden;

use hysteron_model::control::{Forward, Loop, LoopSettings, RequiredMargins};
use hysteron_model::dynamics::Dynamics;
use hysteron_model::fractional::Scheme;
use hysteron_model::hammerstein;
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::model::{Hammerstein, InverseRequest};
use hysteron_model::realise::{Realisation, RealiseError, RealiseOptions};
use hysteron_model::record::InterSample;
use hysteron_model::tracking::{Controller, ControllerFamily, ReferenceKnowledge};

use crate::error::ExportError;
use crate::inverse::Inverse;
use crate::number::Precision;
use crate::subject::Subject;
pub use files::controller_files;

/// A controller to export.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Its name.
    pub controller: Controller,
    /// The loop, designed from the model with stated margins.
    pub made: Loop,
    /// Its inverse.
    pub inverse: Inverse,
    /// Beginning of every name in the source.
    name: String,
    /// Poles of the feedback law.
    law: Option<Subject>,
    /// The model that the observer compares the stage with, under zero-order hold and with its delay.
    observed: Option<Subject>,
}

impl ClosedLoop {
    /// The controller for the model of `subject`, its inverse as `asked` for.
    ///
    /// # Errors
    /// [`ExportError::Controller`] for one without inverse or without a law or observer, adaptive ones, and
    /// predicting ones where `asked` states no frequency; [`ExportError::ControllerPrecision`] in single
    /// precision; [`ExportError::Control`] of the design; those of [`Inverse::new`].
    pub fn new(
        model: &Hammerstein,
        subject: &Subject,
        controller: Controller,
        asked: &InverseRequest,
        realise: RealiseOptions,
    ) -> Result<Self, ExportError> {
        if subject.precision == Precision::F32 {
            return Err(ExportError::ControllerPrecision);
        }
        let rate = subject.realisation.sample_rate_hz;
        let predicts = controller.family() == ControllerFamily::Predicted;
        let predict_to_hz = match asked.predict_to_hz {
            None if predicts => return Err(ExportError::Prediction { controller: controller.name() }),
            given => given.unwrap_or(0.5 * rate),
        };
        let known =
            ReferenceKnowledge { preview: asked.preview, predict_to_hz, bandwidth_hz: asked.bandwidth_hz };
        let strategy = controller.strategy(&known);
        let is_closed = strategy.feedback.is_some() || strategy.observer;
        let has_inverse = matches!(strategy.forward, Forward::Inverse(_));
        if !has_inverse || !is_closed || strategy.adaptive.is_some() {
            return Err(ExportError::Controller { controller: controller.name() });
        }
        let limits = asked.limits(model)?;
        let valid = model.data().valid_range.as_ref();
        let settings = LoopSettings {
            sample_rate_hz: rate,
            range_v: [limits.low, limits.high],
            slew_v_per_s: limits.slew_v_per_s,
            wanted: RequiredMargins {
                trusted_to_hz: valid.and_then(|valid| valid.frequency.as_ref()).map(|f| f.high),
                ..RequiredMargins::default()
            },
            realise: model.realise_options(rate, realise),
        };
        let made = Loop::new(model.law(), &settings, &strategy)?;
        let Some(compensation) = made.inverse.clone() else {
            return Err(ExportError::Controller { controller: controller.name() });
        };
        let inverse = Inverse::new(subject, compensation, settings.range_v, settings.slew_v_per_s)?;
        let law = match &made.feedback {
            Some(tuned) if tuned.law.dynamics.states() > 0 => {
                let dynamics = tuned.law.dynamics.clone();
                Some(block(subject, "law", unity()?, dynamics))
            }
            _ => None,
        };
        let observed = made
            .observer
            .is_some()
            .then(|| block(subject, "observed", made.model.clone(), made.dynamics.clone()));
        Ok(Self { controller, inverse, law, observed, name: format!("{}_controller", subject.name), made })
    }
}

/// A block of a controller, under a name of its own.
fn block(
    subject: &Subject,
    name: &str,
    model: hammerstein::Model,
    dynamics: hysteron_model::realise::LinearRealisation,
) -> Subject {
    let realisation = Realisation {
        model,
        dynamics,
        sample_rate_hz: subject.realisation.sample_rate_hz,
        joins_means: false,
    };
    Subject { name: format!("{}_{name}", subject.name), realisation, ..subject.clone() }
}

/// displacement = voltage, in front of the poles of a law.
fn unity() -> Result<hammerstein::Model, ExportError> {
    Ok(hammerstein::Model {
        hysteresis: Hysteresis::without_memory(vec![1.0]).map_err(RealiseError::from)?,
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Hold,
        sample_rate_hz: None,
    })
}
