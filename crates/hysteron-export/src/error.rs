//! Why a model was not exported.

use hysteron_io::IoError;
use hysteron_model::invert::InversionError;
use hysteron_model::realise::RealiseError;

/// Error of an export.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The export was stopped by its listener.
    #[error("it was stopped")]
    Stopped,
    /// The name is no identifier of C and Rust.
    #[error(
        "`{name}` is not a valid name prefix in C and Rust: expected 1 to 48 of the letters a to z, digits \
         and _, a letter first, no keyword"
    )]
    Name {
        /// The name.
        name: String,
    },
    /// No form of that name.
    #[error("`{name}` is no form of an export: {}", crate::Form::ALL.map(crate::Form::name).join(", "))]
    Form {
        /// The name.
        name: String,
    },
    /// Not for MATLAB in single precision.
    #[error(
        "MATLAB functions compute in double precision: single precision is for controllers, in C or Rust"
    )]
    MatlabPrecision,
    /// The name is no name of MATLAB.
    #[error(
        "`{name}` is no name of a MATLAB function: it is a word of the language, or longer than 63 letters \
         with `_parameters` behind it"
    )]
    MatlabName {
        /// The name.
        name: String,
    },
    /// No sample rate is known.
    #[error("the model was identified from records without a sample rate, and a controller runs at one")]
    SampleRate,
    /// The model cannot be realised.
    #[error(transparent)]
    Realise(#[from] RealiseError),
    /// There is no inverse.
    #[error(transparent)]
    Inverse(#[from] InversionError),
    /// There is no inverse of several axes.
    #[error(transparent)]
    Decoupling(Box<hysteron_model::decoupling::DecouplingError>),
    /// The kind of model has no export.
    #[error(transparent)]
    Unsupported(#[from] hysteron_model::model::Unsupported),
    /// A form that is not there for models of several axes yet.
    #[error("a model of several axes is exported as C99, Rust or FMUs, not as {form} yet")]
    OneAxis {
        /// The form asked for.
        form: String,
    },
    /// Nothing to test.
    #[error("the {what} is constant along the drive of the self-test, which would pass with any source")]
    Still {
        /// Result that is constant.
        what: &'static str,
    },
    /// Single precision is too coarse.
    #[error(
        "single precision may move the {what} by {bound:.2e} {unit}, {percent:.2} % of its range: at most 1 \
         % is exported"
    )]
    Rounding {
        /// Result concerned.
        what: &'static str,
        /// Bound on its rounding error.
        bound: f64,
        /// Unit of the bound.
        unit: String,
        /// The bound in percent of the result's range.
        percent: f64,
    },
    /// No controller to export.
    #[error(
        "controller `{controller}` is not exported: those with the inverse and a feedback law or an observer \
         are: {}",
        exported()
    )]
    Controller {
        /// Its name.
        controller: &'static str,
    },
    /// A predicting controller without a frequency.
    #[error("controller `{controller}` predicts the reference: say up to which frequency it may move")]
    Prediction {
        /// Its name.
        controller: &'static str,
    },
    /// A controller in another form.
    #[error("a controller is exported as C99, Rust or FMUs, with the inverse, not as {form}")]
    ControllerForm {
        /// The form asked for.
        form: &'static str,
    },
    /// A controller without its inverse.
    #[error("a controller is exported with the inverse that it runs: ask for both")]
    ControllerAlone,
    /// A controller of several axes.
    #[error(
        "controller `{controller}` is not exported for a model of several axes: feedback there corrects drives \
         that are computed ahead for the whole references; the inverse alone runs sample by sample"
    )]
    AxesController {
        /// Its name.
        controller: &'static str,
    },
    /// A controller cannot be designed or played.
    #[error(transparent)]
    Control(#[from] hysteron_model::control::ControlError),
    /// The source would fail its own test.
    #[error(
        "a dry run of the single-precision {what} departs from the double-precision one by {departure:.2e} \
         {unit} along its own test vectors, where {bound:.2e} {unit} is allowed"
    )]
    Departs {
        /// Inverse or controller.
        what: &'static str,
        /// Largest difference.
        departure: f64,
        /// Largest difference allowed.
        bound: f64,
        /// Unit of both.
        unit: String,
    },
    /// The folder cannot be written.
    #[error(transparent)]
    Folder(#[from] IoError),
    /// No binary could be made.
    #[error("the C compiler `{compiler}` {problem}")]
    Compiler {
        /// Its name.
        compiler: String,
        /// The problem.
        problem: String,
    },
    /// No archive could be made.
    #[error("the archive of the FMU cannot be made: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// A template refers to an undefined item.
    #[error("internal: undefined template item {place}")]
    Template {
        /// Where.
        place: String,
    },
}

/// Names of the controllers that are exported.
fn exported() -> String {
    crate::ClosedLoop::EXPORTED.map(hysteron_model::tracking::Controller::name).join(", ")
}
