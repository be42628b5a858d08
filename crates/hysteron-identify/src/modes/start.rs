//! Initial model of the searches.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Options;
use super::records::{Campaign, RecordPeriod};
use crate::IdentifyError;
use hysteron_model::axes::{
    CommonPoles, FeedbackStrain, FrequencyMatrix, InfluenceMatrix, LevelLaw, ScheduledModes, StrainLaw,
    Trajectory, VectorFit, frequency, linear_states, spectrum, spread_poles,
};
use hysteron_numeric::{Complex64, LeastSquares, least_squares};
use hysteron_optimize::Stop;

/// Share of a column orthogonal to the others below which it is dependent.
const DEPENDENT: f64 = 1e-14;

/// Poles start between these shares of the highest excited frequency, with this damping.
const SPREAD: (f64, f64) = (0.1, 1.05);
const START_DAMPING: f64 = 0.01;
const RELOCATIONS: usize = 30;
/// Damping ratios that a mode may have; the narrowest half bandwidth is two lines.
const LARGEST_DAMPING: f64 = 0.15;
const NARROWEST_LINES: f64 = 2.0;
/// Numbers of pole pairs tried where none is given.
const TRIED: [usize; 11] = [2, 3, 4, 6, 8, 10, 12, 15, 18, 22, 26];
/// Every further pair must lower the error of the response by this share.
const WORTH: f64 = 0.01;
/// First guess of the relative fall of every resonance from level 0 to the highest.
const SOFTENING: f64 = 0.011;
/// Share of the stress in the input of an actuator's hysteresis, as identified on the public steering mirror
/// (0.07 ± 0.02).
pub(super) const STRESS_SHARE: f64 = 0.07;
/// Radii of the plays over the rms of their input.
const RADII: (f64, f64) = (0.08, 2.2);

/// The linear initial model and quantities derived with it.
pub(super) struct Start {
    pub model: ScheduledModes,
    pub influence: InfluenceMatrix,
    /// Corner of the lags \[Hz\].
    pub lag_hz: f64,
    /// Lead of the extension over the measured outputs \[s\].
    pub advance_s: f64,
    /// Lowest and highest excited frequency \[Hz\].
    pub excited_hz: (f64, f64),
    /// Pairs of poles started from.
    pub pairs: usize,
}

/// Linear modes from the frequency response of the highest level.
pub(super) fn linear_start(
    campaign: &Campaign,
    options: &Options,
    exponent: f64,
    stop: &Stop,
) -> Result<Start, IdentifyError> {
    let top = campaign.top();
    let periods: Vec<_> = top.iter().map(|piece| &piece.period).collect();
    let response = FrequencyMatrix::local_polynomial(&periods)?;
    let top_hz = response.frequency_hz.last().copied().unwrap_or(0.0);
    let low_hz = response.frequency_hz.first().copied().unwrap_or(0.0);
    let rate = campaign.rate * options.steps as f64;
    let lag_hz = options.lag_hz.unwrap_or(0.8 * top_hz);
    let lag = (-std::f64::consts::TAU * lag_hz / rate).exp();
    let fit = VectorFit::new(&response, rate, vec![lag]);
    let line_hz = response.frequency_hz.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    let is_mode = |p: &Complex64| {
        let mode = frequency(*p, rate);
        mode.damping < LARGEST_DAMPING
            && mode.damping * mode.frequency_hz > NARROWEST_LINES * line_hz
            && mode.frequency_hz < 1.2 * top_hz
    };
    let (pairs, poles) = choose_poles(&fit, &response, (options.modes, rate, top_hz), is_mode, stop)?;
    if poles.pairs.is_empty() {
        return Err(IdentifyError::NoModes { top_hz });
    }
    let influence = InfluenceMatrix::of_response(&response);
    if influence.inverse().is_none() {
        return Err(IdentifyError::Singular { condition: influence.condition_number() });
    }
    let residues = fit.residues(&poles)?;
    let mut model = rank_one(campaign, (options, exponent), &poles, &residues, lag);
    refit_outputs(&mut model, &top);
    schedule_poles(&mut model);
    let advance_s = advance(&response, &influence, &model, lag_hz);
    Ok(Start { model, influence, lag_hz, advance_s, excited_hz: (low_hz, top_hz), pairs })
}

