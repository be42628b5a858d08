//! A drive waveform, ready to be played.

use crate::record::{Channel, Record, TimeBase, Unit};

/// A drive waveform: what a DAC has to play, and how to read what comes back.
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
    /// Length of one period of the waveform proper, where it repeats a whole number of samples.
    pub period_samples: Option<usize>,
    /// Frequencies \[Hz\] of a multisine's excited lines; empty for other waveforms.
    pub excited_hz: Vec<f64>,
    /// Frequencies \[Hz\] of lines left out on purpose: what comes back there is noise or nonlinear distortion.
    pub detection_hz: Vec<f64>,
}

impl Excitation {
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
