//! Numbers out of bytes.

/// Takes numbers from the front.
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// The next byte; 0 past the end.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// The next four bytes, as a number of any size and sign: half of them near `around`, so that not all of
    /// them are refused at once.
    pub fn number(&mut self, around: f64) -> f64 {
        let four = [self.byte(), self.byte(), self.byte(), self.byte()];
        let bits = u32::from_le_bytes(four);
        if bits & 1 == 0 {
            around * f64::from(bits >> 1) / f64::from(1_u32 << 30)
        } else if bits & 2 == 0 {
            f64::from(f32::from_bits(bits))
        } else {
            f64::from_bits(u64::from(bits) << 32)
        }
    }

    /// Whether nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
