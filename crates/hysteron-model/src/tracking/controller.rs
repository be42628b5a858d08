//! Controllers by name.

use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::compensator::{CompensatorOptions, Prediction};
use crate::control::{Adaptive, Forward, LawFamily, Strategy};
use crate::unknown_name::UnknownName;

/// Controller that follows a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Controller {
    /// Straight line through the loop, no compensation.
    Uncompensated,
    /// Straight line and PI.
    Pi,
    /// Straight line and fractional PI^λ.
    FractionalPi,
    /// Straight line and an integral behind a notch on the resonance.
    NotchIntegral,
    /// Inverse of the model with preview of the reference.
    Feedforward,
    /// Inverse, the reference predicted from its past.
    Predicted,
    /// Inverse without preview or prediction.
    Causal,
    /// Inverse with preview, and PI.
    FeedforwardPi,
    /// Inverse with preview, and fractional PI^λ.
    FeedforwardFractionalPi,
    /// Inverse with preview, and disturbance observer.
    FeedforwardObserver,
    /// Inverse with prediction, and PI.
    PredictedPi,
    /// Inverse with prediction, and disturbance observer.
    PredictedObserver,
    /// Inverse with preview, and adaptive feedforward (filtered-x LMS).
    FeedforwardLms,
    /// Inverse without preview or prediction, and adaptive feedforward (filtered-x LMS).
    CausalLms,
}

/// Controllers with the same feedforward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerFamily {
    /// Straight line.
    Line,
    /// Inverse with preview of the reference.
    Preview,
    /// Inverse with prediction of the reference.
    Predicted,
    /// Inverse without preview or prediction.
    Causal,
}

impl ControllerFamily {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Line, Self::Preview, Self::Predicted, Self::Causal];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Line => "straight line, with feedback",
            Self::Preview => "inverse with preview",
            Self::Predicted => "inverse with predictor",
            Self::Causal => "inverse with neither",
        }
    }
}

/// Preview and prediction of the reference that the controllers use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceKnowledge {
    /// Preview in samples; `None`: as many as the inverse uses.
    pub preview: Option<usize>,
    /// Highest frequency that is predicted \[Hz\].
    pub predict_to_hz: f64,
    /// Highest frequency that is followed \[Hz\]; `None`: a twentieth of the sample rate.
    pub bandwidth_hz: Option<f64>,
}

impl Controller {
    /// All of them.
    pub const ALL: [Self; 14] = [
        Self::Uncompensated,
        Self::Pi,
        Self::FractionalPi,
        Self::NotchIntegral,
        Self::Feedforward,
        Self::Predicted,
        Self::Causal,
        Self::FeedforwardPi,
        Self::FeedforwardFractionalPi,
        Self::FeedforwardObserver,
        Self::PredictedPi,
        Self::PredictedObserver,
        Self::FeedforwardLms,
        Self::CausalLms,
    ];

