//! Jobs: one computation at a time, the others wait.

use hysteron_identify::modes::ModesComparisonSummary;
use hysteron_identify::{CandidateSummary, ComparisonSummary, Task};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Problem;

/// A job to be queued.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum JobRequest {
    /// Identifies a model.
    Identify {
        /// Identifiers of the records.
        records: Vec<String>,
        /// Kind of model with its options; left out: a Hammerstein model with the usual ones.
        #[serde(default)]
        task: Option<Task>,
        /// Structure by its name, as a comparison ranks them, in place of `task`.
        #[serde(default)]
        structure: Option<String>,
        /// Model whose parameters are the first start of every search, of the kind of the task.
        #[serde(default)]
        start: Option<String>,
        /// Identifier of the model to write, `stage.json`; left out: named after record and structure.
        #[serde(default)]
        model: Option<String>,
        /// Columns of the inputs, for a kind of several axes.
        #[serde(default)]
        inputs: Vec<String>,
        /// Columns of the outputs, for a kind of several axes.
        #[serde(default)]
        outputs: Vec<String>,
        /// Write the report too, beside the model.
        #[serde(default)]
        report: bool,
    },
    /// Compares structures by their error on held-out data.
    Compare {
        /// Identifiers of the records.
        records: Vec<String>,
        /// Structures; empty: a search.
        #[serde(default)]
        candidates: Vec<String>,
        /// One pass through the commonest structures only.
        #[serde(default)]
        quick: bool,
        /// Ends the search after this time \[s\].
        #[serde(default)]
        time_limit_s: Option<f64>,
        /// The records are parts of one run.
        #[serde(default)]
        continued: bool,
        /// Columns of the inputs: structures of several axes are compared.
        #[serde(default)]
        inputs: Vec<String>,
        /// Columns of the outputs, likewise.
        #[serde(default)]
        outputs: Vec<String>,
        /// Write the report, under this identifier, `compare.html`.
        #[serde(default)]
        report: Option<String>,
    },
}

/// State of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JobState {
    /// In the queue.
    Waiting,
    /// Computing.
    Running,
    /// Finished.
    Done,
    /// Stopped; the best so far is kept.
    Stopped,
    /// Ended with an error.
    Failed,
    /// The program ended while it ran; the last saved state is kept.
    Interrupted,
}

/// A job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Job {
    /// Number.
    pub id: i64,
    /// What was asked.
    pub request: JobRequest,
    /// Name for people: the model, or `compare`.
    pub name: String,
    /// State.
    pub state: JobState,
    /// Number of changes so far: of two pieces of news the one with the greater number is the newer.
    #[serde(default)]
    pub revision: u64,
    /// Names of the stages in their usual order, as far as they are known before: the name of a stage that is
    /// entered begins with one of them, and one may be left out.
    pub planned: Vec<String>,
    /// Stages entered so far, the last one is the current one.
    pub stages: Vec<Stage>,
    /// Share done, 0 to 1; never decreases.
    pub fraction: f64,
    /// Best cost so far, in `unit`.
    pub cost: Option<f64>,
    /// Symbol of the unit of the cost; empty where it is weighted.
    pub unit: String,
    /// Time it has run \[s\].
    pub elapsed_s: f64,
    /// Estimated time left \[s\].
    pub left_s: Option<f64>,
    /// Jobs before it in the queue.
    pub ahead: usize,
    /// Commands that do the same.
    pub command: Command,
    /// Queued at (ISO 8601, UTC).
    pub created: String,
    /// Begun at.
    pub started: Option<String>,
    /// Ended at.
    pub ended: Option<String>,
    /// A stopped or interrupted job that can go on from where it was.
    pub resumable: bool,
    /// What it made.
    pub result: JobResult,
    /// What goes wrong beside it while it runs: the best so far cannot be kept.
    #[serde(default)]
    pub warning: Option<String>,
    /// Why it failed.
    pub error: Option<Problem>,
}

/// A stage of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stage {
    /// Its name.
    pub name: String,
    /// Begun after this time of the job \[s\].
    pub from_s: f64,
    /// Best cost in it; on thinned data in some stages, so that costs of stages differ in more than the fit.
    pub cost: Option<f64>,
}

/// What a job made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct JobResult {
    /// Identifiers of models.
    pub models: Vec<String>,
    /// Identifiers of reports.
    pub reports: Vec<String>,
    /// Candidates of a comparison that are finished, in the order of their error, while it runs.
    pub candidates: Vec<CandidateSummary>,
    /// Ranking of a comparison at its end.
    pub comparison: Option<ComparisonSummary>,
    /// Ranking of structures of several axes at its end.
    pub axes_comparison: Option<ModesComparisonSummary>,
}

/// The commands that do the same as the page.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Command {
    /// In a shell, in the workspace's folder.
    pub shell: String,
    /// In Python.
    pub python: String,
}
