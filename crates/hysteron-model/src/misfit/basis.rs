//! Columns of the misfit model: what a device may do beside its model.
//!
//! With x the drive scaled to [−1, 1] over the trained range, P_r the play of half-width r, z the part of the
//! model's hysteresis that is not a polynomial of the drive, H the model's own dynamics with delay, m the
//! model's output and f the reference frequency:
//!
//! | group | columns |
//! | --- | --- |
//! | memory | H of ∫ hat_i dP_r: 9 half-widths r, each with 3 or 5 hats over P_r |
//! | | H of z: plays may stand for the model's own memory altogether, whose minor loops may not close |
//! | | H of branches dξ = dx − a ξ \|dx\|, a = 2, 6, 20, whose minor loops do not close either |
//! | | H of Legendre's P₁(x) … P₅(x) |
//! | dynamics | (s/ω)ᵏ/(1 + s/ω)ᵏ m: k = 1, 2, 3 at ω = 8πf, k = 1, 2 at ω = πf/2 |
//! | creep | m/(1 + sT), T = 6/f, 60/f, 600/f, 6000/f |
//! | rate | (x − P_r)/(1 + sT): r = 0.06, 0.3, 0.6, T = 1/(0.03πf), 1/(0.3πf) |
//! | | H of plays that relax towards x between samples with T = 20/f, 200/f; the same r |
//!
//! All begin at 0, the device at rest at the first sample or in its cycle.

use hysteron_rt::play;
use rayon::prelude::*;

use super::MisfitError;
use super::response::{ModelResponse, lag};
use super::steps::Steps;
use crate::hammerstein::{Model, SETTLING_PERIODS, extend};
use crate::record::Timing;
use crate::start::Start;

/// Half-widths of the plays in units of the trained half-range, and the hats over each.
const PLAYS: [(f64, usize); 9] =
    [(0.02, 5), (0.06, 5), (0.12, 5), (0.2, 5), (0.3, 5), (0.42, 5), (0.56, 5), (0.72, 3), (0.88, 3)];
/// Rates a of the branches in units of the trained half-range.
const BRANCHES: [f64; 3] = [2.0, 6.0, 20.0];
/// Degrees of the polynomial in the drive.
const DEGREE: usize = 5;
/// Corner of the derivatives in units of the reference frequency, and their highest order.
const DERIVATIVES: [(f64, usize); 2] = [(4.0, 3), (0.25, 2)];
/// Time constants of creep in periods of the reference frequency.
const CREEP: [f64; 4] = [6.0, 60.0, 600.0, 6000.0];
/// Half-widths of the plays whose distance from the drive lags, and corners of the lags in units of the
/// reference frequency.
const RATE_PLAYS: [f64; 3] = [0.06, 0.3, 0.6];
const RATE_CORNERS: [f64; 2] = [0.015, 0.15];
/// Time constants of the same plays that relax, in periods of the reference frequency.
const RELAXATIONS: [f64; 2] = [20.0, 200.0];

/// Columns of the basis, by group in this order.
pub const GROUPS: [(ColumnGroup, usize); 4] =
    [(ColumnGroup::Memory, 50), (ColumnGroup::Dynamics, 5), (ColumnGroup::Creep, 4), (ColumnGroup::Rate, 12)];
/// Columns of the basis.
pub const COLUMNS: usize = 71;
/// Index of the column of the model's own memory.
pub(super) const OWN_MEMORY: usize = 41;
/// Columns of [`ColumnGroup::Memory`] that are polynomials of the drive; they come last of it.
pub const POLYNOMIALS: usize = DEGREE;

/// Kind of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnGroup {
    /// Static: plays, branches and polynomials of the drive.
    Memory,
    /// Derivatives of the model's output.
    Dynamics,
    /// Lags of the model's output.
    Creep,
    /// Lags and relaxation of the hysteresis.
    Rate,
}

/// The columns for a drive range and a reference frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Lowest drive trained \[V\].
    pub low_v: f64,
    /// Highest drive trained \[V\].
    pub high_v: f64,
    /// Reference frequency f \[Hz\]: the fastest motion trained, within limits that the sample rate sets.
    pub frequency_hz: f64,
}

/// Drive over time, with what was before it.
#[derive(Clone, Copy, Debug)]
pub struct TimedRun<'a> {
    /// Samples \[V\].
    pub samples_v: &'a [f64],
    /// When they were taken: a rate or stamps.
    pub timing: Timing<'a>,
    /// Start of the device.
    pub start: &'a Start,
}

