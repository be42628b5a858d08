//! Multisines of equal amplitudes, with chosen lines and low crest factor.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rand_xoshiro::Xoshiro256PlusPlus;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Shape;
use super::random::{fill_range, generator, synthesise, uniform};

/// Multiples of 1/period that a multisine excites inside its band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lines {
    /// All of them.
    #[default]
    Full,
    /// Odd multiples: even-order distortion appears at the even ones.
    Odd,
    /// Odd multiples but one, chosen at random, of every `group`: odd-order distortion appears at those left
    /// out (Pintelon and Schoukens 2012, doi:10.1002/9781118287422, §4.3).
    OddWithDetection {
        /// Consecutive odd multiples of which one is left out, at least 2 (3 or 4 are usual).
        group: u32,
    },
}

/// Choice of the phases of a multisine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Phases {
    /// Independent, uniform: Gaussian amplitudes, the assumption of the best linear approximation.
    Random,
    /// −π i(i − 1)/K for the i-th of K lines (Schroeder 1970, doi:10.1109/TIT.1970.1054411).
    Schroeder,
    /// Lowest crest factor found by repeated clipping from Schroeder's phases and from random ones (Van der
    /// Ouderaa, Schoukens and Renneboog 1988, doi:10.1109/19.7446).
    #[default]
    Optimised,
}

/// A checked multisine: lines are multiples of 1/period.
pub(super) struct Request {
    pub first_line: usize,
    pub last_line: usize,
    pub period_samples: usize,
    pub periods: usize,
    pub lines: Lines,
    pub phases: Phases,
}

/// Clipping rounds from one start; fewer for very long signals, so that rounds × samples stays below `WORK`.
const ROUNDS: usize = 1000;
const WORK: usize = 100_000_000;
/// Clipping level in the first and in the last round, as fractions of the largest value.
const FIRST_CLIP: f64 = 0.5;
const LAST_CLIP: f64 = 0.99;
/// Samples per period of the highest line in the search for peaks.
const FINENESS: usize = 8;

pub(super) fn multisine(request: &Request, fs: f64, seed: u64) -> Shape {
    let mut rng = generator(seed);
    let (excited, left_out) = choose_lines(request, &mut rng);
    let phases = choose_phases(&excited, request.phases, &mut rng);
    let n = request.period_samples;
    let mut spectrum = vec![Complex64::ZERO; n / 2 + 1];
    for (&line, &phase) in excited.iter().zip(&phases) {
        if let Some(bin) = spectrum.get_mut(line) {
            *bin = Complex64::from_polar(1.0, phase);
        }
    }
    let mut period = synthesise(spectrum, n);
    fill_range(&mut period);
    let hz = |lines: &[usize], wanted: &dyn Fn(usize) -> bool| {
        lines.iter().filter(|l| wanted(**l)).map(|&l| l as f64 * fs / n as f64).collect::<Vec<f64>>()
    };
    let even = match request.lines {
        Lines::Full => Vec::new(),
        Lines::Odd | Lines::OddWithDetection { .. } => {
            let all: Vec<usize> = (request.first_line..=request.last_line).collect();
            hz(&all, &|l| l % 2 == 0)
        }
    };
    Shape {
        values: period.repeat(request.periods),
        period_samples: Some(n),
        excited_hz: hz(&excited, &|_| true),
        odd_detection_hz: hz(&left_out, &|_| true),
        even_detection_hz: even,
    }
}

