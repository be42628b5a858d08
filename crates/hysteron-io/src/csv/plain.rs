//! Blocks of lines that hold plain numbers, many lines at once.
//!
//! The result is that of reading line by line; anything not plain (comments, quotes, decimal commas, an
//! error) is left to that.

use rayon::prelude::*;

use crate::options::{MAX_LINE_BYTES, MAX_NUMBER_BYTES};

/// Bytes that one thread takes at a time.
const PART: usize = 1 << 16;

/// Number of lines, and the numbers of each column that is to be `read` (empty for the others). `None` unless
/// every line of `block`, which holds whole lines, is one finite number a column.
pub(crate) fn plain_columns(block: &[u8], delimiter: u8, read: &[bool]) -> Option<(usize, Vec<Vec<f64>>)> {
    let mut parts = Vec::new();
    let mut rest = block;
    while !rest.is_empty() {
        let from = rest.len().min(PART) - 1;
        let end = from + rest[from..].iter().position(|&b| b == b'\n')? + 1;
        let (part, after) = rest.split_at(end);
        parts.push(part);
        rest = after;
    }
    let parts: Vec<_> = parts.into_par_iter().map(|part| part_columns(part, delimiter, read)).collect();
    let mut parts = parts.into_iter();
    let (mut lines, mut columns) = parts.next()??;
    for part in parts {
        let (more, values) = part?;
        lines += more;
        columns.iter_mut().zip(values).for_each(|(to, values)| to.extend(values));
    }
    Some((lines, columns))
}

fn part_columns(part: &[u8], delimiter: u8, read: &[bool]) -> Option<(usize, Vec<Vec<f64>>)> {
    // A quote may hide a delimiter in a column that is not read.
    let text = std::str::from_utf8(part).ok().filter(|text| !text.contains('"'))?;
    let mut columns = vec![Vec::new(); read.len()];
    let mut lines = 0;
    for line in text.split_terminator('\n') {
        let line = line.strip_suffix('\r').unwrap_or(line);
        let begins = line.bytes().next()?;
        if !(begins.is_ascii_digit() || b"+-.".contains(&begins)) || line.len() >= MAX_LINE_BYTES {
            return None;
        }
        let mut fields = Fields { rest: Some(line), delimiter };
        for (column, read) in columns.iter_mut().zip(read) {
            let field = fields.next()?;
            if *read {
                let field = field.trim_ascii();
                let value: f64 = field.parse().ok().filter(|_| field.len() <= MAX_NUMBER_BYTES)?;
                column.push(Some(value).filter(|value| value.is_finite())?);
            }
        }
        // A delimiter at the end of the line is accepted.
        if fields.rest.is_some_and(|rest| !rest.is_empty()) {
            return None;
        }
        lines += 1;
    }
    Some((lines, columns))
}

/// Fields of a line between delimiters.
struct Fields<'a> {
    rest: Option<&'a str>,
    delimiter: u8,
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?;
        let Some(at) = rest.bytes().position(|b| b == self.delimiter) else {
            self.rest = None;
            return Some(rest);
        };
        self.rest = rest.get(at + 1..);
        rest.get(..at)
    }
}
