//! Exponent of the level in the schedule of the modes.
//!
//! Three levels or more can determine it. With the responses G_l of the levels, the exponent p is that of the
//! closest
//!
//! ```text
//! G_l ≈ A + S_l B,   S_l = (level_l / reference)^p − 1
//! ```
//!
//! A and B free at every line, where it is clearly closer than 0.3: noise and distortions alone change the
//! misfit by less than a factor of two over p. Else, and with two levels, which fit any p, 0.3 is assumed,
//! between constant and linear in amplitude.

use super::Options;
use super::records::Campaign;
use hysteron_model::axes::FrequencyMatrix;
use hysteron_numeric::Complex64;

/// Where the levels do not determine it.
const ASSUMED: f64 = 0.3;
/// Factor by which the misfit of the closest exponent is below that of the assumed one.
const CLEARLY: f64 = 2.0;
/// Exponents tried: 0.1, 0.15 … 2.
const LOWEST: f64 = 0.1;
const STEP: f64 = 0.05;
const TRIED: usize = 39;

/// The exponent and its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Exponent {
    pub value: f64,
    pub origin: Origin,
}

/// Origin of an exponent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// By the options.
    Given,
    /// From the responses of three levels or more.
    Responses,
    /// Not determined.
    Assumed,
}

impl Exponent {
    /// Of the options, else of the records.
    pub(super) fn new(campaign: &Campaign, options: &Options) -> Self {
        if let Some(value) = options.exponent {
            return Self { value, origin: Origin::Given };
        }
        let value = if campaign.levels.len() > 2 { of_responses(campaign) } else { None };
        match value {
            Some(value) => Self { value, origin: Origin::Responses },
            None => Self { value: ASSUMED, origin: Origin::Assumed },
        }
    }
}

/// The closest exponent; `None` where it is not clearly closer than the assumed one, a level has no response
/// of its own, or the lines differ.
fn of_responses(campaign: &Campaign) -> Option<f64> {
    let responses = (0..campaign.levels.len()).map(|level| {
        let pieces = campaign.of_level(level);
        let periods: Vec<_> = pieces.iter().map(|piece| &piece.period).collect();
        FrequencyMatrix::local_polynomial(&periods).ok()
    });
    let responses = responses.collect::<Option<Vec<_>>>()?;
    let first = responses.first()?;
    if responses.iter().any(|of| of.frequency_hz != first.frequency_hz) {
        return None;
    }
    let values: Vec<&[Complex64]> = responses.iter().map(|of| of.values.as_slice()).collect();
    let misfit = |p: f64| misfit(&values, &campaign.levels, p);
    let tried = (0..TRIED).map(|k| LOWEST + STEP * k as f64);
    let closest = tried.min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))?;
    (misfit(ASSUMED) > CLEARLY * misfit(closest)).then_some(closest)
}

/// Σ_l w_l |G_l − A − S_l B|² with the best A and B, over all lines; w_l the level, as in the weights of the
/// fit.
fn misfit(responses: &[&[Complex64]], levels: &[f64], p: f64) -> f64 {
    let highest = levels.last().copied().unwrap_or(1.0);
    let states: Vec<f64> = levels.iter().map(|level| (level / highest).powf(p) - 1.0).collect();
    let mean = |of: &dyn Fn(usize) -> f64| {
        let weight: f64 = levels.iter().sum();
        (0..levels.len()).map(|l| levels[l] * of(l)).sum::<f64>() / weight
    };
    let centre = mean(&|l| states[l]);
    let spread = mean(&|l| (states[l] - centre).powi(2));
    let entry = |k: usize| {
        let part = |of: &dyn Fn(&Complex64) -> f64| {
            let middle = mean(&|l| of(&responses[l][k]));
            let slope = mean(&|l| (states[l] - centre) * of(&responses[l][k])) / spread;
            mean(&|l| (of(&responses[l][k]) - middle - slope * (states[l] - centre)).powi(2))
        };
        part(&|g| g.re) + part(&|g| g.im)
    };
    (0..responses.first().map_or(0, |of| of.len())).map(entry).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponent_of_three_responses_is_the_closest() {
        let levels = [0.5, 1.0, 2.0];
        let response = |level: f64| {
            let s = f64::powf(level / 2.0, 0.45) - 1.0;
            [Complex64::new(2.0 + 0.3 * s, -0.4 * s), Complex64::new(-1.0, 0.2 + 0.1 * s)]
        };
        let responses = levels.map(response);
        let values: Vec<&[Complex64]> = responses.iter().map(|r| r.as_slice()).collect();
        assert!(misfit(&values, &levels, 0.45) < 1e-28);
        assert!(misfit(&values, &levels, 0.35) > 1e-8 && misfit(&values, &levels, 0.55) > 1e-8);
    }
}