/// Excited lines, and odd ones left out for detection.
fn choose_lines(request: &Request, rng: &mut Xoshiro256PlusPlus) -> (Vec<usize>, Vec<usize>) {
    let band = request.first_line..=request.last_line;
    match request.lines {
        Lines::Full => (band.collect(), Vec::new()),
        Lines::Odd => (band.filter(|l| l % 2 == 1).collect(), Vec::new()),
        Lines::OddWithDetection { group } => {
            let odd: Vec<usize> = band.filter(|l| l % 2 == 1).collect();
            let (mut excited, mut left_out) = (Vec::new(), Vec::new());
            for chunk in odd.chunks(group as usize) {
                // An incomplete last group is excited entirely.
                let out = if chunk.len() == group as usize {
                    (uniform(rng) * f64::from(group)) as usize
                } else {
                    usize::MAX
                };
                for (i, &line) in chunk.iter().enumerate() {
                    if i == out { left_out.push(line) } else { excited.push(line) }
                }
            }
            (excited, left_out)
        }
    }
}

fn choose_phases(excited: &[usize], how: Phases, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    let random = |rng: &mut Xoshiro256PlusPlus| excited.iter().map(|_| TAU * uniform(rng)).collect();
    match how {
        Phases::Random => random(rng),
        Phases::Schroeder => schroeder(excited.len()),
        Phases::Optimised => {
            let mut clipper = Clipper::new(excited);
            let starts: [Vec<f64>; 2] = [schroeder(excited.len()), random(rng)];
            let results = starts.map(|start| clipper.improve(start));
            let [(from_schroeder, a), (from_random, b)] = results;
            if b < a { from_random } else { from_schroeder }
        }
    }
}

fn schroeder(count: usize) -> Vec<f64> {
    let k = count as f64;
    (0..count).map(|i| -PI * (i as f64 * (i as f64 - 1.0) / k % 2.0)).collect()
}

/// Repeated clipping: clip the signal's peaks, keep the phases of the clipped signal, restore the amplitudes.
struct Clipper<'a> {
    excited: &'a [usize],
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    spectrum: Vec<Complex64>,
    signal: Vec<f64>,
}

impl<'a> Clipper<'a> {
    fn new(excited: &'a [usize]) -> Self {
        let n = (FINENESS * excited.last().copied().unwrap_or(1)).next_power_of_two();
        let mut planner = RealFftPlanner::<f64>::new();
        let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
        let (spectrum, signal) = (forward.make_output_vec(), inverse.make_output_vec());
        Clipper { excited, forward, inverse, spectrum, signal }
    }

    /// Best phases of the iteration from `phases`, and their peak-to-peak value.
    fn improve(&mut self, mut phases: Vec<f64>) -> (Vec<f64>, f64) {
        let mut best = (phases.clone(), f64::INFINITY);
        let rounds = (WORK / self.signal.len()).clamp(50, ROUNDS);
        for round in 0..rounds {
            let (low, high) = self.play(&phases);
            if high - low < best.1 {
                best = (phases.clone(), high - low);
            }
            let clip = FIRST_CLIP + (LAST_CLIP - FIRST_CLIP) * round as f64 / (rounds - 1) as f64;
            let limit = clip * high.max(-low);
            for x in &mut self.signal {
                *x = x.clamp(-limit, limit);
            }
            // The lengths fit by construction; an error would leave the phases unchanged.
            if self.forward.process(&mut self.signal, &mut self.spectrum).is_err() {
                break;
            }
            for (phase, &line) in phases.iter_mut().zip(self.excited) {
                *phase = self.spectrum[line].arg();
            }
        }
        best
    }

