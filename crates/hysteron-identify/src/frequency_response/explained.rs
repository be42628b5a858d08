//! A frequency response, the structures fitted to it, and their presentation.

use std::collections::BTreeMap;

use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::Hysteresis;
use hysteron_model::model_file::{Maker, ModelFile, Provenance, SignalUnits};
use hysteron_model::record::InterSample;
use hysteron_model::{Advice, Finding, FindingKind};
use hysteron_numeric::number::significant;
use serde::{Deserialize, Serialize, Serializer};

use super::empirical::{DetectionLines, EmpiricalResponse};
use super::{Candidate, FrequencyResponse, Weighting};
use crate::IdentifyError;

/// Relative rms error above which a structure is returned with a warning.
pub const POOR: f64 = 0.1;

/// A measured response and the structures fitted to it.
#[derive(Clone, Debug)]
pub struct Explained {
    /// The response that was fitted.
    pub response: FrequencyResponse,
    /// The empirical estimate, where the response comes from records.
    pub empirical: Option<EmpiricalResponse>,
    /// The structures.
    pub candidates: Vec<Candidate>,
}

/// The structure of lowest AIC that a model file can hold.
#[derive(Clone, Debug)]
pub struct WrittenStructure {
    /// The model.
    pub file: ModelFile,
    /// Its name among the candidates.
    pub name: String,
    /// Relative rms error √(mean |Ĝ/G − 1|²).
    pub relative_rms: f64,
    /// Its DC gain is infinite (a power law).
    pub is_unbounded_at_rest: bool,
}

impl Explained {
    /// The lowest AIC.
    pub fn lowest_aic(&self) -> f64 {
        self.candidates.iter().map(|c| c.fit.aic).fold(f64::INFINITY, f64::min)
    }

    /// Points, band and weights in one sentence.
    pub fn what(&self) -> String {
        let response = &self.response;
        let (low, high) = response.range_hz();
        let weights = Weighting::of(response).in_words();
        format!(
            "{}: {} points from {} to {} Hz, {weights}.",
            response.name,
            response.len(),
            significant(low, 4),
            significant(high, 4)
        )
    }

    /// Warnings about the fits: noise in the band, an error above [`POOR`].
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings = Vec::new();
        if let Some((low, high)) = self.response.band_above_noise() {
            let text = format!(
                "Outside of {} to {} Hz the points scatter by more than 30 % of their value: that is noise, \
                 and no structure describes it.",
                significant(low, 4),
                significant(high, 4)
            );
            findings.push(Finding::new(FindingKind::Warning, "noise", text).with_advice(Advice::NarrowBand));
        }
        let best = self.candidates.iter().min_by(|a, b| a.fit.relative_rms.total_cmp(&b.fit.relative_rms));
        if let Some(best) = best.filter(|best| best.fit.relative_rms > POOR) {
            let text = format!(
                "The best structure, {}, has an error of {} % rms: none of these describes the response. \
                 Take a narrower band, or more modes.",
                best.name,
                significant(100.0 * best.fit.relative_rms, 3)
            );
            findings.push(Finding::new(FindingKind::Warning, "error", text).with_advice(Advice::NarrowBand));
        }
        findings
    }

    /// The model file of the structure of lowest AIC that one can hold, with a linear hysteresis block.
    ///
    /// # Errors
    /// The best structure cannot be held in a file, or there is none.
    pub fn model_file(&self, maker: &Maker) -> Result<WrittenStructure, IdentifyError> {
        let mut order: Vec<&Candidate> = self.candidates.iter().collect();
        order.sort_by(|a, b| a.fit.aic.total_cmp(&b.fit.aic));
        let mut refused = None;
        for candidate in order {
            match candidate.fit.to_transfer_function(&self.response) {
                Ok((tf, delay_s)) => {
                    let is_unbounded_at_rest = tf.dc_gain().is_infinite();
                    let dynamics =
                        if tf.is_integer_order() { Dynamics::Integer(tf) } else { Dynamics::Fractional(tf) };
                    let file = self.file(dynamics, delay_s, candidate, maker)?;
                    return Ok(WrittenStructure {
                        file,
                        name: candidate.name.clone(),
                        relative_rms: candidate.fit.relative_rms,
                        is_unbounded_at_rest,
                    });
                }
                Err(reason) => refused = refused.or(Some(reason)),
            }
        }
        Err(refused.unwrap_or(IdentifyError::NoStructure))
    }

    fn file(
        &self,
        dynamics: Dynamics,
        delay_s: f64,
        candidate: &Candidate,
        maker: &Maker,
    ) -> Result<ModelFile, hysteron_model::hysteresis::HysteresisError> {
        let response = &self.response;
        let (output, input) = response.unit.split_once("_per_").unwrap_or(("", ""));
        let model = Model {
            hysteresis: Hysteresis::without_memory(vec![1.0])?,
            dynamics,
            offset: 0.0,
            delay_s,
            scheme: Scheme::Tustin,
            sample_rate_hz: None,
            inter_sample: InterSample::Linear,
        };
        // With v = u in the input's unit, the gain of the dynamic block converts the units.
        let units = SignalUnits { input: input.to_owned(), output: output.to_owned() };
        let mut file = ModelFile::from_model(&model, units);
        if let Ok((names, covariance)) = candidate.fit.covariance_of_numbers() {
            file.set_covariance(&names, &covariance);
        }
        let (low, high) = response.range_hz();
        let options = BTreeMap::from([
            ("method".to_owned(), "frequency-response".to_owned()),
            ("structure".to_owned(), candidate.fit.structure.to_string()),
            ("response".to_owned(), response.name.clone()),
            ("band".to_owned(), format!("{low}:{high} Hz")),
            ("relative rms error".to_owned(), format!("{:.4} %", 100.0 * candidate.fit.relative_rms)),
        ]);
        file.provenance = Some(Provenance::new(maker, Vec::new(), options, None));
        Ok(file)
    }
}

