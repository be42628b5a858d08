//! Scheduled modes at a controller's rate, their inputs held from sample to sample.
//!
//! The model's own steps take inputs that are band-limited between them. Here a sample is the fewest steps that
//! are no longer than the model's, and the inputs are held over it. Poles move by p → p^r, r = T/T_s ≤ 1 of the
//! steps, and the rows of the outputs, of the free strokes and of the stresses aim at the model's response times
//! that of the hold, H(s) = (1 − e^(−sT))/(sT) with T a step, over the model's band:
//!
//! - on the modes, inputs scaled by r, by equal residues: c → c p^(r−1) H(s_k), complex, s_k = ln p/T_s. What
//!   the hysteresis drives then has its poles right, too;
//! - on the lags as they are, their inputs scaled to the same gain: the loop through the hysteresis keeps its own;
//! - on the inputs, a pair of fast poles per input, which keeps its last steps, and a pair beside each lag, both
//!   driven by the input alone, by least squares of what is left: smooth, since the poles are accounted for.
//!
//! What the strains do at rest is that of the model: their inputs are moved by the least relative change with
//! which free strokes and stresses are exact there, and their feedthrough takes up the rest of the outputs.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::{AtLevel, ScheduledModes, linear_states};
use crate::axes::AxesError;
use hysteron_numeric::Complex64;

/// Frequencies of the refit spread evenly over the band, and those about each mode, in half bandwidths.
const EVEN: usize = 240;
const AROUND: [f64; 6] = [-3.0, -1.0, -0.3, 0.3, 1.0, 3.0];
/// Share of the band, half the model's sample rate, that is fitted.
const BAND: f64 = 0.94;
/// Share of the largest response of a row below which its error counts absolutely.
const FLOOR: f64 = 0.03;
/// Poles ±i times this, a step of the model, of the pairs that keep the last inputs.
const FAST_POLE: f64 = 0.05;
/// Smallest magnitude, a step of the model, of the pair beside a lag, and its angle: with the lag's own pole no
/// regulator is found, as the input moves both alike.
const FASTEST_BESIDE: f64 = 0.1;
const BESIDE: f64 = 0.3;
/// Ridge of the refit, relative to the columns.
const RIDGE: f64 = 1e-5;
/// Largest relative rms error of the refitted outputs.
const WORST: f64 = 0.05;
/// Error with which the fewest steps are taken.
const GOOD: f64 = 1e-2;
/// Most steps of a sample.
const MOST_STEPS: f64 = 64.0;
/// Smallest size of an entry of the strain inputs, relative to the largest, in the measure of their change.
const SMALL: f64 = 1e-2;
/// Largest relative change of an entry with which they are moved at all.
const LARGEST_CHANGE: f64 = 0.1;

/// A model whose samples are those of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldModes {
    /// The model; its sample rate is the controller's.
    pub model: ScheduledModes,
    /// Modes of the model at its own rate; more pairs of poles match the inputs at another.
    pub own_modes: usize,
    /// Relative rms error of its linear response over the model's band.
    pub error: f64,
}

impl ScheduledModes {
    /// The model at the rate of a controller \[Hz\].
    ///
    /// # Errors
    /// [`AxesError::Rate`] for a rate below a 64th of that of the steps, or at which the linear response cannot
    /// be matched to 5 %.
    pub fn held_at(&self, rate_hz: f64) -> Result<HeldModes, AxesError> {
        let lowest_hz = self.step_rate_hz() / MOST_STEPS;
        let refused = |error| AxesError::Rate { rate_hz, lowest_hz, error };
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(refused(f64::INFINITY));
        }
        let steps = self.step_rate_hz() / rate_hz;
        let fewest = (steps - 1e-9 * steps).ceil().max(1.0);
        // Where poles of the model are as fast as its steps, halves of them are matched better.
        let mut best: Option<HeldModes> = None;
        for substeps in [fewest, 2.0 * fewest].into_iter().filter(|substeps| *substeps <= MOST_STEPS) {
            let Some(found) = refitted(self, rate_hz * substeps) else { continue };
            if best.as_ref().is_none_or(|best| found.error < best.error) {
                let steps = substeps as usize;
                let model = ScheduledModes { sample_rate_hz: rate_hz, steps, ..found.model };
                best = Some(HeldModes { model, ..found });
            }
            if best.as_ref().is_some_and(|best| best.error <= GOOD) {
                break;
            }
        }
        match best {
            Some(found) if found.error <= WORST => Ok(found),
            found => Err(refused(found.map_or(f64::INFINITY, |held| held.error))),
        }
    }
}

