//! Simulation, step by step.

use std::borrow::Cow;

use super::columns::Columns;
use super::{AtLevel, ScheduledModes, Streaming};
use crate::axes::steady::{level, repeats};
use crate::axes::{AxesError, SteadyPeriod};
use crate::hysteresis::RecordEnds;
use crate::record::InterSample;

/// Time constants of the slowest state after which the initial state has decayed, to 2e-9.
const FORGOTTEN: f64 = 20.0;
/// Most periods simulated for a steady state.
const MOST_PERIODS: usize = 60;
/// Change of the output per period, relative to its rms, at which it counts as settled.
const SETTLED: f64 = 1e-6;

/// State of a simulation.
#[derive(Clone, Debug)]
pub(super) struct Runner<'m> {
    pub model: Cow<'m, ScheduledModes>,
    pub at: AtLevel,
    pub x: Vec<f64>,
    next: Vec<f64>,
    columns: Columns,
    plays: Vec<f64>,
    /// v, then σ.
    pub z: Vec<f64>,
    pub w: Vec<f64>,
    /// Terms of the laws of v, then of σ.
    pub terms: Vec<f64>,
    /// Slopes of the laws of v, then of σ.
    pub slopes: Vec<f64>,
    pub moved: Vec<u32>,
}

impl<'m> Runner<'m> {
    /// At rest at 0 without memory.
    pub(super) fn new(model: &'m ScheduledModes, s: f64) -> Self {
        Self::of(Cow::Borrowed(model), s)
    }

    /// [`Self::new`] of a model, owned or not.
    pub(super) fn of(model: Cow<'m, ScheduledModes>, s: f64) -> Self {
        let (n, x) = (model.inputs, model.states());
        let plays = model.feedback.as_ref().map_or(0, |f| n * f.plays());
        let terms = model.feedback.as_ref().map_or(0, |f| n * 2 * f.drive.terms());
        Self {
            at: model.at(s),
            x: vec![0.0; x],
            next: vec![0.0; x],
            columns: Columns::new(&model),
            plays: vec![0.0; plays],
            z: vec![0.0; 2 * n],
            w: vec![0.0; n],
            terms: vec![0.0; terms],
            slopes: vec![0.0; 2 * n],
            moved: vec![0; 2 * n],
            model,
        }
    }

    pub(super) fn set_state(&mut self, s: f64) {
        self.model.set(s, &mut self.at);
    }

    /// Strains w under the inputs u; moves the plays.
    pub(super) fn strain(&mut self, u: &[f64]) {
        let Some(feedback) = &self.model.feedback else { return };
        let n = self.model.inputs;
        self.columns.channels(&self.x, u, &mut self.z);
        let (terms, plays) = (feedback.drive.terms(), feedback.drive.radii.len());
        self.w.iter_mut().for_each(|w| *w = 0.0);
        for i in 0..2 * n {
            let law = if i < n { Some(&feedback.drive) } else { feedback.stress.get(i - n) };
            let places = (
                self.plays.get_mut(i * plays..(i + 1) * plays),
                self.terms.get_mut(i * terms..(i + 1) * terms),
            );
            let (Some(law), (Some(plays), Some(terms))) = (law, places) else { continue };
            let (value, slope, moved) = law.step(self.z[i], plays, terms);
            self.w[i % n] += value;
            self.slopes[i] = slope;
            self.moved[i] = moved;
        }
    }

    /// Outputs under the inputs u, after [`Self::strain`].
    pub(super) fn output(&self, u: &[f64], y: &mut [f64]) {
        let (n, x) = (self.model.inputs, self.x.len());
        for (m, y) in y.iter_mut().enumerate() {
            *y = dot(&self.at.output[m * x..(m + 1) * x], &self.x)
                + dot(&self.at.feedthrough[m * n..(m + 1) * n], u)
                + dot(&self.model.strain_feedthrough[m * n..(m + 1) * n], &self.w);
        }
    }

    /// The next state under the inputs u, after [`Self::strain`].
    pub(super) fn advance(&mut self, u: &[f64]) {
        let modes = self.model.modes;
        self.columns.force(u, &self.w, &mut self.next);
        let (pairs, lags) = self.next.split_at_mut(2 * modes);
        let (poles, decays) = self.at.transition.split_at(2 * modes);
        let (x, lagged) = self.x.split_at(2 * modes);
        for ((to, x), p) in pairs.chunks_exact_mut(2).zip(x.chunks_exact(2)).zip(poles.chunks_exact(2)) {
            to[0] += p[0] * x[0] - p[1] * x[1];
            to[1] += p[0] * x[1] + p[1] * x[0];
        }
        for ((to, x), a) in lags.iter_mut().zip(lagged).zip(decays) {
            *to += a * x;
        }
        std::mem::swap(&mut self.x, &mut self.next);
    }

    pub(super) fn step(&mut self, u: &[f64]) {
        self.strain(u);
        self.advance(u);
    }

