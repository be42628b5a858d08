//! The frequencies of a plan, and ln s at them: point by point where it bends, elsewhere as short power
//! series.
//!
//! Away from s = 0 (and from the pole of `Tustin` at half the sample rate) ln s changes so little from one
//! frequency to the next that over a run of them a power of s is a polynomial of the frequency, to the last
//! bit: exp of a power series. A candidate then costs exponentials per run instead of per frequency, and all
//! terms of a polynomial in s add up to one.

use std::f64::consts::{PI, TAU};

use super::Scheme;
use super::blocks::{BLOCK, frequencies};
use hysteron_numeric::{Complex64, SeriesPanel};

/// Longest half of a run, as a share of the distance over which ln s is smooth.
const REACH: f64 = 1.0 / 32.0;
/// Runs shorter than this are not worth a series.
const SHORTEST_RUN: usize = 64;
/// Lengths of runs are multiples of this, so that vectors are full.
const LANES: usize = 16;
/// A series is cut off behind the power n where (half of the run / that distance)^(n + 1) is below this. Its
/// factor, in powers of s about s = 0 a binomial coefficient, is of order 1 for the orders that occur.
const CUT: f64 = 1.2e-16;

/// Bins 0 ..= length/2.
#[derive(Debug)]
pub(super) struct Frequencies {
    /// Number of bins.
    pub(super) bins: usize,
    /// Largest ln |s|.
    pub(super) top: f64,
    pub(super) points: Vec<Points>,
    pub(super) panels: Vec<Panel>,
}

/// ln s = `log_abs` + i `angle` bin by bin, at most [`BLOCK`] from `first` on.
#[derive(Debug)]
pub(super) struct Points {
    pub(super) first: usize,
    pub(super) log_abs: Vec<f64>,
    pub(super) angle: Vec<f64>,
}

/// Runs of bins on which ln s is a power series in the bin.
#[derive(Debug)]
pub(super) struct Panel {
    pub(super) runs: [BinRange; SeriesPanel::LANES],
    pub(super) log: SeriesPanel,
}

/// `count` bins from `first` on; none where the panel is not full.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BinRange {
    pub(super) first: usize,
    pub(super) count: usize,
    /// Degree that is enough for powers of s.
    pub(super) degree: usize,
}

/// The circle |z| = e^(−damping) and s on it.
struct Circle {
    scheme: Scheme,
    length: usize,
    damping: f64,
    sample_rate_hz: f64,
}

impl Frequencies {
    pub(super) fn new(scheme: Scheme, length: usize, damping: f64, sample_rate_hz: f64) -> Self {
        let circle = Circle { scheme, length, damping, sample_rate_hz };
        let bins = length / 2 + 1;
        let (mut points, mut panels) = (Vec::new(), Vec::new());
        let mut runs = Vec::new();
        let mut first = 0;
        while first < bins {
            let count = circle.run(first, bins);
            if count >= SHORTEST_RUN {
                runs.push(BinRange { first, count, degree: circle.degree(first, count) });
                first += count;
            } else {
                let count = BLOCK.min(bins - first);
                let (log_abs, angle) = frequencies(scheme, length, damping, sample_rate_hz, first, count);
                points.push(Points { first, log_abs, angle });
                first += count;
            }
        }
        for group in runs.chunks(SeriesPanel::LANES) {
            let mut panel = Panel { runs: Default::default(), log: SeriesPanel::ZERO };
            for (lane, run) in group.iter().enumerate() {
                panel.runs[lane] = *run;
                circle.write_log(run, lane, &mut panel.log);
            }
            panels.push(panel);
        }
        // |s| grows along the circle, whose end is always among the points.
        let top = points.iter().flat_map(|p| &p.log_abs).copied().fold(f64::NEG_INFINITY, f64::max);
        Self { bins, top, points, panels }
    }
}

impl Circle {
    /// x of z = e^(−x), at a bin or between two.
    fn place(&self, bin: f64) -> Complex64 {
        Complex64::new(self.damping, TAU * bin / self.length as f64)
    }

    /// Radius about a bin, in bins, within which ln s is smooth: the distance to s = 0, or three quarters of
    /// that to the pole of `Tustin` at x = πi, since powers of s grow towards it; `GrunwaldLetnikov` and
    /// `Bdf2` are polynomials in e^(−x), which grow everywhere.
    fn distance(&self, bin: f64) -> f64 {
        let x = self.place(bin);
        let other = match self.scheme {
            Scheme::Tustin => 0.75 * (x - Complex64::new(0.0, PI)).norm(),
            Scheme::GrunwaldLetnikov | Scheme::Bdf2 => 0.5,
            Scheme::BandLimited => f64::INFINITY,
        };
        x.norm().min(other) * self.length as f64 / TAU
    }

    /// Length of the run that may begin at bin `first`.
    fn run(&self, first: usize, bins: usize) -> usize {
        // The last two bins, where s may be infinite, are left to points.
        let most = BLOCK.min((bins - first).saturating_sub(2));
        let within = |distance: f64| most.min((2.0 * REACH * distance) as usize) / LANES * LANES;
        let count = within(self.distance(first as f64));
        count.min(within(self.distance((first + count) as f64)))
    }

    fn degree(&self, first: usize, count: usize) -> usize {
        let half = 0.5 * count as f64;
        let ratio = half / self.distance(first as f64 + half);
        ((CUT.ln() / ratio.ln()).ceil() as usize).saturating_sub(1).clamp(3, SeriesPanel::TERMS - 1)
    }