/// Coefficients at one S.
struct AtEnd {
    transition: Vec<f64>,
    /// Rows of the outputs, of the free strokes, of the stresses: on the states, then on the inputs.
    rows: Vec<Vec<f64>>,
    error: f64,
}

fn refitted(model: &ScheduledModes, rate_hz: f64) -> Option<HeldModes> {
    let ratio = model.step_rate_hz() / rate_hz;
    let (n, modes) = (model.inputs, model.modes);
    let kept = modes + 2 * n;
    let states = 2 * kept + n;
    let mut held = ScheduledModes {
        modes: kept,
        sample_rate_hz: rate_hz,
        steps: 1,
        input: vec![0.0; states * n],
        strain_input: vec![0.0; states * n],
        ..model.clone()
    };
    for k in 0..2 * modes * n {
        (held.input[k], held.strain_input[k]) = (model.input[k] * ratio, model.strain_input[k] * ratio);
    }
    for i in 0..n {
        held.input[(2 * modes + 2 * i) * n + i] = ratio;
        held.input[(2 * (modes + n) + 2 * i) * n + i] = ratio;
        let (own, lag) = ((2 * modes + i) * n, (2 * kept + i) * n);
        let alpha = model.transition[2 * modes + i];
        let scale = (1.0 - lag_at(alpha, ratio)) / (1.0 - alpha);
        for j in 0..n {
            held.input[lag + j] = model.input[own + j] * scale;
            held.strain_input[lag + j] = model.strain_input[own + j] * scale;
        }
    }
    let (high, low) = (model.level.state(model.level.highest), model.level.state(model.level.lowest));
    let at_high = at_end(model, &held, high, ratio)?;
    let at_low = at_end(model, &held, low, ratio)?;
    let line = |a: f64, b: f64| {
        let slope = if (low - high).abs() > 1e-12 { (b - a) / (low - high) } else { 0.0 };
        (a - high * slope, slope)
    };
    let lines =
        |a: &[f64], b: &[f64]| -> (Vec<f64>, Vec<f64>) { a.iter().zip(b).map(|(a, b)| line(*a, *b)).unzip() };
    (held.transition, held.transition_slopes) = lines(&at_high.transition, &at_low.transition);
    let m = model.outputs;
    let flat = |end: &AtEnd, from: usize, to: usize, of: std::ops::Range<usize>| -> Vec<f64> {
        end.rows[from..to].iter().flat_map(|row| row[of.clone()].to_vec()).collect()
    };
    let part =
        |of: std::ops::Range<usize>| lines(&flat(&at_high, 0, m, of.clone()), &flat(&at_low, 0, m, of));
    (held.output, held.output_slopes) = part(0..states);
    (held.feedthrough, held.feedthrough_slopes) = part(states..states + n);
    exact_at_rest(model, &mut held, high, &at_high);
    if let Some(feedback) = &mut held.feedback {
        feedback.drive_rows = flat(&at_high, m, m + n, 0..states + n);
        feedback.stress_rows = flat(&at_high, m + n, m + 2 * n, 0..states + n);
    }
    Some(HeldModes { model: held, own_modes: modes, error: at_high.error.max(at_low.error) })
}

/// The pole of a lag at another rate; one that is not positive has decayed.
fn lag_at(alpha: f64, ratio: f64) -> f64 {
    if alpha > 0.0 { alpha.powf(ratio) } else { 0.0 }
}

