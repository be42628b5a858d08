//! Figure 1: how the loop changes with frequency, and the claim that below 5 Hz it hardly does.

use super::ArticleError;
use super::measurements::Measurements;
use hysteron_model::record::InputOutput;
use serde::{Deserialize, Serialize};

/// Loops of the bench against frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopStudy {
    /// One loop a frequency, the slowest first.
    pub loops: Vec<LoopAt>,
}

/// The last period of a sine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopAt {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// max y − min y over the period \[µm\].
    pub stroke_um: f64,
    /// Opening at mid-range drive, % of stroke; positive: counter-clockwise.
    pub opening_percent: f64,
    /// Largest distance from the slowest loop at the same phase, each about its own mean, % of the slowest
    /// stroke.
    pub largest_distance_percent: f64,
    /// Root mean square of that distance, % of the slowest stroke.
    pub rms_distance_percent: f64,
    /// Drive over the period \[V\].
    pub u_v: Vec<f64>,
    /// Displacement \[µm\].
    pub y_um: Vec<f64>,
}

/// Most points kept of a loop.
const POINTS: usize = 1000;

impl LoopStudy {
    pub(super) fn of(bench: &Measurements) -> Result<Self, ArticleError> {
        let mut loops: Vec<LoopAt> = Vec::new();
        let mut slowest: Option<(Vec<f64>, f64)> = None;
        for (frequency_hz, record) in bench.loops() {
            let (u, y) = last_period(record, frequency_hz)?;
            let stroke_um = span(&y);
            let centred = about_mean(&y);
            let (reference, scale) = slowest.get_or_insert_with(|| (centred.clone(), stroke_um));
            let distances: Vec<f64> = (0..y.len())
                .map(|k| centred[k] - at_phase(reference, k as f64 * reference.len() as f64 / y.len() as f64))
                .collect();
            let largest = distances.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
            let step = y.len().div_ceil(POINTS);
            let thin = |x: &[f64]| x.iter().step_by(step).copied().collect();
            let quarter = y.len() / 4;
            let at = |k: usize| y.get(k).copied().unwrap_or(0.0);
            loops.push(LoopAt {
                frequency_hz,
                stroke_um,
                opening_percent: 100.0 * (at(3 * quarter) - at(quarter)) / stroke_um,
                largest_distance_percent: 100.0 * largest / *scale,
                rms_distance_percent: 100.0 * hysteron_optimize::root_mean_square(&distances) / *scale,
                u_v: thin(&u),
                y_um: thin(&y),
            });
        }
        Ok(Self { loops })
    }

    /// The loop at a frequency.
    pub fn at(&self, frequency_hz: f64) -> Option<&LoopAt> {
        self.loops.iter().find(|l| l.frequency_hz == frequency_hz)
    }
}

/// Drive and displacement over the last period, which starts at the lowest drive.
fn last_period(record: &InputOutput, frequency_hz: f64) -> Result<(Vec<f64>, Vec<f64>), ArticleError> {
    let rate = record.require_sample_rate_hz("loops against frequency")?;
    let samples = ((rate / frequency_hz).round() as usize).clamp(1, record.len());
    let from = record.len() - samples;
    Ok((record.u[from..].to_vec(), record.y[from..].to_vec()))
}

fn about_mean(y: &[f64]) -> Vec<f64> {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    y.iter().map(|y| y - mean).collect()
}

/// Value of a period at a place of 0 … its length, linear between samples.
fn at_phase(period: &[f64], place: f64) -> f64 {
    let k = place.floor() as usize % period.len();
    let next = (k + 1) % period.len();
    let share = place - place.floor();
    (1.0 - share) * period[k] + share * period[next]
}

fn span(y: &[f64]) -> f64 {
    let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &y| (l.min(y), h.max(y)));
    high - low
}
