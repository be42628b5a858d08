//! Summary of an excitation, for programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Excitation;

/// Numbers of an [`Excitation`], without its samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExcitationSummary {
    /// One sentence with all numbers and units.
    pub description: String,
    /// Samples.
    pub samples: usize,
    /// Sample rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Duration \[s\].
    pub duration_s: f64,
    /// Least voltage \[V\].
    pub low_v: f64,
    /// Largest voltage \[V\].
    pub high_v: f64,
    /// Largest rate \[V/s\].
    pub max_slew_v_per_s: f64,
    /// Crest factor.
    pub crest_factor: f64,
    lead_in_samples: usize,
    lead_out_samples: usize,
    period_samples: Option<usize>,
    excited_hz: Vec<f64>,
    odd_detection_hz: Vec<f64>,
    even_detection_hz: Vec<f64>,
}

impl Excitation {
    /// The result for programs.
    pub fn summary(&self) -> ExcitationSummary {
        let (low_v, high_v) = self.range_v();
        ExcitationSummary {
            description: self.description.clone(),
            samples: self.samples_v.len(),
            sample_rate_hz: self.sample_rate_hz,
            duration_s: self.duration_s(),
            low_v,
            high_v,
            max_slew_v_per_s: self.max_slew_v_per_s(),
            crest_factor: self.crest_factor(),
            lead_in_samples: self.lead_in_samples,
            lead_out_samples: self.lead_out_samples,
            period_samples: self.period_samples,
            excited_hz: self.excited_hz.clone(),
            odd_detection_hz: self.odd_detection_hz.clone(),
            even_detection_hz: self.even_detection_hz.clone(),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::excitation::ExcitationSpec;

    #[test]
    fn a_summary_comes_back() {
        let text = r#"{"sample_rate_hz": 1000, "low_v": 0, "high_v": 10,
            "waveform": {"kind": "sine", "frequency_hz": 5, "periods": 2}}"#;
        let summary = serde_json::from_str::<ExcitationSpec>(text).unwrap().generate().unwrap().summary();
        let json = serde_json::to_string(&summary).unwrap();
        assert_eq!(serde_json::from_str::<ExcitationSummary>(&json).unwrap(), summary);
    }
}
