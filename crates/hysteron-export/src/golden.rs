//! Golden vectors: outputs of the library along a drive that covers the range.

use hysteron_model::Start;
use hysteron_model::hysteresis::DriveGrid;
use hysteron_model::realise::{LinearRealisation, RuntimeParts, sweep};
use hysteron_rt::{Model, ModelError, Real};

use crate::error::ExportError;
use crate::number::Precision;
use crate::subject::{Subject, significant};

/// Voltages, exact in the number type of the export, and the library's displacements in double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Golden {
    /// Voltages, from rest at the first.
    pub voltages: Vec<f64>,
    /// Samples that each voltage after the sweep is held; those of the sweep last one each.
    pub hold: usize,
    /// Displacements at the end of each voltage.
    pub displacements: Vec<f64>,
    /// Largest difference that the exported source may show.
    pub tolerance: f64,
    /// Lowest to highest displacement.
    pub span: f64,
    /// Whether a move to the largest number of the type is refused (not so where the voltage enters a bounded
    /// operator alone).
    pub refuses_largest: bool,
}

/// Bound of the self-test on the rounding error of a result in the number type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounding {
    /// Bound in the unit of the result.
    pub bound: f64,
    /// Bound as a share of its range.
    pub share: f64,
}

impl Rounding {
    /// Share above which the source carries a note.
    pub const NOTED: f64 = 1e-3;
    /// Share above which the export is refused.
    pub const MOST: f64 = 1e-2;

    /// A bound on the result `what` of this range.
    ///
    /// # Errors
    /// [`ExportError::Rounding`] where it is too large a share.
    pub(crate) fn new(what: &'static str, unit: &str, bound: f64, range: f64) -> Result<Self, ExportError> {
        let share = bound / range;
        if share <= Self::MOST {
            return Ok(Self { bound, share });
        }
        Err(ExportError::Rounding { what, bound, unit: unit.to_owned(), percent: 100.0 * share })
    }

    /// In words, for the source.
    pub(crate) fn in_words(self, what: &str, unit: &str) -> String {
        let warning = if self.share > Self::NOTED { "NOTE: " } else { "" };
        format!(
            "{warning}Single precision may move the {what} by {} {unit}, {} of its range.",
            significant(self.bound),
            significant(self.share)
        )
    }
}

/// Samples of the sweep, of the jumps, of the crawl and of the rest.
const PIECES: [usize; 4] = [360, 160, 60, 60];
/// Voltages of the sweep last one sample each; later ones are held until long delays and slow states have
/// settled.
pub(crate) const HELD_FROM: usize = PIECES[0];
/// Length of a self-test, in multiples of delay and taps.
const DELAYS: usize = 4;
/// Longest self-test for slow states \[samples\]: it also runs on controllers.
const MOST_FOR_STATES: f64 = 20_000.0;
/// Share of the gain above which the weight of a state is significant here.
const MATTERS: f64 = 1e-3;
/// Share of the sum of magnitudes below which a displacement counts as constant.
const STILL: f64 = 1e-6;
/// Tolerance in double precision: share of the range.
const DOUBLE: f64 = 1e-12;
/// Tolerance in single precision: units of rounding (2^-23) of the sum of magnitudes.
const SINGLE: f64 = 16.0;

impl Golden {
    /// Samples that voltage `k` lasts.
    pub fn lasts(&self, k: usize) -> usize {
        samples_of(k, HELD_FROM, self.hold)
    }

    /// The vectors of a model.
    ///
    /// # Errors
    /// [`ExportError::Realise`] where the library has no result along the drive; [`ExportError::Still`] where
    /// the displacement is constant: a test would pass with any source.
    pub fn new(subject: &Subject) -> Result<Self, ExportError> {
        let voltages: Vec<f64> =
            drive(subject.voltages()).iter().map(|&u| subject.precision.round(u)).collect();
        let linear = &subject.realisation.dynamics;
        let lasts = patience(linear, linear.delay_samples, subject.realisation.sample_rate_hz);
        let hold = lasts.div_ceil(voltages.len() - HELD_FROM);
        let displacements = of_library(subject, &voltages, hold)?;
        let [low, high] =
            displacements.iter().fold([f64::MAX, f64::MIN], |[low, high], &y| [low.min(y), high.max(y)]);
        let (span, added_up) = (high - low, added_up(subject, &voltages)?);
        let moves = span > STILL * added_up;
        if !moves {
            return Err(ExportError::Still { what: "displacement" });
        }
        let offset = subject.realisation.model.offset.abs();
        let tolerance = match subject.precision {
            Precision::F64 => DOUBLE * span,
            Precision::F32 => SINGLE * subject.precision.epsilon() * (added_up + offset),
        };
        let refuses_largest = match subject.precision {
            Precision::F32 => refuses::<f32>(subject, f32::MAX)?,
            Precision::F64 => refuses::<f64>(subject, f64::MAX)?,
        };
        Ok(Self { voltages, hold, displacements, tolerance, span, refuses_largest })
    }
}

