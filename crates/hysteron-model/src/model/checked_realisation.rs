//! A realisation, checked along a sweep over the model's own range and timed.

use std::time::Duration;

use serde::{Serialize, Serializer};

use crate::model_file::{ModelFile, ValidRange};
use crate::realise::{
    Realisation, RealiseError, Section, StreamParts, Verification, nanoseconds_per_sample, sweep, verify,
};

/// Samples of the sweep that is compared and timed, and passes of the clock.
const SAMPLES: usize = 20_000;
const ROUNDS: usize = 20;

/// A drive over the range and the frequencies of a model's records.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// The drive.
    pub drive: Vec<f64>,
    /// Its least and largest value.
    pub voltages: (f64, f64),
    /// Its lowest and highest frequency \[Hz\].
    pub frequencies_hz: (f64, f64),
}

impl Sweep {
    /// Two periods of the lowest frequency of the records, within reason.
    pub fn over(range: Option<&ValidRange>, sample_rate_hz: f64) -> Self {
        let voltages = range.map_or((0.0, 1.0), |r| (r.input.low, r.input.high));
        let frequencies_hz = frequencies(range, sample_rate_hz);
        let samples = ((2.0 * sample_rate_hz / frequencies_hz.0) as usize).clamp(SAMPLES, 20 * SAMPLES);
        Self { drive: sweep(voltages, frequencies_hz, sample_rate_hz, samples), voltages, frequencies_hz }
    }
}

/// The sweep that is compared: the frequencies of the records, within what the sample rate carries.
fn frequencies(range: Option<&ValidRange>, sample_rate_hz: f64) -> (f64, f64) {
    let most = 0.01 * sample_rate_hz;
    let own = range.and_then(|r| r.frequency.as_ref()).map(|f| (f.low, f.high));
    let (low, high) = own.unwrap_or((0.01 * most, most));
    let high = if high > 0.0 { high.min(0.1 * sample_rate_hz) } else { most };
    (if low > 0.0 { low.clamp(1e-4 * high, high) } else { 0.01 * high }, high)
}

/// A realisation and what was found out about it.
#[derive(Clone, Debug)]
pub struct CheckedRealisation {
    /// The realisation.
    pub realisation: Realisation,
    /// What it is off the batch simulation along the sweep.
    pub verification: Verification,
    /// The sweep.
    pub sweep: Sweep,
    /// Nanoseconds a sample on this machine.
    pub nanoseconds: f64,
    /// Accuracy asked for, as a share of the range.
    pub accuracy: f64,
    /// Symbols of the units of input and output.
    pub units: (String, String),
}

impl CheckedRealisation {
    /// Checks and times the realisation of a model file; `now` is a clock.
    ///
    /// # Errors
    /// As [`verify`].
    pub fn new(
        realisation: Realisation,
        file: &ModelFile,
        accuracy: f64,
        now: &dyn Fn() -> Duration,
    ) -> Result<Self, RealiseError> {
        let sweep = Sweep::over(file.valid_range.as_ref(), realisation.sample_rate_hz);
        let verification = verify(&realisation, &sweep.drive)?;
        let mut parts = StreamParts::new(&realisation)?;
        let mut streams = [parts.stream()?];
        let timed = sweep.drive.get(..SAMPLES).unwrap_or(&sweep.drive);
        let times = nanoseconds_per_sample(&mut streams, timed, ROUNDS, now)?;
        Ok(Self {
            realisation,
            verification,
            sweep,
            nanoseconds: times.first().copied().unwrap_or(f64::NAN),
            accuracy,
            units: (file.units.input.clone(), file.units.output.clone()),
        })
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    sample_rate_hz: f64,
    accuracy: f64,
    states: usize,
    delay_samples: usize,
    taps: &'a [f64],
    sections: Vec<SectionEntry>,
    rest_gain: f64,
    offset: f64,
    moves_half_way: bool,
    band_hz: [f64; 2],
    frequency_error: f64,
    reference_gain: f64,
    weights_over_gain: f64,
    batch_difference_largest: f64,
    batch_difference_rms: f64,
    range: f64,
    output_unit: &'a str,
    nanoseconds_per_sample: f64,
}

#[derive(Serialize)]
struct SectionEntry {
    kind: &'static str,
    rate_rad_per_s: f64,
    gain: [f64; 2],
    weight: [f64; 2],
}

impl SectionEntry {
    fn new(section: &Section, rate: f64) -> Self {
        SectionEntry {
            kind: if section.is_pair() { "pair" } else { "real" },
            rate_rad_per_s: section.rate(rate),
            gain: [section.gain.re, section.gain.im],
            weight: [section.weight.re, section.weight.im],
        }
    }
}

impl Serialize for CheckedRealisation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let realisation = &self.realisation;
        let linear = &realisation.dynamics;
        let rate = realisation.sample_rate_hz;
        let summary = Summary {
            sample_rate_hz: rate,
            accuracy: self.accuracy,
            states: linear.states(),
            delay_samples: linear.delay_samples,
            taps: &linear.taps,
            sections: linear.sections.iter().map(|s| SectionEntry::new(s, rate)).collect(),
            rest_gain: linear.rest_gain,
            offset: realisation.model.offset,
            moves_half_way: realisation.joins_means,
            band_hz: [linear.band_hz.0, linear.band_hz.1],
            frequency_error: linear.frequency_error,
            reference_gain: linear.reference_gain,
            weights_over_gain: linear.amplification(),
            batch_difference_largest: self.verification.largest,
            batch_difference_rms: self.verification.rms,
            range: self.verification.range,
            output_unit: &self.units.1,
            nanoseconds_per_sample: self.nanoseconds,
        };
        summary.serialize(serializer)
    }
}
