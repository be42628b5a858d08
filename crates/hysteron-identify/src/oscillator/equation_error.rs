//! The equation of motion as a linear regression: u = m ÿ + c ẏ + k y + α ζ\[y\] + e, line by line of the
//! spectrum.

use nalgebra::{DMatrix, DVector};
use rustfft::num_complex::Complex64;

use super::Options;
use super::preparation::PreparedRecord;
use crate::IdentifyError;
use hysteron_model::Start;
use hysteron_model::hysteresis::{RecordEnds, UnitShape};
use hysteron_model::record::InterSample;
use hysteron_numeric::fft::RealFft;
use hysteron_numeric::triangular;

/// Oversampling factor of the path along which the loop is simulated.
const FINER: usize = 4;
/// Share of the force's power above the highest frequency used.
const BEYOND: f64 = 1e-3;
/// Highest frequency of the force used, and of the path, as a share of the sample rate.
const HIGHEST: f64 = 0.45;
/// Iterations of the weights.
const WEIGHTINGS: usize = 5;
/// Least damping ratio of the linear oscillator.
const LEAST_DAMPING: f64 = 1e-3;

/// m, c, k and α of the best oscillator with a given shape of its loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coefficients {
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub alpha: f64,
}

/// The regression, prepared for any shape.
#[derive(Debug)]
pub(super) struct EquationError {
    parts: Vec<RecordSpectra>,
    /// Weighted spectra of ÿ, ẏ and y, line by line, and of the force less the contribution of held
    /// parameters.
    columns: [Vec<f64>; 3],
    target: Vec<f64>,
    held: [Option<f64>; 2],
    /// Root mean square of the motion.
    pub size: f64,
    /// m, c and k + α of the best linear oscillator.
    pub linear: [f64; 3],
    /// Lowest frequency of the force and highest used \[Hz\].
    pub band_hz: (f64, f64),
}

/// One record.
struct RecordSpectra {
    path: Vec<f64>,
    start: Start<f64>,
    window: Option<Vec<f64>>,
    fft: RealFft,
    /// First line used.
    first: usize,
    weights: Vec<Complex64>,
    samples: usize,
}

impl std::fmt::Debug for RecordSpectra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Part({} samples, {} lines)", self.samples, self.weights.len())
    }
}

/// Buffers of one evaluation.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    zeta: Vec<f64>,
    column: Vec<f64>,
}

