//! What can be asked, from the library's own types and lists.

use hysteron_export::ClosedLoop;
use hysteron_identify::design::DesignOptions;
use hysteron_identify::structure::{Block, Candidate};
use hysteron_identify::{DynamicsChoice, FamilyChoice, Initial, Method, Task};
use hysteron_model::dynamics::{Creep, Scheme};
use hysteron_model::model::DecouplingRequest;
use hysteron_model::model_file::Kind;
use hysteron_model::record::InterSample;
use hysteron_model::tracking::{Controller, TrackOptions};
use hysteron_rig::excitation::ExcitationSpec;
use hysteron_rig::{CampaignPlan, Truth};
use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::Value;

use crate::api::{
    AdaptOptions, Choice, Choices, FormOffered, OperationOffered, OptionsOffered, PrepareOptions,
    RealiseOptions, RecalibrateOptions, ResponseFitOptions, SimulateOptions, TrackAxesOptions,
};

/// Options with their schemas, defaults and choices.
pub(crate) fn offered() -> OptionsOffered {
    OptionsOffered {
        task: schema::<Task>(),
        defaults: Kind::ALL.iter().map(|kind| value(&Task::of(*kind))).collect(),
        choices: vec![
            choices("hysteresis", FamilyChoice::offered(), |c| c.name(), |c| c.summary()),
            choices("dynamics", DynamicsChoice::ALL, |c| c.name(), |c| c.summary()),
            choices("creep", Creep::USUAL, |c| c.name(), |c| c.summary()),
            choices("method", Method::ALL, |c| c.name(), |c| c.summary()),
            choices("initial", Initial::ALL, |c| c.name(), |c| c.summary()),
            choices("scheme", Scheme::ALL, |c| c.name(), |c| c.summary()),
            choices("inter_sample", InterSample::ALL, |c| c.name(), |c| c.summary()),
            choices("controllers", Controller::ALL, |c| c.name(), |c| c.summary()),
            choices("exported_controllers", ClosedLoop::EXPORTED, |c| c.name(), |c| c.summary()),
        ],
        structures: structures(),
        truth: schema::<Truth>(),
        truth_default: value(&Truth::default()),
        plan: schema::<CampaignPlan>(),
        plan_default: value(&CampaignPlan::default()),
        drive: schema::<ExcitationSpec>(),
        track: schema::<TrackOptions>(),
        forms: hysteron_export::Form::ALL.into_iter().map(form).collect(),
        operations: vec![
            operation::<PrepareOptions>("prepare"),
            operation::<SimulateOptions>("simulate"),
            operation::<DecouplingRequest>("decouple"),
            operation::<TrackAxesOptions>("track-axes"),
            operation::<DesignOptions>("design"),
            operation::<RecalibrateOptions>("recalibrate"),
            operation::<AdaptOptions>("adapt"),
            operation::<RealiseOptions>("realise"),
            operation::<ResponseFitOptions>("frequency-response"),
        ],
    }
}

/// The structures that a comparison can be asked for, without creep and with it.
fn structures() -> Vec<Choice> {
    let of = |dynamics: DynamicsChoice| Candidate::of(Block { dynamics, order: 2 });
    let dynamics = [
        DynamicsChoice::None,
        DynamicsChoice::Integer,
        DynamicsChoice::Fractional,
        DynamicsChoice::TwoFractional,
    ];
    let plain = dynamics.into_iter().map(|dynamics| (of(dynamics), dynamics.summary()));
    let creeping = dynamics
        .into_iter()
        .skip(1)
        .map(|dynamics| (Candidate { creep: Creep::Fractional, ..of(dynamics) }, dynamics.summary()));
    let choice = |(candidate, summary): (Candidate, &str)| Choice {
        name: candidate.to_string(),
        summary: summary.to_owned(),
        value: Value::String(candidate.to_string()),
    };
    plain.chain(creeping).map(choice).collect()
}

fn choices<T: Serialize>(
    option: &str,
    all: impl IntoIterator<Item = T>,
    name: impl Fn(&T) -> &'static str,
    summary: impl Fn(&T) -> &'static str,
) -> Choices {
    let choice = |one: T| Choice {
        name: name(&one).to_owned(),
        summary: summary(&one).to_owned(),
        value: value(&one),
    };
    Choices { option: option.to_owned(), choices: all.into_iter().map(choice).collect() }
}

fn form(form: hysteron_export::Form) -> FormOffered {
    FormOffered {
        name: form.name().to_owned(),
        summary: form.summary().to_owned(),
        contents: form.contents().to_owned(),
        has_single_precision: form.has_single_precision(),
        has_controllers: form.has_controllers(),
    }
}

fn operation<T: JsonSchema + Default + Serialize>(name: &str) -> OperationOffered {
    OperationOffered { name: name.to_owned(), schema: schema::<T>(), usual: value(&T::default()) }
}

fn schema<T: JsonSchema>() -> Value {
    schema_for!(T).to_value()
}

fn value(of: &impl Serialize) -> Value {
    serde_json::to_value(of).unwrap_or_default()
}
