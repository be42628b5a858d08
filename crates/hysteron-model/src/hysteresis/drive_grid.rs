//! How the samples of a drive lie beside those of an output, and in time.

/// Grid of a drive, which may be finer than that of what an operator puts out for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGrid<'a> {
    /// Every so many samples of the drive one is put out.
    pub factor: usize,
    /// Seconds from one sample of the drive to the next; `None` where they are not known, or not equal.
    pub interval_s: Option<f64>,
    /// |du/dt| \[V/s\] of the move to each sample of the drive, as many as it has, where its samples are not an equal time apart
    /// ([`crate::record::rates_on`]). An operator whose memory depends on the rate asks for this or for the interval; for every other one the order
    /// of the samples is enough.
    pub rates: Option<&'a [f64]>,
}

impl DriveGrid<'_> {
    /// Of a record at this rate \[Hz\], as far as it is known, `finer` times as fine, of which every `factor`-th sample is put out.
    pub fn new(sample_rate_hz: Option<f64>, finer: usize, factor: usize) -> Self {
        let interval_s = sample_rate_hz.map(|rate| 1.0 / (rate * finer as f64));
        Self { factor, interval_s, rates: None }
    }
}

impl<'a> DriveGrid<'a> {
    /// Of a drive with these rates ([`Self::rates`]), of which every `factor`-th sample is put out.
    pub fn of_rates(rates: &'a [f64], factor: usize) -> Self {
        Self { factor, interval_s: None, rates: Some(rates) }
    }
}

/// Every so many samples, whose order alone is known.
impl From<usize> for DriveGrid<'_> {
    fn from(factor: usize) -> Self {
        Self { factor, interval_s: None, rates: None }
    }
}
