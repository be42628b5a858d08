//! Cursor over the bytes of a binary file; a read past the end is an error, never a panic.

/// Bytes that are read from front to back.
#[derive(Clone, Copy)]
pub(crate) struct Bytes<'a> {
    data: &'a [u8],
    position: usize,
    pub big_endian: bool,
}

impl<'a> Bytes<'a> {
    pub fn new(data: &'a [u8], big_endian: bool) -> Self {
        Bytes { data, position: 0, big_endian }
    }

    /// Number of bytes not read yet.
    pub fn left(&self) -> usize {
        self.data.len() - self.position
    }

    /// Number of bytes read so far.
    pub fn position(&self) -> usize {
        self.position
    }

    /// The next bytes.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.position.checked_add(count);
        let taken = end.and_then(|end| self.data.get(self.position..end));
        let taken = taken.ok_or_else(|| {
            format!("it ends at byte {}, within {count} bytes expected there", self.data.len())
        })?;
        self.position += count;
        Ok(taken)
    }

    /// An unsigned number of this many bytes, at most 8.
    fn unsigned(&mut self, count: usize) -> Result<u64, String> {
        let big_endian = self.big_endian;
        let bytes = self.take(count)?;
        let push = |sum: u64, byte: &u8| (sum << 8) | u64::from(*byte);
        Ok(if big_endian { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) })
    }

    pub fn u32(&mut self) -> Result<u32, String> {
        Ok(self.unsigned(4)? as u32)
    }

    pub fn u64(&mut self) -> Result<u64, String> {
        self.unsigned(8)
    }

    /// The bytes of a text, behind its length of 4 bytes.
    pub fn raw_text(&mut self) -> Result<&'a [u8], String> {
        let length = self.u32()? as usize;
        self.take(length)
    }
}