/// Fits to a frequency response in numbers, for JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExplainedSummary {
    /// Name of the response.
    pub response: String,
    /// Unit of its gain.
    pub unit: String,
    /// Number of its points.
    pub points: usize,
    /// Its lowest and highest frequency \[Hz\].
    pub band_hz: (f64, f64),
    /// `relative`, `scatter` or `uncertainty`.
    pub weighting: String,
    /// Warnings about the fits.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    /// Quality of the empirical estimate, where the response comes from records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub empirical: Option<EmpiricalSummary>,
    /// Structures that were fitted, the preferred one first.
    pub structures: Vec<StructureSummary>,
}

/// A structure fitted to a frequency response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StructureSummary {
    /// Its name.
    pub name: String,
    /// Its transfer function.
    pub formula: String,
    /// Rms of the relative error \[%\].
    pub rms_error_percent: f64,
    /// Largest relative error \[%\].
    pub largest_error_percent: f64,
    /// Frequency of the largest error \[Hz\].
    pub largest_error_at_hz: f64,
    /// Akaike's information criterion.
    pub aic: f64,
    /// Starts of the search.
    pub starts: usize,
    /// Starts that ended in the best optimum.
    pub starts_in_best_optimum: usize,
    /// Meaning of the parameters, in a sentence.
    pub explanation: String,
    /// Its parameters.
    pub parameters: Vec<ResponseParameter>,
}

/// A parameter of a structure fitted to a frequency response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResponseParameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Standard error, where the response determines it.
    pub std_error: Option<f64>,
    /// It ended at a bound of its range.
    pub on_edge: bool,
}

impl Serialize for Explained {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}