fn at_end(model: &ScheduledModes, held: &ScheduledModes, s: f64, ratio: f64) -> Option<AtEnd> {
    let at = model.at(s);
    let (n, m, own_states, states) = (model.inputs, model.outputs, model.states(), held.states());
    let mut transition = vec![0.0; states];
    for (k, p) in at.transition.chunks_exact(2).take(model.modes).enumerate() {
        let moved = Complex64::new(p[0], p[1]).powf(ratio);
        (transition[2 * k], transition[2 * k + 1]) = (moved.re, moved.im);
    }
    // Of the model's own speed: at a far higher rate the last samples are alike.
    let last = Complex64::new(0.0, FAST_POLE).powf(ratio);
    for i in 0..n {
        let fast = 2 * (model.modes + i);
        (transition[fast], transition[fast + 1]) = (last.re, last.im);
        let alpha = at.transition[2 * model.modes + i].max(FASTEST_BESIDE);
        let near = Complex64::from_polar(alpha, BESIDE).powf(ratio);
        (transition[fast + 2 * n], transition[fast + 2 * n + 1]) = (near.re, near.im);
        transition[2 * held.modes + i] = lag_at(at.transition[2 * model.modes + i], ratio);
    }
    let targets = targets(model, &at);
    // Signals at every frequency, input by input: the model's (x, u), and those of the basis.
    let response = |(z, poles, of, u): (Complex64, &[f64], &ScheduledModes, usize)| {
        let mut signals = linear_states(poles, of.modes, z, |k| Complex64::new(of.input[k * n + u], 0.0));
        signals.extend((0..n).map(|i| if i == u { Complex64::ONE } else { Complex64::ZERO }));
        signals
    };
    let (mut own, mut basis) = (Vec::new(), Vec::new());
    for f in frequencies(model, s) {
        let angle = TAU * f / held.sample_rate_hz;
        let hold = (1.0 - Complex64::from_polar(1.0, -angle)) / Complex64::new(0.0, angle);
        let fine = Complex64::from_polar(1.0, TAU * f / model.step_rate_hz());
        let coarse = Complex64::from_polar(1.0, angle);
        for u in 0..n {
            let target = |x: Vec<Complex64>| x.into_iter().map(|x| x * hold).collect::<Vec<_>>();
            own.push(target(response((fine, &at.transition, model, u))));
            basis.push(response((coarse, &transition, held, u)));
        }
    }
    let of = |row: &[f64], x: &[Complex64]| -> Complex64 { row.iter().zip(x).map(|(c, x)| x * *c).sum() };
    // The pairs of fast poles, those beside the lags, the inputs.
    let free: Vec<usize> = (2 * model.modes..2 * held.modes).chain(states..states + n).collect();
    let moved = moved_residues(&at.transition[..2 * model.modes], ratio);
    let at_rest: Vec<_> = (0..n)
        .map(|u| {
            let own = response((Complex64::ONE, &at.transition, model, u));
            (own, response((Complex64::ONE, &transition, held, u)))
        })
        .collect();
    let mut rows = Vec::with_capacity(targets.len());
    let (mut missed, mut all) = (0.0, 0.0);
    for (o, target) in targets.iter().enumerate() {
        let wanted: Vec<Complex64> = own.iter().map(|x| of(target, x)).collect();
        let of_modes = moved.iter().zip(target.chunks_exact(2)).flat_map(|(factor, c)| {
            // Re(c̄ q) for the row c on Re q, Im q.
            let c = Complex64::new(c[0], -c[1]) * factor;
            [c.re, -c.im]
        });
        let mut row: Vec<f64> = of_modes.collect();
        row.resize(states + n, 0.0);
        row[2 * held.modes..states].copy_from_slice(&target[2 * model.modes..own_states]);
        let left: Vec<Complex64> = basis.iter().zip(&wanted).map(|(x, y)| y - of(&row, x)).collect();
        for (place, c) in free.iter().zip(least_squares(&basis, &free, &left, &wanted)?) {
            row[*place] = c;
        }
        // Exact at rest.
        for (u, (own, found)) in at_rest.iter().enumerate() {
            row[states + u] += (of(target, own) - of(&row, found)).re;
        }
        if o < m {
            for (x, wanted) in basis.iter().zip(&wanted) {
                missed += (of(&row, x) - wanted).norm_sqr();
                all += wanted.norm_sqr();
            }
        }
        rows.push(row);
    }
    let error = (missed / f64::max(all, f64::MIN_POSITIVE)).sqrt();
    Some(AtEnd { transition, rows, error })
}

/// Rows of the outputs, of the free strokes, of the stresses: on the states, then on the inputs.
fn targets(model: &ScheduledModes, at: &AtLevel) -> Vec<Vec<f64>> {
    let (n, states) = (model.inputs, model.states());
    let outputs = at.output.chunks_exact(states).zip(at.feedthrough.chunks_exact(n));
    let mut rows: Vec<Vec<f64>> = outputs.map(|(of_x, of_u)| [of_x, of_u].concat()).collect();
    if let Some(feedback) = &model.feedback {
        let both = [&feedback.drive_rows, &feedback.stress_rows];
        rows.extend(both.iter().flat_map(|list| list.chunks_exact(states + n)).map(<[f64]>::to_vec));
    }
    rows
}