    /// The series of ln s about the middle of the run, in bins.
    fn write_log(&self, run: &BinRange, lane: usize, log: &mut SeriesPanel) {
        let middle = self.place(run.first as f64 + 0.5 * (run.count - 1) as f64);
        let (log_abs, angle) = self.scheme.log_delta(self.damping, middle.im);
        (log.re[0][lane], log.im[0][lane]) = (log_abs + self.sample_rate_hz.ln(), angle);
        let step = Complex64::new(0.0, TAU / self.length as f64);
        let slopes = match self.scheme {
            Scheme::BandLimited => self.slopes_of_x(middle, step),
            Scheme::GrunwaldLetnikov => one_minus(1.0, middle, step),
            Scheme::Tustin => {
                let (zero, pole) = (one_minus(1.0, middle, step), one_minus(-1.0, middle, step));
                std::array::from_fn(|n| zero[n] - pole[n])
            }
            Scheme::Bdf2 => {
                let (zero, other) = (one_minus(1.0, middle, step), one_minus(1.0 / 3.0, middle, step));
                std::array::from_fn(|n| zero[n] + other[n])
            }
        };
        for (n, slope) in slopes.iter().enumerate().skip(1) {
            (log.re[n][lane], log.im[n][lane]) = (slope.re / n as f64, slope.im / n as f64);
        }
    }

    /// n times coefficient n of ln (x + step t): −(−step/x)ⁿ.
    fn slopes_of_x(&self, x: Complex64, step: Complex64) -> [Complex64; SeriesPanel::TERMS] {
        let mut power = Complex64::new(-1.0, 0.0);
        let ratio = -step / x;
        std::array::from_fn(|n| {
            if n > 0 {
                power *= ratio;
            }
            power
        })
    }
}

/// n times coefficient n of ln g, g = 1 − c e^(−x − step t): with gₙ those of g, n gₙ = Σ k lₖ gₙ₋ₖ, k from 1
/// to n.
fn one_minus(c: f64, x: Complex64, step: Complex64) -> [Complex64; SeriesPanel::TERMS] {
    let (radius, gap) = ((-x.re).exp(), -(-x.re).exp_m1());
    let (sin, cos) = x.im.sin_cos();
    // 1 − z and 1 + z without cancellation.
    let half = match c {
        1.0 => gap + 2.0 * radius * (0.5 * x.im).sin().powi(2),
        -1.0 => gap + 2.0 * radius * (0.5 * x.im).cos().powi(2),
        _ => 1.0 - c * radius * cos,
    };
    let g0 = Complex64::new(half, c * radius * sin);
    let mut g = [g0; SeriesPanel::TERMS];
    let mut term = Complex64::new(cos, -sin) * (-c * radius);
    for (n, g) in g.iter_mut().enumerate().skip(1) {
        term *= -step / n as f64;
        *g = term;
    }
    let mut slopes = [Complex64::ZERO; SeriesPanel::TERMS];
    for n in 1..SeriesPanel::TERMS {
        let known: Complex64 = (1..n).map(|k| slopes[k] * g[n - k]).sum();
        slopes[n] = (g[n] * n as f64 - known) / g0;
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron_numeric::InstructionSet;

    /// Every bin is there once, and powers by series are those of the points.
    #[test]
    fn powers_by_series_are_those_of_the_points() {
        let set = InstructionSet::detected();
        for scheme in Scheme::ALL {
            for (length, damping) in [(256, 0.09), (20_000, 1.15e-3), (15_001, 0.0), (400_000, 5.8e-5)] {
                let found = Frequencies::new(scheme, length, damping, 1e4);
                let (log_abs, angle) = frequencies(scheme, length, damping, 1e4, 0, length / 2 + 1);
                let mut seen = vec![0; found.bins];
                for p in &found.points {
                    let bins = p.first..p.first + p.log_abs.len();
                    assert_eq!(p.log_abs, log_abs[bins.clone()]);
                    assert_eq!(p.angle, angle[bins.clone()]);
                    seen[bins].iter_mut().for_each(|n| *n += 1);
                }
                let mut power = SeriesPanel::ZERO;
                for (order, panel) in [0.02, 0.5, 1.0523, 2.6, 5.2]
                    .into_iter()
                    .flat_map(|order| found.panels.iter().map(move |panel| (order, panel)))
                {
                    SeriesPanel::power(set, order, &panel.log, &mut power);
                    for (lane, run) in panel.runs.iter().enumerate().filter(|(_, run)| run.count > 0) {
                        let (mut re, mut im) = (vec![0.0; run.count], vec![0.0; run.count]);
                        power.evaluate(set, lane, run.degree, &mut re, &mut im);
                        for (j, (re, im)) in re.into_iter().zip(im).enumerate() {
                            let bin = run.first + j;
                            let want =
                                Complex64::from_polar((order * log_abs[bin]).exp(), order * angle[bin]);
                            let error = (Complex64::new(re, im) - want).norm() / want.norm();
                            // Both round the exponent, order · ln s, and the angle, which Tustin magnifies
                            // near π.
                            let exponent = log_abs[bin].hypot(angle[bin]);
                            let theta = TAU * bin as f64 / length as f64;
                            let angle = if scheme == Scheme::Tustin { theta / (PI - theta) } else { 0.0 };
                            let rounding = 3e-15 + 2.0 * f64::EPSILON * order * (exponent + angle);
                            assert!(error < rounding, "{scheme} {length} {order} at {bin}: {error:e}");
                        }
                        if order == 0.02 {
                            seen[run.first..run.first + run.count].iter_mut().for_each(|n| *n += 1);
                        }
                    }
                }
                assert!(seen.iter().all(|&n| n == 1), "{scheme} {length}");
                assert_eq!(found.top, log_abs.iter().copied().fold(f64::NEG_INFINITY, f64::max));
                assert!(length < 1000 || !found.panels.is_empty());
            }
        }
    }
}
