//! Tracking strategies, designed from the model.

use std::f64::consts::TAU;

use super::margins::loop_frequencies;
use super::tuning::{LawFamily, Still};
use super::{
    Adaptive, AdaptiveFilter, ControlError, Margins, RequiredMargins, StraightLine, Tuned, tune,
    tune_observer,
};
use crate::compensator::{Compensation, CompensatorOptions};
use crate::hammerstein::Model;
use crate::realise::{LinearRealisation, RealiseOptions, held};
use hysteron_numeric::Complex64;

/// Frequency of the slow loops that the straight line fits, as a share of the sample rate: 1 Hz at 10 kHz.
/// (With unbounded creep the static gain is infinite.)
pub(super) const SLOW: f64 = 1e-4;
/// |1 − T| of a sine whose error is 1 % of its stroke, rms: the stroke is 2 √2 times its rms.
const ONE_PERCENT: f64 = 0.02 * std::f64::consts::SQRT_2;

/// Feedforward: the law from reference to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Forward {
    /// The straight line through the loop: no compensation.
    Line,
    /// The inverse of the model.
    Inverse(CompensatorOptions),
}

/// A tracking strategy.
#[derive(Clone, Debug, PartialEq)]
pub struct Strategy {
    /// Name of the strategy.
    pub name: String,
    /// Feedforward.
    pub forward: Forward,
    /// Feedback on the reading.
    pub feedback: Option<LawFamily>,
    /// True if a disturbance observer compensates the difference between model and stage.
    pub observer: bool,
    /// Additional adaptive feedforward.
    pub adaptive: Option<Adaptive>,
}

impl Strategy {
    /// Feedforward alone.
    pub fn new(name: impl Into<String>, forward: Forward) -> Self {
        Self { name: name.into(), forward, feedback: None, observer: false, adaptive: None }
    }

    /// This strategy with feedback.
    #[must_use]
    pub fn with_feedback(self, family: LawFamily) -> Self {
        Self { feedback: Some(family), ..self }
    }

    /// This strategy with a disturbance observer.
    #[must_use]
    pub fn with_observer(self) -> Self {
        Self { observer: true, ..self }
    }

    /// This strategy with adaptive feedforward weights.
    #[must_use]
    pub fn with_adaptive(self, adaptive: Adaptive) -> Self {
        Self { adaptive: Some(adaptive), ..self }
    }
}

/// Settings shared by all loops of a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopSettings {
    /// The controller's rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Least and largest voltage \[V\].
    pub range_v: [f64; 2],
    /// Largest rate of the drive \[V/s\]; infinite for none.
    pub slew_v_per_s: f64,
    /// Margins of the feedback.
    pub wanted: RequiredMargins,
    /// Accuracy of the dynamics.
    pub realise: RealiseOptions,
}

/// Bandwidths of a linear loop, searched from 1e-4 of the sample rate up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bandwidth {
    /// Lowest frequency \[Hz\] with a gain below 1/√2.
    pub minus_3_db_hz: f64,
    /// Lowest frequency \[Hz\] at which the error is above 1 % of the stroke, rms.
    pub one_percent_hz: f64,
}

/// A strategy designed for one model and rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Loop {
    /// The strategy.
    pub strategy: Strategy,
    /// Settings of the loop.
    pub settings: LoopSettings,
    /// The model.
    pub model: Model,
    /// Its dynamics under a zero-order hold, delay included.
    pub dynamics: LinearRealisation,
    /// The straight line through the model's loop.
    pub line: StraightLine,
    /// The inverse.
    pub inverse: Option<Compensation>,
    /// The feedback.
    pub feedback: Option<Tuned>,
    /// Gain of the observer, and margins of its loop.
    pub observer: Option<(f64, Margins)>,
    /// The adaptive weights.
    pub adaptive: Option<AdaptiveFilter>,
    /// Bandwidths, the model assumed linear and exact.
    pub bandwidth: Bandwidth,
}

