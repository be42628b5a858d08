//! Noise and distortion of a response taken from records.

use hysteron_identify::frequency_response::empirical::{DetectionLines, EmpiricalResponse};
use hysteron_report::number::significant;
use serde::Serialize;

/// Root mean squares over the lines.
#[derive(Serialize)]
pub struct Summary {
    realisations: usize,
    periods: Vec<usize>,
    period_samples: usize,
    lines: usize,
    noise_percent: Option<f64>,
    distortion_percent: Option<f64>,
    odd_detection: Option<Detection>,
    even_detection: Option<Detection>,
}

#[derive(Serialize)]
struct Detection {
    lines: usize,
    amplitude_rms: f64,
    noise_rms: f64,
}

pub fn summary(found: &EmpiricalResponse) -> Summary {
    let relative = |list: &Option<Vec<f64>>| {
        let list = list.as_ref()?;
        let shares: Vec<f64> =
            list.iter().zip(&found.response.values).map(|(s, g)| 100.0 * s / g.norm()).collect();
        Some(rms(&shares))
    };
    let detection = |lines: &DetectionLines| {
        (!lines.amplitude.is_empty()).then(|| Detection {
            lines: lines.amplitude.len(),
            amplitude_rms: rms(&lines.amplitude),
            noise_rms: rms(&lines.noise),
        })
    };
    Summary {
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

/// The same in sentences.
pub fn words(found: &EmpiricalResponse) -> String {
    let s = summary(found);
    let periods = s.periods.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let mut text = format!(
        "From {} record(s) of {periods} whole period(s) of {} samples in steady state: {} excited lines, no leakage.",
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
        None => text += " Records with other phases would tell nonlinear distortion from noise.",
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
