//! A force that saturates with the rate: a dashpot d tanh(v/ν) behind a compliance.

use serde::{Deserialize, Serialize};

/// The force d s, ρ ṡ = v − ν artanh s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saturation {
    /// Force d at which it saturates \[N\].
    pub force: f64,
    /// Rate ν > 0 of the dashpot, at which it takes tanh 1 = 76 % of d \[µm/s\].
    pub rate: f64,
    /// Displacement ρ ≥ 0 over which the compliance yields by the time the force is d \[µm\].
    pub reach: f64,
}

/// Diagonal coefficient of the two-stage method: 1 − 1/√2.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Most iterations of Newton's method: it converges from one side, and ends long before this.
const ITERATIONS: usize = 100;

impl Saturation {
    /// Name of the number `force`, `rate` or `reach` of the element `index`, from 0.
    pub fn name(number: &str, index: usize) -> String {
        match index {
            0 => format!("saturating_{number}"),
            _ => format!("saturating_{number}_{}", index + 1),
        }
    }

    /// State w = artanh s after `interval_s`, the rate going linearly from `rates[0]` to `rates[1]`.
    ///
    /// The stiffly accurate, L-stable two-stage method of second order (Alexander 1977,
    /// doi:10.1137/0714068): a slider (ν → 0) and a stiff spring (ρ → 0) are no special case. |s| < 1 always.
    pub fn moved(&self, w: f64, rates: [f64; 2], interval_s: f64) -> f64 {
        if self.reach == 0.0 {
            return rates[1] / self.rate;
        }
        let step = GAMMA * interval_s / self.reach;
        if step == 0.0 {
            return w;
        }
        let before = w.tanh();
        let middle = rates[0] + GAMMA * (rates[1] - rates[0]);
        let first = stage(step * self.rate, before + step * middle);
        let grown = (1.0 - GAMMA) / GAMMA * (first.tanh() - before);
        stage(step * self.rate, before + grown + step * rates[1])
    }
}

/// Solution of tanh w + g w = q, g > 0. The left side is odd and, for w ≥ 0, concave: Newton's method from a
/// point below the root rises to it.
fn stage(g: f64, q: f64) -> f64 {
    let target = q.abs();
    // Both are lower bounds: tanh w ≤ w, and tanh w ≤ 1.
    let mut w = (target / (1.0 + g)).max((target - 1.0) / g);
    for _ in 0..ITERATIONS {
        let s = w.tanh();
        let change = (target - s - g * w) / (1.0 - s * s + g);
        w += change;
        if change.abs() <= 1e-14 * w {
            break;
        }
    }
    w.copysign(q)
}
