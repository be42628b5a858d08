//! Values of the flags.

use clap::ValueEnum;
use hysteron_identify::Choice;
use hysteron_model::dynamics::Scheme;
use hysteron_model::record::InterSample;

use crate::numbers::number;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StructureArg {
    /// Hysteresis, then linear dynamics
    Hammerstein,
    /// A mass on a hysteretic spring: resonances move with the amplitude
    Oscillator,
    /// Several axes: structural modes with hysteresis in feedback, that move with the level of the drive
    Modes,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodArg {
    /// All records, both blocks, delay and initial states in one fit
    Joint,
    /// The article's way: hysteresis from slow records, then dynamics from the others
    TwoStep,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum InitialArg {
    /// Rest, judged by the record
    Auto,
    /// Rest at the first sample, with an unknown hysteresis memory
    Rest,
    /// The record is a steady state that repeats
    Periodic,
    /// Rest at 0 V without memory
    Zero,
    /// Rest, with motion left over from before
    Free,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum DynamicsArg {
    None,
    /// Whole orders: pairs of poles and, for an odd --order, a lag in series
    Integer,
    /// Resonances in parallel and, for an odd --order, a lag behind them
    Modes,
    /// Equation error, sampled (two steps)
    Arx,
    /// Output error B/F, sampled (two steps)
    Oe,
    /// Box–Jenkins: output error B/F with a noise model C/D, sampled (two steps)
    Bj,
    /// B(s)/A(s) in continuous time by refined instrumental variables (two steps)
    Srivc,
    /// b / (s^a2 + c1 s^a1 + c0)
    Fractional,
    /// b / (s^a2 + c1 s^a1 + c0 s^a0)
    FractionalFreeLowest,
    /// Two fractional modes in parallel
    TwoFractional,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum CreepArg {
    /// 1 + k s^-mu: a power law without an end
    Fractional,
    /// 1 + gamma log10(1 + t/t0) after a unit step: the same amount every decade of time
    Logarithmic,
    /// 1 + sum of k/(1 + tau s): springs and dampers, creep that comes to an end
    KelvinVoigt,
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

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SchemeArg {
    Tustin,
    GrunwaldLetnikov,
    Bdf2,
    BandLimited,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum InterSampleArg {
    Hold,
    Linear,
    BandLimited,
}

impl From<InterSampleArg> for InterSample {
    fn from(arg: InterSampleArg) -> Self {
        match arg {
            InterSampleArg::Hold => InterSample::Hold,
            InterSampleArg::Linear => InterSample::Linear,
            InterSampleArg::BandLimited => InterSample::BandLimited,
        }
    }
}

impl From<SchemeArg> for Scheme {
    fn from(arg: SchemeArg) -> Self {
        match arg {
            SchemeArg::Tustin => Scheme::Tustin,
            SchemeArg::GrunwaldLetnikov => Scheme::GrunwaldLetnikov,
            SchemeArg::Bdf2 => Scheme::Bdf2,
            SchemeArg::BandLimited => Scheme::BandLimited,
        }
    }
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
