//! Controllers of several axes compared on a stage: tracking and cross-coupling errors.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::linear::{LinearAxes, right_inverse};
use super::{
    AxesDrive, AxesStage, DecouplingError, DecouplingLaw, DecouplingOptions, LawOptions, decouple, limited,
};
use crate::axes::ScheduledModes;
use crate::compensator::Limits;
use crate::record::range_of;
use hysteron_numeric::Complex64;
use std::f64::consts::TAU;

/// Samples at rest on whose mean the sensors are zeroed.
const RESTED: usize = 1000;
/// Share of the references at the beginning that is not scored by default.
const SKIPPED: f64 = 0.25;
/// Largest singular value of the sensitivity of the integral feedback.
const SENSITIVITY: f64 = 2.0;
/// Frequencies at which it is computed.
const FREQUENCIES: usize = 400;
/// Largest gain of the integral per sample.
const LARGEST_GAIN: f64 = 0.5;

/// Controller of several axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AxesController {
    /// A straight line for every axis, by its own actuator.
    Uncompensated,
    /// Inverse of the gains at rest.
    StaticDecoupling,
    /// Inverse of the model sample by sample, with preview.
    Preview,
    /// Inverse of the model, the references known.
    Feedforward,
    /// That, and an integral of the error through the inverse of the gains at rest.
    FeedforwardIntegral,
}

impl AxesController {
    /// Every one.
    pub const ALL: [Self; 5] = [
        Self::Uncompensated,
        Self::StaticDecoupling,
        Self::Preview,
        Self::Feedforward,
        Self::FeedforwardIntegral,
    ];

    /// Name, as in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uncompensated => "uncompensated",
            Self::StaticDecoupling => "static-decoupling",
            Self::Preview => "preview",
            Self::Feedforward => "feedforward",
            Self::FeedforwardIntegral => "feedforward-integral",
        }
    }
}

/// Options of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesTrackOptions {
    /// Limits of every actuator.
    pub limits: Vec<Limits>,
    /// Bandwidth of the inverse \[Hz\]; `None`: its default.
    pub bandwidth_hz: Option<f64>,
    /// Preview of the sample-by-sample controller; `None`: as many samples as are useful.
    pub preview: Option<usize>,
    /// Seconds at the beginning that are not scored; `None`: a quarter of the references.
    pub skip_s: Option<f64>,
}

/// Comparison of controllers.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesTracking {
    /// The controllers' rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Scored samples.
    pub scored: Range<usize>,
    /// Stroke of every reference over the scored samples \[µm\].
    pub strokes: Vec<f64>,
    /// The law of the sample-by-sample controller.
    pub law: DecouplingLaw,
    /// Gain of the integral per sample, and the frequency at which its loop gain is 1 \[Hz\].
    pub integral: (f64, f64),
    /// Every controller.
    pub runs: Vec<AxesControllerRun>,
}

/// One controller's run.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesControllerRun {
    /// The controller.
    pub controller: AxesController,
    /// Drives \[V\].
    pub drive: Vec<Vec<f64>>,
    /// True displacements, zeroed at rest to the first references \[µm\].
    pub displacement: Vec<Vec<f64>>,
    /// rms error of every axis, its mean removed \[µm\].
    pub rms: Vec<f64>,
    /// Largest error of every axis, its mean removed \[µm\].
    pub max: Vec<f64>,
    /// Cross-coupling: the axes that are to stay while one moves, the worst pair.
    pub cross: Option<CrossCoupling>,
    /// Samples at a limit, all actuators together.
    pub held_back: usize,
}

/// Motion of an axis that is to stay while another moves along its reference alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossCoupling {
    /// Moving axis, from 0.
    pub moving: usize,
    /// Staying axis, from 0.
    pub staying: usize,
    /// rms, mean removed, in per cent of the moving axis' stroke.
    pub rms_percent: f64,
    /// Largest of all pairs, in per cent of the moving axis' stroke.
    pub max_percent: f64,
}

