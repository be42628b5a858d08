//! Scheduled modes at a controller's rate, their inputs held from sample to sample.
//!
//! Where the rate divides that of the model's steps, each sample is a whole number of steps under one input:
//! exact. At any other rate, not below the model's sample rate, a sample is the fewest steps that are no longer
//! than the model's. Poles move by p → p^r, r = T/T_s ≤ 1 of the steps, and the rows of the outputs, of the free
//! strokes and of the stresses aim at the model's response times that of the hold, H(s) = (1 − e^(−sT))/(sT),
//! over the model's band:
//!
//! - on the modes, inputs scaled by r, by equal residues: c → c p^(r−1) H(s_k), complex, s_k = ln p/T_s. What
//!   the hysteresis drives then has its poles right, too;
//! - on the lags as they are, their inputs scaled to the same gain: the loop through the hysteresis keeps its own;
//! - on the inputs, a pair of fast poles per input, which keeps its last steps, and a pair beside each lag, both
//!   driven by the input alone, by least squares of what is left: smooth, since the poles are accounted for.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::{ScheduledModes, linear_states};
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

/// A model whose samples are those of a controller.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldModes {
    /// The model; its sample rate is the controller's.
    pub model: ScheduledModes,
    /// Modes of the model at its own rate; more pairs of poles match the inputs at another.
    pub own_modes: usize,
    /// Relative rms error of its linear response over the model's band; 0 where it is exact.
    pub error: f64,
}

impl ScheduledModes {
    /// The model at the rate of a controller \[Hz\].
    ///
    /// # Errors
    /// [`AxesError::Rate`] for a rate that does not divide that of the steps and is below the model's sample
    /// rate, or at which the linear response cannot be matched to 5 %.
    pub fn held_at(&self, rate_hz: f64) -> Result<HeldModes, AxesError> {
        let refused = |error| AxesError::Rate { rate_hz, model_hz: self.sample_rate_hz, error };
        if !(rate_hz.is_finite() && rate_hz > 0.0) {
            return Err(refused(f64::INFINITY));
        }
        let steps = self.step_rate_hz() / rate_hz;
        if steps.round() >= 1.0 && (steps - steps.round()).abs() < 1e-9 * steps && steps.round() <= 64.0 {
            let model =
                ScheduledModes { sample_rate_hz: rate_hz, steps: steps.round() as usize, ..self.clone() };
            return Ok(HeldModes { model, own_modes: self.modes, error: 0.0 });
        }
        if rate_hz < self.sample_rate_hz {
            return Err(refused(f64::INFINITY));
        }
        let substeps = (steps - 1e-9).ceil().max(1.0);
        match refitted(self, rate_hz * substeps) {
            Some(HeldModes { model, error, .. }) if error <= WORST => {
                let model = ScheduledModes { sample_rate_hz: rate_hz, steps: substeps as usize, ..model };
                Ok(HeldModes { model, own_modes: self.modes, error })
            }
            found => Err(refused(found.map_or(f64::INFINITY, |held| held.error))),
        }
    }
}

/// Coefficients at one S.
struct AtEnd {
    transition: Vec<f64>,
    /// Rows of the outputs, of the free strokes, of the stresses: on the states, then on the inputs.
    rows: Vec<Vec<f64>>,
    strain_feedthrough: Vec<f64>,
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
    held.strain_feedthrough = at_high.strain_feedthrough.clone();
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
    let mut targets: Vec<Vec<f64>> = (0..m)
        .map(|o| {
            let states = &at.output[o * own_states..(o + 1) * own_states];
            [states, &at.feedthrough[o * n..(o + 1) * n]].concat()
        })
        .collect();
    if let Some(feedback) = &model.feedback {
        let rows = feedback.drive_rows.chunks_exact(own_states + n);
        targets.extend(rows.chain(feedback.stress_rows.chunks_exact(own_states + n)).map(<[f64]>::to_vec));
    }
    // Signals at every frequency, input by input: the model's (x, u), and those of the basis.
    let response = |(z, poles, of, input, u): (Complex64, &[f64], &ScheduledModes, &[f64], usize)| {
        let mut signals = linear_states(poles, of.modes, z, |k| Complex64::new(input[k * n + u], 0.0));
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
            own.push(target(response((fine, &at.transition, model, &model.input, u))));
            basis.push(response((coarse, &transition, held, &held.input, u)));
        }
    }
    let of = |row: &[f64], x: &[Complex64]| -> Complex64 { row.iter().zip(x).map(|(c, x)| x * *c).sum() };
    // The pairs of fast poles, those beside the lags, the inputs.
    let free: Vec<usize> = (2 * model.modes..2 * held.modes).chain(states..states + n).collect();
    let moved = moved_residues(&at.transition[..2 * model.modes], ratio);
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
        if o < m {
            for (x, wanted) in basis.iter().zip(&wanted) {
                missed += (of(&row, x) - wanted).norm_sqr();
                all += wanted.norm_sqr();
            }
        }
        rows.push(row);
    }
    // The feedthrough of the strains takes up what the states do not explain at rest.
    let mut strain_feedthrough = vec![0.0; m * n];
    for o in 0..m {
        for u in 0..n {
            let one = Complex64::ONE;
            let own = response((one, &at.transition, model, &model.strain_input, u));
            let new = response((one, &transition, held, &held.strain_input, u));
            let left =
                of(&targets[o][..own_states], &own[..own_states]) - of(&rows[o][..states], &new[..states]);
            strain_feedthrough[o * n + u] = model.strain_feedthrough[o * n + u] + left.re;
        }
    }
    let error = (missed / f64::max(all, f64::MIN_POSITIVE)).sqrt();
    Some(AtEnd { transition, rows, strain_feedthrough, error })
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