    /// Name, e.g. `feedforward-pi`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uncompensated => "uncompensated",
            Self::Pi => "pi",
            Self::FractionalPi => "fractional-pi",
            Self::NotchIntegral => "notch-integral",
            Self::Feedforward => "feedforward",
            Self::Predicted => "predicted",
            Self::Causal => "causal",
            Self::FeedforwardPi => "feedforward-pi",
            Self::FeedforwardFractionalPi => "feedforward-fractional-pi",
            Self::FeedforwardObserver => "feedforward-observer",
            Self::PredictedPi => "predicted-pi",
            Self::PredictedObserver => "predicted-observer",
            Self::FeedforwardLms => "feedforward-lms",
            Self::CausalLms => "causal-lms",
        }
    }

    /// One-line description.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Uncompensated => "Linear gain, no hysteresis compensation",
            Self::Pi => "Linear gain and PI",
            Self::FractionalPi => "Linear gain and fractional PI^λ",
            Self::NotchIntegral => "Linear gain and an integral controller behind a notch on the resonance",
            Self::Feedforward => "Inverse of the model with preview of the reference",
            Self::Predicted => "Inverse, the reference predicted from its past",
            Self::Causal => "Inverse without preview or prediction",
            Self::FeedforwardPi => "Inverse with preview, and PI",
            Self::FeedforwardFractionalPi => "Inverse with preview, and fractional PI^λ",
            Self::FeedforwardObserver => "Inverse with preview, and disturbance observer",
            Self::PredictedPi => "Inverse with prediction, and PI",
            Self::PredictedObserver => "Inverse with prediction, and disturbance observer",
            Self::FeedforwardLms => "Inverse with preview, and adaptive feedforward (filtered-x LMS)",
            Self::CausalLms => {
                "Inverse without preview or prediction, and adaptive feedforward (filtered-x LMS)"
            }
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Uncompensated => "straight line",
            Self::Pi => "PI alone",
            Self::FractionalPi => "PI^λ alone",
            Self::NotchIntegral => "notch + integral alone",
            Self::Feedforward => "inverse, preview",
            Self::Predicted => "inverse, causal, predictor",
            Self::Causal => "inverse, causal",
            Self::FeedforwardPi => "inverse, preview + PI",
            Self::FeedforwardFractionalPi => "inverse, preview + PI^λ",
            Self::FeedforwardObserver => "inverse, preview + observer",
            Self::PredictedPi => "inverse, causal, predictor + PI",
            Self::PredictedObserver => "inverse, causal, predictor + observer",
            Self::FeedforwardLms => "inverse, preview + filtered-x LMS",
            Self::CausalLms => "inverse, causal + filtered-x LMS",
        }
    }

    /// Feedforward that its reference passes.
    pub fn family(self) -> ControllerFamily {
        match self {
            Self::Uncompensated | Self::Pi | Self::FractionalPi | Self::NotchIntegral => {
                ControllerFamily::Line
            }
            Self::Predicted | Self::PredictedPi | Self::PredictedObserver => ControllerFamily::Predicted,
            Self::Causal | Self::CausalLms => ControllerFamily::Causal,
            Self::Feedforward
            | Self::FeedforwardPi
            | Self::FeedforwardFractionalPi
            | Self::FeedforwardObserver
            | Self::FeedforwardLms => ControllerFamily::Preview,
        }
    }

    /// Tracking strategy for this knowledge of the reference.
    pub fn strategy(self, known: &ReferenceKnowledge) -> Strategy {
        let inverse = |preview, prediction| {
            let bandwidth_hz = known.bandwidth_hz;
            let options =
                CompensatorOptions { bandwidth_hz, preview, prediction, ..CompensatorOptions::default() };
            Strategy::new(self.words(), Forward::Inverse(options))
        };
        let band = Prediction::up_to(Some(known.predict_to_hz));
        let whole = || inverse(known.preview, Prediction::Stays);
        let predicted = || inverse(Some(0), band);
        let causal = || inverse(Some(0), Prediction::Stays);
        let line = || Strategy::new(self.words(), Forward::Line);
        match self {
            Self::Uncompensated => line(),
            Self::Pi => line().with_feedback(LawFamily::Pi),
            Self::FractionalPi => line().with_feedback(LawFamily::FractionalPi),
            Self::NotchIntegral => line().with_feedback(LawFamily::NotchIntegral),
            Self::Feedforward => whole(),
            Self::Predicted => predicted(),
            Self::Causal => causal(),
            Self::FeedforwardPi => whole().with_feedback(LawFamily::Pi),
            Self::FeedforwardFractionalPi => whole().with_feedback(LawFamily::FractionalPi),
            Self::FeedforwardObserver => whole().with_observer(),
            Self::PredictedPi => predicted().with_feedback(LawFamily::Pi),
            Self::PredictedObserver => predicted().with_observer(),
            Self::FeedforwardLms => whole().with_adaptive(Adaptive::up_to(known.predict_to_hz)),
            Self::CausalLms => causal().with_adaptive(Adaptive::up_to(known.predict_to_hz)),
        }
    }
}

impl FromStr for Controller {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        UnknownName::find("controller", name, Self::ALL, Self::name)
    }
}
