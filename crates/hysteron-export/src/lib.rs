//! Identified models for where they are used: C99 source, a `no_std` Rust crate, functional mock-up
//! units, functions of MATLAB, Simulink S-functions.
//!
//! * [`export`]: the files of a model as they are asked for, by an [`ExportRequest`].
//! * [`Subject`]: a model realised at one sample rate, with its name, units, range and scores.
//! * [`c_files`]: one header, one source without `malloc`, and a self-test with golden vectors.
//! * [`rust_files`]: a `no_std` crate on top of `hysteron-rt`, with the same golden vectors.
//! * [`fmu_files`]: FMI 2.0 and 3.0 for co-simulation, source and binary.
//! * [`matlab_files`], [`matlab_inverse_files`]: functions of MATLAB and GNU Octave.
//! * [`simulink_files`], [`simulink_inverse_files`]: an S-function around the C.
//! * [`Form`]: the list of all these, and the files of each.
//! * [`Inverse`], [`inverse_files`], [`inverse_fmu_files`]: the inverse, reference in and voltage out, in the
//!   same forms.
//! * [`AxesSubject`], [`axes_files`], [`axes_inverse_files`], [`axes_rust_files`]: a model of several axes
//!   and its inverse, as C and Rust.
//! * [`ClosedLoop`], [`controller_files`]: the inverse with a feedback law or an observer around it.
//! * [`DryRun`]: the inverse in the number type of its source beside double precision, before it is
//!   written.
//! * [`write_folder`]: all files or none.
//!
//! The arithmetic of the exported source is that of `hysteron-rt`, operation by operation: in double
//! precision the two differ by what the functions of `<math.h>` differ by.

mod axes;
mod c;
mod closed_loop;
mod dry_run;
mod error;
mod escape;
mod fmu;
mod form;
mod golden;
mod inverse;
mod matlab;
mod number;
mod operator;
mod origin;
mod request;
mod rust_crate;
mod saved;
mod simulink;
mod subject;
mod summary;
mod template;

pub use axes::{
    AxesExportRequest, AxesExported, AxesSubject, axes_files, axes_fmu_files, axes_inverse_files,
    axes_rust_files, export_axes,
};
pub use c::c_files;
pub use closed_loop::{ClosedLoop, GoldenLoop, controller_files};
pub use dry_run::DryRun;
pub use error::ExportError;
pub use fmu::{Platform, controller_fmu_files, fmu_files, inverse_fmu_files};
pub use form::{Form, Means};
pub use golden::{Golden, Rounding};
pub use hysteron_io::NamedFile;
pub use inverse::{GoldenInverse, Inverse, inverse_files};
pub use matlab::{matlab_files, matlab_inverse_files};
pub use number::Precision;
pub use origin::Origin;
pub use request::{ExportRequest, Exported, export, name_of};
pub use rust_crate::{RUNTIME, rust_files};
pub use simulink::{simulink_files, simulink_inverse_files};
pub use subject::Subject;
pub use summary::{ExportSummary, FileSummary};

/// Writes the files of an export into `folder`, made where it does not exist, all of them or none. Files of
/// other names stay as they are; one of the same name is replaced where an export wrote it.
///
/// # Errors
/// [`ExportError::Folder`]. Nothing has changed then.
pub fn write_folder(folder: &std::path::Path, files: &[NamedFile]) -> Result<(), ExportError> {
    Ok(hysteron_io::write_folder(folder, files, Some(MARK))?)
}

/// Marks exported files: a file without these bytes was not written by an export and is not overwritten.
const MARK: &[u8] = b"hysteron export";
