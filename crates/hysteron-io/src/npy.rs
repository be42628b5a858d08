//! NPY: one array of numpy; the fields of a structured one are columns.

use std::io::Read;

use crate::columns::{ColumnForm, Columns, Headings, SampleLines};
use crate::hash::sha256;
use crate::options::MAX_LINE_BYTES;
use crate::place::{FilePart, Place, shown};
use crate::reader::{Input, Reader};
use crate::{IoError, ReadOptions};

/// Single arrays.
pub(crate) const READER: Reader =
    Reader { extensions: &["npy"], recognises: |head| head.starts_with(MAGIC), read };

const MAGIC: &[u8] = b"\x93NUMPY";
/// Most bytes of one element.
const MAX_ELEMENT_BYTES: usize = 1 << 20;
/// Bytes decoded at a time.
const BLOCK_BYTES: usize = 1 << 16;
/// Deepest nesting of a header.
const MAX_DEPTH: usize = 16;

fn read(mut input: Input<'_>) -> Result<Columns, IoError> {
    let bytes = input.read_to_end()?;
    let Input { file, options, wanted, .. } = input;
    let whole = Place::new(file, FilePart::Whole);
    let malformed = |problem| IoError::Malformed { place: whole.clone(), format: "NPY", problem };
    let mut data = bytes.as_slice();
    let array = Array::read_header(&mut data).map_err(malformed)?;
    let Type::Fields(fields) = &array.values else {
        return Err(IoError::NoNames { place: whole, found: array.shape_text() });
    };
    if !array.is_vector() {
        return Err(IoError::ArrayShape { place: whole, found: array.shape_text() });
    }
    let headings = Headings::new(file, None, fields.iter().map(|field| field.name.clone()).collect())?;
    let wanted = wanted(&headings)?;
    let mut numbers = Vec::new();
    for (field, _) in fields.iter().zip(&wanted).filter(|(_, wanted)| **wanted != ColumnForm::Nothing) {
        numbers.push((
            field.offset,
            field.number.ok_or_else(|| IoError::ArrayType {
                place: Place::new(file, FilePart::Array(field.name.as_str().into())),
                found: field.dtype.clone(),
            })?,
        ));
    }
    Budget::new(options).spend(&whole, &array, numbers.len())?;
    let mut read = array.read_values(data, &numbers).map_err(malformed)?.into_iter();
    let values = wanted
        .iter()
        .map(|&wanted| if wanted == ColumnForm::Nothing { None } else { read.next() }.unwrap_or_default())
        .collect();
    let texts = vec![Vec::new(); headings.columns.len()];
    let lines = SampleLines::default();
    Ok(Columns { headings, values, texts, lines, rate: None, sha256: sha256(&bytes) })
}

/// Header of an array.
pub(crate) struct Array {
    pub values: Type,
    shape: Vec<u64>,
    /// Whether the first index runs fastest (`fortran_order`).
    pub is_column_major: bool,
    /// Bytes of one element.
    element_bytes: usize,
}

/// Element type of an array.
pub(crate) enum Type {
    Number(Number),
    Fields(Vec<Field>),
    /// A type that is not read: text, complex numbers, dates; its name.
    Other(String),
}

/// A field of a structured array.
pub(crate) struct Field {
    name: String,
    /// Its first byte in an element.
    offset: usize,
    /// `None` where it is not read.
    number: Option<Number>,
    /// Its type, as the file names it.
    dtype: String,
}

/// Storage format of a number.
#[derive(Clone, Copy)]
pub(crate) struct Number {
    kind: Kind,
    bytes: usize,
    big_endian: bool,
}

#[derive(Clone, Copy)]
enum Kind {
    Float,
    Signed,
    Unsigned,
    Bool,
}

/// Values and bytes that may still be read.
pub(crate) struct Budget {
    values: usize,
    max_values: usize,
    bytes: u64,
    max_bytes: u64,
}

impl Budget {
    pub fn new(options: &ReadOptions) -> Self {
        let ReadOptions { max_values, max_bytes, .. } = *options;
        Budget { values: max_values, max_values, bytes: max_bytes, max_bytes }
    }

