//! Quantities that a drive may be for, as functions of the model, and their derivatives along the prior.
//!
//! They are read off the frequency response, so that they mean the same for every form of the dynamics: the
//! delay; the resonance, the lowest frequency at which G lags by 90°, and its gain there over that at a tenth
//! of it (1/(2ζ) for a pair of poles); creep, the gain at one over the time of the drive over that at ten
//! times this frequency, less 1: the share that creeps within a decade of time.

use nalgebra::DMatrix;

use super::Purpose;
use super::prior::Prior;
use crate::sensitivity::STEP;
use hysteron_model::hammerstein::Model;
use hysteron_numeric::Complex64;

/// Points of the search for a lag of 90°.
const POINTS: usize = 400;
/// Lag from which the dynamics do more than creep.
const LAG_OF_CREEP: f64 = std::f64::consts::FRAC_PI_6;
/// Share of a resonance up to which the gain shows creep: it rises by the square of it.
const BELOW_RESONANCE: f64 = 0.05;
/// Gain over a decade that tells creep from none.
const CREEPS: f64 = 5e-4;

/// A quantity of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    /// Dead time \[s\].
    Delay,
    /// Frequency of the resonance \[Hz\].
    Resonance,
    /// Gain there over the gain at a tenth of it.
    ResonantGain,
    /// Creep within the last decade of the time of the drive.
    Creep,
}

impl Quantity {
    /// Name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Delay => "delay",
            Self::Resonance => "resonance",
            Self::ResonantGain => "gain at resonance",
            Self::Creep => "creep per decade",
        }
    }

    /// Unit, empty for a ratio.
    pub(super) fn unit(self) -> &'static str {
        match self {
            Self::Delay => "s",
            Self::Resonance => "Hz",
            Self::ResonantGain | Self::Creep => "",
        }
    }

    /// Value along direction `k` of the prior. A resonance that is assumed is the pair of poles by itself: the
    /// lag of other dynamics would move the frequency that was asked for.
    fn along(self, prior: &Prior, (k, step): (usize, f64), time_s: f64) -> Option<f64> {
        match (self, prior.assumed_resonance(k, step)) {
            (Self::Resonance, Some((frequency_hz, _))) => Some(frequency_hz),
            (Self::ResonantGain, Some((_, damping))) => {
                Some((1.0f64 - 0.01).hypot(0.2 * damping) / (2.0 * damping))
            }
            _ => self.of(&prior.at(k, step).ok()?, time_s),
        }
    }

    /// Nominal value; `None` where the model has no such quantity.
    pub(super) fn value(self, prior: &Prior, time_s: f64) -> Option<f64> {
        self.along(prior, (0, 0.0), time_s)
    }

    /// Value for a drive of this time \[s\]; `None` where the model has no such quantity.
    pub(super) fn of(self, model: &Model, time_s: f64) -> Option<f64> {
        match self {
            Self::Delay => Some(model.delay_s),
            Self::Resonance => resonance_hz(model),
            Self::ResonantGain => {
                let at = resonance_hz(model)?;
                let gains = gains(model, &[at, 0.1 * at])?;
                Some(gains[0] / gains[1])
            }
            Self::Creep => {
                if !lasts_for_creep(model, time_s) {
                    return None;
                }
                let gains = gains(model, &[1.0 / time_s, 10.0 / time_s])?;
                Some(gains[0] / gains[1] - 1.0)
            }
        }
    }

    /// Derivatives along the directions of the prior; `None` where the model has no such quantity.
    pub(super) fn gradient(self, prior: &Prior, time_s: f64) -> Option<Vec<f64>> {
        let along = |k: usize| {
            let at = |step: f64| self.along(prior, (k, step), time_s);
            Some((at(STEP)? - at(-STEP)?) / (2.0 * STEP))
        };
        (0..prior.count()).map(along).collect()
    }
}

/// Quantities that a purpose is for; none where it is for the output along a motion.
pub(super) fn quantities_of(purpose: Purpose) -> &'static [Quantity] {
    match purpose {
        Purpose::Delay => &[Quantity::Delay],
        Purpose::Resonance => &[Quantity::Resonance, Quantity::ResonantGain],
        Purpose::Creep => &[Quantity::Creep],
        Purpose::MinorLoops | Purpose::Prediction => &[],
    }
}

/// Gradients of quantities, a row each, divided by their values where these are not 0.
pub(super) fn gradients(quantities: &[Quantity], prior: &Prior, time_s: f64) -> Option<DMatrix<f64>> {
    let row = |quantity: &Quantity| {
        let value = quantity.value(prior, time_s)?;
        let scale = if value == 0.0 { 1.0 } else { value };
        Some(quantity.gradient(prior, time_s)?.into_iter().map(|d| d / scale).collect::<Vec<f64>>())
    };
    let rows: Option<Vec<Vec<f64>>> = quantities.iter().map(row).collect();
    let rows = rows?;
    Some(DMatrix::from_fn(rows.len(), prior.count(), |i, j| rows[i][j]))
}

