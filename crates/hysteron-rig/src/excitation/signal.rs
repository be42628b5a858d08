//! A generated drive waveform.

use hysteron_model::record::{Channel, Record, TimeBase, Unit};

/// A drive waveform for a DAC, with the numbers needed to evaluate the response.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// Short name, fit for a file name (`sweep`, `multisine`, …).
    pub name: String,
    /// One sentence with all numbers and units.
    pub description: String,
    /// The drive \[V\].
    pub samples_v: Vec<f64>,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Samples of soft start before the waveform proper begins.
    pub lead_in_samples: usize,
    /// Samples of soft end after the waveform proper.
    pub lead_out_samples: usize,
    /// Length of one period of the waveform proper, where it repeats a whole number of samples.
    pub period_samples: Option<usize>,
    /// Frequencies \[Hz\] of the lines of a multisine or a sum of sines; empty for other waveforms.
    pub excited_hz: Vec<f64>,
    /// Odd multiples of 1/period \[Hz\] in a multisine's band that are not excited: odd-order distortion and
    /// noise appear there.
    pub odd_detection_hz: Vec<f64>,
    /// Even multiples of 1/period \[Hz\] in the band that are not excited: even-order distortion and noise
    /// appear there.
    pub even_detection_hz: Vec<f64>,
}

impl Excitation {
    /// A drive given only by its samples \[V\] at `sample_rate_hz`.
    pub fn of_samples(name: String, description: String, samples_v: Vec<f64>, sample_rate_hz: f64) -> Self {
        Self {
            name,
            description,
            samples_v,
            sample_rate_hz,
            lead_in_samples: 0,
            lead_out_samples: 0,
            period_samples: None,
            excited_hz: Vec::new(),
            odd_detection_hz: Vec::new(),
            even_detection_hz: Vec::new(),
        }
    }

    /// Duration `samples / sample rate` \[s\].
    pub fn duration_s(&self) -> f64 {
        self.samples_v.len() as f64 / self.sample_rate_hz
    }

    /// Smallest and largest sample \[V\]; `(0, 0)` for an empty waveform.
    pub fn range_v(&self) -> (f64, f64) {
        if self.samples_v.is_empty() {
            return (0.0, 0.0);
        }
        self.samples_v.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &u| (l.min(u), h.max(u)))
    }

    /// Crest factor of the waveform proper about its mid-range: half the peak-to-peak value over the standard
    /// deviation (√2 for a sine); 0 for a constant.
    pub fn crest_factor(&self) -> f64 {
        let end = self.samples_v.len().saturating_sub(self.lead_out_samples);
        let proper = self.samples_v.get(self.lead_in_samples..end).unwrap_or_default();
        let n = proper.len() as f64;
        let mean = proper.iter().sum::<f64>() / n;
        let deviation = (proper.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / n).sqrt();
        let (low, high) =
            proper.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &u| (l.min(u), h.max(u)));
        if deviation > 0.0 { 0.5 * (high - low) / deviation } else { 0.0 }
    }

    /// Largest |u_{k+1} − u_k| · sample rate \[V/s\].
    pub fn max_slew_v_per_s(&self) -> f64 {
        let step = self.samples_v.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
        step * self.sample_rate_hz
    }

    /// The waveform as a record with the one channel `u` \[V\] from t = 0, ready to be written for a DAQ.
    pub fn to_record(&self) -> Record {
        Record {
            name: self.name.clone(),
            time: TimeBase::Uniform {
                start_s: 0.0,
                sample_rate_hz: self.sample_rate_hz,
                jitter_samples: 0.0,
            },
            channels: vec![Channel {
                name: "u".into(),
                unit: Unit::new("V"),
                samples: self.samples_v.clone(),
            }],
            valid: None,
            source: None,
        }
    }
}