    /// Accounts for an array of which so many columns are read.
    pub fn spend(&mut self, place: &Place, array: &Array, columns: usize) -> Result<(), IoError> {
        let bytes = array.len().checked_mul(array.element_bytes as u64);
        self.bytes = bytes
            .and_then(|bytes| self.bytes.checked_sub(bytes))
            .ok_or_else(|| IoError::TooLarge { place: place.clone(), limit_bytes: self.max_bytes })?;
        let values = usize::try_from(array.len()).ok().and_then(|n| n.checked_mul(columns));
        self.values = values
            .and_then(|values| self.values.checked_sub(values))
            .ok_or_else(|| IoError::TooManyValues { place: place.clone(), limit: self.max_values })?;
        Ok(())
    }
}

impl Array {
    /// Reads the header in front of the values. An error says what is wrong with it.
    pub fn read_header(source: &mut impl Read) -> Result<Self, String> {
        let mut exact = |bytes: usize| {
            let mut found = Vec::new();
            match source.take(bytes as u64).read_to_end(&mut found) {
                Ok(got) if got == bytes => Ok(found),
                Ok(_) => Err("it ends in its header".to_owned()),
                Err(e) => Err(e.to_string()),
            }
        };
        if exact(MAGIC.len())? != MAGIC {
            return Err("it does not begin with the bytes of NPY, `\\x93NUMPY`".to_owned());
        }
        let length = match exact(2)?[0] {
            1 => exact(2)?,
            2 | 3 => exact(4)?,
            version => return Err(format!("version {version} of NPY is not read, expected 1, 2 or 3")),
        };
        let length = length.iter().rev().fold(0, |sum, &byte| (sum << 8) + usize::from(byte));
        if length > MAX_LINE_BYTES {
            return Err(format!("its header is longer than {MAX_LINE_BYTES} bytes"));
        }
        let bytes = exact(length)?;
        // Versions 1 and 2 are Latin-1.
        let text =
            String::from_utf8(bytes).unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect());
        let header = literal(&text).ok_or("its header is no Python dictionary")?;
        Array::new(&header).ok_or_else(|| "its header lacks `descr` or `shape`, or holds others".to_owned())
    }

    fn new(header: &Literal) -> Option<Self> {
        let Literal::Dict(entries) = header else { return None };
        let entry = |key: &str| entries.iter().find(|(k, _)| k.text() == Some(key)).map(|(_, value)| value);
        let shape = entry("shape")?.list()?.iter().map(Literal::integer).collect::<Option<Vec<_>>>()?;
        shape.iter().try_fold(1u64, |product, &n| product.checked_mul(n))?;
        let descr = entry("descr")?;
        let element_bytes = size_of(descr)?;
        let values = match (descr, descr.text()) {
            (_, Some(dtype)) => match Number::new(dtype) {
                Some(number) => Type::Number(number),
                None => Type::Other(dtype.to_owned()),
            },
            (Literal::List(fields), None) => Type::Fields(Field::all(fields)?),
            _ => return None,
        };
        let is_column_major = entry("fortran_order") == Some(&Literal::True);
        Some(Array { values, shape, is_column_major, element_bytes })
    }

    /// Number of elements.
    pub fn len(&self) -> u64 {
        self.shape.iter().product()
    }

    /// Whether the array is one column or one row; its order in memory then does not matter.
    fn is_vector(&self) -> bool {
        !self.shape.is_empty() && self.shape.iter().filter(|&&n| n != 1).count() <= 1
    }

    /// The shape as numpy writes it.
    pub fn shape_text(&self) -> String {
        let lengths: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        if lengths.len() == 1 { format!("({},)", lengths[0]) } else { format!("({})", lengths.join(", ")) }
    }

    /// The shape; lengths beyond the address space as the largest one.
    pub fn shape(&self) -> Vec<usize> {
        self.shape.iter().map(|&n| usize::try_from(n).unwrap_or(usize::MAX)).collect()
    }

    /// Reads the values behind the header: one list for each of the numbers that stand at these offsets of an
    /// element. An error says what is wrong with them.
    pub fn read_values(
        &self,
        mut source: impl Read,
        numbers: &[(usize, Number)],
    ) -> Result<Vec<Vec<f64>>, String> {
        let mut columns = vec![Vec::new(); numbers.len()];
        let block_elements = (BLOCK_BYTES / self.element_bytes.max(1)).max(1) as u64;
        let mut block = Vec::new();
        let mut left = self.len();
        // Memory grows with the data present, not with the length in the header.
        while left > 0 && self.element_bytes > 0 {
            let elements = left.min(block_elements);
            let bytes = elements * self.element_bytes as u64;
            block.clear();
            (&mut source).take(bytes).read_to_end(&mut block).map_err(|e| e.to_string())?;
            if (block.len() as u64) < bytes {
                let there = self.len() - left + (block.len() / self.element_bytes) as u64;
                return Err(format!(
                    "it ends after {there} of the {} values its header promises",
                    self.len()
                ));
            }
            for ((offset, number), column) in numbers.iter().zip(&mut columns) {
                let elements = block.chunks_exact(self.element_bytes);
                column
                    .extend(elements.map(|element| number.value(element.get(*offset..).unwrap_or_default())));
            }
            left -= elements;
        }
        match source.read(&mut [0]) {
            Ok(0) => Ok(columns),
            Ok(_) => Err(format!("it goes on behind the {} values its header promises", self.len())),
            Err(e) => Err(e.to_string()),
        }
    }
}