/// True if a drive of this time \[s\] lasts long enough for creep to be told from a lag of the dynamics: at ten
/// times its inverse they lag by less than 30°, more than creep of a power of time up to 1/3.
pub(super) fn lasts_for_creep(model: &Model, time_s: f64) -> bool {
    let at = response(model, &[10.0 / time_s, 1.0 / time_s]);
    at.is_some_and(|at| (at[0] / at[1]).arg().abs() < LAG_OF_CREEP)
}

/// True if the gain rises towards a resonance by more than a four-hundredth within a decade above the inverse of
/// the time \[s\]: it takes that from creep.
pub(super) fn rises_within(resonance_hz: f64, time_s: f64) -> bool {
    10.0 / time_s > BELOW_RESONANCE * resonance_hz
}

/// True if the gain falls over the decade above a tenth of one over the time \[s\]; towards a resonance it
/// rises.
pub(super) fn creeps(model: &Model, time_s: f64) -> bool {
    gains(model, &[0.1 / time_s, 1.0 / time_s]).is_some_and(|gains| gains[0] > (1.0 + CREEPS) * gains[1])
}

/// Lowest frequency at which the dynamics lag by 90° \[Hz\], below half the sample rate if the model has one.
pub(super) fn resonance_hz(model: &Model) -> Option<f64> {
    const LOW: f64 = 0.1;
    const HIGH: f64 = 1e6;
    let high = model.sample_rate_hz.map_or(HIGH, |rate| 0.45 * rate);
    let at = |i: usize| LOW * (high / LOW).powf(i as f64 / (POINTS - 1) as f64);
    let grid: Vec<f64> = (0..POINTS).map(at).collect();
    let response = response(model, &grid)?;
    let sign = response.first()?.re.signum();
    let turned = |g: &Complex64| sign * g.re;
    let above = response.iter().position(|g| turned(g) < 0.0).filter(|&k| k > 0)?;
    let (mut low, mut high) = (grid[above - 1], grid[above]);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        let crossed = self::response(model, &[middle])?.first().is_some_and(|g| turned(g) < 0.0);
        if crossed { high = middle } else { low = middle }
    }
    Some((low * high).sqrt())
}

fn gains(model: &Model, frequencies_hz: &[f64]) -> Option<Vec<f64>> {
    Some(response(model, frequencies_hz)?.iter().map(|g| g.norm()).collect())
}

/// Response of the dynamics without the delay.
fn response(model: &Model, frequencies_hz: &[f64]) -> Option<Vec<Complex64>> {
    Model { delay_s: 0.0, ..model.clone() }.frequency_response(frequencies_hz).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
    use hysteron_model::hysteresis::Hysteresis;
    use hysteron_model::record::InterSample;
    use std::f64::consts::TAU;

    #[test]
    fn a_pair_of_poles_has_its_frequency_and_gain() {
        let term = |coefficient, order| Term { coefficient, order };
        let (omega, damping) = (TAU * 120.0, 0.05);
        let g = TransferFunction {
            numerator: vec![term(omega * omega, 0.0)],
            denominator: vec![term(omega * omega, 0.0), term(2.0 * damping * omega, 1.0), term(1.0, 2.0)],
        };
        let model = Model {
            hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
            dynamics: Dynamics::Integer(g),
            offset: 0.0,
            delay_s: 1e-3,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: Some(5000.0),
        };
        assert!((Quantity::Resonance.of(&model, 10.0).unwrap() - 120.0).abs() < 1e-9);
        // |G| = 10 there, and 1/0.99 (but for the damping) at a tenth.
        let gain = Quantity::ResonantGain.of(&model, 10.0).unwrap();
        assert!((gain - 9.9).abs() < 0.01, "{gain}");
        assert_eq!(Quantity::Delay.of(&model, 10.0), Some(1e-3));
        assert!(!creeps(&model, 10.0));
        assert_eq!(Quantity::Resonance.of(&Model { dynamics: Dynamics::None, ..model }, 10.0), None);
    }

    #[test]
    fn creep_is_the_gain_over_a_decade() {
        let term = |coefficient, order| Term { coefficient, order };
        let g = TransferFunction {
            numerator: vec![term(0.01, 0.0), term(1.0, 0.15)],
            denominator: vec![term(1.0, 0.15)],
        };
        let model = Model {
            hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
            dynamics: Dynamics::Fractional(g.clone()),
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::BandLimited,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        };
        assert!(creeps(&model, 20.0));
        let at = |f: f64| (1.0 + 0.01 * Complex64::new(0.0, TAU * f).powf(-0.15)).norm();
        let expected = at(0.05) / at(0.5) - 1.0;
        assert!((Quantity::Creep.of(&model, 20.0).unwrap() - expected).abs() < 1e-12);
        // Of s^−0.15 without an end there is no time too short; with a pole at 1 Hz there is.
        assert!(lasts_for_creep(&model, 1e-3));
        let mut slow = g;
        slow.denominator = vec![term(1.0, 0.15), term(1.0 / TAU, 1.15)];
        let model = Model { dynamics: Dynamics::Fractional(slow), ..model };
        assert!(lasts_for_creep(&model, 200.0) && !lasts_for_creep(&model, 10.0));
        assert_eq!(Quantity::Creep.of(&model, 10.0), None);
    }
}
