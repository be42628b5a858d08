//! Failures of an identification, with remedies.

use std::path::Path;

use hysteron_identify::IdentifyError;
use hysteron_identify::force::ForceError;
use hysteron_model::axes::AxesError;
use hysteron_model::model_file::Kind;
use hysteron_optimize::OptimizeError;

use crate::advice;
use crate::failure::Failure;

const RESUME: &str =
    "resume with the records and options of the interrupted run; or leave out --resume to start again";

/// Failure of an identification that was interrupted while it compared families of hysteresis.
pub(super) fn interrupted(file: &Path) -> Failure {
    Failure::new("the fit was interrupted")
        .because(format!("what is done so far is in {}", file.display()))
        .hint(format!("go on with the same command and --resume {}", file.display()))
}

/// Failure for a library error in a fit of this kind, with a remedy.
pub(super) fn explain(error: &IdentifyError, kind: Kind) -> Failure {
    let title = title(error, kind);
    let failure = Failure::new(title).because(error);
    match error {
        IdentifyError::UnknownParameter { .. }
        | IdentifyError::Demand { .. }
        | IdentifyError::CreepTakesJointFit
        | IdentifyError::Option { .. }
        | IdentifyError::OscillatorFixed { .. }
        | IdentifyError::Force(ForceError::Fixed { .. } | ForceError::Option { .. })
        | IdentifyError::ModesOption { .. } => Failure::usage(title).because(error).advised(error.advice()),
        IdentifyError::Optimize(OptimizeError::CheckpointProblem { .. }) => {
            failure.because("the interrupted searches belong to other records or options").hint(RESUME)
        }
        IdentifyError::Optimize(e) if e.is_of_checkpoint() => failure.hint(RESUME),
        IdentifyError::Resume => failure.hint(RESUME),
        IdentifyError::ModelClass { .. } => failure.hint(
            "look at the record with hysteron inspect; check the columns (--input, --output); --least-fit 0 \
             returns the model regardless; --dynamic FILE names a record that carries dynamics; --degree 1 \
             --fix alpha=0 is a linear device",
        ),
        IdentifyError::NoOscillator { .. } => failure.hint(
            "check the columns (--input is the force, --output the displacement) and their signs; without a \
             resonance in the record identify a Hammerstein model (leave --structure out)",
        ),
        IdentifyError::OtherKind { kind, .. } => {
            failure.hint(format!("--structure {kind}; --least-fit 0 returns the model regardless"))
        }
        IdentifyError::DeadBand { .. } => failure
            .hint("--least-fit 0 returns the model regardless")
            .hint_first(error.advice().as_ref().map(advice::in_flags).unwrap_or_default()),
        IdentifyError::OscillatorClass { .. } => failure.hint(
            "look at the record with hysteron inspect; --initial free for a record cut out of motion; \
             --least-fit 0 returns the model regardless",
        ),
        IdentifyError::Force(ForceError::Class { .. }) => failure.hint(
            "check the columns (--input is the displacement, --output the force) and their signs; \
             --hysteresis takes another family; --least-fit 0 returns the model regardless",
        ),
        IdentifyError::Force(ForceError::Record { .. }) => {
            failure.hint("choose the columns with --input and --output")
        }
        IdentifyError::Force(ForceError::NoTimes { .. }) => {
            failure.hint("name the time column with --time, or give --sample-rate")
        }
        IdentifyError::AxesClass { .. } if kind == Kind::Modes => failure.hint(
            "check the columns and their order (--inputs, --outputs); --least-fit 0 returns the model \
             regardless",
        ),
        IdentifyError::AxesClass { .. } => failure.hint(
            "check the columns and their order (--inputs, --outputs); several modes per path need \
             --structure modes; --least-fit 0 returns the model regardless",
        ),
        IdentifyError::Axes(AxesError::NotPeriodic { .. }) if kind == Kind::Modes => failure.hint(
            "drive the inputs with periodic multisines of different phases, two periods or more; --initial \
             periodic treats each record as one period of a steady state; --structure hammerstein fits \
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

/// Headline of a failure: the missing result.
fn title(error: &IdentifyError, kind: Kind) -> &'static str {
    match (error, kind) {
        // Errors raised before the fit of this kind began.
        (
            IdentifyError::Records { .. }
            | IdentifyError::Unsupported(_)
            | IdentifyError::OtherStart { .. }
            | IdentifyError::Threads { .. },
            _,
        ) => "no model was identified",
        (_, Kind::Oscillator) => "no oscillator was identified",
        (_, Kind::Force) => "no force was identified",
        (_, Kind::Modes) => "no modes were identified",
        (_, Kind::Branches) => "no branches were identified",
        _ => "no model was identified",
    }
}
