//! Lines of a file with their numbers, hashed and counted on the way, in bounded memory.

use std::io::{BufRead, BufReader, Read};

use crate::hash::hexadecimal;
use sha2::{Digest, Sha256};

use crate::IoError;
use crate::options::MAX_LINE_BYTES;
use crate::place::{FilePart, Place};

/// Reader that hashes what passes and stops one byte after a limit.
struct Hashed<R> {
    inner: R,
    hash: Sha256,
    bytes: u64,
    limit: u64,
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let allowed = (self.limit + 1).saturating_sub(self.bytes);
        let want = buffer.len().min(usize::try_from(allowed).unwrap_or(usize::MAX));
        let got = self.inner.read(&mut buffer[..want])?;
        self.hash.update(&buffer[..got]);
        self.bytes += got as u64;
        Ok(got)
    }
}

/// The lines of a file, one at a time.
pub(crate) struct Lines<R> {
    reader: BufReader<Hashed<R>>,
    buffer: Vec<u8>,
    file: String,
    /// Number of the line last read, from 1.
    line: u64,
    /// Bytes of the lines read.
    position: u64,
    /// Last byte of a line: a line feed; a carriage return in a file that has no line feeds (old Macintosh).
    end: u8,
}

/// One line, without its line end.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    /// Counted from 1.
    pub number: u64,
    pub bytes: &'a [u8],
    /// Whether it ended with a line feed; only a file's last line may not.
    pub ended: bool,
}

impl<R: Read> Lines<R> {
    pub fn new(file: &str, inner: R, limit: u64) -> Self {
        let limit = limit.min(u64::MAX - 1);
        let hashed = Hashed { inner, hash: Sha256::new(), bytes: 0, limit };
        Lines {
            reader: BufReader::with_capacity(1 << 16, hashed),
            buffer: Vec::new(),
            file: file.to_string(),
            line: 0,
            position: 0,
            end: b'\n',
        }
    }

    /// Next line without its line end (and without the byte order mark); `None` at the end of the file.
    pub fn next_line(&mut self) -> Result<Option<Line<'_>>, IoError> {
        self.buffer.clear();
        if self.line == 0 {
            let first = self.reader.fill_buf().unwrap_or_default();
            let is_old_macintosh = !first.contains(&b'\n') && first.contains(&b'\r');
            self.end = if is_old_macintosh { b'\r' } else { b'\n' };
        }
        let end = self.end;
        let read = (&mut self.reader).take(MAX_LINE_BYTES as u64 + 1).read_until(end, &mut self.buffer);
        if let Err(source) = read {
            return Err(IoError::Read { place: self.place(self.line + 1), source });
        }
        if self.buffer.len() > MAX_LINE_BYTES {
            return Err(IoError::LineTooLong { place: self.place(self.line + 1), limit: MAX_LINE_BYTES });
        }
        let hashed = self.reader.get_ref();
        if hashed.bytes > hashed.limit {
            return Err(IoError::TooLarge { place: self.place(self.line + 1), limit_bytes: hashed.limit });
        }
        if self.buffer.is_empty() {
            return Ok(None);
        }
        self.line += 1;
        self.position += self.buffer.len() as u64;
        let ended = self.buffer.last() == Some(&end);
        let mut line = self.buffer.as_slice();
        if self.line == 1 {
            if let Some(rest) = line.strip_prefix(b"\xEF\xBB\xBF") {
                line = rest;
            } else if line.starts_with(b"\xFF\xFE") || line.starts_with(b"\xFE\xFF") {
                return Err(IoError::NotUtf8 {
                    place: Place::cell(&self.file, 1, 1, ""),
                    byte: line[0],
                    hint: "it begins like UTF-16",
                });
            }
        }
        if let Some(rest) = line.strip_suffix(&[end]) {
            line = rest;
        }
        if let Some(rest) = line.strip_suffix(b"\r") {
            line = rest;
        }
        Ok(Some(Line { number: self.line, bytes: line, ended }))
    }

    /// The whole lines that lie ahead in memory, line ends included: none where one has to be read by
    /// [`Self::next_line`], which also says what is wrong.
    pub fn ahead(&mut self) -> &[u8] {
        let hashed = self.reader.get_ref();
        if hashed.bytes > hashed.limit || self.end != b'\n' {
            return &[];
        }
        let bytes = self.reader.fill_buf().unwrap_or_default();
        let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |last| last + 1);
        &bytes[..whole]
    }

    /// Passes over the first `bytes` of [`Self::ahead`], which are `lines` lines.
    pub fn skip(&mut self, bytes: usize, lines: u64) {
        self.reader.consume(bytes);
        self.position += bytes as u64;
        self.line += lines;
    }

    fn place(&self, line: u64) -> Place {
        Place::new(&self.file, FilePart::Line(line))
    }

    /// Number of the line last read, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Bytes of the lines read.
    pub fn position(&self) -> u64 {
        self.position
    }

    /// SHA-256 of all bytes read so far, lower-case hexadecimal: of the whole file after its last line.
    pub fn sha256(self) -> String {
        hexadecimal(&self.reader.into_inner().hash.finalize())
    }
}

/// Whether a line carries no fields: blank, or a comment.
pub(crate) fn is_skipped(line: &[u8]) -> bool {
    let start = line.trim_ascii_start();
    match start.first() {
        None => true,
        Some(b'%') => true,
        Some(b'#') => !is_spreadsheet_error(start),
        Some(_) => false,
    }
}

/// `#DIV/0!` and its like: a spreadsheet's failed cell, never a comment.
pub(crate) fn is_spreadsheet_error(text: &[u8]) -> bool {
    [&b"#DIV/0!"[..], b"#N/A", b"#NAME?", b"#NULL!", b"#NUM!", b"#REF!", b"#VALUE!"]
        .iter()
        .any(|error| text.starts_with(error))
}
