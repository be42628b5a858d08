//! Saved states: `HYST`, a mark of 8 bytes, words of 8 bytes, and the CRC-32 (IEEE 802.3) of all before it,
//! each with its lowest byte first. Written by hysteron export.

use core::fmt::{Display, Formatter};

/// The bytes are no saved state of this export, or damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotSaved;

impl Display for NotSaved {
    fn fmt(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        write!(f, "the bytes are no saved state of this model and version, or damaged")
    }
}

impl core::error::Error for NotSaved {}

const MAGIC: [u8; 4] = *b"HYST";
/// Bytes of magic and mark, and of the checksum.
const HEAD: usize = 12;
const TAIL: usize = 4;

/// Bytes of a saved state of so many words.
pub(crate) const fn bytes_of(words: usize) -> usize {
    HEAD + 8 * words + TAIL
}

pub(crate) fn save(mark: u64, words: impl Iterator<Item = u64>, bytes: &mut [u8]) {
    let head = MAGIC.into_iter().chain(mark.to_le_bytes());
    let all = head.chain(words.flat_map(u64::to_le_bytes));
    let Some((before, tail)) = bytes.split_last_chunk_mut::<TAIL>() else { return };
    before.iter_mut().zip(all).for_each(|(slot, byte)| *slot = byte);
    *tail = checksum(before).to_le_bytes();
}

/// The words of a saved state.
pub(crate) fn restore(mark: u64, bytes: &[u8]) -> Result<impl Iterator<Item = u64>, NotSaved> {
    let (before, tail) = bytes.split_last_chunk::<TAIL>().ok_or(NotSaved)?;
    let mut head = MAGIC.into_iter().chain(mark.to_le_bytes());
    let words = before.get(HEAD..).ok_or(NotSaved)?;
    let is_own = before.iter().take(HEAD).all(|byte| head.next() == Some(*byte));
    if !is_own || *tail != checksum(before).to_le_bytes() {
        return Err(NotSaved);
    }
    Ok(words.as_chunks::<8>().0.iter().map(|word| u64::from_le_bytes(*word)))
}

fn checksum(bytes: &[u8]) -> u32 {
    let crc = bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 }
        })
    });
    !crc
}
