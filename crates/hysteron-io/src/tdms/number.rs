//! Types of values in a TDMS file.

/// Seconds of the timestamp's fraction: 2⁻⁶⁴.
const FRACTION_S: f64 = 1.0 / 18_446_744_073_709_551_616.0;

/// A type of value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DataType {
    Signed(u8),
    Unsigned(u8),
    Float32,
    Float64,
    Boolean,
    /// Seconds since 1904 and 2⁻⁶⁴ of a second.
    Timestamp,
    Text,
    /// Of known size, but not read: its name and bytes.
    Other(&'static str, u8),
}

impl DataType {
    /// The type of this number.
    pub fn new(code: u32) -> Result<Self, String> {
        Ok(match code {
            0 => DataType::Other("void", 1),
            1 => DataType::Signed(1),
            2 => DataType::Signed(2),
            3 => DataType::Signed(4),
            4 => DataType::Signed(8),
            5 => DataType::Unsigned(1),
            6 => DataType::Unsigned(2),
            7 => DataType::Unsigned(4),
            8 => DataType::Unsigned(8),
            9 | 0x19 => DataType::Float32,
            10 | 0x1A => DataType::Float64,
            11 | 0x1B => DataType::Other("float of extended precision", 16),
            0x20 => DataType::Text,
            0x21 => DataType::Boolean,
            0x44 => DataType::Timestamp,
            0x4F => DataType::Other("fixed-point number", 8),
            0x08_000C => DataType::Other("complex", 8),
            0x10_000D => DataType::Other("complex", 16),
            other => return Err(format!("it has values of type {other:#x}, which TDMS does not define")),
        })
    }

    /// Bytes of a value; `None` for texts, whose lengths differ.
    pub fn bytes(self) -> Option<usize> {
        match self {
            DataType::Signed(bytes) | DataType::Unsigned(bytes) | DataType::Other(_, bytes) => {
                Some(usize::from(bytes))
            }
            DataType::Float32 => Some(4),
            DataType::Float64 => Some(8),
            DataType::Boolean => Some(1),
            DataType::Timestamp => Some(16),
            DataType::Text => None,
        }
    }

    /// Its name, where it is not read as a number.
    pub fn not_a_number(self) -> Option<&'static str> {
        match self {
            DataType::Text => Some("text"),
            DataType::Other(name, _) => Some(name),
            _ => None,
        }
    }

    /// The number in these bytes; of a timestamp, see [`Timestamp`].
    pub fn value(self, bytes: &[u8], big_endian: bool) -> f64 {
        let raw = raw(bytes, big_endian) as u64;
        match self {
            DataType::Signed(count) => {
                let unused = 64 - 8 * u32::from(count.clamp(1, 8));
                (((raw << unused) as i64) >> unused) as f64
            }
            DataType::Unsigned(_) => raw as f64,
            DataType::Float32 => f64::from(f32::from_bits(raw as u32)),
            DataType::Float64 => f64::from_bits(raw),
            DataType::Boolean => f64::from(u8::from(raw != 0)),
            DataType::Timestamp | DataType::Text | DataType::Other(..) => f64::NAN,
        }
    }
}

/// A point in time: 2⁻⁶⁴ s since 1904.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Timestamp(i128);

impl Timestamp {
    pub fn new(bytes: &[u8], big_endian: bool) -> Self {
        Timestamp(raw(bytes, big_endian) as i128)
    }

    /// Seconds since another one, rounded once.
    pub fn since(self, other: Timestamp) -> f64 {
        self.0.wrapping_sub(other.0) as f64 * FRACTION_S
    }
}

/// The bytes as one number.
fn raw(bytes: &[u8], big_endian: bool) -> u128 {
    let push = |sum: u128, byte: &u8| (sum << 8) | u128::from(*byte);
    let bytes = &bytes[..bytes.len().min(16)];
    if big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) }
}
