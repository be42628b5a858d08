//! Errors of reading and writing files.

use hysteron_numeric::display::exact;
use std::path::PathBuf;

use crate::atomic_file::AtomicWriteError;
use hysteron_model::advice::ColumnRole;
use hysteron_model::model_file::ModelFileError;
use hysteron_model::record::RecordError;

use crate::json_file::JsonFileError;
use crate::place::Place;
use crate::response_file_error::ResponseFileError;

/// Error of this crate: why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file cannot be opened.
    #[error("cannot open `{file}`: {source}")]
    Open {
        /// The file.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be read to its end.
    #[error("{place}: cannot be read: {source}")]
    Read {
        /// Place in the file.
        place: Place,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] AtomicWriteError),
    /// Nothing but blank lines and comments.
    #[error("`{file}` {what}: expected a header line such as `t_s,u_V,y_um` and one line a sample")]
    Empty {
        /// The file.
        file: String,
        /// Its state: empty, or without data.
        what: &'static str,
    },
    /// Arrays without data.
    #[error("{place}: its columns hold no samples; was the recording stopped before it began?")]
    NoSamples {
        /// The file.
        place: Place,
    },
    /// A header without data.
    #[error(
        "`{}` has a header{} but no samples below it; was the recording stopped before it began?",
        place.file,
        place.in_brackets("")
    )]
    HeaderOnly {
        /// Place in the file.
        place: Place,
    },
    /// Numbers in the first line.
    #[error(
        "{place}: found {columns} number(s) where the column names should be; add a header line above, e.g. \
         `{suggestion}`, with the units that hold"
    )]
    NoHeader {
        /// Place in the file.
        place: Place,
        /// Fields in it.
        columns: usize,
        /// Header that could be added.
        suggestion: String,
    },
    /// One sample only.
    #[error(
        "`{}` has one sample only{}; a record needs at least 2, a fit some hundreds",
        place.file,
        place.in_brackets("")
    )]
    OneSample {
        /// Place in the file.
        place: Place,
    },
    /// Columns of different lengths.
    #[error(
        "{place}: {found} samples where `{reference}` has {expected}; cut them to one length, or choose \
         other columns"
    )]
    LengthMismatch {
        /// Place in the file.
        place: Place,
        /// Its number of samples.
        found: usize,
        /// Number of samples of the column it is compared with.
        expected: usize,
        /// Header of that column.
        reference: String,
    },
    /// A binary file that does not hold what its format says.
    #[error("{place}: no sound {format} file: {problem}; write it again, or save the record as CSV")]
    Malformed {
        /// Place in the file.
        place: Place,
        /// The format.
        format: &'static str,
        /// The problem.
        problem: String,
    },
    /// An array of something else than real numbers.
    #[error(
        "{place}: found values of type {found}, expected real numbers of 8 to 64 bits or bool; convert it \
         (`.astype(float)`), or choose other columns"
    )]
    ArrayType {
        /// Place in the file.
        place: Place,
        /// The type, as the file names it.
        found: String,
    },
    /// An array that is no column.
    #[error(
        "{place}: shape {found}, expected a column: (n,), (n, 1) or (1, n); save each column under a name of \
         its own, or choose other columns"
    )]
    ArrayShape {
        /// Place in the file.
        place: Place,
        /// The shape.
        found: String,
    },
    /// An array without names of columns.
    #[error(
        "{place}: an array of shape {found} without column names; save named ones with their units, e.g. \
         `numpy.savez(\"record.npz\", t_s=t, u_V=u, y_um=y)`"
    )]
    NoNames {
        /// The file.
        place: Place,
        /// The shape.
        found: String,
    },
    /// An invalid sample rate in the file.
    #[error(
        "{place}: no sample rate follows from {value}, expected a finite number above 0; correct it",
        value = exact(*.value)
    )]
    BadRate {
        /// Place in the file.
        place: Place,
        /// The number found.
        value: f64,
    },
    /// Sample rates in the file that differ.
    #[error(
        "{place}: {hz} Hz, but {other_hz} Hz by `{other}`; give the sample rate that holds",
        hz = exact(*.hz),
        other_hz = exact(*.other_hz)
    )]
    ChooseRate {
        /// Place of one of them.
        place: Place,
        /// That rate \[Hz\].
        hz: f64,
        /// The array that gives another one.
        other: String,
        /// The other rate \[Hz\].
        other_hz: f64,
    },
    /// A sample rate in the file that its time column contradicts.
    #[error("{place}: {source}")]
    RateContradictsTime {
        /// Place of the rate.
        place: Place,
        /// Both rates.
        source: Box<RecordError>,
    },
    /// More bytes than allowed.
    #[error(
        "`{}` is larger than {limit_bytes} bytes{}; raise the limit (`max_bytes`) if this is meant, or crop \
         the file",
        place.file,
        place.in_brackets("stopped in ")
    )]
    TooLarge {
        /// Place in the file.
        place: Place,
        /// The limit.
        limit_bytes: u64,
    },
    /// More numbers than allowed.
    #[error("{place}: more than {limit} numbers to keep; choose the columns needed, or crop the file")]
    TooManyValues {
        /// Place in the file.
        place: Place,
        /// The limit.
        limit: usize,
    },
    /// More columns than a record may have.
    #[error("{place}: {found} columns, more than {limit}; is this a record with one line a sample?")]
    TooManyColumns {
        /// Place in the file.
        place: Place,
        /// Columns found.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// A line without end.
    #[error(
        "{place}: longer than {limit} bytes; expected text with one line a sample, is this a binary file or \
         one with other line ends?"
    )]
    LineTooLong {
        /// Place in the file.
        place: Place,
        /// The limit.
        limit: usize,
    },
    /// Carriage returns within a line.
    #[error("{place}: carriage return within the line; save the file with LF or CRLF line ends")]
    BareCarriageReturn {
        /// Place in the file.
        place: Place,
    },
    /// Bytes that are no UTF-8.
    #[error("{place}: byte 0x{byte:02X} is not UTF-8 text; save the file as UTF-8 ({hint})")]
    NotUtf8 {
        /// Place in the file.
        place: Place,
        /// First byte that does not fit.
        byte: u8,
        /// Probable format of the file.
        hint: &'static str,
    },
    /// A quote that is not closed in its line.
    #[error("{place}: a quoted field is not closed on its line; remove or close the quote")]
    UnclosedQuote {
        /// Place in the file.
        place: Place,
    },
    /// A format that is not written.
    #[error("cannot write {path}: no .{extension} is written; use .csv, .npz or .mat")]
    NotWritten {
        /// Path of the file.
        path: String,
        /// Its extension.
        extension: String,
    },
    /// A column without a name, or with one that cannot be printed.
    #[error("{place}: no column name of printable characters; give every column one, e.g. `u_V`")]
    UnnamedColumn {
        /// Place in the file.
        place: Place,
    },
    /// Two columns of one name.
    #[error("{place}: columns {first} and {second} are both called `{name}`; rename one")]
    DuplicateColumn {
        /// Place in the file.
        place: Place,
        /// The name.
        name: String,
        /// First column of that name.
        first: usize,
        /// Second column of that name.
        second: usize,
    },
    /// A chosen column that is not there.
    #[error("{place}: no column `{asked}` to be the {role}; the columns are {available}")]
    NoSuchColumn {
        /// Place in the file.
        place: Place,
        /// Column asked for.
        asked: String,
        /// Intended role.
        role: ColumnRole,
        /// The columns there are.
        available: String,
    },
    /// A choice that several columns match.
    #[error(
        "{place}: `{asked}`, the {role}, could be any of {candidates}; write the name with its unit, or the \
         column's number"
    )]
    AmbiguousColumn {
        /// Place in the file.
        place: Place,
        /// Column asked for, or looked for.
        asked: String,
        /// Intended role.
        role: ColumnRole,
        /// The columns it could be.
        candidates: String,
    },
    /// Arrays that make no single record unless some are chosen.
    #[error("{place}: {problem}; the file holds {held}")]
    ChooseArrays {
        /// Place in the file.
        place: Place,
        /// The problem.
        problem: String,
        /// The arrays, with shape and unit.
        held: String,
    },
    /// A chosen time column that is not in a unit of time.
    #[error("{place}: column `{name}` cannot be the time, it is in {unit}; expected s, ms, us, ns or min")]
    NotTime {
        /// Place in the file.
        place: Place,
        /// The column.
        name: String,
        /// Its unit.
        unit: String,
    },
    /// A frequency response, not samples in time.
    #[error(
        "{place}: column `{column}` makes this look like a frequency response, not a record in time; \
         expected columns such as `t_s,u_V,y_um`"
    )]
    FrequencyResponse {
        /// Place in the file.
        place: Place,
        /// The column that indicates it.
        column: String,
    },
    /// The file holds no frequency response.
    #[error(transparent)]
    ResponseFile(#[from] ResponseFileError),
    /// No channel besides time and mask.
    #[error(
        "{place}: no channel besides {found}; expected columns such as `t_s,u_V,y_um`; is the delimiter none \
         of comma, semicolon, tab?"
    )]
    NoChannels {
        /// Place in the file.
        place: Place,
        /// The columns found.
        found: String,
    },
    /// Text where a number should be.
    #[error("{place}: found `{found}`, expected a number{hint}")]
    NotANumber {
        /// Place in the file.
        place: Place,
        /// The text found, cut to a readable length.
        found: String,
        /// Remedy, where the text suggests one; begins with a separator.
        hint: &'static str,
    },
    /// An empty field.
    #[error(
        "{place}: empty, expected a number; cut the record there or fill the gap and mark it 0 in a `valid` \
         column"
    )]
    MissingValue {
        /// Place in the file.
        place: Place,
    },
    /// NaN, an infinity, or a number too large for a double.
    #[error(
        "{place}: `{found}` is not a finite number; cut the record there or fill the gap and mark it 0 in a \
         `valid` column"
    )]
    NotFinite {
        /// Place in the file.
        place: Place,
        /// The text found.
        found: String,
    },
    /// Decimal commas in a comma-separated file.
    #[error(
        "{place}: {found} fields where the header has {expected}: decimal commas in a comma-separated file \
         cannot be distinguished from delimiters; export it with semicolons or tabs between the columns, or \
         with decimal points"
    )]
    DecimalCommas {
        /// Place in the file.
        place: Place,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// Decimal commas and decimal points in one file.
    #[error(
        "{place}: `{found}` mixes with the decimal {other} of line {other_line}; thousands separators are \
         not read, write all numbers in one way"
    )]
    MixedDecimalMarks {
        /// Place in the file.
        place: Place,
        /// The text found.
        found: String,
        /// `point` or `comma`.
        other: &'static str,
        /// First line with the other mark.
        other_line: u64,
    },
    /// A line with too few or too many fields.
    #[error("{place}: {found} fields where the header (line {header_line}) has {expected}{hint}")]
    Ragged {
        /// Place in the file.
        place: Place,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
        /// Line of the header.
        header_line: u64,
        /// Remedy, where one is known; begins with a separator.
        hint: &'static str,
    },
    /// A last line that stops in the middle.
    #[error(
        "{place}: the last line is cut off after {found} of {expected} fields; was the recording \
         interrupted? Delete that line to use the rest"
    )]
    Truncated {
        /// Place in the file.
        place: Place,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// A mask value that is neither 0 nor 1.
    #[error("{place}: found `{found}`, expected 0 (do not score) or 1")]
    BadMask {
        /// Place in the file.
        place: Place,
        /// The text found.
        found: String,
    },
    /// Time that runs backwards.
    #[error(
        "{place}: time runs backwards, {after} s after {before} s; sort the rows, or split the file where \
         the clock was reset",
        after = exact(*.after),
        before = exact(*.before)
    )]
    TimeDecreases {
        /// Place in the file.
        place: Place,
        /// Time of the line before \[s\].
        before: f64,
        /// Time of this line \[s\].
        after: f64,
    },
    /// A text condition on a column that is numeric by its format.
    #[error("{place}: holds numbers, `{text}` is none; ask for a number or a range")]
    TextCondition {
        /// The array.
        place: Place,
        /// The text.
        text: String,
    },
    /// A new name with another unit.
    #[error(
        "{place}: `{name}` is in {unit}, and a new name `{to}` converts no number; scale it to another unit"
    )]
    RenamedUnit {
        /// Place in the file.
        place: Place,
        /// Header of the column.
        name: String,
        /// Its unit.
        unit: String,
        /// The new name.
        to: String,
    },
    /// The data read do not make a usable record.
    #[error("{source}")]
    Record {
        /// The file.
        file: String,
        /// The reason.
        source: Box<RecordError>,
    },
    /// An existing file in the folder lacks the mark of files written before.
    #[error("{} is there already and was not written by an export", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The folder or a file of it cannot be written.
    #[error("{action} {} failed: {source}", path.display())]
    Folder {
        /// The step that failed.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A JSON or model file cannot be read.
    #[error(transparent)]
    Json(#[from] JsonFileError),
    /// A model file that holds no sound model.
    #[error(transparent)]
    Model(#[from] ModelFileError),
}