impl Field {
    /// Fields of a structured type, but for the padding between them.
    fn all(fields: &[Literal]) -> Option<Vec<Field>> {
        let mut found = Vec::new();
        let mut offset = 0;
        for field in fields {
            let (name, descr) = match field.list()? {
                [name, descr] | [name, descr, _] => (name, descr),
                _ => return None,
            };
            // A title stands in front of the name.
            let name = match name.list() {
                Some([_, name]) => name.text()?,
                _ => name.text()?,
            };
            let bytes = field_bytes(field)?;
            let dtype = descr.text().unwrap_or("structure");
            let number = Number::new(dtype).filter(|number| number.bytes == bytes);
            if !dtype.starts_with("|V") {
                found.push(Field { name: name.to_owned(), offset, number, dtype: shown(dtype.as_bytes()) });
            }
            offset += bytes;
        }
        Some(found)
    }
}

/// Bytes of an element of a type; at most [`MAX_ELEMENT_BYTES`].
fn size_of(descr: &Literal) -> Option<usize> {
    let bytes = match (descr, descr.text()) {
        (_, Some(dtype)) => {
            let letters = dtype.trim_start_matches(['<', '>', '|', '=']);
            let kind = letters.chars().next()?;
            let number: String = letters.chars().skip(1).take_while(char::is_ascii_digit).collect();
            match kind {
                'O' => 8,
                'U' => number.parse::<usize>().ok()?.checked_mul(4)?,
                _ => number.parse().ok()?,
            }
        }
        (Literal::List(fields), None) => {
            fields.iter().try_fold(0usize, |sum, field| sum.checked_add(field_bytes(field)?))?
        }
        _ => return None,
    };
    Some(bytes).filter(|&bytes| bytes <= MAX_ELEMENT_BYTES)
}

/// Bytes of a field, which may be an array itself.
fn field_bytes(field: &Literal) -> Option<usize> {
    let (descr, shape) = match field.list()? {
        [_, descr] => (descr, &[][..]),
        [_, descr, shape] => (descr, shape.list().unwrap_or(std::slice::from_ref(shape))),
        _ => return None,
    };
    let count = shape.iter().try_fold(1u64, |product, n| product.checked_mul(n.integer()?))?;
    size_of(descr)?.checked_mul(usize::try_from(count).ok()?)
}

impl Number {
    /// `<f8`, `>i4`, `|b1` and the like.
    fn new(dtype: &str) -> Option<Self> {
        let (order, kind) = dtype.split_at_checked(1)?;
        let big_endian = match order {
            "<" | "|" | "=" => false,
            ">" => true,
            _ => return None,
        };
        let (kind, bytes) = match kind {
            "f4" => (Kind::Float, 4),
            "f8" => (Kind::Float, 8),
            "i1" => (Kind::Signed, 1),
            "i2" => (Kind::Signed, 2),
            "i4" => (Kind::Signed, 4),
            "i8" => (Kind::Signed, 8),
            "u1" => (Kind::Unsigned, 1),
            "u2" => (Kind::Unsigned, 2),
            "u4" => (Kind::Unsigned, 4),
            "u8" => (Kind::Unsigned, 8),
            "b1" => (Kind::Bool, 1),
            _ => return None,
        };
        Some(Number { kind, bytes, big_endian })
    }

    /// The number at the start of these bytes.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut raw = [0; 8];
        raw.iter_mut().zip(bytes).take(self.bytes).for_each(|(to, byte)| *to = *byte);
        if self.big_endian {
            raw[..self.bytes].reverse();
        }
        let bits = u64::from_le_bytes(raw);
        let unused_bits = 64 - 8 * self.bytes;
        match self.kind {
            Kind::Float if self.bytes == 4 => f64::from(f32::from_bits(bits as u32)),
            Kind::Float => f64::from_bits(bits),
            Kind::Signed => (((bits << unused_bits) as i64) >> unused_bits) as f64,
            Kind::Unsigned => bits as f64,
            Kind::Bool => f64::from(u8::from(bits != 0)),
        }
    }
}

