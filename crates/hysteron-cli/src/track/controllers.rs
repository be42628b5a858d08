//! The controllers by name.

use clap::ValueEnum;
use hysteron_model::compensator::{CompensatorOptions, Prediction};
use hysteron_model::control::{Adaptive, Forward, LawFamily, Strategy};

/// A way to follow a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Controller {
    /// Straight line through the loop, no compensation
    Uncompensated,
    /// Straight line and PI
    Pi,
    /// Straight line and fractional PI^λ
    FractionalPi,
    /// Straight line and an integral behind a notch on the resonance
    NotchIntegral,
    /// Inverse of the model, the reference known ahead
    Feedforward,
    /// Inverse, the reference predicted from its past
    Predicted,
    /// Inverse, nothing known or predicted
    Causal,
    /// Inverse with preview, and PI
    FeedforwardPi,
    /// Inverse with preview, and fractional PI^λ
    FeedforwardFractionalPi,
    /// Inverse with preview, and disturbance observer
    FeedforwardObserver,
    /// Inverse with prediction, and PI
    PredictedPi,
    /// Inverse with prediction, and disturbance observer
    PredictedObserver,
    /// Inverse with preview, and adaptive feedforward (filtered-x LMS)
    FeedforwardLms,
    /// Inverse without either, and adaptive feedforward (filtered-x LMS)
    CausalLms,
}

/// Controllers that are drawn together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Line,
    Preview,
    Predicted,
    Causal,
}

impl Family {
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

/// What is known of the reference.
pub struct Known {
    pub preview: Option<usize>,
    pub predict_to_hz: f64,
    pub bandwidth_hz: Option<f64>,
}

impl Controller {
    /// As on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
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

    /// What its reference passes.
    pub fn family(self) -> Family {
        match self {
            Self::Uncompensated | Self::Pi | Self::FractionalPi | Self::NotchIntegral => Family::Line,
            Self::Predicted | Self::PredictedPi | Self::PredictedObserver => Family::Predicted,
            Self::Causal | Self::CausalLms => Family::Causal,
            Self::Feedforward
            | Self::FeedforwardPi
            | Self::FeedforwardFractionalPi
            | Self::FeedforwardObserver
            | Self::FeedforwardLms => Family::Preview,
        }
    }

    pub fn strategy(self, known: &Known) -> Strategy {
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
