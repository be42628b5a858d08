//! The operations, by what they are about.

pub(super) mod bench;
pub(super) mod follow;
pub(super) mod jobs;
pub(super) mod models;
pub(super) mod records;
pub(super) mod reports;
pub(super) mod workspace;
