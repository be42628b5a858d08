//! The dynamic block as sections, to a specified accuracy.

use std::f64::consts::{PI, TAU};

use super::fit::{FittedSections, Point, weights};
use super::poles::{Cut, about, logarithmic, of_arx, of_transfer_function, on_the_cut, upper_half};
use super::sections::{Discrete, Section, of_continuous, of_sampled};
use super::target::{Pole, Target};
use super::{RealiseError, RealiseOptions};
use crate::dynamics::{Dynamics, Stability, TransferFunction, stability};
use crate::fractional::Scheme;
use crate::hammerstein::Model;
use crate::record::InterSample;
use hysteron_numeric::Complex64;

/// Most real poles for a branch cut.
const MOST_POLES: usize = 64;
/// Most whole samples of delay.
const MOST_DELAY: usize = 1 << 20;
/// Points of the fit per decade; those of the check are denser.
const PER_DECADE: usize = 24;
/// Images of the sampled spectrum that the error is summed over, to either side.
const IMAGES: i32 = 12;
/// Lowest angle evaluated for a response that settles.
const LOWEST: f64 = 1e-12;
/// A static gain below this share of the largest does not measure the range.
const SMALL_GAIN: f64 = 1e-3;

/// The dynamic block, delay included, as taps and stable sections of first and second order:
///
/// H = q^m (Σ tapsⱼ qʲ + q^L Σ sections), q the unit delay, m = `delay_samples`, L taps.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearRealisation {
    /// Taps on the newest inputs.
    pub taps: Vec<f64>,
    /// Sections, slow ones first.
    pub sections: Vec<Section>,
    /// Whole samples of delay.
    pub delay_samples: usize,
    /// Gain at rest: G(0), or 1 where that is infinite.
    pub rest_gain: f64,
    /// Largest |error of the response| over the band, as a share of `reference_gain`.
    pub frequency_error: f64,
    /// The gain that errors are relative to: the static gain (that at the lowest frequency where it is
    /// infinite); the largest where that is negligible.
    pub reference_gain: f64,
    /// The band \[Hz\]: from rest, or the lowest frequency, to half the sample rate.
    pub band_hz: (f64, f64),
}

/// Matrices of a discrete state space of one input and one output.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    /// A, row by row.
    pub a: Vec<f64>,
    /// B.
    pub b: Vec<f64>,
    /// C.
    pub c: Vec<f64>,
    /// D.
    pub d: f64,
}

impl LinearRealisation {
    /// States: numbers that are multiplied by a pole.
    pub fn states(&self) -> usize {
        self.sections.iter().map(Section::states).sum()
    }

    /// Sum of taps and sections at rest; for unbounded creep, the gain at which creep stops.
    pub fn held_gain(&self) -> f64 {
        self.taps.iter().sum::<f64>() + self.sections.iter().map(|s| s.weight.re).sum::<f64>()
    }

    /// Σ |weights| over the gain that errors are relative to: the amplification of the rounding of a
    /// coefficient.
    pub fn amplification(&self) -> f64 {
        let taps: f64 = self.taps.iter().map(|tap| tap.abs()).sum();
        let sections: f64 = self.sections.iter().map(|s| s.weight.norm()).sum();
        (taps + sections) / self.reference_gain
    }

