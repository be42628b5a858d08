//! Values of the flags.

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use hysteron_identify::Choice;
use hysteron_model::record::InterSample;

use crate::numbers::number;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StructureArg {
    /// Hysteresis, then linear dynamics
    Hammerstein,
    /// A mass on a hysteretic spring: resonances move with the amplitude
    Oscillator,
    /// Force of a damper against a displacement: hysteresis beside terms of the rate
    Force,
    /// Several axes: structural modes with hysteresis in feedback, scheduled by the level of the drive
    Modes,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum OptimizerArg {
    Auto,
    DeAbc,
    Abc,
    De,
    Pso,
    CmaEs,
    LeastSquares,
}

/// [`Choice`] as clap wants it.
#[derive(Clone, Copy)]
pub(super) struct ChoiceArg<T>(pub(super) Choice<T>);

pub(super) fn degree(text: &str) -> Result<ChoiceArg<usize>, String> {
    if text == "auto" {
        return Ok(ChoiceArg(Choice::Auto));
    }
    let degree = text.parse().map_err(|_| "expected a whole number or auto".to_owned())?;
    Ok(ChoiceArg(Choice::Given(degree)))
}

/// Parser of an inter-sample rule, or auto.
pub(super) fn inter_sample() -> impl TypedValueParser<Value = ChoiceArg<InterSample>> {
    let auto = PossibleValue::new("auto").help("Recognised from the records if possible, else linear");
    let rules = InterSample::ALL.map(|rule| PossibleValue::new(rule.name()).help(rule.summary()));
    let possible: Vec<PossibleValue> = std::iter::once(auto).chain(rules).collect();
    PossibleValuesParser::new(possible)
        .map(|name: String| ChoiceArg(name.parse().map_or(Choice::Auto, Choice::Given)))
}

pub(super) fn exponent(text: &str) -> Result<ChoiceArg<f64>, String> {
    number_or(text, "free")
}

pub(super) fn delay(text: &str) -> Result<ChoiceArg<f64>, String> {
    number_or(text, "auto")
}

pub(super) fn number_or(text: &str, word: &str) -> Result<ChoiceArg<f64>, String> {
    if text == word {
        return Ok(ChoiceArg(Choice::Auto));
    }
    number(text).map(|x| ChoiceArg(Choice::Given(x))).map_err(|e| format!("{e} or {word}"))
}

pub(super) fn name_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE, e.g. gamma=0")?;
    Ok((name.trim().to_owned(), number(value.trim())?))
}

pub(super) fn name_range(text: &str) -> Result<(String, f64, f64), String> {
    const WANTED: &str = "expected NAME=LOW:HIGH, e.g. beta=0:2";
    let (name, range) = text.split_once('=').ok_or(WANTED)?;
    let (low, high) = range.split_once(':').ok_or(WANTED)?;
    Ok((name.trim().to_owned(), number(low.trim())?, number(high.trim())?))
}
