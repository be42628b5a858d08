//! MAT files of version 4: matrices one behind the other, each with a header of 20 bytes.

use super::Variables;
use super::element::{Numbers, Type};
use crate::bytes::Bytes;
use crate::columns::Kind;
use crate::container::{HeldArray, MAX_ARRAYS, shape_of_texts};

/// Longest name of a variable, its zero included.
const MOST_NAME_BYTES: usize = 1024;

pub(super) fn variables(file: Vec<u8>) -> Result<Variables, String> {
    let mut found = Variables::default();
    let no_mat = || "it is no MAT file: neither the header of version 5 nor one of version 4".to_owned();
    let mut bytes = Bytes::new(&file, false);
    while bytes.left() > 0 {
        let mut header = Bytes::new(bytes.take(20)?, false);
        let mut kind = header.u32()?;
        let big_endian = kind > 4052;
        header.big_endian = big_endian;
        if big_endian {
            kind = kind.swap_bytes();
        }
        let (precision, form, machine) = (kind / 10 % 10, kind % 10, kind / 1000);
        let number = match precision {
            0 => Type::F64,
            1 => Type::F32,
            2 => Type::I32,
            3 => Type::I16,
            4 => Type::U16,
            5 => Type::U8,
            _ => return Err(no_mat()),
        };
        if machine != u32::from(big_endian) || kind / 100 % 10 != 0 || form > 2 {
            return Err(no_mat());
        }
        let [rows, columns, imaginary, length] =
            [header.u32()?, header.u32()?, header.u32()?, header.u32()?].map(|n| n as usize);
        if length > MOST_NAME_BYTES {
            return Err(no_mat());
        }
        let name = bytes.take(length)?;
        let end = name.iter().position(|byte| *byte == 0).unwrap_or(length);
        let name = String::from_utf8_lossy(&name[..end]).into_owned();
        let count = rows.checked_mul(columns);
        let size = count.and_then(|count| count.checked_mul(number.bytes()));
        let (Some(count), Some(size)) = (count, size) else {
            return Err(format!("`{name}` has {rows}×{columns} numbers"));
        };
        let start = bytes.position();
        bytes.take(size)?;
        if imaginary != 0 {
            bytes.take(size)?;
        }
        let kind = match form {
            0 if imaginary != 0 => Kind::Other("complex numbers".to_owned()),
            0 => Kind::Numbers,
            1 => Kind::Other("text".to_owned()),
            _ => Kind::Other("sparse matrix".to_owned()),
        };
        let numbers = Numbers { buffer: 0, range: start..start + size, kind: number, big_endian, count };
        found.numbers.push((kind == Kind::Numbers).then_some(numbers));
        let shape = if form == 1 { shape_of_texts(&[rows, columns]) } else { vec![rows, columns] };
        let held = HeldArray { row_major: false, ..HeldArray::new("", &name, shape, kind) };
        found.held.push(held);
        if found.held.len() > MAX_ARRAYS {
            return Err(format!("it holds more than {MAX_ARRAYS} variables"));
        }
    }
    found.buffers.push(file);
    Ok(found)
}
