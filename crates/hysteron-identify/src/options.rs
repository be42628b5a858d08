//! Options of an identification.

use super::layout::Demands;
use hysteron_model::dynamics::{Creep, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{HysteresisError, HysteresisForm};
use hysteron_model::record::{InputOutput, InterSample};
use hysteron_optimize::Algorithm;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A record of the campaign and its role.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignRecord {
    /// Input and output.
    pub data: InputOutput,
    /// Role, if the user gave one; otherwise it is recognised.
    pub role: Option<RecordRole>,
}

/// Use of a record in the two-step identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RecordRole {
    /// Step 1: hysteresis block.
    QuasiStatic,
    /// Step 2: dynamic block.
    Dynamic,
}

/// Method by which a campaign with dynamics is identified.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// All records, both blocks, delay and initial states in one fit.
    #[default]
    Joint,
    /// The article's way (§4.3): hysteresis from the quasi-static records, then dynamics from the others.
    TwoStep,
}

impl Method {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Joint, Self::TwoStep];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::TwoStep => "two-step",
        }
    }

    /// Description in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Joint => "All records, both blocks, delay and initial states in one fit",
            Self::TwoStep => {
                "The article's procedure: hysteresis from slow records, then dynamics from the others"
            }
        }
    }
}

/// Assumption on the state before a record ([`hysteron_model::Start`] is the resulting start).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Initial {
    /// `Rest`; for a record that does not begin at 0 V, also at rest at 0 V before a step, if that fits
    /// better.
    #[default]
    Auto,
    /// At rest at u(0), with an unknown hysteresis memory.
    Rest,
    /// The record is a steady state that repeats.
    Periodic,
    /// At rest at 0 V, without memory.
    Zero,
    /// `Rest` with a free transient from before the record, fitted as responses to two impulses and a step at
    /// the first sample.
    Free,
}

impl Initial {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Auto, Self::Rest, Self::Periodic, Self::Zero, Self::Free];

    /// Name, as in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Rest => "rest",
            Self::Periodic => "periodic",
            Self::Zero => "zero",
            Self::Free => "free",
        }
    }

    /// Description in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Auto => "Rest, chosen from the record",
            Self::Rest => "Rest at the first sample, with an unknown hysteresis memory",
            Self::Periodic => "The record is a steady state that repeats",
            Self::Zero => "Rest at 0 V without memory",
            Self::Free => "Rest, with a residual transient",
        }
    }
}

/// Dynamic block asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DynamicsChoice {
    /// Dynamics that the records support: with a dynamic record a resonance and a lag, or fractional orders where
    /// these leave a far smaller error; a first-order lag with a start from rest; else none.
    #[default]
    Auto,
    /// Static model.
    None,
    /// Whole orders: pairs of poles and a lag in series.
    Integer,
    /// Resonances in parallel and, where the number of poles is odd, a lag behind them (joint fit).
    Modes,
    /// Autoregressive: equation error (two steps, as the next three).
    Arx,
    /// Output error B/F.
    OutputError,
    /// Output error with a noise model C/D.
    BoxJenkins,
    /// Continuous time, by simplified refined instrumental variables.
    Srivc,
    /// Real orders, Eq. 13.
    Fractional,
    /// Eq. 13 with a free lowest order: b / (s^α₂ + c₁ s^α₁ + c₀ s^α₀) (joint fit).
    FractionalFreeLowest,
    /// Two fractional modes in parallel (joint fit).
    TwoFractional,
}

impl DynamicsChoice {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Auto,
        Self::None,
        Self::Integer,
        Self::Modes,
        Self::Arx,
        Self::OutputError,
        Self::BoxJenkins,
        Self::Srivc,
        Self::Fractional,
        Self::FractionalFreeLowest,
        Self::TwoFractional,
    ];

    /// Name to choose it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::None => "none",
            Self::Integer => "integer",
            Self::Modes => "modes",
            Self::Arx => "arx",
            Self::OutputError => "oe",
            Self::BoxJenkins => "bj",
            Self::Srivc => "srivc",
            Self::Fractional => "fractional",
            Self::FractionalFreeLowest => "fractional-free-lowest",
            Self::TwoFractional => "two-fractional",
        }
    }

    /// Description in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Auto => "Chosen from the records",
            Self::None => "Static model",
            Self::Integer => "Whole orders: pairs of poles and, for an odd order, a lag in series",
            Self::Modes => "Resonances in parallel and, for an odd order, a lag behind them",
            Self::Arx => "Equation error, sampled (two steps)",
            Self::OutputError => "Output error B/F, sampled (two steps)",
            Self::BoxJenkins => "Box–Jenkins: output error B/F with a noise model C/D, sampled (two steps)",
            Self::Srivc => "B(s)/A(s) in continuous time by refined instrumental variables (two steps)",
            Self::Fractional => "b / (s^a2 + c1 s^a1 + c0)",
            Self::FractionalFreeLowest => "b / (s^a2 + c1 s^a1 + c0 s^a0)",
            Self::TwoFractional => "Two fractional modes in parallel",
        }
    }

    /// True if the block is a regression of the displacement on the output of an identified hysteresis block.
    pub fn takes_two_steps(self) -> bool {
        matches!(self, Self::Arx | Self::OutputError | Self::BoxJenkins | Self::Srivc)
    }

    /// Name in messages.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Auto => "automatic",
            Self::None => "static",
            Self::Integer => "integer-order",
            Self::Modes => "modal",
            Self::Arx => "ARX",
            Self::OutputError => "output-error",
            Self::BoxJenkins => "Box–Jenkins",
            Self::Srivc => "SRIVC",
            Self::Fractional | Self::FractionalFreeLowest | Self::TwoFractional => "fractional",
        }
    }
}