    /// At 0 without memory.
    pub(super) fn reset(&mut self) {
        for list in [&mut self.x, &mut self.plays, &mut self.w] {
            list.fill(0.0);
        }
    }

    /// Steps after which every state has settled.
    pub(super) fn settling(&self, s: f64) -> usize {
        self.model.settling_steps(s, FORGOTTEN)
    }

    /// Holds the inputs until every state has settled.
    pub(super) fn settle(&mut self, u: &[f64], s: f64) {
        for _ in 0..self.settling(s) {
            self.step(u);
        }
    }

    /// Runs the last `steps` steps before the period begins.
    pub(super) fn preroll(&mut self, fine: &[f64], steps: usize) {
        let n = self.model.inputs;
        let count = fine.len() / n;
        for step in 0..steps {
            let k = (step + count - steps % count) % count;
            self.step(&fine[k * n..(k + 1) * n]);
        }
    }

    /// Outputs at every sample of one period; `None` on overflow.
    fn period(&mut self, fine: &[f64]) -> Option<Vec<f64>> {
        if !self.is_finite() {
            return None;
        }
        let (n, m, steps) = (self.model.inputs, self.model.outputs, self.model.steps);
        let mut y = vec![0.0; fine.len() / n / steps * m];
        for (k, u) in fine.chunks_exact(n).enumerate() {
            self.strain(u);
            if k % steps == 0 {
                let at = k / steps * m;
                self.output(u, &mut y[at..at + m]);
            }
            self.advance(u);
        }
        y.iter().all(|y| y.is_finite()).then_some(y)
    }