/// Plays `references` \[µm\], one list per axis, on the stage with every controller; then each axis'
/// reference alone, for the cross-coupling.
///
/// # Errors
/// [`DecouplingError`].
pub fn track_axes(
    model: &ScheduledModes,
    references: &[Vec<f64>],
    sample_rate_hz: f64,
    options: &AxesTrackOptions,
    stage: &dyn AxesStage,
) -> Result<AxesTracking, DecouplingError> {
    super::check(references, &options.limits, (model.inputs, model.outputs))?;
    let samples = references.first().map_or(0, Vec::len);
    let skip = options.skip_s.map_or(SKIPPED * samples as f64, |s| s * sample_rate_hz);
    if !(skip >= 0.0 && skip + 2.0 <= samples as f64) {
        let allowed = "at least 0 and shorter than the references";
        return Err(DecouplingError::Option {
            name: "skipped time [s]",
            value: skip / sample_rate_hz,
            allowed,
        });
    }
    let bench = Bench::new(model, sample_rate_hz, options, stage)?;
    let scored = skip as usize..samples;
    let stroke = |r: &Vec<f64>| {
        let (low, high) = range_of(&r[scored.clone()]);
        high - low
    };
    let strokes: Vec<f64> = references.iter().map(stroke).collect();
    let alone: Vec<Option<Vec<Vec<f64>>>> = (0..references.len())
        .map(|axis| {
            let hold = |(m, r): (usize, &Vec<f64>)| if m == axis { r.clone() } else { vec![r[0]; samples] };
            (strokes[axis] > 0.0).then(|| references.iter().enumerate().map(hold).collect())
        })
        .collect();
    let mut runs = Vec::new();
    for controller in AxesController::ALL {
        if controller == AxesController::Uncompensated && model.inputs != model.outputs {
            continue;
        }
        let played = bench.play(controller, references)?;
        let errors = |m: usize| deviations(&played.displacement[m], &references[m], &scored);
        let of_axes: Vec<(f64, f64)> = (0..references.len()).map(errors).collect();
        let mut cross: Option<CrossCoupling> = None;
        for (moving, references) in alone.iter().enumerate() {
            let Some(references) = references else { continue };
            let played = bench.play(controller, references)?;
            for staying in (0..references.len()).filter(|m| *m != moving) {
                let (rms, max) = deviations(&played.displacement[staying], &references[staying], &scored);
                let percent = |x: f64| 100.0 * x / strokes[moving];
                let (rms_percent, max_percent) = (percent(rms), percent(max));
                cross = Some(match cross {
                    Some(worst) if worst.rms_percent >= rms_percent => {
                        CrossCoupling { max_percent: worst.max_percent.max(max_percent), ..worst }
                    }
                    other => CrossCoupling {
                        moving,
                        staying,
                        rms_percent,
                        max_percent: other.map_or(max_percent, |worst| worst.max_percent.max(max_percent)),
                    },
                });
            }
        }
        runs.push(AxesControllerRun {
            controller,
            drive: played.drive,
            displacement: played.displacement,
            rms: of_axes.iter().map(|(rms, _)| *rms).collect(),
            max: of_axes.iter().map(|(_, max)| *max).collect(),
            cross,
            held_back: played.held_back,
        });
    }
    let integral = (bench.gain, bench.gain * sample_rate_hz / TAU);
    Ok(AxesTracking { sample_rate_hz, scored, strokes, law: bench.law, integral, runs })
}

/// rms and largest deviation from the reference about their mean.
fn deviations(displacement: &[f64], reference: &[f64], scored: &Range<usize>) -> (f64, f64) {
    let errors: Vec<f64> =
        displacement[scored.clone()].iter().zip(&reference[scored.clone()]).map(|(y, r)| y - r).collect();
    let count = errors.len().max(1) as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let rms = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / count).sqrt();
    (rms, errors.iter().fold(0.0_f64, |most, e| most.max((e - mean).abs())))
}

