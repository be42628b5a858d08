//! Tracking of a reference by several controllers: page, tables and words.

mod axes;
mod page;
mod tables;
mod words;

pub use axes::{AxesTracked, axes_page};
pub use page::page;
pub use tables::{TextTable, adaptations, bandwidths, errors, margins, reaches};
pub use words::{OF_ADAPTATIONS, introduction, of_bandwidths, of_runaways};