impl Explained {
    /// The fits in numbers.
    pub fn summary(&self) -> ExplainedSummary {
        let response = &self.response;
        let structure = |c: &Candidate| StructureSummary {
            name: c.name.clone(),
            formula: c.fit.structure.to_string(),
            rms_error_percent: 100.0 * c.fit.relative_rms,
            largest_error_percent: 100.0 * c.fit.largest.0,
            largest_error_at_hz: c.fit.largest.1,
            aic: c.fit.aic,
            starts: c.fit.starts,
            starts_in_best_optimum: c.fit.agreeing,
            explanation: c.explanation.clone(),
            parameters: c
                .fit
                .parameters
                .iter()
                .map(|p| ResponseParameter {
                    name: p.name.clone(),
                    value: p.value,
                    unit: p.unit.clone(),
                    std_error: p.std_error,
                    on_edge: p.on_edge,
                })
                .collect(),
        };
        ExplainedSummary {
            response: response.name.clone(),
            unit: response.unit.clone(),
            points: response.len(),
            band_hz: response.range_hz(),
            weighting: Weighting::of(response).name().to_owned(),
            findings: self.findings(),
            empirical: self.empirical.as_ref().map(empirical_summary),
            structures: self.candidates.iter().map(structure).collect(),
        }
    }
}

/// Quality of an estimated frequency response; root mean squares over its lines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmpiricalSummary {
    /// Records.
    pub realisations: usize,
    /// Whole periods of each in steady state.
    pub periods: Vec<usize>,
    /// Samples of a period.
    pub period_samples: usize,
    /// Excited lines.
    pub lines: usize,
    /// Noise \[%\]; `None` for a single period.
    pub noise_percent: Option<f64>,
    /// Nonlinear distortion \[%\]; `None` for a single record.
    pub distortion_percent: Option<f64>,
    /// Odd lines that were not excited, where there are any.
    pub odd_detection: Option<DetectionSummary>,
    /// Even lines that were not excited, where there are any.
    pub even_detection: Option<DetectionSummary>,
}

/// Lines that were not excited and show nonlinear distortion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetectionSummary {
    /// Their number.
    pub lines: usize,
    /// Rms amplitude of the output at them.
    pub amplitude_rms: f64,
    /// Rms noise at them.
    pub noise_rms: f64,
}

fn empirical_summary(found: &EmpiricalResponse) -> EmpiricalSummary {
    let relative = |list: &Option<Vec<f64>>| {
        let list = list.as_ref()?;
        let shares: Vec<f64> =
            list.iter().zip(&found.response.values).map(|(s, g)| 100.0 * s / g.norm()).collect();
        Some(rms(&shares))
    };
    let detection = |lines: &DetectionLines| {
        (!lines.amplitude.is_empty()).then(|| DetectionSummary {
            lines: lines.amplitude.len(),
            amplitude_rms: rms(&lines.amplitude),
            noise_rms: rms(&lines.noise),
        })
    };
    EmpiricalSummary {
        realisations: found.realisations,
        periods: found.periods.clone(),
        period_samples: found.period_samples,
        lines: found.response.len(),
        noise_percent: relative(&found.noise_std),
        distortion_percent: relative(&found.distortion_std),
        odd_detection: detection(&found.odd_detection),
        even_detection: detection(&found.even_detection),
    }
}

fn rms(list: &[f64]) -> f64 {
    (list.iter().map(|x| x * x).sum::<f64>() / list.len().max(1) as f64).sqrt()
}

impl EmpiricalResponse {
    /// Noise and distortion in sentences.
    pub fn in_words(&self) -> String {
        let s = empirical_summary(self);
        let periods = s.periods.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let mut text = format!(
            "From {} record(s) of {periods} whole period(s) of {} samples in steady state: {} excited lines, \
             no leakage.",
            s.realisations, s.period_samples, s.lines
        );
        match s.noise_percent {
            Some(noise) => {
                text += &format!(" Noise of the mean response: {} % rms.", significant(noise, 3));
            }
            None => text += " One period: no noise estimate.",
        }
        match s.distortion_percent {
            Some(distortion) => {
                text += &format!(
                    " Stochastic nonlinear distortion of one realisation: {} % rms.",
                    significant(distortion, 3)
                );
            }
            None => text += " Records with other phases would distinguish nonlinear distortion from noise.",
        }
        for (parity, lines) in [("odd", &s.odd_detection), ("even", &s.even_detection)] {
            if let Some(d) = lines {
                text += &format!(
                    " {} {parity} line(s) that are not excited: amplitude {} rms, of which noise {}.",
                    d.lines,
                    significant(d.amplitude_rms, 3),
                    significant(d.noise_rms, 3)
                );
            }
        }
        text
    }
}