    /// State-space form x⁺ = A x + B w, v = C x + D w of one input and one output: a register of the past
    /// inputs that delay and taps reach, then the sections, real and imaginary part of a pair.
    pub fn state_space(&self) -> StateSpace {
        let depth = self.delay_samples + self.taps.len();
        let n = depth + self.states();
        let mut space = StateSpace { a: vec![0.0; n * n], b: vec![0.0; n], c: vec![0.0; n], d: 0.0 };
        let put = |row: &mut [f64], d: &mut f64, back: usize, gain: f64| match back {
            0 => *d += gain,
            back => row[back - 1] += gain,
        };
        for (j, tap) in self.taps.iter().enumerate() {
            put(&mut space.c, &mut space.d, self.delay_samples + j, *tap);
        }
        for k in 0..depth {
            let row = &mut space.a[k * n..(k + 1) * n];
            put(row, &mut space.b[k], k, 1.0);
        }
        let mut first = depth;
        for section in &self.sections {
            let (kept, count) = (1.0 - section.gain, section.states());
            // ξ⁺ = (1 − g) ξ + g w(k − depth), and v = Re(c ξ⁺).
            let rotation = [[kept.re, -kept.im], [kept.im, kept.re]];
            let entry = [section.gain.re, section.gain.im];
            let read = [section.weight.re, -section.weight.im];
            for (i, kept_row) in rotation.iter().enumerate().take(count) {
                let kept_row = &kept_row[..count];
                let row = &mut space.a[(first + i) * n..(first + i + 1) * n];
                row[first..first + count].copy_from_slice(kept_row);
                put(row, &mut space.b[first + i], depth, entry[i]);
                for (c, kept) in space.c[first..].iter_mut().zip(kept_row) {
                    *c += read[i] * kept;
                }
                put(&mut space.c, &mut space.d, depth, read[i] * entry[i]);
            }
            first += count;
        }
        space
    }

    /// Response at a frequency \[Hz\] at the sample rate it was made for.
    pub fn response(&self, frequency_hz: f64, sample_rate_hz: f64) -> Complex64 {
        let theta = TAU * frequency_hz / sample_rate_hz;
        let discrete = Discrete { taps: self.taps.clone(), sections: self.sections.clone() };
        discrete.at(theta) * Complex64::from_polar(1.0, -theta * self.delay_samples as f64)
    }
}

/// The dynamic block of a model as sections.
pub(super) fn realise(
    model: &Model,
    sample_rate_hz: f64,
    options: &RealiseOptions,
) -> Result<LinearRealisation, RealiseError> {
    let samples = model.delay_s * sample_rate_hz;
    // A delay that is whole but for rounding.
    let samples = if (samples - samples.round()).abs() < 1e-9 { samples.round() } else { samples };
    if !(0.0..=MOST_DELAY as f64).contains(&samples) {
        return Err(RealiseError::Delay { samples, most: MOST_DELAY });
    }
    let (whole, fraction) = (samples.floor() as usize, samples.fract());
    match &model.dynamics {
        Dynamics::None => {
            let taps = if fraction > 0.0 { vec![1.0 - fraction, fraction] } else { vec![1.0] };
            Ok(LinearRealisation {
                taps,
                sections: Vec::new(),
                delay_samples: whole,
                rest_gain: 1.0,
                frequency_error: 0.0,
                reference_gain: 1.0,
                band_hz: (0.0, 0.5 * sample_rate_hz),
            })
        }
        Dynamics::Arx(arx) => {
            arx.validate()?;
            if !arx.is_stable() {
                return Err(RealiseError::Unstable { poles: 0 });
            }
            let first = arx.b.iter().position(|b| *b != 0.0).unwrap_or(0);
            let problem = Problem::new(Target::Arx { arx, first }, of_arx(arx), sample_rate_hz, options)?;
            problem.realised(whole + first, fraction, InterSample::Linear)
        }
        Dynamics::Integer(g) | Dynamics::Fractional(g) => {
            g.validate()?;
            let target = if model.scheme == Scheme::BandLimited {
                Target::Continuous { g, rate_hz: sample_rate_hz }
            } else {
                Target::Sampled { g, scheme: model.scheme, rate_hz: sample_rate_hz }
            };
            if !g.is_proper() && !model.scheme.may_damp() {
                let order = |terms: &[crate::fractional::Term]| terms.last().map_or(0.0, |t| t.order);
                let (numerator, denominator) = (order(&g.numerator), order(&g.denominator));
                return Err(crate::dynamics::DynamicsError::Improper { numerator, denominator }.into());
            }
            match stability(g) {
                Stability::Stable | Stability::Integrating { .. } => {}
                Stability::Unstable { poles } => return Err(RealiseError::Unstable { poles }),
                Stability::Marginal { .. } => return Err(RealiseError::Unstable { poles: 2 }),
            }
            let found = g.poles()?;
            let mut poles = of_transfer_function(target, &found, pole_count(g, found.len()));
            let on_cut = if target.has_cut() { on_the_cut(g) } else { Vec::new() };
            poles.extend(on_cut.iter().flat_map(|x| target.poles_of(Complex64::new(-x, 0.0))));
            let mut problem = Problem::new(target, poles, sample_rate_hz, options)?;
            problem.fall = if model.inter_sample == InterSample::Hold { 1 } else { 2 };
            problem.resonances = found.into_iter().filter(|s| s.im > 0.0).collect();
            problem.realised(whole, fraction, model.inter_sample)
        }
    }
}

