//! Options of tracking a reference, with their defaults from model and reference.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;

use super::{Controller, ReferenceKnowledge};
use crate::control::{ControlError, Loop, LoopSettings, RequiredMargins, Sines};
use crate::hammerstein;
use crate::model::Body;
use crate::model_file::ModelFile;
use crate::realise::RealiseOptions;
use crate::record::{range_of, shortest_swing};

/// Highest frequency that is predicted, as a share of the sample rate.
const MOST_PREDICTED: f64 = 0.25;
/// Samples that are scored, at least.
const LEAST_SCORED: usize = 10;
/// Lowest and highest sine, as shares of the sample rate.
const SINES: [f64; 2] = [1e-4, 0.1];

/// Options of [`track`](super::track).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackOptions {
    /// Controllers to play; empty: all.
    pub controllers: Vec<Controller>,
    /// Preview of the reference in samples; `None`: as many as the inverse uses.
    pub preview: Option<usize>,
    /// Highest frequency that is predicted \[Hz\]; `None`: that of the fastest swing of the reference.
    pub predict_to_hz: Option<f64>,
    /// Tracking bandwidth of the inverse \[Hz\]; `None`: a twentieth of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Least and largest drive; `None`: the range in which the model was identified.
    pub range: Option<[f64; 2]>,
    /// Largest rate of the drive, in its unit per second; infinite: not limited.
    #[serde(with = "crate::unlimited")]
    #[schemars(with = "Option<f64>")]
    pub slew_per_s: f64,
    /// Voltage of the device without hysteresis memory, before the reference; `None`: 0 where the range holds
    /// it, else at rest.
    pub virgin_v: Option<f64>,
    /// Margins of the feedback. Its highest trusted frequency is that of the model's records.
    pub margins: RequiredMargins,
    /// Accuracy of the dynamics.
    pub realise: RealiseOptions,
    /// Time at the beginning that is not scored \[s\]; `None`: a quarter of the reference.
    pub skip_s: Option<f64>,
    /// Lowest and highest of the sines by which bandwidths are measured \[Hz\]; `None`: 1e-4 to 0.1 of the
    /// sample rate.
    pub sines_hz: Option<[f64; 2]>,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self {
            controllers: Vec::new(),
            preview: None,
            predict_to_hz: None,
            bandwidth_hz: None,
            range: None,
            slew_per_s: f64::INFINITY,
            virgin_v: None,
            margins: RequiredMargins::default(),
            realise: RealiseOptions::default(),
            skip_s: None,
            sines_hz: None,
        }
    }
}

impl TrackOptions {
    pub(super) fn settings(
        &self,
        model: &Body<ModelFile, hammerstein::Model>,
        sample_rate_hz: f64,
    ) -> Result<LoopSettings, ControlError> {
        let valid = model.data().valid_range.as_ref();
        let own = || valid.map(|valid| [valid.input.low, valid.input.high]);
        let trusted_to_hz = valid.and_then(|valid| valid.frequency.as_ref()).map(|f| f.high);
        Ok(LoopSettings {
            sample_rate_hz,
            range_v: self.range.or_else(own).ok_or(ControlError::NoRange)?,
            slew_v_per_s: self.slew_per_s,
            wanted: RequiredMargins { trusted_to_hz, ..self.margins },
            realise: model.realise_options(sample_rate_hz, self.realise),
        })
    }

    pub(super) fn knowledge(&self, reference: &[f64], sample_rate_hz: f64) -> ReferenceKnowledge {
        let fastest_hz = sample_rate_hz / (2.0 * shortest_swing(reference).max(1) as f64);
        let predict_to_hz = self.predict_to_hz.unwrap_or(fastest_hz.min(MOST_PREDICTED * sample_rate_hz));
        ReferenceKnowledge { preview: self.preview, predict_to_hz, bandwidth_hz: self.bandwidth_hz }
    }

    /// Samples between those skipped at the beginning and, at the end, the missing preview.
    pub(super) fn scored(
        &self,
        loops: &[(Controller, Loop)],
        samples: usize,
        sample_rate_hz: f64,
    ) -> Result<Range<usize>, ControlError> {
        let skipped = self.skip_s.map_or(samples / 4, |seconds| (seconds * sample_rate_hz) as usize);
        let previews = loops.iter().filter_map(|(_, made)| made.inverse.as_ref()).map(|i| i.preview);
        let ahead = previews.max().unwrap_or(0).min(samples);
        let end = samples - ahead;
        if skipped.saturating_add(LEAST_SCORED) > end {
            return Err(ControlError::NothingScored { samples, skipped, ahead });
        }
        Ok(skipped..end)
    }

    /// Sines about the middle of the reference with its amplitude; none for a constant reference.
    pub(super) fn sines(
        &self,
        reference: &[f64],
        sample_rate_hz: f64,
    ) -> Result<Option<Sines>, ControlError> {
        let range_hz = self.sines_hz.unwrap_or(SINES.map(|share| share * sample_rate_hz));
        let half_rate_hz = 0.5 * sample_rate_hz;
        if !(range_hz[0] > 0.0 && range_hz[1] < half_rate_hz) {
            return Err(ControlError::Sines { half_rate_hz });
        }
        let lowest_hz = Sines::lowest_hz(sample_rate_hz);
        if range_hz[0] < lowest_hz {
            return Err(ControlError::SlowSines { begin_hz: range_hz[0], lowest_hz });
        }
        let (low, high) = range_of(reference);
        let (level, amplitude) = (0.5 * (low + high), 0.5 * (high - low));
        Ok((amplitude > 0.0).then_some(Sines { level, amplitude, range_hz }))
    }
}