/// Displacement, velocity and acceleration at the samples.
struct Motion {
    y: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl EquationError {
    pub(super) fn new(pieces: &[PreparedRecord], options: &Options) -> Result<Self, IdentifyError> {
        let fixed = |name: &str| options.fixed.iter().find(|(n, _)| n == name).map(|(_, value)| *value);
        let held = [fixed("mass"), fixed("damping")];
        let mut parts = Vec::new();
        let mut spectra: Vec<[Vec<Complex64>; 4]> = Vec::new();
        let mut omegas: Vec<Vec<f64>> = Vec::new();
        let (mut power, mut count, mut band) = (0.0, 0usize, (f64::INFINITY, 0f64));
        for piece in pieces {
            let samples = piece.y.len();
            let open = piece.start != Start::PERIODIC;
            let fft = RealFft::new(samples);
            let window = open.then(|| hann(samples));
            // A constant leaks into lines 0 and 1 under the window.
            let first = if open { 2 } else { 1 };
            let mean = mean(&piece.u);
            let force: Vec<f64> = piece.u.iter().map(|u| u - mean).collect();
            let spectrum = spectrum(&fft, &force, window.as_deref());
            let last = last_line(&spectrum, samples).max(first + 3);
            let resolution = piece.rate / samples as f64;
            let highest = (2.0 * last as f64 * resolution).min(HIGHEST * piece.rate);
            let motion = motion(&piece.y, piece.rate, piece.ends(), highest);
            let of = |x: &[f64]| -> Vec<Complex64> {
                let all = self::spectrum(&fft, x, window.as_deref());
                all.into_iter().skip(first).take(last + 1 - first).collect()
            };
            let lines = last + 1 - first;
            omegas
                .push((first..=last).map(|line| std::f64::consts::TAU * line as f64 * resolution).collect());
            spectra.push([of(&motion.acceleration), of(&motion.velocity), of(&motion.y), of(&force)]);
            power += motion.y.iter().map(|y| y * y).sum::<f64>();
            count += samples;
            let lowest = first_line(&spectrum).max(first) as f64 * resolution;
            band = (band.0.min(lowest), band.1.max(last as f64 * resolution));
            let path = InterSample::BandLimited.upsample(&motion.y, FINER, piece.ends())?;
            let start = match piece.start {
                Start::Settled { .. } => Start::PERIODIC,
                _ => Start::AsIdentified,
            };
            parts.push(RecordSpectra {
                path,
                start,
                window,
                fft,
                first,
                weights: vec![Complex64::ONE; lines],
                samples,
            });
        }
        let size = (power / count.max(1) as f64).sqrt();
        let mut regression = Self {
            parts,
            columns: Default::default(),
            target: Vec::new(),
            held,
            size,
            linear: [0.0; 3],
            band_hz: band,
        };
        regression.weigh(&spectra, &omegas)?;
        Ok(regression)
    }

    /// The linear oscillator by iterated weights 1/impedance, and the columns under the last weights.
    fn weigh(&mut self, spectra: &[[Vec<Complex64>; 4]], omegas: &[Vec<f64>]) -> Result<(), IdentifyError> {
        for _ in 0..WEIGHTINGS {
            self.fill(spectra);
            let Some((found, _)) = self.solve(None, None) else { return Err(IdentifyError::NoLoop) };
            let [mass, damping, stiffness] = [found.mass, found.damping, found.stiffness];
            if !(mass > 0.0 && stiffness > 0.0) {
                return Err(IdentifyError::NoOscillator { mass, damping, stiffness });
            }
            let damping = damping.max(LEAST_DAMPING * 2.0 * (mass * stiffness).sqrt());
            self.linear = [mass, damping, stiffness];
            for (part, omegas) in self.parts.iter_mut().zip(omegas) {
                for (weight, &omega) in part.weights.iter_mut().zip(omegas) {
                    let impedance = Complex64::new(stiffness - mass * omega * omega, damping * omega);
                    *weight = 1.0 / impedance;
                }
            }
        }
        self.fill(spectra);
        Ok(())
    }

    /// Columns and target under the present weights.
    fn fill(&mut self, spectra: &[[Vec<Complex64>; 4]]) {
        let weighted = |which: usize| {
            let mut column = Vec::new();
            for (part, spectra) in self.parts.iter().zip(spectra) {
                part.weigh(&spectra[which], &mut column);
            }
            column
        };
        self.columns = [weighted(0), weighted(1), weighted(2)];
        self.target = weighted(3);
        for (column, held) in self.columns.iter().zip(self.held) {
            if let Some(value) = held {
                self.target.iter_mut().zip(column).for_each(|(u, x)| *u -= value * x);
            }
        }
    }

    /// Number of residuals.
    pub(super) fn rows(&self) -> usize {
        self.target.len()
    }

    /// m, c, k and α for the loop of the shape (b, g, n) normalised by the size of the motion, and the
    /// residual, as an output error, into `residual`. `None` where the loop has no steady state.
    pub(super) fn project(
        &self,
        [b, g, n]: [f64; 3],
        scratch: &mut Scratch,
        residual: Option<&mut [f64]>,
    ) -> Option<(Coefficients, f64)> {
        let scale = self.size.powf(-n);
        let shape = UnitShape { beta: b * scale, gamma: g * scale, n };
        scratch.column.clear();
        for part in &self.parts {
            scratch.zeta.clear();
            scratch.zeta.resize(part.samples, 0.0);
            shape.simulate_every(FINER, &part.path, part.start, &mut scratch.zeta).ok()?;
            let spectrum = spectrum(&part.fft, &scratch.zeta, part.window.as_deref());
            part.weigh(spectrum.get(part.first..).unwrap_or_default(), &mut scratch.column);
        }
        let found = self.solve(Some(&scratch.column), residual)?;
        found.1.is_finite().then_some(found)
    }

    /// Linear least squares; the second result is the root mean square of the residual.
    fn solve(&self, zeta: Option<&[f64]>, residual: Option<&mut [f64]>) -> Option<(Coefficients, f64)> {
        let free = |i: usize| self.held.get(i).is_none_or(|held| held.is_none());
        let which: Vec<usize> = (0..3).filter(|&i| free(i)).collect();
        let mut columns: Vec<&[f64]> = which.iter().map(|&i| self.columns[i].as_slice()).collect();
        columns.extend(zeta);
        let unknowns = columns.len();
        let mut with_target = columns.clone();
        with_target.push(&self.target);
        let r = triangular(&with_target);
        let square: DMatrix<f64> = r.view((0, 0), (unknowns, unknowns)).into_owned();
        let right: DVector<f64> = r.view((0, unknowns), (unknowns, 1)).column(0).into_owned();
        let solution = square.solve_upper_triangular(&right).filter(|x| x.iter().all(|x| x.is_finite()))?;
        let of = |i: usize| which.iter().position(|&w| w == i).map(|at| solution[at]);
        let held = |i: usize| self.held.get(i).copied().flatten();
        let value = |i: usize| of(i).or(held(i)).unwrap_or(0.0);
        let found = Coefficients {
            mass: value(0),
            damping: value(1),
            stiffness: value(2),
            alpha: if zeta.is_some() { solution[unknowns - 1] } else { 0.0 },
        };
        if let Some(out) = residual {
            out.copy_from_slice(&self.target);
            for (column, factor) in columns.iter().zip(solution.iter()) {
                out.iter_mut().zip(*column).for_each(|(r, x)| *r -= factor * x);
            }
        }
        let left = r[(unknowns, unknowns)].abs() / (self.rows().max(1) as f64).sqrt();
        Some((found, left))
    }
}

impl RecordSpectra {
    /// Appends real and imaginary parts of the weighted lines to `column`, scaled so that their sum of
    /// squares is that over the samples.
    fn weigh(&self, lines: &[Complex64], column: &mut Vec<f64>) {
        let scale = (2.0 / self.samples as f64).sqrt();
        for (weight, line) in self.weights.iter().zip(lines) {
            let value = weight * line * scale;
            column.extend([value.re, value.im]);
        }
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

fn hann(samples: usize) -> Vec<f64> {
    let turn = std::f64::consts::TAU / samples as f64;
    (0..samples).map(|k| 0.5 - 0.5 * (turn * k as f64).cos()).collect()
}

/// Half-spectrum of `x` under the window.
fn spectrum(fft: &RealFft, x: &[f64], window: Option<&[f64]>) -> Vec<Complex64> {
    let mut time = x.to_vec();
    if let Some(window) = window {
        time.iter_mut().zip(window).for_each(|(x, w)| *x *= w);
    }
    let mut lines = fft.forward.make_output_vec();
    // Lengths come from the plan, so the transform cannot fail.
    fft.transform(&mut time, &mut lines);
    lines
}

/// Line above which the force has negligible power.
fn last_line(spectrum: &[Complex64], samples: usize) -> usize {
    let power: Vec<f64> = spectrum.iter().map(|c| c.norm_sqr()).collect();
    let total: f64 = power.iter().sum();
    let mut above = 0.0;
    let highest = (HIGHEST * samples as f64) as usize;
    let beyond = power.iter().rposition(|p| {
        above += p;
        above > BEYOND * total
    });
    beyond.unwrap_or(highest).min(highest)
}

/// The lowest line of the force: below it lies as little of its power as above [`last_line`].
fn first_line(spectrum: &[Complex64]) -> usize {
    let total: f64 = spectrum.iter().map(|c| c.norm_sqr()).sum();
    let mut below = 0.0;
    let within = spectrum.iter().position(|c| {
        below += c.norm_sqr();
        below > BEYOND * total
    });
    within.unwrap_or(0)
}

/// Displacement low-passed at `highest_hz`, and its derivatives. A non-periodic record is extended as in
/// [`RecordEnds::Open`].
fn motion(y: &[f64], rate: f64, ends: RecordEnds, highest_hz: f64) -> Motion {
    let samples = y.len();
    let (first, last) = (y.first().copied().unwrap_or(0.0), y.last().copied().unwrap_or(0.0));
    let (from, slope) = match ends {
        RecordEnds::Periodic => (mean(y), 0.0),
        RecordEnds::Open => (first, (last - first) / (samples.max(2) - 1) as f64),
    };
    let line = |k: usize| from + slope * k as f64;
    let mut series: Vec<f64> = y.iter().enumerate().map(|(k, y)| y - line(k)).collect();
    if ends == RecordEnds::Open {
        let mirrored: Vec<f64> = series.iter().skip(1).rev().skip(1).map(|d| -d).collect();
        series.extend(mirrored);
    }
    let fft = RealFft::new(series.len());
    let lines = spectrum(&fft, &series, None);
    let resolution = rate / series.len() as f64;
    let derivative = |order: i32| -> Vec<f64> {
        let mut filtered: Vec<Complex64> = lines.clone();
        for (line, value) in filtered.iter_mut().enumerate() {
            let frequency = line as f64 * resolution;
            let factor = Complex64::new(0.0, std::f64::consts::TAU * frequency).powi(order);
            *value =
                if frequency > highest_hz { Complex64::ZERO } else { *value * factor / series.len() as f64 };
        }
        let mut out = fft.inverse.make_output_vec();
        fft.invert(&mut filtered, &mut out);
        out.truncate(samples);
        out
    };
    let mut velocity = derivative(1);
    velocity.iter_mut().for_each(|v| *v += slope * rate);
    let middle = mean(y);
    let y = derivative(0).into_iter().enumerate().map(|(k, y)| y + line(k) - middle).collect();
    Motion { y, velocity, acceleration: derivative(2) }
}