/// Number of pole pairs and common poles: of the number given, or of the smallest that fits the response
/// about as well as more.
fn choose_poles(
    fit: &VectorFit,
    response: &FrequencyMatrix,
    (given, rate, top_hz): (Option<usize>, f64, f64),
    is_mode: impl Fn(&Complex64) -> bool + Sync,
    stop: &Stop,
) -> Result<(usize, CommonPoles), IdentifyError> {
    let poles = |count: usize| -> Result<CommonPoles, IdentifyError> {
        let start = spread_poles(count, (SPREAD.0 * top_hz, SPREAD.1 * top_hz), START_DAMPING, rate);
        let mut found = fit.poles(start, RELOCATIONS, || !stop.is_requested())?;
        if stop.is_requested() {
            return Err(IdentifyError::Stopped);
        }
        found.pairs.retain(&is_mode);
        found.real.clear();
        Ok(found)
    };
    if let Some(count) = given {
        return Ok((count, poles(count)?));
    }
    // Requires twice as many equations as unknowns.
    let tried = TRIED.into_iter().filter(|count| 4 * (2 * count + 2) <= 2 * response.len());
    let tried: Vec<usize> = tried.collect();
    // Each number apart from the others; the largest, which take longest, first.
    let with_error = |&count: &usize| {
        let found = poles(count).ok()?;
        let error = fit.error(&found).ok()?;
        Some((error, count, found))
    };
    let fitted: Vec<_> = tried.par_iter().rev().with_max_len(1).map(with_error).collect();
    if stop.is_requested() {
        return Err(IdentifyError::Stopped);
    }
    let mut best: Option<(f64, usize, CommonPoles)> = None;
    for (error, count, found) in fitted.into_iter().rev().flatten() {
        let worth = |least: f64, fewer: usize| error < (1.0 - WORTH).powi((count - fewer) as i32) * least;
        if best.as_ref().is_none_or(|(least, fewer, _)| worth(*least, *fewer)) {
            best = Some((error, count, found));
        }
    }
    let (_, count, poles) = best.ok_or(IdentifyError::NoModes { top_hz })?;
    Ok((count, poles))
}

/// Residues c_k b_kᵀ of rank one, lags of all inputs, and the response's constant.
fn rank_one(
    campaign: &Campaign,
    (options, exponent): (&Options, f64),
    poles: &CommonPoles,
    residues: &[Vec<Complex64>],
    lag: f64,
) -> ScheduledModes {
    let (n, m, modes) = (campaign.inputs, campaign.outputs, poles.pairs.len());
    let states = 2 * modes + n;
    let mut model = ScheduledModes {
        inputs: n,
        outputs: m,
        modes,
        sample_rate_hz: campaign.rate,
        steps: options.steps,
        level: level_law(campaign, options, exponent),
        transition: poles.pairs.iter().flat_map(|p| [p.re, p.im]).chain((0..n).map(|_| lag)).collect(),
        transition_slopes: vec![0.0; states],
        input: vec![0.0; states * n],
        strain_input: vec![0.0; states * n],
        output: vec![0.0; m * states],
        output_slopes: vec![0.0; m * states],
        feedthrough: vec![0.0; m * n],
        feedthrough_slopes: vec![0.0; m * n],
        strain_feedthrough: vec![0.0; m * n],
        feedback: None,
    };
    let residue = |k: usize| DMatrix::from_fn(m, n, |o, i| residues[o * n + i][k]);
    for k in 0..modes {
        let svd = residue(k).svd(true, true);
        let (Some(left), Some(right)) = (&svd.u, &svd.v_t) else { continue };
        let first = svd.singular_values.imax();
        let size = svd.singular_values[first].sqrt();
        let squares: Complex64 = (0..n).map(|i| right[(first, i)] * right[(first, i)]).sum();
        // Phase rotation that makes the sum of the squares of b real and positive.
        let turn = Complex64::from_polar(1.0, -0.5 * squares.arg());
        for i in 0..n {
            let b = right[(first, i)] * turn * size;
            model.input[2 * k * n + i] = b.re;
            model.input[(2 * k + 1) * n + i] = b.im;
        }
        for o in 0..m {
            let c = left[(o, first)] / turn * size;
            model.output[o * states + 2 * k] = 2.0 * c.re;
            model.output[o * states + 2 * k + 1] = -2.0 * c.im;
        }
    }
    for i in 0..n {
        let state = 2 * modes + i;
        model.input[state * n + i] = 1.0 - lag;
        for o in 0..m {
            let of = &residues[o * n + i];
            model.output[o * states + state] = of[modes].re / (1.0 - lag);
            model.feedthrough[o * n + i] = of[modes + 1].re;
        }
    }
    model
}

fn level_law(campaign: &Campaign, options: &Options, exponent: f64) -> LevelLaw {
    let levels = || campaign.pieces.iter().map(|p| p.period.level);
    LevelLaw {
        reference: campaign.levels.last().copied().unwrap_or(1.0),
        exponent,
        lowest: levels().fold(f64::INFINITY, f64::min),
        highest: levels().fold(0.0, f64::max),
        time_constant_s: options.time_constant_s,
    }
}