impl Loop {
    /// Designs the loop of a strategy.
    ///
    /// # Errors
    /// [`ControlError`]; an observer or adaptive weights without the inverse are refused.
    pub fn new(model: &Model, settings: &LoopSettings, strategy: &Strategy) -> Result<Self, ControlError> {
        Self::new_while(&|| Ok(()), model, settings, strategy)
    }

    /// [`Self::new`], asking now and then whether to go on.
    ///
    /// # Errors
    /// Those of [`Self::new`]; [`ControlError::Stopped`].
    pub fn new_while(
        still: Still<'_>,
        model: &Model,
        settings: &LoopSettings,
        strategy: &Strategy,
    ) -> Result<Self, ControlError> {
        let rate = settings.sample_rate_hz;
        if !(rate.is_finite() && rate > 0.0) {
            return Err(ControlError::Number { name: "sample rate [Hz]", value: rate });
        }
        let inverse = match strategy.forward {
            Forward::Line => None,
            Forward::Inverse(options) => {
                let options = CompensatorOptions { realise: settings.realise, ..options };
                Some(Compensation::new(model, rate, &options)?)
            }
        };
        let dynamics = match &inverse {
            Some(inverse) => inverse.dynamics.clone(),
            None => held(model, rate, &settings.realise)?,
        };
        let slow_gain = dynamics.response(SLOW * rate, rate).norm();
        let line = StraightLine::of_model(model, slow_gain, settings.range_v)?;
        let frequencies = loop_frequencies(&dynamics, rate);
        let late = |f: f64| Complex64::from_polar(1.0, -TAU * f / rate);
        // Response of the displacement to a correction of the reference.
        let correction = |f: f64| match &inverse {
            Some(inverse) => inverse.correction(f),
            None => dynamics.response(f, rate) / slow_gain,
        };
        let steepest = if inverse.is_some() { 1.0 } else { line.steepest };
        let feedback = match strategy.feedback {
            None => None,
            Some(family) => {
                let rest: Vec<(f64, Complex64)> =
                    frequencies.iter().map(|f| (*f, steepest * correction(*f) * late(*f))).collect();
                Some(tune(family, &rest, &dynamics, rate, &settings.wanted, still)?)
            }
        };
        let needs_inverse = strategy.observer || strategy.adaptive.is_some();
        if needs_inverse && inverse.is_none() {
            let name = "observer or adaptive feedforward without the inverse (number of inverses)";
            return Err(ControlError::Number { name, value: 0.0 });
        }
        let path = || -> Vec<(f64, Complex64)> { frequencies.iter().map(|f| (*f, correction(*f))).collect() };
        let observer =
            if strategy.observer { Some(tune_observer(&path(), rate, &settings.wanted)?) } else { None };
        let adaptive = match strategy.adaptive {
            Some(asked) => Some(AdaptiveFilter::new(&path(), &correction, rate, asked, &settings.wanted)?),
            None => None,
        };
        let followed = |f: f64| {
            let forward = match &inverse {
                Some(inverse) => inverse.tracking(f),
                None => correction(f),
            };
            match &feedback {
                None => forward,
                Some(tuned) => {
                    let open = tuned.law.response(f) * correction(f) * late(f);
                    (forward + open) / (1.0 + open)
                }
            }
        };
        let half = 0.5 * rate;
        let first = |lost: &dyn Fn(Complex64) -> bool| {
            frequencies.iter().copied().find(|f| *f >= SLOW * rate && lost(followed(*f))).unwrap_or(half)
        };
        let bandwidth = Bandwidth {
            minus_3_db_hz: first(&|t| t.norm_sqr() < 0.5),
            one_percent_hz: first(&|t| (t - 1.0).norm() > ONE_PERCENT),
        };
        Ok(Self {
            strategy: strategy.clone(),
            settings: *settings,
            model: model.clone(),
            dynamics,
            line,
            inverse,
            feedback,
            observer,
            adaptive,
            bandwidth,
        })
    }

    /// Margins of its feedback, or of its observer.
    pub fn margins(&self) -> Option<Margins> {
        self.feedback.as_ref().map(|tuned| tuned.margins).or(self.observer.map(|(_, margins)| margins))
    }
}
