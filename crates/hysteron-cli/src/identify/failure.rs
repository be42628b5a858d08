//! Why no model came of the records, with what to do about it.

use hysteron_identify::coupled::CoupledFitError;
use hysteron_identify::modes::ModesFitError;
use hysteron_identify::oscillator::OscillatorFitError;
use hysteron_identify::{FitError, IdentifyError};
use hysteron_optimize::OptimizeError;

use crate::failure::Failure;

const NO_MODEL: &str = "no model was identified";
const NO_OSCILLATOR: &str = "no oscillator was identified";
const NO_MODES: &str = "no modes were identified";
const NO_BRANCHES: &str = "no branches were identified";

const RESUME: &str =
    "resume with the records and options of the interrupted run; or leave --resume out and begin anew";

/// The library's error with what to do about it.
pub(super) fn explain(error: &FitError) -> Failure {
    let failure = failure_of(error);
    if failure.has_hint() { failure } else { failure.advised(error.advice()) }
}

fn failure_of(error: &FitError) -> Failure {
    match error {
        FitError::Hammerstein(e) => hammerstein(e),
        FitError::Oscillator(e) => oscillator(e),
        FitError::Modes(e) => modes(e),
        FitError::Branches(e) => branches(e),
        error => Failure::new(NO_MODEL).because(error),
    }
}

/// A fit that cannot go on from what was given to go on from.
fn cannot_resume(title: &str, error: &OptimizeError) -> Failure {
    let failure = Failure::new(title).hint(RESUME);
    match error {
        OptimizeError::CheckpointProblem { .. } => {
            failure.because("the interrupted searches are of other records or options")
        }
        error => failure.because(error),
    }
}

fn hammerstein(error: &IdentifyError) -> Failure {
    let failure = Failure::new(NO_MODEL).because(error);
    match error {
        IdentifyError::UnknownParameter { .. }
        | IdentifyError::Demand { .. }
        | IdentifyError::CreepTakesJointFit
        | IdentifyError::Option { .. } => Failure::usage(NO_MODEL).because(error),
        IdentifyError::Optimize(e) if e.is_of_checkpoint() => cannot_resume(NO_MODEL, e),
        IdentifyError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; check the columns (--input, --output); --least-fit 0 hands the model \
             out all the same; --dynamic FILE names a record that carries dynamics; --degree 1 --fix alpha=0 is a linear device",
        ),
        _ => failure,
    }
}

fn oscillator(error: &OscillatorFitError) -> Failure {
    let failure = Failure::new(NO_OSCILLATOR).because(error);
    match error {
        OscillatorFitError::Fixed { .. } => Failure::usage(NO_OSCILLATOR).because(error),
        OscillatorFitError::Optimize(e) if e.is_of_checkpoint() => cannot_resume(NO_OSCILLATOR, e),
        OscillatorFitError::NoOscillator { .. } => failure.hint(
            "check the columns (--input is the force, --output the displacement) and their signs; without a resonance in the \
             record identify a Hammerstein model (leave --structure out)",
        ),
        OscillatorFitError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; --initial free for a record cut out of motion; --least-fit 0 hands \
             the model out all the same",
        ),
        _ => failure,
    }
}

fn modes(error: &ModesFitError) -> Failure {
    let failure = Failure::new(NO_MODES).because(error);
    match error {
        ModesFitError::Resume => failure.hint(RESUME),
        ModesFitError::Option { .. } => Failure::usage(NO_MODES).because(error),
        ModesFitError::ModelClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); --least-fit 0 hands the model out all the same",
        ),
        ModesFitError::Axes(hysteron_model::axes::AxesError::NotPeriodic { .. }) => failure.hint(
            "drive the inputs with periodic multisines of different phases, two periods or more; --initial periodic takes each record for \
             one period of a steady state; --structure hammerstein fits records that do not repeat",
        ),
        ModesFitError::Axes(hysteron_model::axes::AxesError::Dependent { .. }) => {
            failure.hint("add records whose inputs have other phases, at the same level")
        }
        _ => failure,
    }
}

fn branches(error: &CoupledFitError) -> Failure {
    let failure = Failure::new(NO_BRANCHES).because(error);
    match error {
        CoupledFitError::Optimize(e) if e.is_of_checkpoint() => cannot_resume(NO_BRANCHES, e),
        CoupledFitError::ModelClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); several modes a path need --structure modes; --least-fit 0 hands \
             the model out all the same",
        ),
        CoupledFitError::NoStart => failure.hint("drive all inputs in the same record, each with a signal of its own"),
        _ => failure,
    }
}
