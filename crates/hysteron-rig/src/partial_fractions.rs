//! Decomposition of a transfer function into poles and branch cut.
//!
//! For G analytic outside its poles p_j and the cut (−∞, −c],
//!
//! ```text
//! G(s) = d + Σ_j r_j/(s − p_j) + ∫₀^∞ ρ(x) / (s + c + x) dx,     ρ(x) = −Im G(−c + x e^{iπ}) / π .
//! ```
//!
//! With x = e^q the trapezoidal rule in q converges geometrically, so the integral becomes a sum of real
//! poles whose number grows with the logarithms of accuracy and bandwidth only. The sum is compared with G on
//! the imaginary axis, and the step in q is halved until they agree: accuracy is checked, not assumed.

use std::f64::consts::PI;

use rustfft::num_complex::Complex64;

use super::RigError;

/// Required agreement with G on the imaginary axis, relative to the largest |G|.
const TOLERANCE: f64 = 1e-9;
/// Real poles that contribute less than this fraction of the largest gain are dropped.
const NEGLIGIBLE: f64 = 1e-14;

/// Real pole `weight / (s + rate)`, rate > 0 \[rad/s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RealPole {
    pub rate: f64,
    pub weight: f64,
}

/// Complex pair `r/(s − p) + r̄/(s − p̄)`, Im p > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PolePair {
    pub pole: Complex64,
    pub residue: Complex64,
}

/// d + Σ weight/(s + rate) + Σ (r/(s − p) + conjugate).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PartialFractions {
    pub feedthrough: f64,
    pub real: Vec<RealPole>,
    pub pairs: Vec<PolePair>,
    /// G(0), infinite where the plant has none.
    pub static_gain: f64,
}

/// Decomposition of a transfer function before its branch cut is sampled.
pub(super) struct Splitting<'a> {
    /// G as a function of L = ln(s + corner), 0 ≤ Im L ≤ π.
    pub response: &'a dyn Fn(Complex64) -> Complex64,
    /// The cut starts at −corner \[rad/s\].
    pub corner: f64,
    /// Poles off the cut, or on it if G is continuous across it.
    pub pairs: Vec<PolePair>,
    /// Isolated real poles.
    pub isolated: Vec<RealPole>,
    /// Whether G jumps across the cut (false: a rational function).
    pub has_cut: bool,
    /// G(0), infinite where the plant has none.
    pub static_gain: f64,
    /// Angular frequencies \[rad/s\] between which the sum must equal G.
    pub band_rad_s: (f64, f64),
}

impl PartialFractions {
    /// G at s.
    pub fn response(&self, s: Complex64) -> Complex64 {
        let cut: Complex64 = self.real.iter().map(|p| (s + p.rate).inv() * p.weight).sum();
        let pairs: Complex64 = self
            .pairs
            .iter()
            .map(|p| p.residue / (s - p.pole) + p.residue.conj() / (s - p.pole.conj()))
            .sum();
        cut + pairs + self.feedthrough
    }

    /// Splits a transfer function.
    pub fn split(splitting: &Splitting<'_>) -> Result<Self, RigError> {
        let (low, high) = splitting.band_rad_s;
        const POINTS: usize = 240;
        let grid: Vec<(Complex64, Complex64)> = (0..POINTS)
            .map(|i| {
                let omega = low * (high / low).powf(i as f64 / (POINTS - 1) as f64);
                let s = Complex64::new(0.0, omega);
                (s, (splitting.response)((s + splitting.corner).ln()))
            })
            .collect();
        let largest = grid.iter().map(|(_, g)| g.norm()).fold(0.0, f64::max);
        let mut step = 0.5;
        let mut error = f64::INFINITY;
        for _ in 0..if splitting.has_cut { 6 } else { 1 } {
            let mut real = splitting.isolated.clone();
            if splitting.has_cut {
                sample_cut(splitting, step, largest, &mut real);
            }
            let mut sum = PartialFractions {
                feedthrough: 0.0,
                real,
                pairs: splitting.pairs.clone(),
                static_gain: splitting.static_gain,
            };
            let misfit: Vec<Complex64> = grid.iter().map(|&(s, g)| g - sum.response(s)).collect();
            let feedthrough = misfit.iter().map(|m| m.re).sum::<f64>() / POINTS as f64;
            if feedthrough.abs() > TOLERANCE * largest {
                sum.feedthrough = feedthrough;
            }
            error = misfit.iter().map(|m| (m - sum.feedthrough).norm()).fold(0.0, f64::max) / largest;
            if error <= TOLERANCE {
                return Ok(sum);
            }
            step *= 0.5;
        }
        Err(RigError::Decomposition { error })
    }
}

/// Appends the trapezoidal sum over ln x of the cut, outwards from the middle of the band until the terms are
/// negligible.
fn sample_cut(splitting: &Splitting<'_>, step: f64, largest: f64, real: &mut Vec<RealPole>) {
    let (low, high) = splitting.band_rad_s;
    let middle = 0.5 * (low.ln() + high.ln());
    let at = |q: f64| {
        let density = -(splitting.response)(Complex64::new(q, PI)).im / PI;
        let x = q.exp();
        RealPole { rate: splitting.corner + x, weight: density * x * step }
    };
    let limit = NEGLIGIBLE * largest;
    let mut push_while = |direction: f64, first: usize, (end_of_band, end): (f64, f64)| {
        for k in first.. {
            let q = middle + direction * step * k as f64;
            let pole = at(q);
            // Outside the band a term can only shrink: stop there once it no longer counts.
            let share = pole.weight.abs() / pole.rate.max(low);
            if !share.is_finite() || direction * (q - end) > 0.0 {
                break;
            }
            if share > limit {
                real.push(pole);
            } else if direction * (q - end_of_band) > 0.0 {
                break;
            }
        }
    };
    push_while(1.0, 0, (high.ln(), high.ln() + 40.0));
    push_while(-1.0, 1, (low.ln(), low.ln() - 60.0));
}

#[cfg(test)]
impl PartialFractions {
    /// Unit step response at t ≥ 0 from rest at zero, in closed form.
    pub fn step_response(&self, t: f64) -> f64 {
        let cut: f64 = self.real.iter().map(|p| -p.weight / p.rate * (-p.rate * t).exp_m1()).sum();
        let pairs: f64 =
            self.pairs.iter().map(|p| 2.0 * (p.residue / p.pole * ((p.pole * t).exp() - 1.0)).re).sum();
        self.feedthrough + cut + pairs
    }
}