/// A Python literal of a header.
#[derive(Debug, PartialEq)]
enum Literal {
    Text(String),
    Integer(u64),
    True,
    /// False or None.
    Word,
    /// A list or a tuple.
    List(Vec<Literal>),
    Dict(Vec<(Literal, Literal)>),
}

impl Literal {
    fn text(&self) -> Option<&str> {
        if let Literal::Text(text) = self { Some(text) } else { None }
    }

    fn integer(&self) -> Option<u64> {
        if let Literal::Integer(n) = self { Some(*n) } else { None }
    }

    fn list(&self) -> Option<&[Literal]> {
        if let Literal::List(items) = self { Some(items) } else { None }
    }
}

/// Parses a text of one literal.
fn literal(text: &str) -> Option<Literal> {
    let mut rest = text;
    let value = parse(&mut rest, MAX_DEPTH)?;
    rest.trim().is_empty().then_some(value)
}

/// Parses a literal at the beginning of the text, nested at most `depth` deep.
fn parse(rest: &mut &str, depth: usize) -> Option<Literal> {
    let deeper = depth.checked_sub(1)?;
    *rest = rest.trim_start();
    let first = rest.chars().next()?;
    match first {
        '{' => {
            let pair = |rest: &mut &str| {
                let key = parse(rest, deeper)?;
                take(rest, ':').then_some(())?;
                Some((key, parse(rest, deeper)?))
            };
            Some(Literal::Dict(items(rest, '}', pair)?))
        }
        '[' => Some(Literal::List(items(rest, ']', |rest| parse(rest, deeper))?)),
        '(' => Some(Literal::List(items(rest, ')', |rest| parse(rest, deeper))?)),
        '\'' | '"' => quoted(rest, first),
        '0'..='9' => {
            let number = leading(rest, |c| c.is_ascii_digit());
            // Python 2 wrote long integers with an L.
            *rest = rest.strip_prefix('L').unwrap_or(rest);
            Some(Literal::Integer(number.parse().ok()?))
        }
        _ => {
            let word = leading(rest, |c| c.is_ascii_alphabetic());
            ["True", "False", "None"].contains(&word).then_some(Literal::Word)
        }
    }
}

/// Items between brackets, separated by commas.
fn items<T>(rest: &mut &str, close: char, mut item: impl FnMut(&mut &str) -> Option<T>) -> Option<Vec<T>> {
    let mut found = Vec::new();
    *rest = rest.get(1..)?;
    while !take(rest, close) {
        found.push(item(rest)?);
        if !take(rest, ',') {
            return take(rest, close).then_some(found);
        }
    }
    Some(found)
}

/// Takes a character off the text, if it is the next one.
fn take(rest: &mut &str, wanted: char) -> bool {
    *rest = rest.trim_start();
    let after = rest.strip_prefix(wanted);
    *rest = after.unwrap_or(rest);
    after.is_some()
}

/// Takes the characters of a kind off the text.
fn leading<'a>(rest: &mut &'a str, is: impl Fn(char) -> bool) -> &'a str {
    let (taken, after) = rest.split_at(rest.find(|c| !is(c)).unwrap_or(rest.len()));
    *rest = after;
    taken
}

/// A text in quotes; of the escapes those that numpy writes.
fn quoted(rest: &mut &str, quote: char) -> Option<Literal> {
    let mut text = String::new();
    let mut chars = rest.char_indices().skip(1);
    while let Some((at, c)) = chars.next() {
        if c == quote {
            *rest = rest.get(at + 1..)?;
            return Some(Literal::Text(text));
        }
        let code = |chars: &mut dyn Iterator<Item = (usize, char)>, digits| {
            let code: String = chars.take(digits).map(|(_, c)| c).collect();
            char::from_u32(u32::from_str_radix(&code, 16).ok()?)
        };
        text.push(match c {
            '\\' => match chars.next()?.1 {
                'x' => code(&mut chars, 2)?,
                'u' => code(&mut chars, 4)?,
                'n' => '\n',
                't' => '\t',
                escaped => escaped,
            },
            plain => plain,
        });
    }
    None
}