/// Refits C and D by least squares on the spectra of the outputs with the states held, correcting the
/// rank-one truncation.
fn refit_outputs(model: &mut ScheduledModes, pieces: &[&RecordPeriod]) {
    let (n, m, states) = (model.inputs, model.outputs, model.states());
    let (mut rows, mut targets): (Vec<Vec<Complex64>>, Vec<Vec<Complex64>>) = (Vec::new(), Vec::new());
    for piece in pieces {
        let samples = piece.period.samples();
        let (u, y) = (spectrum(&piece.period.u, n), spectrum(&piece.period.y, m));
        let power = |k: usize| u[k * n..(k + 1) * n].iter().map(|u| u.norm_sqr()).sum::<f64>();
        let most = (1..samples.div_ceil(2)).map(power).fold(0.0, f64::max);
        for line in (1..samples.div_ceil(2)).filter(|&k| power(k) > 1e-5 * most) {
            let turn = std::f64::consts::TAU * line as f64 / (samples * model.steps) as f64;
            let z = Complex64::from_polar(1.0, turn);
            let u = &u[line * n..(line + 1) * n];
            let force = |k: usize| (0..n).map(|i| u[i] * model.input[k * n + i]).sum();
            let mut row = linear_states(&model.transition, model.modes, z, force);
            row.extend_from_slice(u);
            rows.push(row);
            targets.push(y[line * m..(line + 1) * m].to_vec());
        }
    }
    let count = rows.len();
    let part = |z: &Complex64, real: bool| if real { z.re } else { z.im };
    let stack = |from: &[Vec<Complex64>], columns: usize| {
        DMatrix::from_fn(2 * count, columns, |k, c| part(&from[k % count][c], k < count))
    };
    let Ok(LeastSquares { solution, .. }) =
        least_squares(stack(&rows, states + n), stack(&targets, m), DEPENDENT)
    else {
        return;
    };
    for o in 0..m {
        for k in 0..states {
            model.output[o * states + k] = solution[(k, o)];
        }
        for i in 0..n {
            model.feedthrough[o * n + i] = solution[(states + i, o)];
        }
    }
}

/// Every resonance frequency decreases slightly from level 0 to the highest: dp = p ln p · (−0.011).
fn schedule_poles(model: &mut ScheduledModes) {
    for k in 0..model.modes {
        let p = Complex64::new(model.transition[2 * k], model.transition[2 * k + 1]);
        let slope = p * p.ln() * -SOFTENING;
        (model.transition_slopes[2 * k], model.transition_slopes[2 * k + 1]) = (slope.re, slope.im);
    }
}

/// Delay \[s\] of the response below half the lowest mode, from the slope of the phase of tr(G₀⁻¹ G), less
/// that of the lag; 0 to four samples.
fn advance(
    response: &FrequencyMatrix,
    influence: &InfluenceMatrix,
    model: &ScheduledModes,
    lag_hz: f64,
) -> f64 {
    let Some(inverse) = influence.inverse() else { return 0.0 };
    let (n, m) = (model.inputs, model.outputs);
    let lowest = model.modes_at(0.0).iter().map(|mode| mode.frequency_hz).fold(f64::INFINITY, f64::min);
    let slow: Vec<(f64, f64)> = (0..response.len())
        .filter(|&k| response.frequency_hz[k] < 0.5 * lowest)
        .map(|k| {
            let g = response.at(k);
            let trace: Complex64 = (0..n)
                .flat_map(|i| (0..m).map(move |o| (i, o)))
                .map(|(i, o)| g[o * n + i] * inverse[i * m + o])
                .sum();
            (std::f64::consts::TAU * response.frequency_hz[k], trace.arg())
        })
        .collect();
    let count = slow.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| slow.iter().map(of).sum::<f64>() / count.max(1.0);
    let (omega, phase) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = slow.iter().map(|p| (p.0 - omega).powi(2)).sum();
    if spread <= 0.0 {
        return 0.0;
    }
    let slope = slow.iter().map(|p| (p.0 - omega) * (p.1 - phase)).sum::<f64>() / spread;
    let beside = -slope - 1.0 / (std::f64::consts::TAU * lag_hz);
    beside.clamp(0.0, 4.0 / model.sample_rate_hz)
}

