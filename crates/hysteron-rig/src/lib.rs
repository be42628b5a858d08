//! A simulated test bench with known truth and realistic records.
//!
//! The truth is either the user's ([`Plant::BoucWenFractional`]) or the default, which lies outside every
//! model class this library identifies ([`PlayStack`]): asymmetric plays, two modes, fractional creep,
//! amplifier lag, delay, 16-bit converter, noise. [`measure`] plays one waveform; [`run_campaign`] the
//! article's set of records; [`LiveRig`] runs in closed loop with a controller. [`axes`] is a bench of
//! several axes.
//!
//! The bench shares no code with the simulators it is used to test. It works in continuous time:
//! rate-independent operators are stepped exactly on a grid at least 20 times finer than the record, and
//! linear dynamics, fractional ones included, are split into poles and branch cut and propagated exactly for
//! an input linear over each grid step.

pub mod axes;
mod bouc_wen;
mod campaign;
mod error;
pub mod excitation;
mod live;
mod partial_fractions;
mod period;
mod plant;
mod plays;
mod propagation;
mod roots;
mod run;
mod sensor;
mod truth;
mod validation;

#[cfg(test)]
mod facts;

pub use campaign::{CampaignPlan, CampaignRun, Role, run_campaign};
pub use error::RigError;
pub use live::{LiveRig, RigStage};
pub use plays::Play;
pub use run::measure;
pub use truth::{Adc, BoucWenFractional, Creep, Dac, Mode, Plant, PlayStack, PowerTerm, Sensor, Truth};

use hysteron_model::record::{Channel, Record, Unit};

/// One experiment on the bench: the measured record and the true signals.
#[derive(Clone, Debug, PartialEq)]
pub struct RigRun {
    /// Channels `u` \[V\] (the command) and `y` \[µm\] (the sensor's reading); the name begins with
    /// `simulated_`.
    pub record: Record,
    /// True displacement \[µm\], before sensor and converter.
    pub y_true_um: Vec<f64>,
    /// True output of the hysteresis block \[µm\], not delayed.
    pub hysteresis_um: Vec<f64>,
    /// Readings at the ends of the converter's range.
    pub clipped_samples: usize,
    /// Header lines of the file: statement that it is simulated, drive, plant, seed.
    pub comments: Vec<String>,
}

impl RigRun {
    /// The record with the true channels `y_true` and `v_true` \[µm\] beside the measured ones.
    pub fn record_with_truth(&self) -> Record {
        let mut record = self.record.clone();
        let channel = |name: &str, samples: &[f64]| Channel {
            name: name.into(),
            unit: Unit::new("um"),
            samples: samples.to_vec(),
        };
        record.channels.push(channel("y_true", &self.y_true_um));
        record.channels.push(channel("v_true", &self.hysteresis_um));
        record
    }
}
