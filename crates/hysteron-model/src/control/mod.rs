//! The closed loop: feedforward, feedback and both, tuned from the identified model with stated margins, and
//! played on a plant.
//!
//! ```text
//! reference ─┬────────────► + ─► inverse, or a straight line ─► drive ─► stage ─┬─► displacement
//!            └─► − ─► feedback ─┘                                              │
//!                ▲─────────────────────────────────────────── reading ◄────────┘
//! ```
//!
//! Feedback acts on the displacement, ahead of the inverse ([`crate::compensator`]): what it adds to the
//! reference passes the limits and the memory of the hysteresis as the reference does. The reading of one
//! period determines the drive of the next, so the delay of the loop is that period, the hold and the plant's
//! delay; tuning ([`tune`]) and the stated [`Margins`] include all three. Theory: `docs/theory/control.md`.

mod adaptive;
mod amplifier;
mod error;
mod law;
mod line;
mod margins;
mod parts;
mod play;
mod score;
mod sines;
mod strategy;
mod tuning;

pub use adaptive::{Adaptive, AdaptiveFilter, AdaptiveParts, step_limit};
pub use amplifier::{Reach, reach, slew_of_current};
pub use error::{ControlError, StageError};
pub use law::{FeedbackKind, FeedbackLaw, FeedbackParts, Notch};
pub use line::StraightLine;
pub use margins::{Margins, loop_frequencies};
pub use parts::ControllerParts;
pub(crate) use play::play_metered;
pub use play::{Plant, Played, Stage, StageRun, StageSample, play};
pub use score::TrackingScore;
pub use sines::{Edge, Followed, SineAnswer, Sines};
pub use strategy::{Bandwidth, Forward, Loop, LoopSettings, Strategy};
pub use tuning::{LawFamily, RequiredMargins, Still, Tuned, tune, tune_observer};
