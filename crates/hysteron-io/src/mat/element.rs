//! Data elements: a tag that gives type and length, and the bytes behind it.

use std::ops::Range;

use crate::bytes::Bytes;
use crate::container::MOST_PATH_BYTES;

/// Types of the numbers in an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
    I64,
    U64,
}

/// Types of elements that are no numbers.
pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;

impl Type {
    /// Type of a version 5 element.
    pub fn of_element(code: u32) -> Option<Self> {
        Some(match code {
            1 => Self::I8,
            2 => Self::U8,
            3 => Self::I16,
            4 => Self::U16,
            5 => Self::I32,
            6 => Self::U32,
            7 => Self::F32,
            9 => Self::F64,
            12 => Self::I64,
            13 => Self::U64,
            _ => return None,
        })
    }

    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 | Self::I64 | Self::U64 => 8,
        }
    }

    fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let mut own = [0; 8];
        let count = bytes.len().min(8);
        own[..count].copy_from_slice(&bytes[..count]);
        if big_endian {
            own[..count].reverse();
        }
        let bits = u64::from_le_bytes(own);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
        }
    }
}

/// Location of the numbers of an array.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    pub buffer: usize,
    pub range: Range<usize>,
    pub kind: Type,
    pub big_endian: bool,
    /// Their number by the shape of the array.
    pub count: usize,
}

impl Numbers {
    pub fn read(&self, buffers: &[Vec<u8>]) -> Result<Vec<f64>, String> {
        let bytes =
            buffers.get(self.buffer).and_then(|buffer| buffer.get(self.range.clone())).unwrap_or_default();
        let size = self.kind.bytes();
        if bytes.len() / size != self.count {
            return Err(format!(
                "it has {} numbers where its shape asks for {}",
                bytes.len() / size,
                self.count
            ));
        }
        Ok(bytes.chunks_exact(size).map(|number| self.kind.value(number, self.big_endian)).collect())
    }
}

/// An element.
pub(super) struct Element<'a> {
    pub kind: u32,
    pub data: &'a [u8],
    /// Where the data begin.
    pub start: usize,
}

impl<'a> Element<'a> {
    /// The element at the position of `bytes`, and the padding behind it.
    pub fn next(bytes: &mut Bytes<'a>) -> Result<Self, String> {
        let first = bytes.u32()?;
        if first >> 16 != 0 {
            // Of at most four bytes: type and length in one word.
            let (kind, length) = (first & 0xFFFF, (first >> 16) as usize);
            let start = bytes.position();
            let data = bytes.take(4)?;
            let data = data.get(..length).ok_or_else(|| format!("a short element of {length} bytes"))?;
            return Ok(Self { kind, data, start });
        }
        let length = bytes.u32()? as usize;
        let start = bytes.position();
        let data = bytes.take(length)?;
        if first != COMPRESSED {
            // The last element of a variable may go without.
            let padding = length.next_multiple_of(8) - length;
            bytes.take(padding.min(bytes.left()))?;
        }
        Ok(Self { kind: first, data, start })
    }

    /// The first of its 32-bit numbers, 0 without any.
    pub fn word(&self, big_endian: bool) -> u32 {
        self.words(big_endian, 1).first().copied().unwrap_or(0)
    }

    /// Its 32-bit numbers, at most so many.
    pub fn words(&self, big_endian: bool, most: usize) -> Vec<u32> {
        let word = |word: &[u8]| {
            let bytes = [word[0], word[1], word[2], word[3]];
            if big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
        };
        self.data.chunks_exact(4).take(most).map(word).collect()
    }

    /// Its text up to the first zero, cut where it is longer than any name.
    pub fn text(&self) -> String {
        let data = self.data.get(..=MOST_PATH_BYTES).unwrap_or(self.data);
        let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
        String::from_utf8_lossy(&data[..end]).into_owned()
    }
}
