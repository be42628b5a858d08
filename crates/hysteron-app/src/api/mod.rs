//! Requests and responses of `/api/v1`, as types; `openapi.json` is made from their schemas.
//!
//! Quantities are in the units that the name or a neighbouring `unit` states. Identifiers of records, models
//! and reports are paths relative to the workspace, with `/` between folders.

mod bench;
mod curve;
mod error;
mod follow;
mod job;
mod live;
mod model;
mod option;
mod record;
mod report;
mod result;
mod workspace;

pub use bench::{BenchMade, BenchRequest, DriveMade, DriveRequest};
pub use curve::{Axis, Curve, CurveQuery};
pub use error::{Line, Problem, Refusal};
pub use follow::{
    FollowRequest, Followed, Reference, TrackRequest, Tracked, TrackedController, TrackedCurve,
};
pub use job::{Command, Job, JobRequest, JobResult, JobState, Stage};
pub use live::{CostPoint, Live, LiveLoop, LiveUpdate, RequestProgress};
pub use model::{
    DownloadQuery, ExportFile, Form, Judged, ModelCurves, ModelCurvesQuery, ModelDetail, ModelEntry,
    ModelPatch, ParameterRow, Preview, ResponseQuery, ResponseRow, Responses, Score, ScoreDefinition, Scored,
    ScoresRequest, Series, View,
};
pub use option::{Choice, Choices, FormOffered, OperationOffered, OptionsOffered};
pub(crate) use record::kind_for;
pub use record::{
    Column, ColumnUse, Gap, ProspectsRequest, ProspectsTogether, RecordDetail, RecordEntry, RecordSettings,
    Role, UploadQuery,
};
pub use report::ReportEntry;
pub use result::{
    AdaptOptions, AdaptRequest, BandOf, DecoupleRequest, DesignRequest, Figure, Listed, Outcome,
    PrepareOptions, PrepareRequest, RealiseOptions, RealiseRequest, RecalibrateOptions, RecalibrateRequest,
    ResponseFitOptions, ResponseFitRequest, SimulateOptions, SimulateRequest, TrackAxesOptions,
    TrackAxesRequest,
};
pub use workspace::{Changed, Example, ExampleOpened, History, Trashed, Workspace};
