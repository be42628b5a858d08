//! Positions of the samples of a drive relative to those of an output, and in time.

use crate::record::Pace;

/// Grid of a drive, which may be finer than that of the operator's output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGrid<'a> {
    /// Samples of the drive per sample of the output.
    pub factor: usize,
    /// Seconds from one sample of the drive to the next; `None` where they are not known, or not equal.
    pub interval_s: Option<f64>,
    /// Paces of the moves to the samples of the drive, where these are unevenly spaced
    /// ([`crate::record::paces_on`]). An operator whose memory depends on time needs this or the interval;
    /// any other needs only the order of the samples.
    pub paces: Option<&'a [Pace]>,
}

impl DriveGrid<'_> {
    /// Grid `finer` times as fine as a record at this rate \[Hz\], if known, with an output at every
    /// `factor`-th sample.
    pub fn new(sample_rate_hz: Option<f64>, finer: usize, factor: usize) -> Self {
        let interval_s = sample_rate_hz.map(|rate| 1.0 / (rate * finer as f64));
        Self { factor, interval_s, paces: None }
    }
}

impl<'a> DriveGrid<'a> {
    /// Grid of a drive with these [`Self::paces`], with an output at every `factor`-th sample.
    pub fn of_paces(paces: &'a [Pace], factor: usize) -> Self {
        Self { factor, interval_s: None, paces: Some(paces) }
    }
}

/// An output every this many samples, of which only the order is known.
impl From<usize> for DriveGrid<'_> {
    fn from(factor: usize) -> Self {
        Self { factor, interval_s: None, paces: None }
    }
}
