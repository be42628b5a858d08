//! Records and models of several inputs and outputs.

mod flags;
mod identify;
mod loaded;
mod scored;

pub use flags::AxesFlags;
pub use identify::ModesFlags;
pub use loaded::LoadedModes;
pub use scored::{AxesScored, table};
