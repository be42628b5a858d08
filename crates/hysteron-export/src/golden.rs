//! Golden vectors: what the library puts out along a drive that goes everywhere.

use hysteron::hysteresis::{DriveGrid, Origin};
use hysteron::realise::{RuntimeParts, sweep};
use hysteron_rt::{Model, ModelError, Real};

use crate::error::ExportError;
use crate::number::Precision;
use crate::subject::Subject;

/// Voltages, exact in the number type of the export, and the library's displacements in double precision.
#[derive(Clone, Debug, PartialEq)]
pub struct Golden {
    /// Voltages; at rest at the first before.
    pub voltages: Vec<f64>,
    /// Displacements.
    pub displacements: Vec<f64>,
    /// Largest difference that the exported source may show.
    pub tolerance: f64,
    /// Whether a move to the largest number of the type is refused (not so where nothing but a bounded operator sees the voltage).
    pub refuses_largest: bool,
}

/// Samples of the sweep, of the jumps, of the crawl and of the rest.
const PIECES: [usize; 4] = [360, 160, 60, 60];
/// Double precision: share of the range.
const DOUBLE: f64 = 1e-12;
/// Single precision: units of rounding (2^-23) of everything that is added up.
const SINGLE: f64 = 16.0;

impl Golden {
    /// The vectors of a model.
    ///
    /// # Errors
    /// [`ExportError::Realise`] where the library has no result along the drive.
    pub fn new(subject: &Subject) -> Result<Self, ExportError> {
        let voltages: Vec<f64> =
            drive(subject.voltages()).iter().map(|&u| subject.precision.round(u)).collect();
        let displacements = of_library(subject, &voltages)?;
        let [low, high] =
            displacements.iter().fold([f64::MAX, f64::MIN], |[low, high], &y| [low.min(y), high.max(y)]);
        let tolerance = match subject.precision {
            Precision::F64 => DOUBLE * (high - low),
            Precision::F32 => SINGLE * subject.precision.epsilon() * added_up(subject, &voltages)?,
        };
        let refuses_largest = match subject.precision {
            Precision::F32 => refuses::<f32>(subject, f32::MAX)?,
            Precision::F64 => refuses::<f64>(subject, f64::MAX)?,
        };
        Ok(Self { voltages, displacements, tolerance, refuses_largest })
    }
}

fn refuses<T: Real>(subject: &Subject, voltage: T) -> Result<bool, ExportError> {
    let mut parts = RuntimeParts::<T>::new(&subject.realisation)?;
    Ok(parts.model()?.step(voltage) == Err(ModelError::Overflow))
}

/// Displacements of the library, in double precision, from rest at the first voltage.
fn of_library(subject: &Subject, voltages: &[f64]) -> Result<Vec<f64>, ExportError> {
    let mut parts = RuntimeParts::<f64>::new(&subject.realisation)?;
    let mut model = parts.model()?;
    let run = |model: &mut Model<'_, f64>| -> Result<Vec<f64>, ModelError<f64>> {
        model.rest_at(voltages.first().copied().unwrap_or(0.0))?;
        voltages.iter().map(|&u| model.step(u)).collect()
    };
    run(&mut model).map_err(|e| ExportError::Realise(e.into()))
}

/// Σ |weights| (max |l\[u\]| + max |memory|) + |offset|: what the rounding of a number type is in proportion to.
fn added_up(subject: &Subject, voltages: &[f64]) -> Result<f64, ExportError> {
    let model = &subject.realisation.model;
    let linear = &subject.realisation.dynamics;
    let mut v = vec![0.0; voltages.len()];
    let rest = voltages.first().copied().unwrap_or(0.0);
    let grid = DriveGrid { factor: 1, interval_s: Some(1.0 / subject.realisation.sample_rate_hz) };
    model
        .hysteresis
        .simulate_every(grid, voltages, Origin::Virgin { rest }, &mut v)
        .map_err(|e| ExportError::Realise(e.into()))?;
    let polynomial = model.hysteresis.polynomial();
    let (mut line, mut memory) = (0.0_f64, 0.0_f64);
    for (&u, &v) in voltages.iter().zip(&v) {
        let l = polynomial.iter().rev().fold(0.0, |sum, c| (sum + c) * u);
        let sizes = polynomial.iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * u.abs());
        line = line.max(sizes);
        memory = memory.max((v - l).abs());
    }
    Ok(linear.amplification() * linear.reference_gain * (line + memory) + model.offset.abs())
}

/// A sweep, jumps, a crawl and a rest, between two voltages.
fn drive((low, high): (f64, f64)) -> Vec<f64> {
    let [swept, jumps, crawl, rest] = PIECES;
    let mut u = sweep((low, high), (0.002, 0.08), 1.0, swept);
    // Numbers that look random (Knuth's 64-bit congruence), so that the vectors are the same everywhere.
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
