//! Summary of an inverse drive, for programs.

use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

use super::Preview;
use crate::Finding;
use crate::invert::InverseDrive;
use crate::model_file::SignalUnits;
use crate::record::{Keyed, key_in, range_of};

/// Figures of an inverse drive and of its predicted error. As JSON, quantities in the units of input and
/// output have keys that end in them.
#[derive(Clone, Debug, PartialEq)]
pub struct InverseSummary {
    /// Samples of the reference.
    pub samples: usize,
    /// Their rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Input at which the device rests before the first sample; `None` where the reference repeats.
    pub rest: Option<f64>,
    /// Least drive.
    pub drive_low: f64,
    /// Largest drive.
    pub drive_high: f64,
    /// Largest rate of the drive, per second.
    pub fastest_drive_per_s: f64,
    /// Samples limited by the range.
    pub samples_at_range: usize,
    /// Samples limited by the slew rate.
    pub samples_at_slew: usize,
    /// Tracking bandwidth \[Hz\]; `None` for a static model.
    pub bandwidth_hz: Option<f64>,
    /// Relative error there.
    pub error_at_bandwidth: Option<f64>,
    /// Gain from white noise on the reference to noise on the hysteresis output, both rms.
    pub noise_gain: Option<f64>,
    /// Preview of a law that works sample by sample; `None` where the whole reference is known.
    pub preview: Option<Preview>,
    /// Rms error, the model assumed exact.
    pub predicted_rms_error: f64,
    /// Largest error, the model assumed exact.
    pub predicted_max_error: f64,
    /// Rms error in per cent of the stroke of the reference \[%\].
    pub predicted_rms_percent_of_stroke: f64,
    /// Error to expect on the device; `None` where the file holds no correlation.
    pub forecast: Option<ErrorForecast>,
    /// Limits on tracking, with remedies.
    pub findings: Vec<Finding>,
    /// Symbol of the unit of the input.
    pub input_unit: String,
    /// Symbol of the unit of the output.
    pub output_unit: String,
}

/// Error to expect when a drive is played on the device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorForecast {
    /// Largest half-width of the 95 % band of the model's output.
    pub band_of_model: f64,
    /// Largest half-width of the 95 % band of a measurement; `None` where the file holds no scores.
    pub band_of_measurement: Option<f64>,
    /// Root of the expected mean square of reference − measurement; `None` as above.
    pub expected_rms: Option<f64>,
    /// What it rests on, where that is not the training records alone; [`InverseSummary::new`] puts them with
    /// its own.
    pub findings: Vec<Finding>,
}

impl InverseSummary {
    /// Summary of the `found` drive for a reference, with the `forecast` of the error on the device, whose
    /// findings join the others.
    pub fn new(
        reference: &[f64],
        (found, preview): (&InverseDrive, Option<Preview>),
        sample_rate_hz: f64,
        mut forecast: Option<ErrorForecast>,
        mut findings: Vec<Finding>,
        units: &SignalUnits,
    ) -> Self {
        findings.extend(forecast.iter_mut().flat_map(|forecast| std::mem::take(&mut forecast.findings)));
        let (drive_low, drive_high) = range_of(&found.drive);
        let (low, high) = range_of(reference);
        let errors = || reference.iter().zip(&found.predicted).map(|(r, y)| (r - y).abs());
        let rms = (errors().map(|e| e * e).sum::<f64>() / reference.len() as f64).sqrt();
        let rest = found.rest.and_then(|start| start.voltage_v());
        let before = rest.or_else(|| found.drive.last().copied());
        let steps = before.into_iter().chain(found.drive.iter().copied());
        let fastest =
            steps.zip(&found.drive).map(|(from, to)| (to - from).abs()).fold(0.0, f64::max) * sample_rate_hz;
        Self {
            samples: reference.len(),
            sample_rate_hz,
            rest,
            drive_low,
            drive_high,
            fastest_drive_per_s: fastest,
            samples_at_range: found.at_range,
            samples_at_slew: found.at_slew,
            bandwidth_hz: found.dynamics.map(|d| d.bandwidth_hz),
            error_at_bandwidth: found.dynamics.map(|d| d.error_at_bandwidth),
            noise_gain: found.dynamics.map(|d| d.noise_gain),
            preview,
            predicted_rms_error: rms,
            predicted_max_error: errors().fold(0.0, f64::max),
            predicted_rms_percent_of_stroke: 100.0 * rms / (high - low).max(f64::MIN_POSITIVE),
            forecast,
            findings,
            input_unit: units.input.clone(),
            output_unit: units.output.clone(),
        }
    }
}