struct Bench<'a> {
    model: &'a ScheduledModes,
    options: &'a AxesTrackOptions,
    sample_rate_hz: f64,
    stage: &'a dyn AxesStage,
    law: DecouplingLaw,
    /// Gains at rest, and their right inverse.
    at_rest: DMatrix<f64>,
    back: DMatrix<f64>,
    /// Gain of the integral per sample.
    gain: f64,
}

struct Played {
    drive: Vec<Vec<f64>>,
    displacement: Vec<Vec<f64>>,
    held_back: usize,
}

impl<'a> Bench<'a> {
    fn new(
        model: &'a ScheduledModes,
        sample_rate_hz: f64,
        options: &'a AxesTrackOptions,
        stage: &'a dyn AxesStage,
    ) -> Result<Self, DecouplingError> {
        let (bandwidth_hz, preview) = (options.bandwidth_hz, options.preview);
        let law =
            DecouplingLaw::new(model, sample_rate_hz, &LawOptions { bandwidth_hz, preview, level: None })?;
        let linear = LinearAxes::of(&law.held.model, law.state);
        let at_rest = linear.gain();
        let back = right_inverse(&at_rest)?;
        let gain = integral_gain(&linear, &back);
        Ok(Self { model, options, sample_rate_hz, stage, law, at_rest, back, gain })
    }

    fn play(&self, controller: AxesController, references: &[Vec<f64>]) -> Result<Played, DecouplingError> {
        let AxesTrackOptions { bandwidth_hz, limits, .. } = self.options;
        let options =
            DecouplingOptions { bandwidth_hz: *bandwidth_hz, ..DecouplingOptions::within(limits.clone()) };
        let planned = match controller {
            AxesController::Preview => self.law.follow(references, limits)?,
            AxesController::Feedforward | AxesController::FeedforwardIntegral => {
                decouple(self.model, references, self.sample_rate_hz, &options)?
            }
            AxesController::Uncompensated => {
                self.straight(references, |n, m| if n == m { 1.0 / self.at_rest[(n, n)] } else { 0.0 })?
            }
            AxesController::StaticDecoupling => self.straight(references, |n, m| self.back[(n, m)])?,
        };
        let gain = if controller == AxesController::FeedforwardIntegral { self.gain } else { 0.0 };
        self.run(references, &planned, gain)
    }

    /// Straight lines from the rest that the law finds.
    fn straight(
        &self,
        references: &[Vec<f64>],
        slope: impl Fn(usize, usize) -> f64,
    ) -> Result<AxesDrive, DecouplingError> {
        let first: Vec<f64> = references.iter().map(|r| r[0]).collect();
        let rest = self.law.controller(&self.options.limits)?.rest_at(&first)?;
        let samples = references.first().map_or(0, Vec::len);
        let drive = (0..rest.len())
            .map(|n| {
                let at = |k: usize| -> f64 {
                    (0..references.len()).map(|m| slope(n, m) * (references[m][k] - first[m])).sum()
                };
                (0..samples).map(|k| rest[n] + at(k)).collect()
            })
            .collect();
        Ok(AxesDrive {
            drive,
            predicted: Vec::new(),
            rest: Some(rest.clone()),
            level: self.law.level,
            at_range: vec![0; rest.len()],
            at_slew: vec![0; rest.len()],
            rounds: 1,
            bandwidth_hz: self.law.bandwidth_hz,
            rate_error: 0.0,
        })
    }

