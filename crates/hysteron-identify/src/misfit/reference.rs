//! The fixed reference drive: nested loops, then random motion, over the trained range.
//!
//! Columns are scaled to unit rms on it, never on the training records: where those excite nothing a column of
//! unit rms would have no bound.

use std::f64::consts::TAU;

use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::misfit::{Basis, COLUMNS, GROUPS, MisfitError, POLYNOMIALS, TimedRun};
use hysteron_model::record::Timing;
use nalgebra::DVector;

use super::evidence::Prior;

/// Samples in a period of the reference frequency.
const RATE: f64 = 8.0;
/// Periods of the reference frequency in one loop, and in the random motion.
const LOOP: f64 = 200.0;
const RANDOM: f64 = 400.0;
/// Amplitudes of the loops in units of the range.
const AMPLITUDES: [f64; 3] = [1.0, 0.66, 0.33];
/// Sines of the random motion, from and to in units of the reference frequency.
const SINES: usize = 24;
const BAND: (f64, f64) = (0.005, 0.5);
/// Least half-opening of the loop in units of the stroke.
const LEAST_OPENING: f64 = 0.02;
/// Least scale of the prior of memory where the records hold loops of one amplitude: small coefficients fit
/// that loop, which is no evidence about the memory of others. Set on the devices that the band's factor was
/// set on.
const LEAST_SCALE: f64 = 0.17;

/// Prior standard deviations of the coefficients \[output unit over unit of the column\], in units of the
/// scale that the evidence sets: S/rms for polynomials, dynamics and creep, w/rms for plays, branches and
/// rate, with S the stroke on the reference drive, w the largest half-opening of its first loop, and the rms
/// of the column.
pub(super) fn prior(basis: &Basis, model: &Model, one_amplitude: bool) -> Result<Prior, MisfitError> {
    let rate_hz = RATE * basis.frequency_hz;
    let shape = drive();
    let range = basis.high_v - basis.low_v;
    let samples_v: Vec<f64> = shape.iter().map(|x| basis.low_v + range * x).collect();
    let start = Start::AsIdentified;
    let drive = TimedRun { samples_v: &samples_v, timing: Timing::Rate(rate_hz), start: &start };
    let columns = basis.columns(model, &drive, 1)?;
    let output = model.simulate(&samples_v, Some(rate_hz), &start)?;
    let (low, high) =
        output.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(*y), b.max(*y)));
    let stroke = high - low;
    let first = &output[..(RATE * LOOP) as usize];
    // The drive is even about the middle of its loop.
    let opening = first.iter().skip(1).zip(first.iter().rev()).map(|(up, down)| (up - down).abs());
    let opening = (0.5 * opening.fold(0.0, f64::max)).max(LEAST_OPENING * stroke);
    let is_memory = |column: usize| {
        let (polynomials, rate) = (GROUPS[0].1 - POLYNOMIALS, COLUMNS - GROUPS[3].1);
        column < polynomials || column >= rate
    };
    let deviation = |column: usize| {
        let values = &columns[column];
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        let size = if is_memory(column) { opening } else { stroke };
        if square > 0.0 { size / square.sqrt() } else { 0.0 }
    };
    let least = |column: usize| if one_amplitude && is_memory(column) { LEAST_SCALE } else { 0.0 };
    Ok(Prior {
        deviation: DVector::from_fn(COLUMNS, |column, _| deviation(column)),
        least_scale: DVector::from_fn(COLUMNS, |column, _| least(column)),
    })
}

/// Loops and random motion from 0 to 1.
fn drive() -> Vec<f64> {
    let in_loop = (RATE * LOOP) as usize;
    let loops = AMPLITUDES.iter().flat_map(|amplitude| {
        (0..in_loop).map(move |k| 0.5 * amplitude * (1.0 - (TAU * k as f64 / in_loop as f64).cos()))
    });
    let mut samples: Vec<f64> = loops.collect();
    // Phases by the golden ratio: incommensurate, the same everywhere.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let tone = |sine: usize, k: usize| {
        let frequency = BAND.0 * (BAND.1 / BAND.0).powf(sine as f64 / (SINES - 1) as f64) / RATE;
        (TAU * (frequency * k as f64 + golden * (sine * sine) as f64)).sin()
    };
    let random: Vec<f64> =
        (0..(RATE * RANDOM) as usize).map(|k| (0..SINES).map(|sine| tone(sine, k)).sum()).collect();
    let (low, high) =
        random.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    samples.extend(random.iter().map(|x| (x - low) / (high - low)));
    samples
}