/// A value that is given or chosen from the data.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Choice<T> {
    /// Chosen from the data.
    #[default]
    Auto,
    /// Given.
    Given(T),
}

/// Family of the hysteresis block of a Hammerstein model.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FamilyChoice {
    /// The default family; plays with activated edges where a non-uniformly sampled record holds small
    /// oscillations beside large moves, then with [`DynamicsChoice::Auto`] and [`Creep::None`] fractional
    /// dynamics without creep.
    #[default]
    Usual,
    /// The family with the smallest held-out error, of those that describe most stacks; the usual one where
    /// the records cannot discriminate ([`FamilySelection`](super::structure::FamilySelection)).
    Auto,
    /// This one.
    Given(HysteresisForm),
}

impl FamilyChoice {
    /// The choices offered by name: `Auto`, and every family at its usual size.
    pub fn offered() -> Vec<Self> {
        std::iter::once(Self::Auto).chain(HysteresisForm::usual().into_iter().map(Self::Given)).collect()
    }

    /// The choice with another number of elements, if one is given.
    ///
    /// # Errors
    /// [`HysteresisError::Elements`] for a number that the family cannot have, and with `Auto`.
    pub fn with_elements(self, count: Option<usize>) -> Result<Self, HysteresisError> {
        let Some(count) = count else { return Ok(self) };
        let form = match self {
            Self::Usual => HysteresisForm::default(),
            Self::Given(form) => form,
            Self::Auto => {
                let allowed = "it compares families at their usual size".to_owned();
                return Err(HysteresisError::Elements { family: self.name(), found: count, allowed });
            }
        };
        form.with_elements(count).map(Self::Given)
    }

    /// Name to choose it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Usual => "usual",
            Self::Auto => "auto",
            Self::Given(form) => form.name(),
        }
    }

    /// Description in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Usual => "The usual one, as without this choice",
            Self::Auto => "The one with the smallest held-out error, of those that describe most stacks",
            Self::Given(form) => form.summary(),
        }
    }
}

impl From<HysteresisForm> for FamilyChoice {
    fn from(form: HysteresisForm) -> Self {
        Self::Given(form)
    }
}

/// Options of an identification; the defaults are meant to be right.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(rename = "HammersteinOptions")]
pub struct Options {
    /// Joint fit or two steps.
    pub method: Method,
    /// Family of the hysteresis block; any but the default needs the joint fit.
    pub hysteresis: FamilyChoice,
    /// Dynamic block.
    pub dynamics: DynamicsChoice,
    /// Poles of [`DynamicsChoice::Integer`] in a joint fit, 1 to 12, or of [`DynamicsChoice::Modes`], 2 to
    /// 12.
    pub order: usize,
    /// Creep factor of a joint fit. With [`DynamicsChoice::Auto`] and [`Creep::None`] a fractional one is
    /// added where the records support it.
    pub creep: Creep,
    /// The records are consecutive parts of one run on one clock: memory, creep and offset carry over. A
    /// record that begins before the previous one ends starts another run.
    pub continued: bool,
    /// State before each record of a joint fit.
    pub initial: Initial,
    /// A joint fit allows for a linear drift of each record's output.
    pub drift: bool,
    /// Optimiser; `None`: least squares from data-driven starts, with the linear parameters eliminated.
    pub algorithm: Option<Algorithm>,
    /// Generations of a population method.
    pub generations: usize,
    /// Seed of every random number.
    pub seed: u64,
    /// Threads; `None`: all cores. The result does not depend on it.
    pub threads: Option<usize>,
    /// Polynomial degree of l\[u\].
    pub degree: Choice<usize>,
    /// Exponent n of the hysteresis family; `Auto` searches it (`--n free`).
    pub n: Choice<f64>,
    /// Delay \[s\]. A given delay is the whole time shift between input and output: unless dynamics are
    /// requested, no lag is fitted to a quasi-static record.
    pub delay_s: Choice<f64>,
    /// Single parameters fixed or bounded.
    pub demands: Demands,
    /// Model whose parameters are the first start of every search; serialised as a model file.
    #[serde(with = "as_model_file")]
    #[schemars(with = "Option<hysteron_model::model_file::ModelFile>")]
    pub start: Option<Model>,
    /// Simulation scheme of the dynamic block; `Auto`: `band-limited` in a joint fit of records that start
    /// smoothly, whose estimates do not depend on the sample rate, else `tustin`.
    pub scheme: Choice<Scheme>,
    /// Inter-sample behaviour of the drive. `Auto`: in a joint fit with dynamics, chosen by likelihood where
    /// the records discriminate ([`InterSampleChoice`](super::InterSampleChoice)); else `linear`.
    pub inter_sample: Choice<InterSample>,
    /// Least fit \[%\] for which a model is returned.
    pub least_fit_percent: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Joint,
            hysteresis: FamilyChoice::Usual,
            dynamics: DynamicsChoice::Auto,
            order: 2,
            creep: Creep::None,
            continued: false,
            initial: Initial::Auto,
            drift: false,
            algorithm: None,
            generations: 150,
            seed: 1,
            threads: None,
            degree: Choice::Auto,
            n: Choice::Given(1.0),
            delay_s: Choice::Auto,
            demands: Demands::default(),
            start: None,
            scheme: Choice::Auto,
            inter_sample: Choice::Auto,
            least_fit_percent: 75.0,
        }
    }
}

