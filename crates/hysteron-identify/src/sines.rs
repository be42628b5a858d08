//! Gain and phase at the sine segments of a record, measured and modelled, with standard errors.
//!
//! Both are H = Y/U, Fourier components of output and drive at the sine's frequency under one window. Y is
//! linear in the output, so that the derivatives of the model's H follow from those of its output under the
//! same window; with the covariance of the parameters they give the errors of |H| and arg H.

use std::ops::Range;

use hysteron_model::record::{
    ExcitationKind, InputOutput, Segment, excitation_kind, find_periods, fundamental_response,
};
use hysteron_numeric::Complex64;
use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::normal::NORMAL_975;

/// Gain and phase with their standard errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GainPhase {
    /// Gain \[output unit per input unit\].
    pub gain: f64,
    /// Its standard error in the same unit, where it is known.
    pub gain_std_error: Option<f64>,
    /// Phase \[°\].
    pub phase_deg: f64,
    /// Its standard error \[°\], where it is known.
    pub phase_std_error_deg: Option<f64>,
}

impl GainPhase {
    /// Measured response of a segment; `None` where it is not a sine or wave.
    fn of_segment(segment: &Segment) -> Option<Self> {
        Some(Self {
            gain: segment.gain?,
            gain_std_error: segment.gain_std_error,
            phase_deg: segment.phase_deg?,
            phase_std_error_deg: segment.phase_std_error_deg,
        })
    }

    /// Without errors.
    fn of_ratio(ratio: Complex64) -> Self {
        let (gain, phase_deg) = (ratio.norm(), ratio.arg().to_degrees());
        Self { gain, gain_std_error: None, phase_deg, phase_std_error_deg: None }
    }

    /// Half the width of the 95 % interval of the gain \[output unit per input unit\].
    pub fn gain_95(&self) -> Option<f64> {
        self.gain_std_error.map(|error| NORMAL_975 * error)
    }

    /// Half the width of the 95 % interval of the phase \[°\].
    pub fn phase_95_deg(&self) -> Option<f64> {
        self.phase_std_error_deg.map(|error| NORMAL_975 * error)
    }
}

/// Gain and phase at one sine of a record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineResponse {
    /// Samples of the record.
    pub samples: Range<usize>,
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Measured; its standard error is from the scatter of the output about the sine.
    pub measured: GainPhase,
    /// From the model's free run; its standard error follows from the parameter covariance.
    pub model: GainPhase,
}

/// The sines of one record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordSines {
    /// Name of the record.
    pub record: String,
    /// Its sines, in the order of time.
    pub sines: Vec<SineResponse>,
}

impl SineResponse {
    /// Sines of a record, measured and simulated, without standard errors of the model; empty for a uniformly
    /// sampled record.
    pub fn of_record(data: &InputOutput, simulated: &[f64]) -> Vec<Self> {
        let one = |segment: Segment| {
            Some(Self {
                measured: GainPhase::of_segment(&segment)?,
                model: GainPhase::of_ratio(segment.response(&data.u, simulated)?),
                frequency_hz: segment.drive.high_hz?,
                samples: segment.samples,
            })
        };
        data.segments().into_iter().filter_map(one).collect()
    }

    /// Response at the one frequency of a uniformly sampled record of a wave, over its settled periods and
    /// without standard errors; `None` for any other record.
    pub fn of_fundamental(data: &InputOutput, simulated: &[f64]) -> Option<Self> {
        let ExcitationKind::Wave { frequency, .. } = excitation_kind(&data.u) else { return None };
        let periods = find_periods(data).ok();
        let response = |data: &InputOutput| {
            let found = fundamental_response(data, frequency, periods.as_ref())?;
            let (gain, phase_deg) = (found.gain, found.phase_rad.to_degrees());
            let response = GainPhase { gain, gain_std_error: None, phase_deg, phase_std_error_deg: None };
            Some((found.frequency_hz, response))
        };
        let of_model = InputOutput { y: simulated.to_vec(), ..data.clone() };
        let ((frequency_hz, measured), (_, model)) = (response(data)?, response(&of_model)?);
        Some(Self { samples: 0..data.len(), frequency_hz, measured, model })
    }
}

/// Sets the standard errors of the model in `sines`. `columns`: derivatives of the record's output with
/// respect to the parameters with this covariance.
pub(crate) fn give_errors<'a>(
    sines: impl Iterator<Item = &'a mut SineResponse>,
    data: &InputOutput,
    simulated: &[f64],
    (columns, covariance): (&[&[f64]], &DMatrix<f64>),
) {
    let segments = data.segments();
    for sine in sines {
        let Some(segment) = segments.iter().find(|s| s.samples == sine.samples) else { continue };
        let Some(ratio) = segment.response(&data.u, simulated) else { continue };
        // d ln H: the relative change of the gain, and the change of the phase in rad.
        let relative: Option<Vec<Complex64>> =
            columns.iter().map(|column| Some(segment.response(&data.u, column)? / ratio)).collect();
        let Some(relative) = relative else { continue };
        let std_error = |part: fn(&Complex64) -> f64| {
            let part: Vec<f64> = relative.iter().map(part).collect();
            let variance: f64 = (0..part.len())
                .flat_map(|i| (0..part.len()).map(move |j| (i, j)))
                .map(|(i, j)| part[i] * covariance[(i, j)] * part[j])
                .sum();
            variance.max(0.0).sqrt()
        };
        sine.model.gain_std_error = Some(sine.model.gain * std_error(|d| d.re));
        sine.model.phase_std_error_deg = Some(std_error(|d| d.im).to_degrees());
    }
}
