//! A realisation, checked along a sweep over the model's own range and timed.

use std::time::Duration;

use serde::{Deserialize, Serialize, Serializer};

use crate::model_file::{ModelFile, ValidRange};
use crate::realise::{
    Realisation, RealiseError, Section, StreamParts, Verification, nanoseconds_per_sample, sweep, verify,
};

/// Fewest and most samples of the sweep that is compared and timed, and timing passes.
const SAMPLES: usize = 20_000;
const MOST_SAMPLES: usize = 20 * SAMPLES;
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
    /// Two periods of the lowest frequency of the records, within limits, and the samples that the output
    /// comes later.
    pub fn over(range: Option<&ValidRange>, sample_rate_hz: f64, delay_samples: usize) -> Self {
        let voltages = range.map_or((0.0, 1.0), |r| (r.input.low, r.input.high));
        let frequencies_hz = frequencies(range, sample_rate_hz);
        let samples =
            ((2.0 * sample_rate_hz / frequencies_hz.0) as usize).clamp(SAMPLES, MOST_SAMPLES) + delay_samples;
        Self { drive: sweep(voltages, frequencies_hz, sample_rate_hz, samples), voltages, frequencies_hz }
    }
}

/// The sweep that is compared: the frequencies of the records, within what the sample rate carries.
fn frequencies(range: Option<&ValidRange>, sample_rate_hz: f64) -> (f64, f64) {
    let most = 0.01 * sample_rate_hz;
    let own = range.and_then(|r| r.frequency.as_ref()).map(|f| (f.low, f.high));
    let (low, high) = own.unwrap_or((0.01 * most, most));
    let high = if high > 0.0 { high.min(0.1 * sample_rate_hz) } else { most };
    let low = if low > 0.0 { low.clamp(1e-4 * high, high) } else { 0.01 * high };
    // At least two periods, or the sweep would not cover its range.
    let low = low.max(2.0 * sample_rate_hz / MOST_SAMPLES as f64);
    (low, high.max(low))
}

/// A realisation with its verification and timing.
#[derive(Clone, Debug)]
pub struct CheckedRealisation {
    /// The realisation.
    pub realisation: Realisation,
    /// Deviation from the batch simulation along the sweep.
    pub verification: Verification,
    /// The sweep.
    pub sweep: Sweep,
    /// Nanoseconds per sample on this machine.
    pub nanoseconds: f64,
    /// Accuracy requested, as a share of the range.
    pub accuracy: f64,
    /// Symbols of the units of input and output.
    pub units: (String, String),
}

impl CheckedRealisation {
    /// Checks and times the realisation of a model file; `now` is a clock.
    ///
    /// # Errors
    /// Those of [`verify`].
    pub fn new(
        realisation: Realisation,
        file: &ModelFile,
        accuracy: f64,
        now: &dyn Fn() -> Duration,
    ) -> Result<Self, RealiseError> {
        let sweep = Sweep::over(
            file.valid_range.as_ref(),
            realisation.sample_rate_hz,
            realisation.dynamics.delay_samples,
        );
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

/// A realisation in numbers: its JSON, to be written and read back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealisationSummary {
    /// Its rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Accuracy requested, as a share of the range.
    pub accuracy: f64,
    /// Linear states.
    pub states: usize,
    /// Whole samples of delay.
    pub delay_samples: usize,
    /// Taps of the fractional part of the delay.
    pub taps: Vec<f64>,
    /// First and second order sections.
    pub sections: Vec<SectionSummary>,
    /// Gain at rest.
    pub rest_gain: f64,
    /// Offset of the output.
    pub offset: f64,
    /// The hysteresis moves half way between samples.
    pub moves_half_way: bool,
    /// Band that is realised \[Hz\].
    pub band_hz: [f64; 2],
    /// Largest error of the frequency response in it, relative.
    pub frequency_error: f64,
    /// Gain that the error is relative to.
    pub reference_gain: f64,
    /// Sum of the weights of the sections over the gain.
    pub weights_over_gain: f64,
    /// Largest difference from the batch simulation along the sweep.
    pub batch_difference_largest: f64,
    /// Rms difference from it.
    pub batch_difference_rms: f64,
    /// Range of the output along the sweep.
    pub range: f64,
    /// Symbol of the unit of the output.
    pub output_unit: String,
    /// Nanoseconds per sample on the machine that made it.
    pub nanoseconds_per_sample: f64,
}

/// A section of a realisation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SectionSummary {
    /// `real` or `pair`.
    pub kind: String,
    /// Rate of its pole \[rad/s\].
    pub rate_rad_per_s: f64,
    /// Gain, real and imaginary part.
    pub gain: [f64; 2],
    /// Weight, real and imaginary part.
    pub weight: [f64; 2],
}

impl SectionSummary {
    fn new(section: &Section, rate: f64) -> Self {
        SectionSummary {
            kind: if section.is_pair() { "pair" } else { "real" }.to_owned(),
            rate_rad_per_s: section.rate(rate),
            gain: [section.gain.re, section.gain.im],
            weight: [section.weight.re, section.weight.im],
        }
    }
}

impl CheckedRealisation {
    /// The realisation in numbers.
    pub fn summary(&self) -> RealisationSummary {
        let realisation = &self.realisation;
        let linear = &realisation.dynamics;
        let rate = realisation.sample_rate_hz;
        RealisationSummary {
            sample_rate_hz: rate,
            accuracy: self.accuracy,
            states: linear.states(),
            delay_samples: linear.delay_samples,
            taps: linear.taps.clone(),
            sections: linear.sections.iter().map(|s| SectionSummary::new(s, rate)).collect(),
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
            output_unit: self.units.1.clone(),
            nanoseconds_per_sample: self.nanoseconds,
        }
    }
}

impl Serialize for CheckedRealisation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_outlasts_the_delay_and_covers_its_range() {
        let range = ValidRange::of_inputs(&[0.0, 3.6], "V", Some((1.0, 1.0)));
        for (rate, delay) in [(1e3, 6), (1e6, 5_716), (1e8, 571_598)] {
            let sweep = Sweep::over(Some(&range), rate, delay);
            let before_delay = &sweep.drive[..sweep.drive.len() - delay];
            let (low, high) = crate::record::range_of(before_delay);
            assert!(low < 0.01 && high > 3.59, "{rate}: {low} {high}");
            assert!(sweep.drive.len() <= MOST_SAMPLES + delay);
        }
    }
}