/// Highest polynomial degree offered.
pub const HIGHEST_DEGREE: usize = 9;

impl Options {
    /// The inter-sample rule given, else the one tried first.
    pub(super) fn inter_sample(&self) -> InterSample {
        match self.inter_sample {
            Choice::Given(rule) => rule,
            Choice::Auto => InterSample::Linear,
        }
    }

    /// The family that a fit searches: that of [`Self::family`] with fewer unknowns, where it has one and no
    /// number of the family itself is asked for.
    pub fn searched_family(&self) -> HysteresisForm {
        let family = self.family();
        let own: Vec<String> = family.weight_names().into_iter().chain(family.shape_names()).collect();
        let is_asked_for = self.demands.names().any(|name| own.iter().any(|own| own == name));
        if is_asked_for { family } else { family.searched() }
    }

    /// The family given, else the default.
    pub fn family(&self) -> HysteresisForm {
        match self.hysteresis {
            FamilyChoice::Given(form) => form,
            FamilyChoice::Usual | FamilyChoice::Auto => HysteresisForm::default(),
        }
    }

    /// The scheme given, else `tustin`.
    pub(super) fn scheme(&self) -> Scheme {
        match self.scheme {
            Choice::Given(scheme) => scheme,
            Choice::Auto => Scheme::Tustin,
        }
    }
}

/// Serialises a Hammerstein model as its model file.
mod as_model_file {
    use super::Model;
    use hysteron_model::model_file::{ModelFile, SignalUnits};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    pub(super) fn serialize<S: Serializer>(model: &Option<Model>, serializer: S) -> Result<S::Ok, S::Error> {
        let file = model.as_ref().map(|model| ModelFile::from_model(model, SignalUnits::default()));
        file.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Model>, D::Error> {
        let file = Option::<ModelFile>::deserialize(deserializer)?;
        file.map(|file| file.to_model().map_err(de::Error::custom)).transpose()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use hysteron_model::dynamics::Dynamics;
    use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};

    #[test]
    fn options_are_read_back_and_what_is_left_out_is_the_default() {
        let hysteresis =
            ArticleOperator { polynomial: vec![0.1, 0.02], alpha: 0.3, beta: 0.2, gamma: -0.1, n: 1.0 };
        let start = Model {
            hysteresis: Hysteresis::from(hysteresis),
            dynamics: Dynamics::None,
            offset: 0.5,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Hold,
            sample_rate_hz: None,
        };
        let options = Options {
            hysteresis: FamilyChoice::Given(HysteresisForm::plays(9)),
            dynamics: DynamicsChoice::TwoFractional,
            creep: Creep::KelvinVoigt { elements: 3 },
            degree: Choice::Given(4),
            demands: Demands {
                fixed: vec![("offset".into(), 1.0)],
                bounded: vec![("delay".into(), 0.0, 1e-3)],
            },
            start: Some(start),
            ..Options::default()
        };
        let text = serde_json::to_string(&options).unwrap();
        assert_eq!(serde_json::from_str::<Options>(&text).unwrap(), options);
        let few: Options =
            serde_json::from_str(r#"{"dynamics": "fractional", "degree": {"given": 2}}"#).unwrap();
        let expected =
            Options { dynamics: DynamicsChoice::Fractional, degree: Choice::Given(2), ..Options::default() };
        assert_eq!(few, expected);
        assert!(serde_json::from_str::<Options>(r#"{"dynamic": "none"}"#).is_err());
    }
}
