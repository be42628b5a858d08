//! A controller of `track`: the inverse with a feedback law, or with an observer of the disturbance, around
//! it.
//!
//! The poles of the law and the model of the observer are exports of their own, run by the controller:
//! `NAME_law`, `NAME_observed`, `NAME_inverse`, and `NAME_controller` over them.

mod files;
mod golden;
mod rust;
mod stage;

use hysteron_model::control::{Forward, Loop, LoopSettings, RequiredMargins};
use hysteron_model::dynamics::Dynamics;
use hysteron_model::fractional::Scheme;
use hysteron_model::hammerstein;
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::model::{Hammerstein, InverseRequest};
use hysteron_model::realise::{Realisation, RealiseError, RealiseOptions};
use hysteron_model::record::InterSample;
use hysteron_model::tracking::{Controller, ControllerFamily, ReferenceKnowledge};

use crate::dry_run::{Compared, DryRun};
use crate::error::ExportError;
use crate::golden::{Golden, Rounding};
use crate::inverse::Inverse;
use crate::number::Precision;
use crate::subject::Subject;
pub(crate) use files::controller_core;
pub use files::controller_files;
pub use golden::GoldenLoop;
pub(crate) use rust::controller_modules;

/// A controller to export.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// Its name.
    pub controller: Controller,
    /// The loop, designed from the model with stated margins.
    pub made: Loop,
    /// Its inverse.
    pub inverse: Inverse,
    /// Bound on the rounding error of the voltage.
    pub rounding: Rounding,
    /// Departure of the number type from double precision.
    pub dry_run: DryRun,
    /// Beginning of every name in the source.
    pub(crate) name: String,
    /// Poles of the feedback law.
    law: Option<Subject>,
    /// The model that the observer compares the stage with, under zero-order hold and with its delay.
    observed: Option<Subject>,
}

impl ClosedLoop {
    /// Controllers that are exported: those with the inverse and a feedback law or an observer.
    pub const EXPORTED: [Controller; 5] = [
        Controller::FeedforwardPi,
        Controller::FeedforwardFractionalPi,
        Controller::FeedforwardObserver,
        Controller::PredictedPi,
        Controller::PredictedObserver,
    ];

    /// The controller for the model of `subject`, its inverse as `asked` for.
    ///
    /// # Errors
    /// [`ExportError::Controller`] for one without inverse or without a law or observer, adaptive ones, and
    /// predicting ones where `asked` states no frequency; [`ExportError::Control`] of the design; those of
    /// [`Inverse::new`], for the voltage of the controller too.
    pub fn new(
        model: &Hammerstein,
        subject: &Subject,
        controller: Controller,
        asked: &InverseRequest,
        realise: RealiseOptions,
    ) -> Result<Self, ExportError> {
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
        let observed = match made.observer {
            Some(_) => {
                let observed = block(subject, "observed", made.model.clone(), made.dynamics.clone());
                let golden = Golden::new(&observed)?;
                let rounding =
                    Rounding::new("displacement", &subject.output_unit, golden.tolerance, golden.span)?;
                Some(Subject { rounding, ..observed })
            }
            None => None,
        };
        let name = format!("{}_controller", subject.name);
        let (rounding, dry_run) = (Rounding { bound: 0.0, share: 0.0 }, DryRun::NONE);
        let mut closed = Self { controller, inverse, law: None, observed, rounding, dry_run, name, made };
        closed.law = closed.law_block()?.filter(|law| law.realisation.dynamics.states() > 0);
        if subject.precision == Precision::F32 {
            let golden = GoldenLoop::new(&closed)?;
            closed.dry_run = golden.dry_run(&closed)?;
            let [low, high] = closed.inverse.range_v;
            closed.rounding =
                Rounding::new("voltage", &subject.input_unit, closed.dry_run.stated(), high - low)?;
        }
        Ok(closed)
    }

    /// The part of the feedback law that has poles of its own, behind displacement = voltage.
    fn law_block(&self) -> Result<Option<Subject>, ExportError> {
        let Some(tuned) = &self.made.feedback else { return Ok(None) };
        let name = self.name.strip_suffix("_controller").unwrap_or(&self.name);
        let subject = Subject { name: name.to_owned(), ..self.inverse.subject.clone() };
        Ok(Some(block(&subject, "law", unity()?, tuned.law.dynamics.clone())))
    }

    /// Samples that the reference is known ahead.
    pub(crate) fn preview(&self) -> usize {
        self.inverse.compensation.preview
    }

    /// What a dry run of it compares.
    pub(crate) fn compared(&self) -> Compared<'_> {
        Compared { what: "controller", ..self.inverse.compared() }
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