impl Basis {
    /// The columns for a drive, each the mean over `factor` samples; a rest of the record shorter than that is
    /// left out. [`COLUMNS`] columns of `drive.samples_v.len() / factor` rows.
    ///
    /// # Errors
    /// [`MisfitError`]: dynamics that belong to one sample rate, a drive that the model cannot be simulated
    /// on.
    pub fn columns(
        &self,
        model: &Model,
        drive: &TimedRun<'_>,
        factor: usize,
    ) -> Result<Vec<Vec<f64>>, MisfitError> {
        let TimedRun { samples_v, timing, start } = *drive;
        let factor = factor.max(1);
        let steps = Steps::new(timing, samples_v.len())?;
        let row_steps = steps.of_blocks(factor);
        let (extended, prologue, rest_v) = extend(start, samples_v)?;
        let half = (0.5 * (self.high_v - self.low_v)).max(f64::MIN_POSITIVE);
        let centre = 0.5 * (self.high_v + self.low_v);
        let scaled: Vec<f64> = extended.iter().map(|u| (u - centre) / half).collect();
        let drive = ScaledDrive { x: &scaled, prologue, rest: (rest_v - centre) / half };
        let rows = samples_v.len() / factor;
        let periodic = prologue == SETTLING_PERIODS * samples_v.len() && rows * factor == samples_v.len();
        let response = ModelResponse::new(model, rows, &row_steps, periodic)?;
        let hats = PLAYS.par_iter().flat_map(|&(r, hats)| {
            let path = drive.play(r);
            let column = |hat: usize| means(&path, factor, |p| hat_integral(hat, hats, p));
            (0..hats).map(column).collect::<Vec<_>>()
        });
        let mut memory: Vec<Vec<f64>> = hats.collect();
        let hysteresis = model.simulate_hysteresis(samples_v, timing, start)?;
        let polynomial =
            |u: &f64| model.hysteresis.polynomial().iter().rev().fold(0.0, |sum, c| (sum + c) * u);
        let own: Vec<f64> = hysteresis.iter().zip(samples_v).map(|(v, u)| v - polynomial(u)).collect();
        debug_assert_eq!(memory.len(), OWN_MEMORY);
        memory.push(means(&own, factor, |v| v));
        memory.extend(BRANCHES.iter().map(|a| means(&drive.branch(*a), factor, |z| z)));
        let own_x = &scaled[prologue..];
        memory.extend((1..=DEGREE).map(|degree| means(own_x, factor, |x| legendre(degree, x))));
        let respond = |v: Vec<Vec<f64>>| -> Result<Vec<Vec<f64>>, MisfitError> {
            v.into_par_iter().map(|v| response.of(v)).collect()
        };
        let mut columns = respond(memory)?;

        let settled = prologue > 0;
        let simulated = model.simulate(samples_v, timing, start)?;
        let first = simulated.first().copied().unwrap_or(0.0);
        let output = means(&simulated, factor, |y| y - first);
        let lagged = |x: &[f64], time_s: f64| lag(x, |k| row_steps.s(k) / time_s, settled);
        let per_s = std::f64::consts::TAU * self.frequency_hz;
        for (corner, orders) in DERIVATIVES {
            let mut derivative = output.clone();
            for _ in 0..orders {
                let low = lagged(&derivative, 1.0 / (corner * per_s));
                derivative.iter_mut().zip(low).for_each(|(x, low)| *x -= low);
                columns.push(derivative.clone());
            }
        }
        columns.extend(CREEP.iter().map(|periods| lagged(&output, periods / self.frequency_hz)));
        for r in RATE_PLAYS {
            let distance: Vec<f64> = own_x.iter().zip(drive.play(r)).map(|(x, p)| x - p).collect();
            let distance = means(&distance, factor, |x| x);
            columns.extend(RATE_CORNERS.iter().map(|corner| lagged(&distance, 1.0 / (corner * per_s))));
        }
        let relaxing = RATE_PLAYS.iter().flat_map(|r| {
            let path = |periods: &f64| {
                let per_s = self.frequency_hz / periods;
                // A cycle before the record is as long as the record.
                let count = samples_v.len();
                // Of equal steps it is computed once.
                let (mut of_step, mut decay) = (f64::NAN, 1.0);
                let decay = |k: usize| {
                    let step_s = steps.s((k + count - prologue % count) % count);
                    if step_s != of_step {
                        (of_step, decay) = (step_s, (-per_s * step_s).exp());
                    }
                    decay
                };
                means(&drive.relaxing_play(*r, decay), factor, |p| p)
            };
            RELAXATIONS.iter().map(path).collect::<Vec<_>>()
        });
        columns.extend(respond(relaxing.collect())?);
        Ok(columns)
    }
}

