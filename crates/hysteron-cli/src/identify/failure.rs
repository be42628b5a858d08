//! Why no model came of the records, with what to do about it.

use hysteron_identify::IdentifyError;
use hysteron_model::axes::AxesError;
use hysteron_model::model_file::Kind;
use hysteron_optimize::OptimizeError;

use crate::failure::Failure;

const RESUME: &str =
    "resume with the records and options of the interrupted run; or leave --resume out and begin anew";

/// The library's error in a fit of that kind, with what to do about it.
pub(super) fn explain(error: &IdentifyError, kind: Kind) -> Failure {
    let title = title(error, kind);
    let failure = Failure::new(title).because(error);
    match error {
        IdentifyError::UnknownParameter { .. }
        | IdentifyError::Demand { .. }
        | IdentifyError::CreepTakesJointFit
        | IdentifyError::Option { .. }
        | IdentifyError::OscillatorFixed { .. }
        | IdentifyError::ModesOption { .. } => Failure::usage(title).because(error).advised(error.advice()),
        IdentifyError::Optimize(OptimizeError::CheckpointProblem { .. }) => {
            failure.because("the interrupted searches are of other records or options").hint(RESUME)
        }
        IdentifyError::Optimize(e) if e.is_of_checkpoint() => failure.hint(RESUME),
        IdentifyError::Resume => failure.hint(RESUME),
        IdentifyError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; check the columns (--input, --output); --least-fit 0 \
             hands the model out all the same; --dynamic FILE names a record that carries dynamics; --degree \
             1 --fix alpha=0 is a linear device",
        ),
        IdentifyError::NoOscillator { .. } => failure.hint(
            "check the columns (--input is the force, --output the displacement) and their signs; without a \
             resonance in the record identify a Hammerstein model (leave --structure out)",
        ),
        IdentifyError::OscillatorClass { .. } => failure.hint(
            "look at the record with hysteron inspect; --initial free for a record cut out of motion; \
             --least-fit 0 hands the model out all the same",
        ),
        IdentifyError::AxesClass { .. } if kind == Kind::Modes => failure.hint(
            "check the columns and their order (--inputs, --outputs); --least-fit 0 hands the model out all \
             the same",
        ),
        IdentifyError::AxesClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); several modes a path need --structure \
             modes; --least-fit 0 hands the model out all the same",
        ),
        IdentifyError::Axes(AxesError::NotPeriodic { .. }) if kind == Kind::Modes => failure.hint(
            "drive the inputs with periodic multisines of different phases, two periods or more; --initial \
             periodic takes each record for one period of a steady state; --structure hammerstein fits \
             records that do not repeat",
        ),
        IdentifyError::Axes(AxesError::Dependent { .. }) if kind == Kind::Modes => {
            failure.hint("add records whose inputs have other phases, at the same level")
        }
        IdentifyError::NoBranches => {
            failure.hint("drive all inputs in the same record, each with a signal independent of the others")
        }
        _ => failure.advised(error.advice()),
    }
}

/// Headline of a failure: the result that is missing.
fn title(error: &IdentifyError, kind: Kind) -> &'static str {
    match (error, kind) {
        // Before it came to a fit of the kind.
        (
            IdentifyError::Records { .. }
            | IdentifyError::Unsupported(_)
            | IdentifyError::OtherStart { .. }
            | IdentifyError::Threads { .. },
            _,
        ) => "no model was identified",
        (_, Kind::Oscillator) => "no oscillator was identified",
        (_, Kind::Modes) => "no modes were identified",
        (_, Kind::Branches) => "no branches were identified",
        _ => "no model was identified",
    }
}
