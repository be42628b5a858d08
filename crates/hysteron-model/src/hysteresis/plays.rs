//! Parts that families of plays share: states of plays, and increasing thresholds.

use hysteron_rt::{Scalar, play};

use super::HysteresisError;

/// States of plays.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayStates<S> {
    pub(super) plays: Vec<S>,
}

impl<S: Scalar<Real = f64>> PlayStates<S> {
    pub(super) fn at(count: usize, at: S) -> Self {
        Self { plays: vec![at; count] }
    }

    /// Moves to the voltage u.
    #[inline]
    pub(super) fn advance(&mut self, thresholds: impl Iterator<Item = S>, u: f64) {
        self.plays.iter_mut().zip(thresholds).for_each(|(state, r)| *state = play(r, *state, S::constant(u)));
    }

    /// One column per play.
    pub(super) fn read(&self, out: &mut [S]) {
        out.iter_mut().zip(&self.plays).for_each(|(out, play)| *out = *play);
    }
}

/// Thresholds times a number.
#[inline(always)]
pub(super) fn scaled<S: Scalar<Real = f64>>(thresholds: &[f64], scale: S) -> impl Iterator<Item = S> + Clone {
    thresholds.iter().map(move |&threshold| scale.scale(threshold))
}

/// Half-widths at equal distances below `reach`: reach · j/(count + 1), j = 1 … count.
pub(super) fn evenly_below(reach: f64, count: usize) -> Vec<f64> {
    (1..=count).map(|j| reach * (j as f64 / (count + 1) as f64)).collect()
}

/// Finite, positive and increasing.
pub(super) fn check_thresholds(thresholds: &[f64]) -> Result<(), HysteresisError> {
    let mut above = 0.0;
    for (index, &value) in thresholds.iter().enumerate() {
        if !(value.is_finite() && value > above) {
            return Err(HysteresisError::Threshold { index, value, above });
        }
        above = value;
    }
    Ok(())
}
