//! Positions of the samples of a drive relative to those of an output, and in time.

use crate::record::Pace;

/// Grid of a drive, which may be finer than that of what an operator puts out for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGrid<'a> {
    /// Every so many samples of the drive one is put out.
    pub factor: usize,
    /// Seconds from one sample of the drive to the next; `None` where they are not known, or not equal.
    pub interval_s: Option<f64>,
    /// Paces of the moves to the samples of the drive, where these are not an equal time apart
    /// ([`crate::record::paces_on`]). An operator whose memory depends on time asks for this or for the
    /// interval; for every other one the order of the samples is enough.
    pub paces: Option<&'a [Pace]>,
}

impl DriveGrid<'_> {
    /// Of a record at this rate \[Hz\], as far as it is known, `finer` times as fine, of which every
    /// `factor`-th sample is put out.
    pub fn new(sample_rate_hz: Option<f64>, finer: usize, factor: usize) -> Self {
        let interval_s = sample_rate_hz.map(|rate| 1.0 / (rate * finer as f64));
        Self { factor, interval_s, paces: None }
    }
}

impl<'a> DriveGrid<'a> {
    /// Of a drive that comes to its samples so ([`Self::paces`]), of which every `factor`-th sample is put
    /// out.
    pub fn of_paces(paces: &'a [Pace], factor: usize) -> Self {
        Self { factor, interval_s: None, paces: Some(paces) }
    }
}

/// Every so many samples, whose order alone is known.
impl From<usize> for DriveGrid<'_> {
    fn from(factor: usize) -> Self {
        Self { factor, interval_s: None, paces: None }
    }
}
