//! Drive waveforms for an identification campaign.
//!
//! An [`ExcitationSpec`] (serde; what a configuration file or a command line fills in) is checked and turned
//! into an [`Excitation`], whose limits an amplifier's [`AmplifierLimits`] check and which becomes a record
//! ready for a DAQ. Every waveform stays inside `low_v … high_v`; the plant is taken to rest at 0 V, and
//! `soft_start_s` leads smoothly from there to the waveform's first sample.
//!
//! ```
//! use hysteron_rig::excitation::{AmplifierLimits, ExcitationSpec, SweepLaw, Waveform};
//!
//! let law = SweepLaw::Logarithmic;
//! let sweep = Waveform::Sweep { law, start_hz: 1.0, end_hz: 100.0, duration_s: 10.0 };
//! let drive = ExcitationSpec::new(10_000.0, 0.0, 10.0, sweep).generate()?;
//! let amplifier = AmplifierLimits {
//!     low_v: -2.0,
//!     high_v: 12.0,
//!     slew_v_per_s: Some(4_000.0),
//!     current_a: None,
//!     capacitance_f: None,
//! };
//! amplifier.check(&drive)?;
//! assert_eq!(drive.samples_v.len(), 100_000);
//! # Ok::<(), hysteron_rig::RigError>(())
//! ```

mod amplifier;
mod check;
mod multisine;
mod paths;
mod random;
mod signal;
mod slow;
mod specification;
mod summary;
mod sweep;
mod waveform;

#[cfg(test)]
mod facts;

pub use amplifier::AmplifierLimits;
pub use multisine::{Lines, Phases};
pub use signal::Excitation;
pub use slow::Tone;
pub use specification::ExcitationSpec;
pub use summary::ExcitationSummary;
pub use sweep::SweepLaw;
pub use waveform::Waveform;

/// Two rates or times are the same sample count if they differ by less than this part of a sample.
const SAMPLE_ROUNDING: f64 = 1e-6;

/// Waveform from a generator, in units of the range: 0 = `low_v`, 1 = `high_v`.
struct Shape {
    /// Values in 0 … 1.
    values: Vec<f64>,
    period_samples: Option<usize>,
    excited_hz: Vec<f64>,
    odd_detection_hz: Vec<f64>,
    even_detection_hz: Vec<f64>,
}

impl Shape {
    fn plain(values: Vec<f64>) -> Self {
        Shape {
            values,
            period_samples: None,
            excited_hz: Vec::new(),
            odd_detection_hz: Vec::new(),
            even_detection_hz: Vec::new(),
        }
    }
}

/// `periods_samples` as a whole number, if it is one.
fn whole_samples(samples: f64) -> Option<usize> {
    let nearest = samples.round();
    ((samples - nearest).abs() < SAMPLE_ROUNDING && nearest >= 1.0).then_some(nearest as usize)
}
