//! Records and models of several inputs and outputs.

mod branches;
mod flags;
mod identify;
mod loaded;
mod scored;

pub use branches::identify_branches;
pub use flags::AxesFlags;
pub use identify::ModesFlags;
pub use loaded::LoadedAxes;
pub use scored::{AxesScored, table};

use hysteron_identify::FindingKind;

/// A finding's kind in a word.
fn kind_name(kind: FindingKind) -> &'static str {
    match kind {
        FindingKind::Verdict => "verdict",
        FindingKind::Advice => "advice",
        FindingKind::Warning => "warning",
    }
}