/// Poles with their multiplicity: known where the orders are whole, else those found.
fn pole_count(g: &TransferFunction, found: usize) -> usize {
    let orders = |pick: fn(&mut dyn Iterator<Item = f64>) -> Option<f64>| {
        pick(&mut g.denominator.iter().filter(|t| t.coefficient != 0.0).map(|t| t.order)).unwrap_or(0.0)
    };
    let (low, high) = (orders(|i| i.next()), orders(|i| i.last()));
    let whole = g.denominator.iter().all(|t| t.coefficient == 0.0 || (t.order - low).fract() == 0.0);
    if whole { (high - low) as usize } else { found }
}

/// A response to fit.
struct Problem<'a> {
    target: Target<'a>,
    /// Known poles.
    poles: Vec<Pole>,
    /// Resonances \[rad/s\], about which points are dense.
    resonances: Vec<Complex64>,
    sample_rate_hz: f64,
    accuracy: f64,
    /// Power of 1/θ by which the input falls off above half the sample rate: 1 held, 2 linear.
    fall: i32,
    /// Gain at rest, where the band reaches down to it; it is met exactly.
    tied: Option<f64>,
    /// Lowest angle of the band.
    low: f64,
    reference: f64,
}

impl<'a> Problem<'a> {
    fn new(
        target: Target<'a>,
        poles: Vec<Pole>,
        sample_rate_hz: f64,
        options: &RealiseOptions,
    ) -> Result<Self, RealiseError> {
        let at_rest = target.at_rest();
        let finite = at_rest.is_finite();
        let lowest = match options.lowest_frequency_hz {
            Some(f) if f > 0.0 && f < 0.5 * sample_rate_hz => Some(TAU * f / sample_rate_hz),
            Some(value) => {
                let allowed = "positive and below half the sample rate";
                return Err(RealiseError::Option { name: "lowest frequency [Hz]", value, allowed });
            }
            None if finite => None,
            None => return Err(RealiseError::LowestFrequency),
        };
        let from = lowest.unwrap_or(LOWEST);
        let largest = logarithmic(from, PI, 10).map(|t| target.at(t).norm()).fold(0.0, f64::max);
        let own = if finite { at_rest.abs() } else { target.at(from).norm() };
        let reference = if own > SMALL_GAIN * largest { own } else { largest };
        let mut problem = Self {
            target,
            poles,
            resonances: Vec::new(),
            sample_rate_hz,
            accuracy: options.accuracy,
            fall: 2,
            tied: None,
            low: from,
            reference,
        };
        if finite {
            // Below this the response is what it is at rest.
            let apart = |low: f64| (target.at(low) - at_rest).norm() / (options.accuracy * reference);
            let mut low = PI / 8.0;
            while low > from && apart(low) > 0.05 {
                low *= 0.5;
            }
            // Without a cut the poles are all there is, however slow.
            if apart(low) < 0.5 || !target.has_cut() {
                (problem.low, problem.tied) = (low, Some(at_rest));
            } else if lowest.is_none() {
                return Err(RealiseError::LowestFrequency);
            }
        }
        Ok(problem)
    }

    /// Highest angle that is fitted: images of the sampled spectrum are responses to G above half the sample
    /// rate.
    fn high(&self) -> f64 {
        if self.target.is_continuous() { TAU * f64::from(IMAGES) } else { PI }
    }