/// A drive in units of the trained half-range, with what was before it.
struct ScaledDrive<'a> {
    /// x, the prologue first.
    x: &'a [f64],
    /// Samples of the prologue.
    prologue: usize,
    /// x before the prologue.
    rest: f64,
}

impl ScaledDrive<'_> {
    /// An operator's path over the drive, without the prologue.
    fn path(&self, step: impl FnMut((usize, &f64)) -> f64) -> Vec<f64> {
        let mut path: Vec<f64> = self.x.iter().enumerate().map(step).collect();
        path.drain(..self.prologue);
        path
    }

    fn play(&self, r: f64) -> Vec<f64> {
        let mut state = self.rest;
        self.path(|(_, &x)| {
            state = play(r, state, x);
            state
        })
    }

    /// Play of half-width `r` whose distance from x decays by the factor `decay(k)` after the move to sample k.
    fn relaxing_play(&self, r: f64, mut decay: impl FnMut(usize) -> f64) -> Vec<f64> {
        let mut state = self.rest;
        self.path(|(k, &x)| {
            state = x + (play(r, state, x) - x) * decay(k);
            state
        })
    }

    /// dξ = dx − a ξ |dx| from 0, exactly.
    fn branch(&self, a: f64) -> Vec<f64> {
        let (mut z, mut before) = (0.0, self.rest);
        self.path(|(_, &x)| {
            let dx = x - before;
            let end = dx.signum() / a;
            z = end + (z - end) * (-a * dx.abs()).exp();
            before = x;
            z
        })
    }
}

/// Means of `of` over blocks of `factor` samples.
fn means(samples: &[f64], factor: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
    let mean = |block: &[f64]| block.iter().map(|x| of(*x)).sum::<f64>() / block.len() as f64;
    samples.chunks_exact(factor).map(mean).collect()
}

/// ∫ hat from −1 to `p`, of hat `index` of `count` ≥ 2 linear hats at equal distances on [−1, 1]. The outer
/// ones are constant beyond it, so that the sum over all is p + 1 everywhere.
fn hat_integral(index: usize, count: usize, p: f64) -> f64 {
    let spacing = 2.0 / (count - 1) as f64;
    let x = (p + 1.0) / spacing;
    let last = (count - 1) as f64;
    let rising =
        if index > 0 { 0.5 * (x - (index as f64 - 1.0)).clamp(0.0, 1.0).powi(2) } else { x.min(0.0) };
    let falling = if index + 1 < count {
        let t = (x - index as f64).clamp(0.0, 1.0);
        t - 0.5 * t * t
    } else {
        (x - last).max(0.0)
    };
    spacing * (rising + falling)
}

