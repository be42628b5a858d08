//! Bands of the mean of plays over a record, in plain numbers.

use hysteron_numeric::{InstructionSet, Pass, run_pass};
use hysteron_rt::{Dual, Scalar, each_band};

use super::super::HysteresisError;
use super::super::family::GRID_ENDS;
use super::super::outputs::{self, Columns};

/// Samples whose means stay in the first-level cache.
const STRETCH: usize = 256;

/// The mean of the plays over a stretch, and its derivatives with respect to the shape numbers and the
/// memory.
struct Means {
    mean: [f64; STRETCH],
    by_shape: [[f64; STRETCH]; 2],
    by_memory: [f64; STRETCH],
}

/// Adds the part of one play, lagging behind the voltage, to the means.
struct AddPlay<'a> {
    means: &'a mut Means,
    play: &'a [f64],
    u: &'a [f64],
    standing: f64,
    share: Dual<f64, 2>,
}

impl Pass for AddPlay<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { means, play, u, standing, share } = self;
        let Means { mean, by_shape: [by_first, by_second], .. } = means;
        let by = mean.iter_mut().zip(by_first.iter_mut().zip(by_second));
        for ((mean, (by_first, by_second)), (play, u)) in by.zip(play.iter().zip(u)) {
            let lag = play + standing - u;
            *mean += share.value * lag;
            *by_first += share.partials[0] * lag;
            *by_second += share.partials[1] * lag;
        }
    }
}

/// Writes the bands of the mean behind the columns of the plays, and their derivatives, from the shares of the
/// plays in the mean with those with respect to the shape numbers.
pub(super) fn bands_of_mean(
    (shares, corners): (&[Dual<f64, 2>], &[f64]),
    (u, factor): (&[f64], usize),
    rest: Option<f64>,
    out: &mut Columns,
) -> Result<(), HysteresisError> {
    let (set, plays) = (InstructionSet::detected(), shares.len());
    let Columns { values, partials, by_memory, rest: at_rest, rest_by_memory, .. } = out;
    let Columns { standing, standing_by_memory, stop, .. } = out;
    let (of_plays, of_bands) = values.split_at_mut(plays);
    let (memory_of_plays, memory_of_bands) = by_memory.split_at_mut(plays);
    memory_of_bands.iter_mut().for_each(Vec::clear);
    let of_standing: f64 = shares.iter().zip(&*standing_by_memory).map(|(share, by)| share.value * by).sum();
    // The memory acts until the drive has moved every play.
    let remembering = match memory_of_plays.iter().map(Vec::len).max() {
        _ if of_standing != 0.0 => of_plays.first().map_or(0, Vec::len),
        longest => longest.unwrap_or(0),
    };
    let mut means = Means { mean: [0.0; STRETCH], by_shape: [[0.0; STRETCH]; 2], by_memory: [0.0; STRETCH] };
    let mut kept = [0.0; STRETCH];
    for (stretch, moves) in u.chunks(STRETCH * factor).enumerate() {
        outputs::look(stop.as_ref())?;
        let first = stretch * STRETCH;
        let count = moves.len().div_ceil(factor);
        kept.iter_mut().zip(moves.iter().step_by(factor)).for_each(|(kept, u)| *kept = *u);
        let u = &kept[..count];
        means.mean[..count].copy_from_slice(u);
        means.by_shape.iter_mut().for_each(|by| by.fill(0.0));
        for (index, (play, &share)) in of_plays.iter().zip(shares).enumerate() {
            let play = &play[first..first + count];
            run_pass(set, AddPlay { means: &mut means, play, u, standing: standing[index], share });
        }
        let of_memory = remembering.saturating_sub(first).min(count);
        means.by_memory.fill(of_standing);
        for (by, share) in memory_of_plays.iter().zip(shares).filter(|_| of_memory > 0) {
            let by = by.get(first..).unwrap_or_default();
            means.by_memory.iter_mut().zip(by).for_each(|(mean, by)| *mean += share.value * by);
        }
        for (band, out) in of_bands.iter_mut().enumerate() {
            let (low, high, zero) = band_of(corners, band);
            let mean = &means.mean[..count];
            out[first..].iter_mut().zip(mean).for_each(|(out, h)| *out = h.max(low).min(high) - zero);
            let inside = |h: &f64| if low < *h && *h < high { 1.0 } else { 0.0 };
            for partial in partials.iter_mut().filter(|partial| partial.column == plays + band) {
                let by = &means.by_shape[partial.shape - GRID_ENDS];
                let out = partial.values[first..].iter_mut();
                out.zip(mean.iter().zip(by)).for_each(|(out, (h, by))| *out = inside(h) * by);
            }
            let by = mean.iter().zip(&means.by_memory).take(of_memory);
            memory_of_bands[band].extend(by.map(|(h, by)| inside(h) * by));
        }
    }
    let Some(rest) = rest else { return Ok(()) };
    let mut mean = Dual::<f64, 3>::constant(rest);
    for (index, share) in shares.iter().enumerate() {
        let lag = at_rest[index] + standing[index] - rest;
        let [by_first, by_second] = share.partials.map(|by| by * lag);
        let by_memory = share.value * (rest_by_memory[index] + standing_by_memory[index]);
        let part = Dual { value: share.value * lag, partials: [by_first, by_second, by_memory] };
        mean = mean + part;
    }
    let mut band = plays;
    each_band(corners, mean, |of| {
        (at_rest[band], rest_by_memory[band]) = (of.value, of.partials[2]);
        for partial in partials.iter_mut().filter(|partial| partial.column == band) {
            partial.rest = of.partials[partial.shape - GRID_ENDS];
        }
        band += 1;
    });
    Ok(())
}

/// Ends of a band, and where it is 0.
fn band_of(corners: &[f64], band: usize) -> (f64, f64, f64) {
    let below = band.checked_sub(1).and_then(|below| corners.get(below)).copied();
    let above = corners.get(band).copied();
    let (low, high) = (below.unwrap_or(f64::NEG_INFINITY), above.unwrap_or(f64::INFINITY));
    (low, high, below.unwrap_or(high))
}
