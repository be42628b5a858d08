//! True hysteresis outside the Bouc–Wen class: a stack of asymmetric play operators followed by a cubic
//! polynomial.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One play operator with its weight.
///
/// w(t) = max(u(t) − rising, min(u(t) + falling, w(t⁻))), initially w = 0. With rising = falling = r this is
/// the backlash of half-width r; unequal thresholds make the two branches of a loop differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Play {
    /// Threshold while the drive rises \[V\], ≥ 0.
    pub rising_v: f64,
    /// Threshold while the drive falls \[V\], ≥ 0.
    pub falling_v: f64,
    /// Weight \[µm/V\].
    pub weight_um_per_v: f64,
}

/// State of a stack of plays: v = s + quadratic·s² + cubic·s³, s = linear·u + Σ weight·w.
pub(super) struct PlayStates<'a> {
    plays: &'a [Play],
    states_v: Vec<f64>,
    linear_um_per_v: f64,
    quadratic_per_um: f64,
    cubic_per_um2: f64,
}

impl<'a> PlayStates<'a> {
    pub fn new(plays: &'a [Play], linear_um_per_v: f64, quadratic_per_um: f64, cubic_per_um2: f64) -> Self {
        PlayStates {
            plays,
            states_v: vec![0.0; plays.len()],
            linear_um_per_v,
            quadratic_per_um,
            cubic_per_um2,
        }
    }

    /// Hysteresis output \[µm\] after the drive went monotonically to `drive_v`. Exact: a play depends on the
    /// sequence of its extremes only.
    pub fn step(&mut self, drive_v: f64) -> f64 {
        let mut s = self.linear_um_per_v * drive_v;
        for (play, w) in self.plays.iter().zip(&mut self.states_v) {
            *w = (drive_v - play.rising_v).max((drive_v + play.falling_v).min(*w));
            s += play.weight_um_per_v * *w;
        }
        s * (1.0 + s * (self.quadratic_per_um + s * self.cubic_per_um2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_asymmetric_play_follows_the_loop_drawn_by_hand() {
        let play = [Play { rising_v: 1.0, falling_v: 2.0, weight_um_per_v: 0.5 }];
        let mut states = PlayStates::new(&play, 0.0, 0.0, 0.0);
        // drive, play state: dead zone, rise with slope 1, hold over 1 + 2 V, fall, hold, rise.
        let path = [
            (0.0, 0.0),
            (1.0, 0.0),
            (3.0, 2.0),
            (5.0, 4.0),
            (2.0, 4.0),
            (1.0, 3.0),
            (-4.0, -2.0),
            (-1.5, -2.0),
            (-1.0, -2.0),
            (0.0, -1.0),
            (5.0, 4.0),
        ];
        for (drive, state) in path {
            assert_eq!(states.step(drive), 0.5 * state, "at {drive} V");
        }
    }

    #[test]
    fn the_bend_is_applied_after_the_sum() {
        let play = [Play { rising_v: 1.0, falling_v: 1.0, weight_um_per_v: 2.0 }];
        let mut states = PlayStates::new(&play, 3.0, 0.01, -0.002);
        // s = 3·4 + 2·(4 − 1) = 18.
        assert!((states.step(4.0) - (18.0 + 0.01 * 324.0 - 0.002 * 5832.0)).abs() < 1e-12);
    }

    #[test]
    fn steps_may_be_split_anywhere_without_changing_the_state() {
        let plays: Vec<Play> = (1..=9)
            .map(|i| Play {
                rising_v: 0.3 * f64::from(i),
                falling_v: 0.25 * f64::from(i),
                weight_um_per_v: 0.1,
            })
            .collect();
        let turning = [4.0, -1.0, 3.5, 0.2, 5.0, 1.0];
        let mut coarse = PlayStates::new(&plays, 1.0, 0.0, 0.0);
        let mut fine = PlayStates::new(&plays, 1.0, 0.0, 0.0);
        let mut at = 0.0;
        for target in turning {
            let v = coarse.step(target);
            let mut w = 0.0;
            for i in 1..=7 {
                w = fine.step(if i == 7 { target } else { at + (target - at) * f64::from(i) / 7.0 });
            }
            assert!((v - w).abs() < 1e-14);
            at = target;
        }
    }
}