/// Legendre's polynomial by its recursion (n + 1) P_{n+1} = (2n + 1) x P_n − n P_{n−1}.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut before, mut value) = (1.0, x);
    for n in 1..degree {
        let next = ((2 * n + 1) as f64 * x * value - n as f64 * before) / (n + 1) as f64;
        (before, value) = (value, next);
    }
    value
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::dynamics::{Dynamics, Scheme, Term, TransferFunction};
    use crate::hysteresis::Hysteresis;
    use crate::record::InterSample;

    fn model(dynamics: Dynamics) -> Model {
        Model {
            hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
            dynamics,
            offset: 0.3,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        }
    }

    const BASIS: Basis = Basis { low_v: 0.0, high_v: 10.0, frequency_hz: 20.0 };

    #[test]
    fn hats_integrate_to_the_play_and_legendre_polynomials_are_those_of_tables() {
        for count in [3, 5] {
            for p in [-1.3, -1.0, -0.4, 0.0, 0.3, 0.99, 1.0, 1.7] {
                let sum: f64 = (0..count).map(|hat| hat_integral(hat, count, p)).sum();
                assert!((sum - (p + 1.0)).abs() < 1e-14, "{count} {p} {sum}");
                // The derivative is the hat: by differences.
                let slope =
                    |hat| (hat_integral(hat, count, p + 1e-6) - hat_integral(hat, count, p - 1e-6)) / 2e-6;
                let x = (p + 1.0) * (count - 1) as f64 / 2.0;
                let x = x.clamp(0.0, (count - 1) as f64);
                for hat in 0..count {
                    let expected = (1.0 - (x - hat as f64).abs()).max(0.0);
                    assert!((slope(hat) - expected).abs() < 1e-5, "{count} {p} {hat}");
                }
            }
        }
        for (degree, at_half) in [(1, 0.5), (2, -0.125), (3, -0.4375), (4, -0.289_062_5), (5, 0.089_843_75)] {
            assert!((legendre(degree, 0.5) - at_half).abs() < 1e-15);
        }
    }

    #[test]
    fn branches_and_relaxing_plays_are_those_of_hand_calculation() {
        let drive = ScaledDrive { x: &[-1.0, 0.0, 1.0, 0.5, 0.5], prologue: 1, rest: -1.0 };
        // dξ/dx = 1 − 2ξ up: ξ = (1 − e^(−2x))/2; down from ξ₀: dξ/dx = 1 + 2ξ.
        let rising = 0.5 * (1.0 - (-4.0_f64).exp());
        let falling = -0.5 + (rising + 0.5) * (-1.0_f64).exp();
        let expected = [0.5 * (1.0 - (-2.0_f64).exp()), rising, falling, falling];
        for (z, expected) in drive.branch(2.0).iter().zip(expected) {
            assert!((z - expected).abs() < 1e-15, "{z} {expected}");
        }
        assert_eq!(drive.play(0.4), [-0.4, 0.6, 0.6, 0.6]);
        // Each distance from x is halved after the move: −0.4 → −0.2, 0.6 → 0.8, 0.8 → 0.65, 0.65 → 0.575.
        for (p, expected) in drive.relaxing_play(0.4, |_| 0.5).iter().zip([-0.2, 0.8, 0.65, 0.575]) {
            assert!((p - expected).abs() < 1e-15, "{p} {expected}");
        }
    }

    #[test]
    fn groups_count_the_columns_of_a_static_and_of_a_dynamic_model() {
        let first_order = TransferFunction {
            numerator: vec![Term { coefficient: 1.0, order: 0.0 }],
            denominator: vec![Term { coefficient: 1.0, order: 0.0 }, Term { coefficient: 0.01, order: 1.0 }],
        };
        let samples: Vec<f64> = (0..1000).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.02).cos()).collect();
        let start = Start::AsIdentified;
        let drive = TimedRun { samples_v: &samples, timing: Timing::Rate(500.0), start: &start };
        assert_eq!(GROUPS.iter().map(|(_, count)| count).sum::<usize>(), COLUMNS);
        for dynamics in [Dynamics::None, Dynamics::Integer(first_order)] {
            let columns = BASIS.columns(&model(dynamics), &drive, 3).unwrap();
            assert_eq!(columns.len(), COLUMNS);
            assert!(columns.iter().all(|c| c.len() == 333 && c[0].abs() < 0.2), "{:?}", columns[0][0]);
        }
    }

    #[test]
    fn means_of_a_static_model_are_those_of_every_sample() {
        let samples: Vec<f64> = (0..600).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.05).cos()).collect();
        let start = Start::AsIdentified;
        let drive = TimedRun { samples_v: &samples, timing: Timing::Rate(500.0), start: &start };
        let still = model(Dynamics::None);
        let (fine, coarse) =
            (BASIS.columns(&still, &drive, 1).unwrap(), BASIS.columns(&still, &drive, 4).unwrap());
        for (fine, coarse) in fine.iter().zip(&coarse).take(GROUPS[0].1) {
            let means: Vec<f64> = fine.chunks_exact(4).map(|b| b.iter().sum::<f64>() / 4.0).collect();
            let shift = coarse[0] - means[0];
            assert!(means.iter().zip(coarse).all(|(a, b)| (b - a - shift).abs() < 1e-12));
        }
    }

    #[test]
    fn what_depends_on_one_rate_or_has_none_is_refused() {
        let arx = crate::dynamics::Arx { a: vec![-0.5], b: vec![0.5] };
        let (samples, start) = ([0.0, 1.0, 2.0], Start::AsIdentified);
        let drive = TimedRun { samples_v: &samples, timing: Timing::Rate(500.0), start: &start };
        let found = BASIS.columns(&model(Dynamics::Arx(arx)), &drive, 1);
        assert!(matches!(found, Err(MisfitError::OneRate)), "{found:?}");
        let timeless = TimedRun { timing: Timing::Unknown, ..drive };
        let found = BASIS.columns(&model(Dynamics::None), &timeless, 1);
        assert!(matches!(found, Err(MisfitError::NoTimes)), "{found:?}");
    }
}
