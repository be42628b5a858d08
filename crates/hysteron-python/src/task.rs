//! Identification tasks from names of options in Python.

use std::collections::BTreeMap;

use hysteron_identify::{
    Choice, Demands, DynamicsChoice, FamilyChoice, Initial, Method, Options, Task, coupled, force, modes,
    oscillator,
};
use hysteron_model::UnknownName;
use hysteron_model::dynamics::{Creep, Scheme};
use hysteron_model::model_file::Kind;
use hysteron_model::record::InterSample;
use hysteron_optimize::Algorithm;
use pyo3::prelude::*;
use serde::Deserialize;

use crate::errors::{from_json, option, raised};

/// Options of a Hammerstein model; missing ones take the library's defaults.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HammersteinOptions {
    hysteresis: Option<String>,
    elements: Option<usize>,
    dynamics: Option<String>,
    order: Option<usize>,
    creep: Option<String>,
    creep_elements: Option<usize>,
    method: Option<String>,
    initial: Option<String>,
    drift: Option<bool>,
    continued: Option<bool>,
    optimizer: Option<String>,
    population: Option<usize>,
    generations: Option<usize>,
    seed: Option<u64>,
    threads: Option<usize>,
    degree: Option<usize>,
    /// A number, or `free`.
    n: Option<Exponent>,
    delay_s: Option<f64>,
    fixed: Option<BTreeMap<String, f64>>,
    bounds: Option<BTreeMap<String, (f64, f64)>>,
    scheme: Option<String>,
    inter_sample: Option<String>,
    least_fit_percent: Option<f64>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Exponent {
    Value(f64),
    Word(String),
}

/// The task of a kind of model with its options as JSON.
pub fn task(kind: Kind, options: &str) -> PyResult<Task> {
    Ok(match kind {
        Kind::Hammerstein => Task::Hammerstein(Box::new(hammerstein(from_json(options)?)?)),
        Kind::Oscillator => Task::Oscillator(from_json::<oscillator::Options>(options)?),
        Kind::Force => Task::Force(from_json::<force::Options>(options)?),
        Kind::Modes => Task::Modes(from_json::<modes::Options>(options)?),
        Kind::Branches => Task::Branches(from_json::<coupled::Options>(options)?),
    })
}

fn hammerstein(asked: HammersteinOptions) -> PyResult<Options> {
    let default = Options::default();
    // `auto` equals no name.
    fn of(name: &Option<String>) -> Option<&str> {
        name.as_deref().filter(|name| *name != "auto")
    }
    let hysteresis =
        named("hysteresis family", &asked.hysteresis, FamilyChoice::offered(), FamilyChoice::name)?;
    let hysteresis = hysteresis.unwrap_or_default().with_elements(asked.elements).map_err(option)?;
    let creep = match asked.creep.as_deref() {
        None | Some("none") => Creep::None,
        Some(name) => UnknownName::find("creep", name, Creep::USUAL, Creep::name).map_err(raised)?,
    };
    let creep = match asked.creep_elements {
        None => creep,
        Some(count) => creep
            .with_elements(count)
            .ok_or_else(|| option("creep_elements belongs to creep=\"kelvin-voigt\""))?,
    };
    let dynamics = named("dynamic block", &asked.dynamics, DynamicsChoice::ALL, DynamicsChoice::name)?;
    let method = named("method", &asked.method, Method::ALL, Method::name)?;
    let initial = named("start", &asked.initial, Initial::ALL, Initial::name)?;
    let algorithm = match of(&asked.optimizer) {
        None => None,
        Some(name) => Some(Algorithm::called(name, asked.population).map_err(option)?),
    };
    let scheme = of(&asked.scheme).map(|name| name.parse::<Scheme>().map_err(raised)).transpose()?;
    let inter_sample =
        of(&asked.inter_sample).map(|name| name.parse::<InterSample>().map_err(raised)).transpose()?;
    Ok(Options {
        method: method.unwrap_or(default.method),
        hysteresis,
        dynamics: dynamics.unwrap_or(default.dynamics),
        order: asked.order.unwrap_or(default.order),
        creep,
        continued: asked.continued.unwrap_or(default.continued),
        initial: initial.unwrap_or(default.initial),
        drift: asked.drift.unwrap_or(default.drift),
        algorithm,
        generations: asked.generations.unwrap_or(default.generations),
        seed: asked.seed.unwrap_or(default.seed),
        threads: asked.threads,
        degree: asked.degree.map_or(default.degree, Choice::Given),
        n: match asked.n {
            None => default.n,
            Some(Exponent::Value(n)) => Choice::Given(n),
            Some(Exponent::Word(word)) if word == "free" => Choice::Auto,
            Some(Exponent::Word(word)) => {
                return Err(option(format!("n: expected a number or \"free\", found \"{word}\"")));
            }
        },
        delay_s: asked.delay_s.map_or(default.delay_s, Choice::Given),
        demands: Demands {
            fixed: asked.fixed.unwrap_or_default().into_iter().collect(),
            bounded: asked
                .bounds
                .unwrap_or_default()
                .into_iter()
                .map(|(name, (low, high))| (name, low, high))
                .collect(),
        },
        start: None,
        scheme: scheme.map_or(default.scheme, Choice::Given),
        inter_sample: inter_sample.map_or(default.inter_sample, Choice::Given),
        least_fit_percent: asked.least_fit_percent.unwrap_or(default.least_fit_percent),
    })
}

/// Item of `all` with this name, if one is given.
fn named<T: Copy>(
    what: &'static str,
    name: &Option<String>,
    all: impl IntoIterator<Item = T>,
    name_of: impl Fn(T) -> &'static str,
) -> PyResult<Option<T>> {
    let found = name.as_deref().map(|name| UnknownName::find(what, name, all, name_of));
    found.transpose().map_err(raised)
}
