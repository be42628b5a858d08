//! What can be wrong with a file. Lines and columns count from 1, as editors do.

use crate::atomic_file::AtomicWriteError;
use hysteron_model::record::RecordError;
use hysteron_model::record::ResponseDataError;

/// Why a file could not be read as a record, or a record not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The file cannot be opened.
    #[error("cannot open `{file}`: {source}")]
    Open {
        /// The file.
        file: String,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file cannot be read to its end.
    #[error("cannot read `{file}` beyond line {line}: {source}")]
    Read {
        /// The file.
        file: String,
        /// Last line read.
        line: u64,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The record cannot be written.
    #[error(transparent)]
    Write(#[from] AtomicWriteError),
    /// Nothing but blank lines and comments.
    #[error("`{file}` {what}: expected a header line such as `t_s,u_V,y_um` and one line a sample")]
    Empty {
        /// The file.
        file: String,
        /// What it is instead.
        what: &'static str,
    },
    /// A header without data.
    #[error(
        "`{file}` has a header (line {line}) but no samples below it; was the recording stopped before it began?"
    )]
    HeaderOnly {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
    },
    /// Numbers in the first line.
    #[error(
        "`{file}`, line {line}: found {columns} number(s) where the column names should be; add a header line above, e.g. `{suggestion}`, with the units that hold"
    )]
    NoHeader {
        /// The file.
        file: String,
        /// First line that is not a comment.
        line: u64,
        /// Fields in it.
        columns: usize,
        /// Header that could be added.
        suggestion: String,
    },
    /// One sample only.
    #[error("`{file}` has one sample only (line {line}); a record needs at least 2, a fit some hundreds")]
    OneSample {
        /// The file.
        file: String,
        /// Its line.
        line: u64,
    },
    /// More bytes than allowed.
    #[error(
        "`{file}` is larger than {limit_bytes} bytes (stopped in line {line}); raise the limit (`max_bytes`) if this is meant, or crop the file"
    )]
    TooLarge {
        /// The file.
        file: String,
        /// Line reached.
        line: u64,
        /// The limit.
        limit_bytes: u64,
    },
    /// More numbers than allowed.
    #[error(
        "`{file}`, line {line}: more than {limit} numbers to keep; choose columns with {choose_with}, or crop the file"
    )]
    TooManyValues {
        /// The file.
        file: String,
        /// Line reached.
        line: u64,
        /// The limit.
        limit: usize,
        /// The flags that choose columns.
        choose_with: &'static str,
    },
    /// More columns than a record can mean.
    #[error(
        "`{file}`, line {line}: {found} columns, more than {limit}; is this a record with one line a sample?"
    )]
    TooManyColumns {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// Columns found.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// A line without end.
    #[error(
        "`{file}`, line {line}: longer than {limit} bytes; expected text with one line a sample, is this a binary file or one with other line ends?"
    )]
    LineTooLong {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The limit.
        limit: usize,
    },
    /// Carriage returns within a line.
    #[error(
        "`{file}`, line {line}: carriage return within the line; save the file with LF or CRLF line ends"
    )]
    BareCarriageReturn {
        /// The file.
        file: String,
        /// The line.
        line: u64,
    },
    /// Bytes that are no UTF-8.
    #[error(
        "`{file}`, line {line}, column {column}: byte 0x{byte:02X} is not UTF-8 text; save the file as UTF-8 ({hint})"
    )]
    NotUtf8 {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column (field).
        column: usize,
        /// First byte that does not fit.
        byte: u8,
        /// What the file may be instead.
        hint: &'static str,
    },
    /// A quote that is not closed in its line.
    #[error(
        "`{file}`, line {line}, column {column}: a quoted field is not closed on its line; remove or close the quote"
    )]
    UnclosedQuote {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
    },
    /// A column without a name.
    #[error("`{file}`, line {line}, column {column}: no column name; give every column one, e.g. `u_V`")]
    UnnamedColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column.
        column: usize,
    },
    /// Two columns of one name.
    #[error("`{file}`, line {line}: columns {first} and {second} are both called `{name}`; rename one")]
    DuplicateColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The name.
        name: String,
        /// First column of that name.
        first: usize,
        /// Second column of that name.
        second: usize,
    },
    /// A chosen column that is not there.
    #[error("`{file}`, line {line}: no column `{asked}` ({flag}); the columns are {available}")]
    NoSuchColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// What was asked for.
        asked: String,
        /// The flag it was asked with.
        flag: &'static str,
        /// The columns there are.
        available: String,
    },
    /// A choice that several columns match.
    #[error(
        "`{file}`, line {line}: `{asked}` ({flag}) could be any of {candidates}; write the name with its unit, or the column's number"
    )]
    AmbiguousColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// What was asked for, or looked for.
        asked: String,
        /// The flag that decides.
        flag: &'static str,
        /// The columns it could be.
        candidates: String,
    },
    /// A chosen time column that is not in a unit of time.
    #[error(
        "`{file}`, line {line}: column `{name}` cannot be the time (--time), it is in {unit}; expected s, ms, us, ns or min"
    )]
    NotTime {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column.
        name: String,
        /// Its unit.
        unit: String,
    },
    /// A frequency response, not samples in time.
    #[error(
        "`{file}`, line {line}: column `{column}` makes this look like a frequency response, not a record in time; expected columns such as `t_s,u_V,y_um`"
    )]
    FrequencyResponse {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The column that gives it away.
        column: String,
    },
    /// No frequency column where a frequency response is wanted.
    #[error(
        "`{file}`, line {line}: no frequency among the columns {found}; expected columns such as `f_Hz,re,im` or `f_Hz,magnitude,phase_deg`"
    )]
    NoFrequency {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The columns found.
        found: String,
    },
    /// Frequencies without a complex value.
    #[error(
        "`{file}`, line {line}: no complex response among the columns {found}; expected real and imaginary part (`re,im`, `stage_re,stage_im`) or magnitude and phase (`magnitude,phase_deg`, `magnitude_dB,phase_rad`)"
    )]
    NoResponse {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The columns found.
        found: String,
    },
    /// Several responses, or none of the name asked for.
    #[error("`{file}`, line {line}: {problem}; the responses are {available}; choose one with {flag}")]
    ChooseResponse {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// What is the matter.
        problem: String,
        /// Names of the responses.
        available: String,
        /// The flag that decides.
        flag: &'static str,
    },
    /// A frequency that is not positive.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): found `{found}`, expected a frequency above 0; delete the line"
    )]
    BadFrequency {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
        /// The text found.
        found: String,
    },
    /// Two lines at one frequency.
    #[error("`{file}`: two lines at {frequency_hz} Hz; average them or delete one")]
    RepeatedFrequency {
        /// The file.
        file: String,
        /// The frequency \[Hz\].
        frequency_hz: f64,
    },
    /// What was read is not a usable frequency response.
    #[error("`{file}`: {source}")]
    Response {
        /// The file.
        file: String,
        /// What is wrong with it.
        source: Box<ResponseDataError>,
    },
    /// No channel besides time and mask.
    #[error(
        "`{file}`, line {line}: no channel besides {found}; expected columns such as `t_s,u_V,y_um`; is the delimiter none of comma, semicolon, tab?"
    )]
    NoChannels {
        /// The file.
        file: String,
        /// Line of the header.
        line: u64,
        /// The columns found.
        found: String,
    },
    /// Text where a number should be.
    #[error("`{file}`, line {line}, column {column} (`{name}`): found `{found}`, expected a number{hint}")]
    NotANumber {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
        /// The text found, cut to a readable length.
        found: String,
        /// What to do, where the text gives a clue; begins with a separator.
        hint: String,
    },
    /// An empty field.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): empty, expected a number; cut the record there or fill the gap and mark it 0 in a `valid` column"
    )]
    MissingValue {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
    },
    /// NaN, an infinity, or a number too large for a double.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): `{found}` is not a finite number; cut the record there or fill the gap and mark it 0 in a `valid` column"
    )]
    NotFinite {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
        /// The text found.
        found: String,
    },
    /// Decimal commas in a comma-separated file.
    #[error(
        "`{file}`, line {line}: {found} fields where the header has {expected}: decimal commas in a comma-separated file cannot be told from delimiters; export it with semicolons or tabs between the columns, or with decimal points"
    )]
    DecimalCommas {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// Decimal commas and decimal points in one file.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): `{found}` mixes with the decimal {other} of line {other_line}; thousands separators are not read, write all numbers in one way"
    )]
    MixedDecimalMarks {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
        /// The text found.
        found: String,
        /// `point` or `comma`.
        other: &'static str,
        /// First line with the other mark.
        other_line: u64,
    },
    /// A line with too few or too many fields.
    #[error(
        "`{file}`, line {line}: {found} fields where the header (line {header_line}) has {expected}{hint}"
    )]
    Ragged {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
        /// Line of the header.
        header_line: u64,
        /// What to do, where there is a clue; begins with a separator.
        hint: &'static str,
    },
    /// A last line that stops in the middle.
    #[error(
        "`{file}`, line {line}: the last line is cut off after {found} of {expected} fields; was the recording interrupted? Delete that line to use the rest"
    )]
    Truncated {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// Fields found.
        found: usize,
        /// Fields of the header.
        expected: usize,
    },
    /// A mask value that is neither 0 nor 1.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): found `{found}`, expected 0 (do not score) or 1"
    )]
    BadMask {
        /// The file.
        file: String,
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Its name.
        name: String,
        /// The text found.
        found: String,
    },
    /// Time that runs backwards.
    #[error(
        "`{file}`, line {line}, column {column} (`{name}`): time runs backwards, {after} s after {before} s; sort the rows, or split the file where the clock was reset"
    )]
    TimeDecreases {
        /// The file.
        file: String,
        /// Line of the earlier stamp that comes later.
        line: u64,
        /// The time column.
        column: usize,
        /// Its name.
        name: String,
        /// Time of the line before \[s\].
        before: f64,
        /// Time of this line \[s\].
        after: f64,
    },
    /// What was read is not a usable record.
    #[error("{source}")]
    Record {
        /// The file.
        file: String,
        /// What is wrong with it.
        source: Box<RecordError>,
    },
}
