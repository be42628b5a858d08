//! Types of numbers in a dataset.

use hdf5_reader::messages::datatype::Datatype;

use crate::columns::Kind;

/// Element type of a dataset.
pub(super) fn kind(datatype: &Datatype) -> Kind {
    let other = |what: &str| Kind::Other(what.to_owned());
    match datatype {
        Datatype::FixedPoint { size: 1 | 2 | 4 | 8, .. }
        | Datatype::FloatingPoint { size: 2 | 4 | 8, .. } => Kind::Numbers,
        Datatype::Enum { base, .. } => kind(base),
        Datatype::FixedPoint { size, .. } | Datatype::FloatingPoint { size, .. } => {
            Kind::Other(format!("numbers of {size} bytes"))
        }
        Datatype::String { .. } => other("text"),
        Datatype::Compound { fields, .. } => {
            let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            match names.as_slice() {
                ["real", "imag"] | ["r", "i"] => other("complex numbers"),
                _ => Kind::Other(format!("structure of {}", names.join(", "))),
            }
        }
        Datatype::VarLen { .. } => other("lists of various lengths, or text"),
        Datatype::Reference { .. } => other("references"),
        Datatype::Array { .. } => other("arrays within an array"),
        Datatype::Opaque { .. } | Datatype::Bitfield { .. } => other("bytes"),
    }
}

/// Numbers in the byte order of this machine.
pub(super) fn numbers(bytes: &[u8], datatype: &Datatype) -> Vec<f64> {
    fn each<const N: usize>(bytes: &[u8], value: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        bytes.as_chunks::<N>().0.iter().map(|chunk| value(*chunk)).collect()
    }
    match datatype {
        Datatype::Enum { base, .. } => numbers(bytes, base),
        Datatype::FixedPoint { size: 1, signed: true, .. } => {
            each(bytes, |b| f64::from(i8::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 1, .. } => each(bytes, |b| f64::from(u8::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 2, signed: true, .. } => {
            each(bytes, |b| f64::from(i16::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 2, .. } => each(bytes, |b| f64::from(u16::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 4, signed: true, .. } => {
            each(bytes, |b| f64::from(i32::from_ne_bytes(b)))
        }
        Datatype::FixedPoint { size: 4, .. } => each(bytes, |b| f64::from(u32::from_ne_bytes(b))),
        Datatype::FixedPoint { size: 8, signed: true, .. } => each(bytes, |b| i64::from_ne_bytes(b) as f64),
        Datatype::FixedPoint { size: 8, .. } => each(bytes, |b| u64::from_ne_bytes(b) as f64),
        Datatype::FloatingPoint { size: 2, .. } => each(bytes, |b| of_half(u16::from_ne_bytes(b))),
        Datatype::FloatingPoint { size: 4, .. } => each(bytes, |b| f64::from(f32::from_ne_bytes(b))),
        Datatype::FloatingPoint { size: 8, .. } => each(bytes, f64::from_ne_bytes),
        _ => Vec::new(),
    }
}

/// Half precision (IEEE 754, binary16).
fn of_half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1F), f64::from(bits & 0x3FF));
    match exponent {
        0 => sign * fraction * 2f64.powi(-24),
        0x1F if fraction == 0.0 => sign * f64::INFINITY,
        0x1F => f64::NAN,
        _ => sign * (1024.0 + fraction) * 2f64.powi(exponent - 25),
    }
}
