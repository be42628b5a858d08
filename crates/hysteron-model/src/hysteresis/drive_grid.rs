//! How the samples of a drive lie beside those of an output, and in time.

/// Grid of a drive, which may be finer than that of what an operator puts out for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGrid {
    /// Every so many samples of the drive one is put out.
    pub factor: usize,
    /// Seconds from one sample of the drive to the next; `None` where their order alone is known, which is enough for every operator
    /// but those whose memory depends on the rate.
    pub interval_s: Option<f64>,
}

impl DriveGrid {
    /// Of a record at this rate \[Hz\], as far as it is known, `finer` times as fine, of which every `factor`-th sample is put out.
    pub fn new(sample_rate_hz: Option<f64>, finer: usize, factor: usize) -> Self {
        Self { factor, interval_s: sample_rate_hz.map(|rate| 1.0 / (rate * finer as f64)) }
    }
}

/// Every so many samples, whose order alone is known.
impl From<usize> for DriveGrid {
    fn from(factor: usize) -> Self {
        Self { factor, interval_s: None }
    }
}
