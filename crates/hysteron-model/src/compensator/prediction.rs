//! Prediction of a reference from its past.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

/// Largest number of past samples in a prediction, and its length in periods of the highest frequency.
const MOST_SAMPLES: usize = 128;
const PERIODS: f64 = 1.0;

/// Model of a reference beyond its known samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Prediction {
    /// It stays constant.
    Stays,
    /// It is a random motion with a flat spectrum from 0 to `highest_hz` about an unknown level, plus white
    /// noise of `noise` times its rms.
    Band {
        /// Highest frequency \[Hz\].
        highest_hz: f64,
        /// Ratio of the rms of the noise to that of the motion.
        noise: f64,
    },
}

/// Default ratio of the rms of the noise to that of the motion.
const USUAL_NOISE: f64 = 1e-3;

impl Prediction {
    /// [`Self::Band`] up to `highest_hz` with the default noise; without a frequency, [`Self::Stays`].
    pub fn up_to(highest_hz: Option<f64>) -> Self {
        highest_hz.map_or(Self::Stays, |highest_hz| Self::Band { highest_hz, noise: USUAL_NOISE })
    }

    /// Weights on the newest samples, the newest first, of the best linear unbiased prediction of each of
    /// `ahead` samples to come: least mean square error, the weights adding up to 1 (ordinary kriging: G.
    /// Matheron, *Econ. Geol.* 58 (1963) 1246–1266, doi:10.2113/gsecongeo.58.8.1246), so that a level is
    /// predicted exactly. One row per sample ahead.
    pub(super) fn weights(self, ahead: usize, sample_rate_hz: f64) -> Option<DMatrix<f64>> {
        let (highest_hz, noise) = match self {
            Self::Stays => return Some(DMatrix::from_element(ahead, 1, 1.0)),
            Self::Band { highest_hz, noise } => (highest_hz, noise),
        };
        let count = (PERIODS * sample_rate_hz / highest_hz).ceil().clamp(2.0, MOST_SAMPLES as f64) as usize;
        let correlation = |samples: f64| {
            let x = TAU * highest_hz * samples / sample_rate_hz;
            if x == 0.0 { 1.0 } else { x.sin() / x }
        };
        let system = DMatrix::from_fn(count + 1, count + 1, |i, j| match (i < count, j < count) {
            (true, true) => correlation(i as f64 - j as f64) + if i == j { noise * noise } else { 0.0 },
            (false, false) => 0.0,
            _ => 1.0,
        });
        let factors = system.lu();
        let mut weights = DMatrix::zeros(ahead, count);
        for step in 0..ahead {
            let distance = (step + 1) as f64;
            let right =
                DVector::from_fn(
                    count + 1,
                    |i, _| {
                        if i < count { correlation(distance + i as f64) } else { 1.0 }
                    },
                );
            let solved = factors.solve(&right)?;
            for i in 0..count {
                weights[(step, i)] = solved[i];
            }
        }
        weights.iter().all(|w| w.is_finite()).then_some(weights)
    }
}