    pub(super) fn is_finite(&self) -> bool {
        self.x.iter().all(|x| x.is_finite())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Inputs at every step, interleaved, from interleaved samples.
pub(super) fn upsampled(
    u: &[f64],
    inputs: usize,
    steps: usize,
    rule: InterSample,
    ends: RecordEnds,
) -> Result<Vec<f64>, AxesError> {
    let mut fine: Vec<Vec<f64>> = Vec::with_capacity(inputs);
    for i in 0..inputs {
        let channel: Vec<f64> = u.iter().skip(i).step_by(inputs).copied().collect();
        fine.push(rule.upsample(&channel, steps, ends)?);
    }
    let length = fine.first().map_or(0, Vec::len);
    Ok((0..length).flat_map(|k| fine.iter().map(move |channel| channel[k])).collect())
}

/// Outputs over one period of inputs `fine` at every step (interleaved, a whole number of samples) after
/// `preroll` steps from rest: outputs at every sample, interleaved. `None` on overflow.
pub fn simulate_steady(model: &ScheduledModes, s: f64, fine: &[f64], preroll: usize) -> Option<Vec<f64>> {
    let mut runner = Runner::new(model, s);
    runner.preroll(fine, preroll);
    runner.period(fine)
}

impl ScheduledModes {
    /// S under a steady period.
    pub fn state_of(&self, period: &SteadyPeriod) -> f64 {
        self.level.state(period.level)
    }

    /// Outputs in the steady state under one period of inputs (interleaved), band-limited between samples; S
    /// is that of the period's rms. Outputs interleaved, one row per sample.
    ///
    /// # Errors
    /// [`AxesError::RunsAway`], [`AxesError::NotSettled`].
    pub fn simulate_period(&self, u: &[f64]) -> Result<Vec<f64>, AxesError> {
        Ok(self.settled(u)?.1)
    }

    /// [`Self::simulate_period`], and the state at the beginning of the period.
    fn settled(&self, u: &[f64]) -> Result<(Runner<'_>, Vec<f64>), AxesError> {
        let fine = upsampled(u, self.inputs, self.steps, InterSample::BandLimited, RecordEnds::Periodic)?;
        let s = self.level.state(level(u, self.inputs));
        let count = fine.len() / self.inputs;
        let settle = self.settling_steps(s, FORGOTTEN).div_ceil(count.max(1)).clamp(1, MOST_PERIODS);
        let mut runner = Runner::new(self, s);
        runner.preroll(&fine, settle * count);
        let mut last = runner.period(&fine).ok_or(AxesError::RunsAway)?;
        if self.feedback.is_none() {
            return Ok((runner, last));
        }
        // The hysteresis may settle more slowly than the modes.
        let mut change = f64::INFINITY;
        for _ in 0..MOST_PERIODS {
            let y = runner.period(&fine).ok_or(AxesError::RunsAway)?;
            let size = y.iter().map(|y| y * y).sum::<f64>().sqrt();
            change = y.iter().zip(&last).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / size;
            // Without motion there is nothing to settle.
            if change <= SETTLED || size == 0.0 {
                return Ok((runner, y));
            }
            last = y;
        }
        Err(AxesError::NotSettled { periods: settle + MOST_PERIODS, change })
    }

    /// Outputs for the samples of each input, one list per output: from the steady state under the first
    /// `settled` samples where given; else from the steady state under the inputs of the first sample.
    ///
    /// While the drive repeats these samples to its noise, so do the outputs, and S is that of one period;
    /// otherwise S follows the running rms of the drive ([`super::LevelTracker`]), from that of the period,
    /// or from rest of the first second, on.
    ///
    /// # Errors
    /// [`AxesError::Channels`], [`AxesError::SampleRate`], [`AxesError::Period`], [`AxesError::RunsAway`],
    /// [`AxesError::NotSettled`].
    pub fn simulate(
        &self,
        u: &[Vec<f64>],
        sample_rate_hz: f64,
        rule: InterSample,
        settled: Option<usize>,
    ) -> Result<Vec<Vec<f64>>, AxesError> {
        let rows = self.rows(u, sample_rate_hz)?;
        let y = match settled {
            Some(period_samples) => self.simulate_settled(u, &rows, rule, period_samples)?,
            None => {
                let second = (self.sample_rate_hz as usize).max(1).saturating_mul(self.inputs);
                let before = level(&rows[..second.min(rows.len())], self.inputs);
                self.simulate_from_rest(&rows, rule, before)?
            }
        };
        Ok(self.lists(&y))
    }

    /// [`Self::simulate`] from rest, with this initial drive level \[V\].
    ///
    /// # Errors
    /// Those of [`Self::simulate`].
    pub fn simulate_after(
        &self,
        u: &[Vec<f64>],
        sample_rate_hz: f64,
        rule: InterSample,
        level: f64,
    ) -> Result<Vec<Vec<f64>>, AxesError> {
        let rows = self.rows(u, sample_rate_hz)?;
        Ok(self.lists(&self.simulate_from_rest(&rows, rule, level)?))
    }

    /// One row of inputs per sample.
    fn rows(&self, u: &[Vec<f64>], sample_rate_hz: f64) -> Result<Vec<f64>, AxesError> {
        if u.len() != self.inputs {
            return Err(AxesError::Channels { role: "input", model: self.inputs, record: u.len() });
        }
        if ((sample_rate_hz / self.sample_rate_hz).ln()).abs() > 1e-6 || sample_rate_hz.is_nan() {
            return Err(AxesError::SampleRate { model_hz: self.sample_rate_hz, record_hz: sample_rate_hz });
        }
        let samples = u.first().map_or(0, Vec::len);
        Ok((0..samples).flat_map(|k| u.iter().map(move |u| u[k])).collect())
    }

    /// One list per output.
    fn lists(&self, rows: &[f64]) -> Vec<Vec<f64>> {
        let outputs = self.outputs;
        (0..outputs).map(|m| rows.iter().skip(m).step_by(outputs).copied().collect()).collect()
    }

    /// The steady state under the first period: repeated over the record where the drive repeats, else
    /// followed by the response to the rest of the record. `u`: the `channels` of the inputs, interleaved.
    fn simulate_settled(
        &self,
        channels: &[Vec<f64>],
        u: &[f64],
        rule: InterSample,
        period_samples: usize,
    ) -> Result<Vec<f64>, AxesError> {
        let n = self.inputs;
        let samples = u.len() / n;
        if period_samples < 2 || period_samples > samples {
            return Err(AxesError::Period { samples, period_samples });
        }
        let first = &u[..period_samples * n];
        let (runner, y) = self.settled(first)?;
        if channels.iter().all(|channel| repeats(channel, period_samples)) {
            return Ok(y.iter().cycle().take(samples * self.outputs).copied().collect());
        }
        // The period before keeps the interpolation from beginning at the first sample.
        let fine = upsampled(&[first, u].concat(), n, self.steps, rule, RecordEnds::Open)?;
        let record = &fine[period_samples * self.steps * n..];
        self.follow(Streaming::from(runner, &u[..n], level(first, n)), record, samples)
    }

    fn simulate_from_rest(&self, u: &[f64], rule: InterSample, before: f64) -> Result<Vec<f64>, AxesError> {
        let n = self.inputs;
        let first = u.get(..n).unwrap_or(&[]);
        let fine = upsampled(u, n, self.steps, rule, RecordEnds::Open)?;
        self.follow(Streaming::new(self, first, before), &fine, u.len() / n)
    }

    /// Outputs under inputs given at every step from the first sample to the last.
    fn follow(&self, mut stream: Streaming<'_>, fine: &[f64], samples: usize) -> Result<Vec<f64>, AxesError> {
        let n = self.inputs;
        let mut y = vec![0.0; samples * self.outputs];
        for (k, row) in y.chunks_exact_mut(self.outputs).enumerate() {
            let from = if k == 0 { 0 } else { (k - 1) * self.steps + 1 };
            stream.follow(&fine[from * n..(k * self.steps + 1) * n], row);
        }
        if y.iter().all(|y| y.is_finite()) { Ok(y) } else { Err(AxesError::RunsAway) }
    }
}