impl Serialize for InverseSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (input, output) = (self.input_unit.as_str(), self.output_unit.as_str());
        let told = Keyed::default()
            .with("samples", self.samples)
            .with("sample_rate_hz", self.sample_rate_hz)
            .in_unit("rest", input, self.rest)
            .in_unit("drive_low", input, self.drive_low)
            .in_unit("drive_high", input, self.drive_high)
            .with(key_in("fastest_drive", input) + "_per_s", self.fastest_drive_per_s)
            .with("samples_at_range", self.samples_at_range)
            .with("samples_at_slew", self.samples_at_slew)
            .with("bandwidth_hz", self.bandwidth_hz)
            .with("error_at_bandwidth", self.error_at_bandwidth)
            .with("noise_gain", self.noise_gain);
        let told = match self.preview {
            Some(preview) => {
                let told = told.with("preview_samples", preview.samples);
                told.with("useful_preview_samples", preview.useful).with("preview_is_cut", preview.cut)
            }
            None => told,
        };
        let told = told
            .in_unit("predicted_rms_error", output, self.predicted_rms_error)
            .in_unit("predicted_max_error", output, self.predicted_max_error)
            .with("predicted_rms_percent_of_stroke", self.predicted_rms_percent_of_stroke)
            .in_unit("band", output, self.forecast.as_ref().map(|forecast| forecast.band_of_model));
        let measured = self.forecast.as_ref().and_then(|f| f.band_of_measurement.zip(f.expected_rms));
        let told = match measured {
            Some((band, rms)) => {
                told.in_unit("band_of_measurement", output, band).in_unit("expected_rms_error", output, rms)
            }
            None => told,
        };
        let told = if self.findings.is_empty() { told } else { told.with("findings", &self.findings) };
        told.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for InverseSummary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keyed = Keyed::deserialize(deserializer)?;
        let unit =
            |key: &str| keyed.unit_of(key).ok_or_else(|| D::Error::custom(format_args!("{key} is missing")));
        let (input, output) = (unit("drive_low")?, unit("predicted_max_error")?);
        let forecast = match keyed.get_in_unit("band", output)? {
            Some(band_of_model) => Some(ErrorForecast {
                band_of_model,
                band_of_measurement: keyed.get_in_unit("band_of_measurement", output)?,
                expected_rms: keyed.get_in_unit("expected_rms_error", output)?,
                findings: Vec::new(),
            }),
            None => None,
        };
        Ok(Self {
            samples: keyed.get("samples")?,
            sample_rate_hz: keyed.get("sample_rate_hz")?,
            rest: keyed.get_in_unit("rest", input)?,
            drive_low: keyed.get_in_unit("drive_low", input)?,
            drive_high: keyed.get_in_unit("drive_high", input)?,
            fastest_drive_per_s: keyed.get(&(key_in("fastest_drive", input) + "_per_s"))?,
            samples_at_range: keyed.get("samples_at_range")?,
            samples_at_slew: keyed.get("samples_at_slew")?,
            bandwidth_hz: keyed.get("bandwidth_hz")?,
            error_at_bandwidth: keyed.get("error_at_bandwidth")?,
            noise_gain: keyed.get("noise_gain")?,
            preview: match keyed.get("preview_samples")? {
                Some(samples) => Some(Preview {
                    samples,
                    useful: keyed.get("useful_preview_samples")?,
                    cut: keyed.get("preview_is_cut")?,
                }),
                None => None,
            },
            predicted_rms_error: keyed.get_in_unit("predicted_rms_error", output)?,
            predicted_max_error: keyed.get_in_unit("predicted_max_error", output)?,
            predicted_rms_percent_of_stroke: keyed.get("predicted_rms_percent_of_stroke")?,
            forecast,
            findings: keyed.get::<Option<_>, _>("findings")?.unwrap_or_default(),
            input_unit: input.to_owned(),
            output_unit: output.to_owned(),
        })
    }
}