    /// The planned drives on the stage, with the integral of the error: c⁺ = c + gain · G⁺(r − reading), one
    /// period later.
    fn run(
        &self,
        references: &[Vec<f64>],
        planned: &AxesDrive,
        gain: f64,
    ) -> Result<Played, DecouplingError> {
        let failed = |e: crate::control::StageError| DecouplingError::Stage { problem: e.to_string() };
        let rest = planned.rest.clone().unwrap_or_default();
        let mut stage = self.stage.at_rest(self.sample_rate_hz, &rest).map_err(failed)?;
        let axes = references.len();
        let (mut zero, mut true_zero) = (vec![0.0; axes], vec![0.0; axes]);
        for _ in 0..RESTED {
            stage.step(&rest).map_err(failed)?;
            for m in 0..axes {
                zero[m] += stage.reading_um()[m] / RESTED as f64;
                true_zero[m] += stage.true_um()[m] / RESTED as f64;
            }
        }
        let samples = references.first().map_or(0, Vec::len);
        let (mut drive, mut displacement) = (vec![Vec::new(); rest.len()], vec![Vec::new(); axes]);
        let (mut last, mut integral) = (rest.clone(), vec![0.0; rest.len()]);
        let mut held_back = 0;
        for k in 0..samples {
            let (mut u, mut beyond) = (vec![0.0; rest.len()], vec![0.0; rest.len()]);
            for (n, limit) in self.options.limits.iter().enumerate() {
                let wanted = planned.drive[n][k] + integral[n];
                let (voltage, by) = limited(wanted, last[n], limit, self.sample_rate_hz);
                held_back += usize::from(by != hysteron_rt::Limited::No);
                (u[n], beyond[n]) = (voltage, wanted - voltage);
            }
            stage.step(&u).map_err(failed)?;
            let error = DVector::from_fn(axes, |m, _| {
                references[m][k] - references[m][0] - (stage.reading_um()[m] - zero[m])
            });
            let change = gain * &self.back * error;
            // An actuator at a limit is not asked for more.
            let grows = |n: usize| change[n] * beyond[n] > 0.0;
            (0..rest.len()).filter(|n| !grows(*n)).for_each(|n| integral[n] += change[n]);
            for m in 0..axes {
                displacement[m].push(stage.true_um()[m] - true_zero[m] + references[m][0]);
            }
            drive.iter_mut().zip(&u).for_each(|(list, u)| list.push(*u));
            last = u;
        }
        // Planned drives keep to the limits already.
        let planned = planned.at_range.iter().chain(&planned.at_slew).sum();
        Ok(Played { drive, displacement, held_back: held_back.max(planned) })
    }
}

/// The largest gain per sample with which the sensitivity (I + L)⁻¹, L = gain/(z − 1) · P G⁺, stays below
/// [`SENSITIVITY`] at every frequency, from small gains upwards. The loop is stable for small ones, and the
/// sensitivity is infinite where it ceases to be.
fn integral_gain(linear: &LinearAxes, back: &DMatrix<f64>) -> f64 {
    let axes = linear.outputs;
    let complex = back.map(|x| Complex64::new(x, 0.0));
    let open: Vec<DMatrix<Complex64>> = (1..=FREQUENCIES)
        .map(|k| {
            let z =
                Complex64::from_polar(1.0, std::f64::consts::PI * (k as f64 / FREQUENCIES as f64).powi(2));
            let plant = DMatrix::from_row_slice(axes, linear.inputs, &linear.transfer(z));
            plant * &complex / (z - 1.0)
        })
        .collect();
    let worst = |gain: f64| {
        open.iter().fold(0.0_f64, |most, open| {
            let identity = DMatrix::<Complex64>::identity(axes, axes);
            let inverse = (identity + open * Complex64::new(gain, 0.0)).try_inverse();
            most.max(inverse.map_or(f64::INFINITY, |s| s.singular_values().max()))
        })
    };
    // Upwards from a small gain: the first violation ends the search.
    let mut gain = LARGEST_GAIN / 4096.0;
    while gain < LARGEST_GAIN && worst(1.1 * gain) <= SENSITIVITY {
        gain *= 1.1;
    }
    gain
}
