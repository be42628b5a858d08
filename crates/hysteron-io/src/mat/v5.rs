//! MAT files of versions 5 to 7: elements, compressed or not, with matrices, structures and cells in them.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::Variables;
use super::element::{COMPRESSED, Element, MATRIX, Numbers, Type};
use crate::bytes::Bytes;
use crate::columns::Kind;
use crate::container::{HeldArray, MAX_ARRAYS, MOST_PATH_BYTES, shape_of_texts};

/// Bytes in front of the first variable.
const HEADER_BYTES: usize = 128;
/// Structures and cells within one another.
const MOST_DEPTH: usize = 32;
/// Dimensions of an array.
const MOST_DIMENSIONS: usize = 32;

/// Why a file is not read.
pub(super) enum Problem {
    /// It unpacks to more than is allowed.
    TooLarge,
    Malformed(String),
}

impl From<String> for Problem {
    fn from(problem: String) -> Self {
        Self::Malformed(problem)
    }
}

/// Classes of arrays.
mod class {
    pub const CELL: u32 = 1;
    pub const STRUCT: u32 = 2;
    pub const OBJECT: u32 = 3;
    pub const CHAR: u32 = 4;
    pub const SPARSE: u32 = 5;
    pub const FIRST_NUMBER: u32 = 6;
    pub const LAST_NUMBER: u32 = 15;
    pub const FUNCTION: u32 = 16;
    pub const OPAQUE: u32 = 17;
}

/// Byte order of a file of version 5, by the end of its header; `None` for one of another version.
pub(super) fn is_little_endian(head: &[u8]) -> Option<bool> {
    match head.get(124..HEADER_BYTES)? {
        [0, 1, b'I', b'M'] => Some(true),
        [1, 0, b'M', b'I'] => Some(false),
        _ => None,
    }
}

/// The variables of a file.
pub(super) fn variables(file: &[u8], big_endian: bool, limit_bytes: u64) -> Result<Variables, Problem> {
    let mut found = Variables::default();
    let mut bytes = Bytes::new(file, big_endian);
    bytes.take(HEADER_BYTES)?;
    let mut left = limit_bytes;
    while bytes.left() > 0 {
        let element = Element::next(&mut bytes)?;
        let buffer = match element.kind {
            COMPRESSED => {
                let unpacked = unpacked(element.data, left)?;
                left -= unpacked.len() as u64;
                let mut whole = Bytes::new(&unpacked, big_endian);
                let inner = Element::next(&mut whole)?;
                match inner.kind {
                    MATRIX => inner.data.to_vec(),
                    _ => continue,
                }
            }
            MATRIX => element.data.to_vec(),
            // Elements that later versions add.
            _ => continue,
        };
        let mut walk = Walk { found: &mut found, data: &buffer, big_endian };
        walk.matrix(0..buffer.len(), "", None, 0)?;
        found.buffers.push(buffer);
    }
    Ok(found)
}

/// The bytes of a compressed element.
fn unpacked(packed: &[u8], limit: u64) -> Result<Vec<u8>, Problem> {
    let mut unpacked = Vec::new();
    let read = ZlibDecoder::new(packed).take(limit.saturating_add(1)).read_to_end(&mut unpacked);
    read.map_err(|e| format!("a variable cannot be unpacked ({e})"))?;
    if unpacked.len() as u64 > limit {
        return Err(Problem::TooLarge);
    }
    Ok(unpacked)
}

/// Traversal of one variable.
struct Walk<'a> {
    found: &'a mut Variables,
    data: &'a [u8],
    big_endian: bool,
}