/// Adds hysteresis in feedback, initially without effect: rows of free stroke and stress, columns of strain,
/// laws with coefficients 0.
///
/// A strain acts at the drive's input, after the lag: h_k = b_k (1 + i f_k/f_lag). The extension e = G₀⁻¹ y
/// of each actuator follows from the outputs' rows, advanced by the sensors' delay; v = (1 − 0.07) a + 0.07
/// e, σ = e − u.
pub(super) fn add_feedback(
    start: &Start,
    model: &mut ScheduledModes,
    pieces: &[&RecordPeriod],
    plays: usize,
) {
    let Some(inverse) = start.influence.inverse() else { return };
    let (n, m, modes, states) = (model.inputs, model.outputs, model.modes, model.states());
    let rate = model.step_rate_hz();
    let row = states + n;
    let mut drive_rows = vec![0.0; n * row];
    let mut stress_rows = vec![0.0; n * row];
    for i in 0..n {
        let through = |of: &dyn Fn(usize) -> f64| (0..m).map(|o| inverse[i * m + o] * of(o)).sum::<f64>();
        let mut extension: Vec<f64> =
            (0..states).map(|k| through(&|o| model.output[o * states + k])).collect();
        extension.extend((0..n).map(|l| through(&|o| model.feedthrough[o * n + l])));
        for k in 0..modes {
            let pole = Complex64::new(model.transition[2 * k], model.transition[2 * k + 1]);
            let ahead = Complex64::from_polar(1.0, pole.arg() * rate * start.advance_s);
            let c = Complex64::new(extension[2 * k], -extension[2 * k + 1]) * ahead;
            (extension[2 * k], extension[2 * k + 1]) = (c.re, -c.im);
        }
        for (k, e) in extension.iter().enumerate() {
            drive_rows[i * row + k] = STRESS_SHARE * e;
            stress_rows[i * row + k] = *e;
        }
        drive_rows[i * row + 2 * modes + i] += 1.0 - STRESS_SHARE;
        stress_rows[i * row + states + i] -= 1.0;
    }
    for k in 0..modes {
        let angle = Complex64::new(model.transition[2 * k], model.transition[2 * k + 1]).arg();
        let behind = Complex64::new(1.0, angle * rate / (std::f64::consts::TAU * start.lag_hz));
        for i in 0..n {
            let b = Complex64::new(model.input[2 * k * n + i], model.input[(2 * k + 1) * n + i]) * behind;
            model.strain_input[2 * k * n + i] = b.re;
            model.strain_input[(2 * k + 1) * n + i] = b.im;
        }
    }
    for o in 0..m {
        for i in 0..n {
            model.strain_feedthrough[o * n + i] =
                model.feedthrough[o * n + i] + model.output[o * states + 2 * modes + i];
        }
    }
    let (drive, stress) = signals(model, pieces, &drive_rows, &stress_rows);
    // One law for all free strokes, from their concatenated series.
    let shared: Vec<f64> = drive.concat();
    let law = |z: &[f64]| strain_law(z, plays);
    model.feedback = Some(FeedbackStrain {
        drive: law(&shared),
        stress: stress.iter().map(|z| law(z)).collect(),
        drive_rows,
        stress_rows,
    });
}

/// v and σ of every actuator over the periods.
pub(super) fn signals(
    model: &ScheduledModes,
    pieces: &[&RecordPeriod],
    drive_rows: &[f64],
    stress_rows: &[f64],
) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (n, states) = (model.inputs, model.states());
    let row = states + n;
    let (mut drive, mut stress) = (vec![Vec::new(); n], vec![Vec::new(); n]);
    for piece in pieces {
        let s = model.state_of(&piece.period);
        let count = piece.fine.len() / n;
        let Some(trajectory) = Trajectory::new(model, s, &piece.fine, count, 0) else { continue };
        for signals in trajectory.signals.chunks_exact(trajectory.width) {
            let of = |rows: &[f64], i: usize| -> f64 {
                rows[i * row..(i + 1) * row].iter().zip(signals).map(|(c, x)| c * x).sum()
            };
            for i in 0..n {
                drive[i].push(of(drive_rows, i));
                stress[i].push(of(stress_rows, i));
            }
        }
    }
    (drive, stress)
}

/// A law without effect whose terms are nearly orthogonal to z: s² its variance, γ_j the mean slope of each
/// play.
fn strain_law(z: &[f64], plays: usize) -> StrainLaw {
    let variance = (z.iter().map(|z| z * z).sum::<f64>() / z.len().max(1) as f64).max(f64::MIN_POSITIVE);
    let gaps = plays.saturating_sub(1).max(1) as f64;
    let radius = |j: usize| variance.sqrt() * RADII.0 * (RADII.1 / RADII.0).powf(j as f64 / gaps);
    let radii: Vec<f64> = (0..plays).map(radius).collect();
    let slope = |radius: &f64| {
        let mut play = 0.0;
        let mut product = 0.0;
        // Twice: the first pass sets the memory.
        for pass in 0..2 {
            for &z in z {
                play = f64::max(z - radius, f64::min(z + radius, play));
                product += f64::from(pass) * play * z;
            }
        }
        product / (variance * z.len().max(1) as f64)
    };
    let slopes = radii.iter().map(slope).collect();
    let coefficients = vec![0.0; hysteron_model::axes::POWERS + plays];
    StrainLaw { coefficients, radii, slopes, variance, reach: f64::INFINITY }
}