    fn points(&self, per_decade: usize) -> Vec<Point> {
        let high = self.high();
        let mut angles: Vec<f64> = logarithmic(self.low, high, per_decade).collect();
        let period = 1.0 / self.sample_rate_hz;
        angles.extend(self.resonances.iter().flat_map(|&s| about(s, period)));
        angles.extend(upper_half(2 * per_decade));
        angles.retain(|theta| (self.low..=high).contains(theta));
        angles.sort_by(f64::total_cmp);
        let weight =
            |theta: f64| if theta > PI { (PI / theta).powi(self.fall) } else { 1.0 } / self.reference;
        angles.into_iter().map(|theta| Point { theta, weight: weight(theta) }).collect()
    }

    /// Adds poles for the cut until the accuracy is reached.
    fn realised(
        &self,
        whole: usize,
        fraction: f64,
        rule: InterSample,
    ) -> Result<LinearRealisation, RealiseError> {
        let (points, check) = (self.points(PER_DECADE), self.points(3 * PER_DECADE + 1));
        // A pole far outside the band is a constant within it.
        let (low, high) = (self.low * self.sample_rate_hz / 8.0, 4.0 * self.high() * self.sample_rate_hz);
        let top = if self.target.is_continuous() { high } else { f64::INFINITY };
        let share = 0.02 * self.accuracy * self.reference;
        let cut = Cut::new(self.target, (low, top), share, self.reference);
        let taps = self.target.taps();
        let mut reached = f64::INFINITY;
        let mut count = 0;
        while count <= MOST_POLES {
            let mut poles = self.poles.clone();
            let places = if cut.is_empty() { spread(low, 0.25 * high, count) } else { cut.places(count) };
            poles.extend(places.into_iter().flat_map(|x| self.target.poles_of(Complex64::new(-x, 0.0))));
            if let Some(fitted) = weights(self.target, self.tied, &points, &poles, taps) {
                let error = self.error(&fitted, &check);
                reached = reached.min(error);
                if error <= self.accuracy {
                    return self.finished(&fitted, whole, fraction, rule, error);
                }
            }
            count += if count < 16 { 1 } else { 2 };
        }
        Err(RealiseError::Accuracy { wanted: self.accuracy, reached, poles: MOST_POLES })
    }

    /// Largest error over the band, as a share of the reference: on the s-plane, of the sampled response to a
    /// linear or held input, all images assumed to add up.
    fn error(&self, fitted: &FittedSections, check: &[Point]) -> f64 {
        let error =
            |theta: f64| (fitted.at(self.target, theta) - self.target.at(theta)).norm() / self.reference;
        let within = check.iter().map(|p| p.theta).filter(|theta| *theta <= PI);
        if !self.target.is_continuous() {
            return within.map(error).fold(0.0, f64::max);
        }
        let image = |theta: f64, k: i32| {
            let there = theta + TAU * f64::from(k);
            let share = ((0.5 * theta).sin() / (0.5 * there)).abs().powi(self.fall);
            share * error(there.abs())
        };
        within.map(|theta| (-IMAGES + 1..IMAGES).map(|k| image(theta, k)).sum()).fold(0.0, f64::max)
    }

    fn finished(
        &self,
        fitted: &FittedSections,
        whole: usize,
        fraction: f64,
        rule: InterSample,
        error: f64,
    ) -> Result<LinearRealisation, RealiseError> {
        let mut discrete = if self.target.is_continuous() {
            of_continuous(fitted, rule, fraction)
        } else {
            of_sampled(fitted, fraction)
        };
        if !discrete.sections.iter().all(Section::is_stable) {
            return Err(RealiseError::Unstable { poles: 0 });
        }
        let rate = self.sample_rate_hz;
        discrete.sections.sort_by(|a, b| a.rate(rate).total_cmp(&b.rate(rate)));
        let at_rest = self.target.at_rest();
        let low = if self.tied.is_some() { 0.0 } else { self.low * rate / TAU };
        Ok(LinearRealisation {
            taps: discrete.taps,
            sections: discrete.sections,
            delay_samples: whole,
            rest_gain: if at_rest.is_finite() { at_rest } else { 1.0 },
            frequency_error: error,
            reference_gain: self.reference,
            band_hz: (low, 0.5 * rate),
        })
    }
}

/// Poles over the band where there is no cut.
fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low * (high / low).powf((k as f64 + 0.5) / count as f64)).collect()
}
