//! Saved states: everything a model remembers as bytes that outlast a reset.
//!
//! The bytes `HYST`; a mark of 8 that the caller chooses, which tells one export from another; the members of
//! the state, indices and flags in 4 bytes, numbers in those of their type; the CRC-32 (IEEE 802.3) of all
//! before it. Each has its lowest byte first.

use core::error::Error;
use core::fmt::{Display, Formatter, Result as Written};

use crate::real::Real;

/// Reason why a state was not saved or restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SavedError {
    /// Room for bytes of another number.
    Length {
        /// Bytes of a saved state.
        expected: usize,
        /// Bytes given.
        found: usize,
    },
    /// Not a saved state, or one with another mark: of another model or version.
    Foreign,
    /// The checksum is another: the bytes were changed, or only some of them written.
    Damaged,
}

impl Display for SavedError {
    fn fmt(&self, f: &mut Formatter<'_>) -> Written {
        match self {
            Self::Length { expected, found } => {
                write!(f, "{found} bytes where a saved state of this model has {expected}")
            }
            Self::Foreign => write!(f, "the bytes are no saved state of this model and version"),
            Self::Damaged => write!(f, "the saved state is damaged: its checksum does not fit"),
        }
    }
}

impl Error for SavedError {}

const MAGIC: [u8; 4] = *b"HYST";
/// Magic and mark.
const HEAD: usize = 12;
/// Checksum.
const TAIL: usize = 4;

/// The members of a state on their way to bytes or from them. One list of members serves both directions, so
/// that what is saved is what is restored.
#[derive(Debug)]
pub(crate) struct Tape<'a> {
    pass: Pass<'a>,
    at: usize,
}

#[derive(Debug)]
enum Pass<'a> {
    Measure,
    Save(&'a mut [u8]),
    Restore(&'a [u8]),
}

impl Tape<'_> {
    /// The lowest `width` bytes of a word.
    fn word(&mut self, word: &mut u64, width: usize) {
        let place = self.at..self.at.saturating_add(width);
        self.at = place.end;
        match &mut self.pass {
            Pass::Measure => {}
            Pass::Save(bytes) => {
                for (slot, byte) in bytes.get_mut(place).into_iter().flatten().zip(word.to_le_bytes()) {
                    *slot = byte;
                }
            }
            Pass::Restore(bytes) => {
                let mut own = [0; 8];
                for (own, byte) in own.iter_mut().zip(bytes.get(place).into_iter().flatten()) {
                    *own = *byte;
                }
                *word = u64::from_le_bytes(own);
            }
        }
    }

    /// A number.
    pub(crate) fn number<T: Real>(&mut self, x: &mut T) {
        let mut bits = x.to_bits();
        self.word(&mut bits, T::BYTES);
        *x = T::from_bits(bits);
    }

    /// Numbers.
    pub(crate) fn numbers<T: Real>(&mut self, all: &mut [T]) {
        all.iter_mut().for_each(|x| self.number(x));
    }

    /// An index; a restored one is 0 where it is not below `bound`.
    pub(crate) fn index(&mut self, index: &mut usize, bound: usize) {
        let mut word = *index as u64;
        self.word(&mut word, 4);
        *index = match usize::try_from(word) {
            Ok(restored) if restored < bound => restored,
            _ => 0,
        };
    }

    /// A flag.
    pub(crate) fn flag(&mut self, flag: &mut bool) {
        let mut index = usize::from(*flag);
        self.index(&mut index, 2);
        *flag = index != 0;
    }
}

/// Bytes of a saved state with these members.
pub(crate) fn bytes_of(members: impl FnOnce(&mut Tape<'_>)) -> usize {
    let mut tape = Tape { pass: Pass::Measure, at: HEAD };
    members(&mut tape);
    tape.at.saturating_add(TAIL)
}

/// Writes a saved state.
pub(crate) fn save(mark: u64, bytes: &mut [u8], members: impl FnOnce(&mut Tape<'_>)) {
    let Some((before, tail)) = bytes.split_last_chunk_mut::<TAIL>() else { return };
    for (slot, byte) in before.iter_mut().zip(MAGIC.into_iter().chain(mark.to_le_bytes())) {
        *slot = byte;
    }
    members(&mut Tape { pass: Pass::Save(before), at: HEAD });
    *tail = checksum(before).to_le_bytes();
}

/// Reads a saved state whose length is right.
///
/// # Errors
/// [`SavedError::Foreign`], [`SavedError::Damaged`]: no member is read then.
pub(crate) fn restore(
    mark: u64,
    bytes: &[u8],
    members: impl FnOnce(&mut Tape<'_>),
) -> Result<(), SavedError> {
    let Some((before, tail)) = bytes.split_last_chunk::<TAIL>() else { return Err(SavedError::Foreign) };
    let head = MAGIC.into_iter().chain(mark.to_le_bytes());
    if before.len() < HEAD || !before.iter().zip(head).all(|(found, expected)| *found == expected) {
        return Err(SavedError::Foreign);
    }
    if *tail != checksum(before).to_le_bytes() {
        return Err(SavedError::Damaged);
    }
    members(&mut Tape { pass: Pass::Restore(before), at: HEAD });
    Ok(())
}

/// CRC-32 (IEEE 802.3), bit by bit: no table.
fn checksum(bytes: &[u8]) -> u32 {
    let crc = bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| {
                if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 }
            },
        )
    });
    !crc
}

/// Implements saving for a type with a list of its members, `each_member`.
macro_rules! saves {
    ($type:ident) => {
        impl<T: Real> $type<'_, T> {
            /// Bytes of a saved state.
            pub fn saved_bytes(&mut self) -> usize {
                crate::saved::bytes_of(|tape| self.each_member(tape))
            }

            /// Writes the state into `bytes`, [`Self::saved_bytes`] of them: `HYST`, the `mark`, indices and
            /// flags in 4 bytes, numbers as IEEE 754 has them, and the CRC-32 of all before it, each with its
            /// lowest byte first. Nothing changes. A state that [`Self::restore`] makes of them goes on with
            /// the same bits.
            ///
            /// # Errors
            /// [`SavedError::Length`](crate::SavedError::Length).
            pub fn save(&mut self, mark: u64, bytes: &mut [u8]) -> Result<(), crate::SavedError> {
                let expected = self.saved_bytes();
                if bytes.len() != expected {
                    return Err(crate::SavedError::Length { expected, found: bytes.len() });
                }
                crate::saved::save(mark, bytes, |tape| self.each_member(tape));
                Ok(())
            }

            /// Takes the state that was saved with this `mark`; coefficients and limits are not part of it.
            ///
            /// # Errors
            /// [`SavedError`](crate::SavedError); the state is then what it was.
            pub fn restore(&mut self, mark: u64, bytes: &[u8]) -> Result<(), crate::SavedError> {
                let expected = self.saved_bytes();
                if bytes.len() != expected {
                    return Err(crate::SavedError::Length { expected, found: bytes.len() });
                }
                crate::saved::restore(mark, bytes, |tape| self.each_member(tape))
            }
        }
    };
}
pub(crate) use saves;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }
}
