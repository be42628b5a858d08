//! From fitted poles to first- and second-order sections with taps and delay.

use std::f64::consts::PI;

use super::fit::FittedSections;
use super::target::real_if_close;
use crate::record::InterSample;
use hysteron_numeric::Complex64;

/// One pole or pair in delta form: ξ ← ξ + g (w − ξ), output Re(c ξ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// g = 1 − a, a the pole in the delay operator's inverse; real for a real pole.
    pub gain: Complex64,
    /// c; its real part is the section's share of the gain at rest.
    pub weight: Complex64,
}

impl Section {
    /// True if it is a pair of poles.
    pub fn is_pair(&self) -> bool {
        self.gain.im != 0.0
    }

    /// True if both poles lie inside the unit circle.
    pub fn is_stable(&self) -> bool {
        // |1 − g|² < 1.
        self.gain.norm_sqr() < 2.0 * self.gain.re
    }

    /// States: one, or two for a pair.
    pub fn states(&self) -> usize {
        if self.is_pair() { 2 } else { 1 }
    }

    /// −ln |a| times the sample rate: the rate \[rad/s\] at which the section decays.
    pub fn rate(&self, sample_rate_hz: f64) -> f64 {
        -0.5 * (self.gain.norm_sqr() - 2.0 * self.gain.re).ln_1p() * sample_rate_hz
    }
}

/// Taps on the newest inputs and the sections behind them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Discrete {
    pub taps: Vec<f64>,
    pub sections: Vec<Section>,
}

/// The exact sampled response of poles on the s-plane to an input that is linear or held between its samples,
/// delayed by a `fraction` of a sample.
pub(super) fn of_continuous(fitted: &FittedSections, rule: InterSample, fraction: f64) -> Discrete {
    let held = rule == InterSample::Hold;
    let direct: f64 = fitted.taps.iter().sum();
    let mut taps = match (held, fraction > 0.0) {
        (_, false) => vec![direct, 0.0, 0.0],
        (true, true) => vec![0.0, direct, 0.0],
        (false, true) => vec![(1.0 - fraction) * direct, fraction * direct, 0.0],
    };
    let last = if fraction > 0.0 { 2 } else { 1 };
    let mut sections = Vec::with_capacity(fitted.poles.len());
    for &(pole, weight) in &fitted.poles {
        let (gain, c) = answer(pole.place, held, fraction);
        let a = 1.0 - gain;
        // (c₀ + c₁q + c₂q²)/(1 − aq) = c₀ + (c₁ + ac₀)q + q²(c₂ + a(c₁ + ac₀))/(1 − aq), or one tap less
        // where c₂ = 0.
        let mut carried = Complex64::ZERO;
        for (k, c) in c.into_iter().take(last).enumerate() {
            carried = carried * a + c;
            taps[k] += (weight * carried).re;
        }
        let behind = (c[last] + a * carried) / gain;
        sections.push(Section { gain: real_if_close(gain), weight: weight * behind });
    }
    taps.truncate(last);
    Discrete { taps, sections }
}

/// g = 1 − a and the numbers by which the last three inputs move the state (their sum is g), for ẋ = −p (w −
/// x), place = p h.
fn answer(place: Complex64, held: bool, fraction: f64) -> (Complex64, [Complex64; 3]) {
    let gain = -expm1(place);
    // Of a stretch of length t (in samples): a constant moves the state by 1 − e^(pt), a ramp of 1 over it by
    // the second number.
    let stretch = |t: f64| {
        let forget = -expm1(place * t);
        let rise = if t == 0.0 { Complex64::ZERO } else { 1.0 - mean_of_exp(place * t) };
        (forget, rise)
    };
    let (early, late) = (stretch(fraction), stretch(1.0 - fraction));
    // The state after the early stretch still decays over the late one.
    let fade = 1.0 - late.0;
    let zero = Complex64::ZERO;
    if held {
        return (gain, [zero, late.0, fade * early.0]);
    }
    // Early: from w₁ + f (w₂ − w₁) to w₁. Late: from w₁ to w₁ + (1 − f)(w₀ − w₁).
    let f = fraction;
    let newest = late.1 * (1.0 - f);
    let oldest = fade * (early.0 - early.1) * f;
    (gain, [newest, gain - newest - oldest, oldest])
}

/// eˣ − 1 without cancellation.
pub(super) fn expm1(x: Complex64) -> Complex64 {
    let (sin, cos) = x.im.sin_cos();
    let half = (0.5 * x.im).sin();
    let grown = x.re.exp_m1();
    Complex64::new(grown * cos - 2.0 * half * half, (grown + 1.0) * sin)
}

/// (eˣ − 1)/x.
fn mean_of_exp(x: Complex64) -> Complex64 {
    if x.norm() > 0.1 {
        return expm1(x) / x;
    }
    // Σ xᵏ/(k + 1)!, truncation 0.1¹⁰/11!.
    (1..=10).rev().fold(Complex64::ONE, |sum, k| 1.0 + sum * x / f64::from(k + 1))
}

/// Sections fitted on the q-plane, with a linearly interpolated delay of a `fraction` of a sample: (1 − f) +
/// f q times them.
pub(super) fn of_sampled(fitted: &FittedSections, fraction: f64) -> Discrete {
    let f = fraction;
    let own = fitted.taps.len();
    let mut taps = fitted.taps.clone();
    let plain =
        |(pole, weight): &(super::target::Pole, Complex64)| Section { gain: pole.place, weight: *weight };
    let mut sections: Vec<Section> = fitted.poles.iter().map(plain).collect();
    if f > 0.0 {
        taps.push(0.0);
        for k in (0..=own).rev() {
            let before = if k > 0 { taps[k - 1] } else { 0.0 };
            taps[k] = (1.0 - f) * taps[k] + f * before;
        }
        // q^L g((1 − f) + fq)/(1 − aq) = (1 − f) g q^L + q^(L+1) g (f + (1 − f) a)/(1 − aq).
        for section in &mut sections {
            taps[own] += (1.0 - f) * (section.weight * section.gain).re;
            section.weight *= f + (1.0 - f) * (1.0 - section.gain);
        }
    }
    Discrete { taps, sections }
}

impl Discrete {
    /// Response at the angle θ.
    pub fn at(&self, theta: f64) -> Complex64 {
        let half = (0.5 * theta).sin();
        let one_minus_q = Complex64::new(2.0 * half * half, theta.sin());
        let q = Complex64::from_polar(1.0, -theta.min(PI));
        let taps = self.taps.iter().rev().fold(Complex64::ZERO, |sum, &tap| sum * q + tap);
        let behind = q.powu(self.taps.len() as u32);
        self.sections.iter().fold(taps, |sum, section| {
            let of = |gain: Complex64, weight: Complex64| weight * gain / (one_minus_q + gain * q);
            let answer = of(section.gain, section.weight);
            let answer = if section.is_pair() {
                0.5 * (answer + of(section.gain.conj(), section.weight.conj()))
            } else {
                answer
            };
            sum + behind * answer
        })
    }
}