    /// Synthesises the signal and returns its extremes.
    fn play(&mut self, phases: &[f64]) -> (f64, f64) {
        self.spectrum.fill(Complex64::ZERO);
        for (&line, &phase) in self.excited.iter().zip(phases) {
            self.spectrum[line] = Complex64::from_polar(1.0, phase);
        }
        if self.inverse.process(&mut self.spectrum, &mut self.signal).is_err() {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        self.signal.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| (l.min(x), h.max(x)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Excitation, ExcitationSpec, Waveform};
    use super::*;

    fn make(lines: Lines, phases: Phases, seed: u64) -> Excitation {
        let waveform =
            Waveform::Multisine { low_hz: 1.0, high_hz: 100.0, period_s: 2.0, periods: 2, lines, phases };
        let spec = ExcitationSpec { seed, ..ExcitationSpec::new(2000.0, 0.0, 10.0, waveform) };
        spec.generate().unwrap()
    }

    /// Amplitudes of the lines of one period, mean left out.
    fn lines_of(drive: &Excitation) -> Vec<f64> {
        let n = drive.period_samples.unwrap();
        assert_eq!(drive.samples_v[..n], drive.samples_v[n..]);
        let forward = RealFftPlanner::<f64>::new().plan_fft_forward(n);
        let mut spectrum = forward.make_output_vec();
        forward.process(&mut drive.samples_v[..n].to_vec(), &mut spectrum).unwrap();
        spectrum.iter().skip(1).map(|x| x.norm() * 2.0 / n as f64).collect()
    }

    #[test]
    fn exactly_the_lines_asked_for_are_excited_all_alike() {
        for lines in [Lines::Full, Lines::Odd, Lines::OddWithDetection { group: 4 }] {
            let drive = make(lines, Phases::Optimised, 5);
            let amplitudes = lines_of(&drive);
            let height = amplitudes[(drive.excited_hz[0] * 2.0) as usize - 1];
            let mut found = Vec::new();
            for (i, a) in amplitudes.iter().enumerate() {
                if *a > 1e-9 {
                    assert!((a / height - 1.0).abs() < 1e-9);
                    found.push((i + 1) as f64 * 0.5);
                }
            }
            assert_eq!(found, drive.excited_hz);
        }
        // 0.5 Hz a line: lines 2 … 200, odd ones 3 … 199.
        assert_eq!(make(Lines::Full, Phases::Random, 1).excited_hz.len(), 199);
        let odd = make(Lines::Odd, Phases::Random, 1);
        assert_eq!(
            (odd.excited_hz.len(), odd.odd_detection_hz.len(), odd.even_detection_hz.len()),
            (99, 0, 100)
        );
    }

    #[test]
    fn one_odd_line_of_every_group_is_left_for_detection() {
        let drive = make(Lines::OddWithDetection { group: 4 }, Phases::Schroeder, 5);
        assert_eq!((drive.excited_hz.len(), drive.odd_detection_hz.len()), (99 - 24, 24));
        for (i, f) in drive.odd_detection_hz.iter().enumerate() {
            // Group i holds the odd lines from 3 + 8i on.
            let line = (f * 2.0) as usize;
            assert!(line % 2 == 1 && (line - 3) / 8 == i, "{line} in group {i}");
        }
        let other = make(Lines::OddWithDetection { group: 4 }, Phases::Schroeder, 6);
        assert_ne!(drive.odd_detection_hz, other.odd_detection_hz);
    }

    #[test]
    fn optimised_crest_factor_is_far_below_random_and_schroeder() {
        for (lines, bound) in
            [(Lines::Full, 1.45), (Lines::Odd, 1.45), (Lines::OddWithDetection { group: 3 }, 1.55)]
        {
            let crest = |phases| make(lines, phases, 2).crest_factor();
            let (random, schroeder, best) =
                (crest(Phases::Random), crest(Phases::Schroeder), crest(Phases::Optimised));
            println!("{lines:?}: random {random:.3}, Schroeder {schroeder:.3}, optimised {best:.3}");
            assert!(random > 2.4 && best < bound && best < 0.9 * schroeder, "{random} {schroeder} {best}");
        }
    }

    #[test]
    fn a_single_odd_pair_of_lines_is_no_trouble() {
        let waveform = Waveform::Multisine {
            low_hz: 1.0,
            high_hz: 2.0,
            period_s: 1.0,
            periods: 1,
            lines: Lines::Odd,
            phases: Phases::Optimised,
        };
        let drive = ExcitationSpec::new(100.0, -1.0, 1.0, waveform).generate().unwrap();
        assert_eq!(drive.excited_hz, [1.0]);
        assert!((drive.crest_factor() - 2f64.sqrt()).abs() < 1e-2);
    }
}