impl Walk<'_> {
    /// Adds the matrix in a range of the variable. `group`: path in front of its name, with the separator;
    /// `name`: its own where it stands in a structure or a cell.
    fn matrix(
        &mut self,
        range: std::ops::Range<usize>,
        group: &str,
        name: Option<&str>,
        depth: usize,
    ) -> Result<(), Problem> {
        if depth > MOST_DEPTH {
            return Err(format!("structures within more than {MOST_DEPTH} others").into());
        }
        let data = self.data;
        let offset = range.start;
        let mut bytes = Bytes::new(data.get(range).unwrap_or_default(), self.big_endian);
        if bytes.left() == 0 {
            // A field without a value.
            return self.push(
                group,
                name.unwrap_or("ans"),
                vec![0, 0],
                Kind::Other("nothing".to_owned()),
                None,
            );
        }
        let flags = Element::next(&mut bytes)?.word(self.big_endian);
        let (class, is_complex) = (flags & 0xFF, flags & 0x0800 != 0);
        if class == class::OPAQUE {
            let own = Element::next(&mut bytes)?.text();
            let name = name.unwrap_or(&own);
            return self.push(group, name, Vec::new(), Kind::Other("object".to_owned()), None);
        }
        let shape = Element::next(&mut bytes)?.words(self.big_endian, MOST_DIMENSIONS + 1);
        if shape.len() > MOST_DIMENSIONS {
            return Err(format!("an array of more than {MOST_DIMENSIONS} dimensions").into());
        }
        let shape: Vec<usize> = shape.into_iter().map(|n| n as usize).collect();
        let own = Element::next(&mut bytes)?.text();
        let name = name.unwrap_or(&own);
        let count = shape.iter().try_fold(1usize, |product, &n| product.checked_mul(n));
        let count = count.ok_or_else(|| format!("`{group}{name}` has more elements than can be counted"))?;
        let other = |what: &str| Kind::Other(what.to_owned());
        match class {
            class::FIRST_NUMBER..=class::LAST_NUMBER if is_complex => {
                self.push(group, name, shape, other("complex numbers"), None)
            }
            class::FIRST_NUMBER..=class::LAST_NUMBER => {
                let element = Element::next(&mut bytes)?;
                let kind = Type::of_element(element.kind).ok_or_else(|| {
                    format!("`{group}{name}` has numbers of the unknown type {}", element.kind)
                })?;
                let start = offset + element.start;
                let numbers = Numbers {
                    buffer: self.found.buffers.len(),
                    range: start..start + element.data.len(),
                    kind,
                    big_endian: self.big_endian,
                    count,
                };
                self.push(group, name, shape, Kind::Numbers, Some(numbers))
            }
            class::CHAR => self.push(group, name, shape_of_texts(&shape), other("text"), None),
            class::SPARSE => self.push(group, name, shape, other("sparse matrix"), None),
            class::FUNCTION => self.push(group, name, shape, other("function"), None),
            class::OBJECT => {
                let of = Element::next(&mut bytes)?.text();
                self.push(group, name, shape, Kind::Other(format!("object of class {of}")), None)
            }
            class::CELL | class::STRUCT if count == 0 => {
                self.push(group, name, shape, other("an empty array"), None)
            }
            class::STRUCT => {
                if self.structure(&mut bytes, offset, (group, name), count, depth)? {
                    return Ok(());
                }
                self.push(group, name, shape, other("structure without fields"), None)
            }
            class::CELL => {
                for index in 0..count {
                    let element = self.inner(&mut bytes)?;
                    let start = offset + element.start;
                    let cell = format!("{name}{{{}}}", index + 1);
                    self.matrix(start..start + element.data.len(), group, Some(&cell), depth + 1)?;
                }
                Ok(())
            }
            _ => self.push(
                group,
                name,
                shape,
                Kind::Other(format!("array of the unknown class {class}")),
                None,
            ),
        }
    }

    /// Adds the fields of a structure, and returns whether it has any.
    fn structure(
        &mut self,
        bytes: &mut Bytes<'_>,
        offset: usize,
        (group, name): (&str, &str),
        count: usize,
        depth: usize,
    ) -> Result<bool, Problem> {
        let length = Element::next(bytes)?.word(self.big_endian) as usize;
        let names = Element::next(bytes)?;
        if length == 0 && names.data.is_empty() {
            return Ok(false);
        }
        if length == 0 {
            return Err(format!("`{group}{name}` has field names of no length").into());
        }
        if names.data.len() / length > MAX_ARRAYS {
            return Err(format!("`{group}{name}` has more than {MAX_ARRAYS} fields").into());
        }
        let fields: Vec<String> = names
            .data
            .chunks_exact(length)
            .map(|field| Element { kind: 1, data: field, start: 0 }.text())
            .collect();
        for index in 0..count {
            let one =
                if count == 1 { format!("{group}{name}.") } else { format!("{group}{name}({}).", index + 1) };
            for field in &fields {
                let element = self.inner(bytes)?;
                let start = offset + element.start;
                self.matrix(start..start + element.data.len(), &one, Some(field), depth + 1)?;
            }
            if fields.is_empty() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// A matrix within another.
    fn inner<'b>(&self, bytes: &mut Bytes<'b>) -> Result<Element<'b>, Problem> {
        if self.found.held.len() >= MAX_ARRAYS {
            return Err(format!("it holds more than {MAX_ARRAYS} arrays").into());
        }
        let element = Element::next(bytes)?;
        if element.kind != MATRIX {
            return Err(format!("an element of the type {} where an array was expected", element.kind).into());
        }
        Ok(element)
    }

    fn push(
        &mut self,
        group: &str,
        name: &str,
        shape: Vec<usize>,
        kind: Kind,
        numbers: Option<Numbers>,
    ) -> Result<(), Problem> {
        // A variable without a name holds what MATLAB keeps for its objects.
        if name.is_empty() && group.is_empty() {
            return Ok(());
        }
        if self.found.held.len() >= MAX_ARRAYS {
            return Err(format!("it holds more than {MAX_ARRAYS} arrays").into());
        }
        if group.len() + name.len() > MOST_PATH_BYTES {
            return Err(format!("it has a path of more than {MOST_PATH_BYTES} bytes").into());
        }
        self.found.held.push(HeldArray { row_major: false, ..HeldArray::new(group, name, shape, kind) });
        self.found.numbers.push(numbers);
        Ok(())
    }
}
