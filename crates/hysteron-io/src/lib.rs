//! File formats of measured records: file to [`Record`](hysteron_model::record::Record) and back.
//!
//! [`read_record`] takes what loggers, spreadsheets and numerical tools write and either returns a checked
//! record or an [`IoError`] that names file, line and column (or array and index), what was found, what was
//! expected and what to do. [`read_input_output`] also decides which column drives and which responds.
//! [`write_record`] writes a record, as CSV, NPZ or MAT, so that it reads back to the same numbers.
//!
//! # Formats
//! Delimited text (CSV), MAT, HDF5, TDMS, NPY and NPZ, XLSX, LVM, GCS arrays, JPK archives. The format is
//! detected by the first bytes, else by the extension; anything else is text.
//!
//! # Columns, in every format
//! * A header is a name with its unit behind the last underscore (`u_V`, `u_cmd_V`, `H_A_per_m`) or in
//!   brackets (`u [V]`); see [`split_header`](hysteron_model::record::split_header).
//! * Time: the column `t`, `time` or `timestamp`, or else the only one with a unit of time; in s where it has
//!   no unit. Stamps must not decrease; equal ones are accepted and make the time base non-uniform.
//! * A column `valid` of 0 and 1 is the sample mask. All other columns are channels and must be numbers;
//!   where both input and output are chosen, only these are read.
//!
//! # Text
//! * One header line, one line a sample. Delimiter comma, semicolon or tab, detected; decimal comma where the
//!   delimiter is not a comma. UTF-8, with or without byte order mark; LF or CRLF. Quoted fields within a
//!   line.
//! * Lines that begin with `#` or `%` are comments, anywhere; blank lines are skipped. Where the first line
//!   is all numbers and the comment line above it has as many fields, that comment is the header (as numpy's
//!   `savetxt` writes it). A file without any header is refused, with the line to add.
//!
//! # Files of named arrays
//! MAT, HDF5, TDMS, XLSX, NPZ, LVM, GCS and JPK files list what they hold ([`contents`]). The rules for
//! headers hold for the last component of a path (`rec.u`, `signals(2).values`, `group/channel`, `sheet!B`);
//! a unit that the file gives counts where the name has none. A column is named by its whole path or by any
//! unambiguous end of it. Vectors are columns, a matrix of at most 16 columns or rows gives one each; a
//! single number is none, but may give the sample rate. Where several arrays could be the record, the error
//! lists them with shape and unit.
//!
//! * MAT 4 to 7: either byte order, doubles stored narrow, compressed; structures, arrays of them, cells. MAT
//!   7.3 is HDF5.
//! * HDF5: integers, floats and booleans, chunked and compressed; attributes `unit` and `units`.
//! * TDMS: several segments, interleaved or not, scaled; `unit_string`, `wf_increment`. Raw data of DAQmx
//!   devices are refused.
//! * XLSX: one table a sheet, with or without a line of headers; dates in s from the first one.
//! * LVM and GCS: LabVIEW's text and the arrays of Physik Instrumente, with their rates.
//! * JPK: force archives of atomic force microscopes; each channel of a curve, in each of its units.
//!
//! # Arrays
//! * NPZ: an array of shape (n,), (n, 1) or (1, n) is a column, its name the header. Arrays of one number are
//!   no columns: `fs` or `sample_rate` (in Hz; `fs_kHz`, `sample_rate_hz`) or `dt` (in s; `dt_ms`, `dt_us`)
//!   give the sample rate where there is no time column, the others are not read.
//! * NPY: the fields of a structured array are the columns. A plain array has no names and is refused.
//! * Integers of 8 to 64 bits, floats of 32 and 64 bits, bool; either byte order.
//!
//! A measured frequency response is read by [`read_frequency_response`], by the same rules for formats, text
//! and numbers.
#![forbid(unsafe_code)]

mod archive;
mod assemble;
pub mod atomic_file;
mod atomic_folder;
mod batch;
mod bytes;
mod columns;
mod container;
mod contents;
mod csv;
mod csv_write;
mod error;
mod error_place;
mod frequency_response;
mod gcs;
mod hash;
mod hdf5;
mod jpk;
mod json_file;
mod laboratory_text;
mod lvm;
mod mat;
mod mat_write;
mod model_file;
mod npy;
mod npz;
mod npz_write;
mod one_record;
mod options;
mod place;
mod read;
mod reader;
mod rename;
mod response_file_error;
mod roles;
mod tdms;
mod write;
mod xlsx;

pub use atomic_folder::{NamedFile, temporary_folder, write_folder};
pub use batch::{Batch, BatchError};
pub use contents::{Content, contents, contents_of_bytes};
pub use csv_write::{write_csv, write_csv_to};
pub use error::IoError;
pub use frequency_response::{ResponseOptions, read_frequency_response, read_frequency_response_bytes};
pub use hash::sha256;
pub use json_file::{JsonFileError, load_json, save_json};
pub use mat_write::write_mat;
pub use model_file::{load_model, load_model_and_source, save_model};
pub use npz_write::write_npz;
pub use options::ReadOptions;
pub use place::{FilePart, Place};
pub use read::{
    PartRead, ReadOutcome, holds_named_arrays, read_drive, read_input_output, read_input_output_bytes,
    read_part, read_record, read_record_bytes, read_reference, record_extensions,
};
pub use rename::{Rename, RenameError};
pub use response_file_error::ResponseFileError;
pub use write::write_record;
