//! What can be asked of an identification and a comparison, from the library's own types.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Options with their schemas, defaults and choices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OptionsOffered {
    /// JSON schema of an identification's `task`: a kind with its options.
    pub task: Value,
    /// The tasks with their default options, by kind.
    pub defaults: Vec<Value>,
    /// Choices by name, each with a line of explanation.
    pub choices: Vec<Choices>,
    /// Names of parameters that can be held or bounded, per hysteresis family.
    pub structures: Vec<Choice>,
    /// Schema of the truth of the simulated bench.
    pub truth: Value,
    /// Its defaults.
    pub truth_default: Value,
    /// Schema of the plan of its records.
    pub plan: Value,
    /// Its defaults.
    pub plan_default: Value,
    /// Schema of a drive.
    pub drive: Value,
    /// Schema of the options of `track`.
    pub track: Value,
    /// Forms of source code.
    pub forms: Vec<FormOffered>,
    /// Operations that answer with tables and sentences.
    pub operations: Vec<OperationOffered>,
}

/// A form of source code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FormOffered {
    /// Its name.
    pub name: String,
    /// What it is, in a line.
    pub summary: String,
    /// The files that it writes.
    pub contents: String,
    /// Whether it is there in single precision.
    pub has_single_precision: bool,
    /// Whether a controller with feedback can be exported so.
    pub has_controllers: bool,
}

/// An operation with the schema of its options.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OperationOffered {
    /// Its name: `prepare`, `simulate`, `decouple`, `track-axes`, `design`, `recalibrate`, `adapt`, `realise`, `frequency-response`.
    pub name: String,
    /// Schema of its options.
    pub schema: Value,
    /// Their usual values.
    pub usual: Value,
}

/// Choices of one option.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Choices {
    /// Name of the option.
    pub option: String,
    /// What can be chosen.
    pub choices: Vec<Choice>,
}

/// One choice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Choice {
    /// Name on the command line.
    pub name: String,
    /// Explanation in a line.
    pub summary: String,
    /// Its value in a task.
    pub value: Value,
}