/// Moves the inputs of the strains, and sets their feedthrough, so that what held strains do at rest is that of
/// the model.
fn exact_at_rest(model: &ScheduledModes, held: &mut ScheduledModes, s: f64, found: &AtEnd) {
    let (n, m, states) = (model.inputs, model.outputs, held.states());
    if model.feedback.is_none() {
        return;
    }
    let at = model.at(s);
    let wanted = targets(model, &at);
    let rest = |poles: &[f64], modes: usize, b: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let x = linear_states(poles, modes, Complex64::ONE, |k| Complex64::new(b(k), 0.0));
        x.into_iter().map(|x| x.re).collect()
    };
    let dot = |row: &[f64], x: &[f64]| row.iter().zip(x).map(|(c, x)| c * x).sum::<f64>();
    // Signals at rest under a unit of every entry of the inputs of a strain.
    let units: Vec<Vec<f64>> = (0..states)
        .map(|entry| rest(&found.transition, held.modes, &|k| f64::from(u8::from(k == entry))))
        .collect();
    for strain in 0..n {
        let own = rest(&at.transition, model.modes, &|k| model.strain_input[k * n + strain]);
        let entry = |k: usize| held.strain_input[k * n + strain];
        let new = rest(&found.transition, held.modes, &entry);
        let size = (0..states).map(|k| entry(k).abs()).fold(0.0, f64::max);
        // Entries without effect on the model stay 0.
        let weights: Vec<f64> = (0..states)
            .map(|k| if entry(k) == 0.0 { 0.0 } else { entry(k).abs().max(SMALL * size) })
            .collect();
        let matrix = DMatrix::from_fn(2 * n, states, |i, k| dot(&found.rows[m + i], &units[k]) * weights[k]);
        let missed =
            DVector::from_fn(2 * n, |i, _| dot(&wanted[m + i], &own) - dot(&found.rows[m + i], &new));
        let largest = matrix.amax();
        let Ok(change) = matrix.svd(true, true).solve(&missed, 1e-9 * largest) else { continue };
        if change.amax() <= LARGEST_CHANGE {
            for k in 0..states {
                held.strain_input[k * n + strain] += weights[k] * change[k];
            }
        }
        let new = rest(&found.transition, held.modes, &|k| held.strain_input[k * n + strain]);
        for (o, (wanted, found)) in wanted.iter().zip(&found.rows).take(m).enumerate() {
            held.strain_feedthrough[o * n + strain] =
                model.strain_feedthrough[o * n + strain] + dot(wanted, &own) - dot(found, &new);
        }
    }
}

/// Factors of the complex rows on the modes that keep their residues, times the hold: b moves by r, and
/// 1/(z − p) is near the pole 1/(p T (s − s_k)).
fn moved_residues(poles: &[f64], ratio: f64) -> Vec<Complex64> {
    let factor = |p: &[f64]| {
        let log = Complex64::new(p[0], p[1]).ln();
        let hold =
            if log.norm() > 0.0 { (1.0 - (-log * ratio).exp()) / (log * ratio) } else { Complex64::ONE };
        (log * (ratio - 1.0)).exp() * hold
    };
    poles.chunks_exact(2).map(factor).collect()
}

fn frequencies(model: &ScheduledModes, s: f64) -> Vec<f64> {
    let top = BAND * 0.5 * model.sample_rate_hz;
    let mut all: Vec<f64> = (0..EVEN).map(|k| top * (k as f64 + 0.5) / EVEN as f64).collect();
    // The lowest ones again: references are slow.
    all.extend((1..=40).map(|k| top * 1e-3 * f64::from(k) * 0.5));
    for mode in model.modes_at(s) {
        all.extend(AROUND.iter().map(|width| mode.frequency_hz * (1.0 + width * mode.damping)));
    }
    all.retain(|f| *f > 0.0 && *f <= top);
    all
}

/// The real coefficients of the `free` columns of the basis that map it to what is `left` of what is `wanted`,
/// relative errors weighted alike down to the floor.
fn least_squares(
    basis: &[Vec<Complex64>],
    free: &[usize],
    left: &[Complex64],
    wanted: &[Complex64],
) -> Option<Vec<f64>> {
    let columns = free.len();
    let floor = FLOOR * wanted.iter().fold(f64::MIN_POSITIVE, |most, y| most.max(y.norm()));
    let rows = 2 * wanted.len();
    let mut matrix = DMatrix::<f64>::zeros(rows + columns, columns);
    let mut right = DVector::<f64>::zeros(rows + columns);
    for (k, ((x, left), wanted)) in basis.iter().zip(left).zip(wanted).enumerate() {
        let weight = 1.0 / wanted.norm().max(floor);
        for (j, x) in free.iter().map(|place| x[*place]).enumerate() {
            (matrix[(2 * k, j)], matrix[(2 * k + 1, j)]) = (weight * x.re, weight * x.im);
        }
        (right[2 * k], right[2 * k + 1]) = (weight * left.re, weight * left.im);
    }
    let sizes: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    for (j, size) in sizes.iter().enumerate() {
        matrix.column_mut(j).scale_mut(1.0 / size);
        matrix[(rows + j, j)] = RIDGE;
    }
    let qr = matrix.qr();
    qr.q_tr_mul(&mut right);
    let solution = qr.r().solve_upper_triangular(&right.rows(0, columns).into_owned())?;
    Some(solution.iter().zip(&sizes).map(|(x, size)| x / size).collect())
}
