//! Properties of the objects of a TDMS file.

use std::collections::BTreeMap;

use super::number::DataType;
use crate::bytes::Bytes;

/// Longest text that is kept: those that are read, units and names of scales, are shorter.
const MOST_TEXT_BYTES: usize = 1024;

/// Properties of an object.
pub(super) type Properties = BTreeMap<String, Value>;

/// Value of a property.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Integer(i128),
    Float(f64),
    Text(String),
    Other,
}

impl Value {
    pub fn text(&self) -> Option<&str> {
        if let Value::Text(text) = self { Some(text) } else { None }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Integer(number) => Some(*number as f64),
            Value::Float(number) => Some(*number),
            _ => None,
        }
    }

    /// An unsigned number of 32 bits; −1 is the largest.
    pub fn as_index(&self) -> Option<u32> {
        match self {
            Value::Integer(-1) => Some(u32::MAX),
            Value::Integer(number) => u32::try_from(*number).ok(),
            _ => None,
        }
    }
}

/// Whether a property says something about the numbers: unit, times, scales.
pub(super) fn is_read(name: &[u8]) -> bool {
    name == b"unit_string" || name.starts_with(b"wf_") || name.starts_with(b"NI_")
}

/// Value of a property, behind its type.
pub(super) fn read_value(bytes: &mut Bytes<'_>) -> Result<Value, String> {
    let data_type = DataType::new(bytes.u32()?)?;
    let Some(size) = data_type.bytes() else {
        let text = bytes.raw_text()?;
        let is_short = text.len() <= MOST_TEXT_BYTES;
        return Ok(if is_short {
            Value::Text(String::from_utf8_lossy(text).into_owned())
        } else {
            Value::Other
        });
    };
    let raw = bytes.take(size)?;
    Ok(match data_type {
        // Exact beyond the 53 bits of a double; no property that is read needs more.
        DataType::Signed(_) | DataType::Unsigned(_) | DataType::Boolean => {
            Value::Integer(data_type.value(raw, bytes.big_endian) as i128)
        }
        DataType::Float32 | DataType::Float64 => Value::Float(data_type.value(raw, bytes.big_endian)),
        _ => Value::Other,
    })
}