fn refuses<T: Real>(subject: &Subject, voltage: T) -> Result<bool, ExportError> {
    let mut parts = RuntimeParts::<T>::new(&subject.realisation)?;
    Ok(parts.model()?.step(voltage) == Err(ModelError::Overflow))
}

/// Displacements of the library, in double precision, from rest at the first voltage.
fn of_library(subject: &Subject, voltages: &[f64], hold: usize) -> Result<Vec<f64>, ExportError> {
    let mut parts = RuntimeParts::<f64>::new(&subject.realisation)?;
    let mut model = parts.model()?;
    let run = |model: &mut Model<'_, f64>| -> Result<Vec<f64>, ModelError<f64>> {
        model.rest_at(voltages.first().copied().unwrap_or(0.0))?;
        let held = |(k, &u): (usize, &f64)| {
            let mut y = model.step(u)?;
            for _ in 1..samples_of(k, HELD_FROM, hold) {
                y = model.step(u)?;
            }
            Ok(y)
        };
        voltages.iter().enumerate().map(held).collect()
    };
    run(&mut model).map_err(|e| ExportError::Realise(e.into()))
}

/// Samples that entry k lasts in a table with entries held from `held_from` on.
pub(crate) fn samples_of(k: usize, held_from: usize, hold: usize) -> usize {
    if k < held_from { 1 } else { hold }
}

/// Settling time \[samples\]: some delays, or a time constant of the slowest significant state, within a
/// limit.
pub(crate) fn patience(linear: &LinearRealisation, delay_samples: usize, sample_rate_hz: f64) -> usize {
    let matters = |weight: f64| weight >= MATTERS * linear.reference_gain;
    let slowest = linear
        .sections
        .iter()
        .filter(|s| matters(s.weight.norm()))
        .map(|s| sample_rate_hz / s.rate(sample_rate_hz))
        .fold(1.0, f64::max);
    (DELAYS * (delay_samples + linear.taps.len())).max(slowest.min(MOST_FOR_STATES) as usize)
}

/// Σ |weights| (max |l\[u\]| + max |memory|): with the offset, the scale of the rounding error of a number
/// type.
fn added_up(subject: &Subject, voltages: &[f64]) -> Result<f64, ExportError> {
    let model = &subject.realisation.model;
    let linear = &subject.realisation.dynamics;
    let mut v = vec![0.0; voltages.len()];
    let rest = voltages.first().copied().unwrap_or(0.0);
    let grid = DriveGrid::new(Some(subject.realisation.sample_rate_hz), 1, 1);
    model
        .hysteresis
        .simulate_every(grid, voltages, Start::Rest { voltage_v: rest }, &mut v)
        .map_err(|e| ExportError::Realise(e.into()))?;
    let polynomial = model.hysteresis.polynomial();
    let (mut line, mut memory) = (0.0_f64, 0.0_f64);
    for (&u, &v) in voltages.iter().zip(&v) {
        let l = polynomial.iter().rev().fold(0.0, |sum, c| (sum + c) * u);
        let sizes = polynomial.iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * u.abs());
        line = line.max(sizes);
        memory = memory.max((v - l).abs());
    }
    Ok(linear.amplification() * linear.reference_gain * (line + memory))
}

/// A sweep, jumps, a crawl and a rest, between two voltages.
fn drive((low, high): (f64, f64)) -> Vec<f64> {
    let [swept, jumps, crawl, rest] = PIECES;
    let mut u = sweep((low, high), (0.002, 0.08), 1.0, swept);
    // Pseudo-random numbers (Knuth's 64-bit congruence), so that the vectors are the same everywhere.
    let mut seed = 1_u64;
    for _ in 0..jumps {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let share = (seed >> 33) as f64 / (1_u64 << 31) as f64;
        u.push(low + share * (high - low));
    }
    let from = u.last().copied().unwrap_or(low);
    u.extend((1..=crawl).map(|k| from + (0.5 * (low + high) - from) * 1e-4 * k as f64 / crawl as f64));
    let at = u.last().copied().unwrap_or(low);
    u.extend(std::iter::repeat_n(at, rest));
    u
}
