//! Identified models for where they are used: C99 source, a `no_std` Rust crate, functional mock-up units.
//!
//! * [`Subject`]: a model realised at one sample rate, with its name, units, range and scores.
//! * [`c_files`]: one header, one source without `malloc`, and a self-test with golden vectors.
//! * [`rust_files`]: a `no_std` crate on top of `hysteron-rt`, with the same golden vectors.
//! * [`fmu_files`]: FMI 2.0 and 3.0 for co-simulation, source and binary.
//! * [`Inverse`], [`inverse_files`], [`inverse_fmu_files`]: the inverse, reference in and voltage out, in the same forms.
//! * [`write_folder`]: all files or none.
//!
//! The arithmetic of the exported source is that of `hysteron-rt`, operation by operation: in double precision the two differ by what the
//! functions of `<math.h>` differ by.

mod c;
mod error;
mod escape;
mod files;
mod fmu;
mod golden;
mod inverse;
mod number;
mod rust_crate;
mod subject;
mod summary;
mod template;

pub use c::c_files;
pub use error::ExportError;
pub use files::{ExportedFile, write_folder};
pub use fmu::{fmu_files, inverse_fmu_files};
pub use golden::{Golden, Rounding};
pub use inverse::{GoldenInverse, Inverse, inverse_files};
pub use number::Precision;
pub use rust_crate::{Runtime, rust_files};
pub use subject::Subject;
pub use summary::{ExportSummary, FileSummary};
