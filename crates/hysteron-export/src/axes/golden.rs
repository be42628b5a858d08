//! Golden vectors of several axes.

use hysteron_model::axes::{AxesError, HeldSimulation};
use hysteron_model::compensator::Limits;
use hysteron_model::decoupling::{DecouplingController, DecouplingError};

use super::AxesSubject;
use super::single::{Single, SingleInverse};
use super::tables::Language;
use crate::c::rows;
use crate::error::ExportError;
use crate::number::Precision;
use crate::template::Filling;

/// Golden vectors; the last are steps.
const VECTORS: usize = 240;
/// Amplitude of the drive, as a share of the range, and how often it is halved at most.
const LARGEST: f64 = 0.4;
const HALVINGS: i32 = 6;
/// Size from which a motion counts as running away: in µm, a metre.
const RUNS_AWAY: f64 = 1e6;
/// Vectors that a preview is passed in.
const WITHIN: usize = 60;
/// Largest difference, as a share of the range: sums in another order.
const TOLERANCE: f64 = 1e-9;
/// Largest share of the range that single precision may depart by.
const LARGEST_DEPARTURE: f64 = 0.01;

impl AxesSubject {
    /// Vectors of the model, over most of the range. At some rates their frequencies are those of the modes,
    /// where a drive of that size throws a model with hysteresis in feedback out of what it holds for: then
    /// they are as large as it stands.
    pub(super) fn golden(&self) -> Result<Golden, ExportError> {
        let mut found = self.golden_over(LARGEST);
        for halvings in 1..=HALVINGS {
            let Err(ExportError::Decoupling(reason)) = &found else { break };
            if !matches!(**reason, DecouplingError::Axes(AxesError::RunsAway)) {
                break;
            }
            found = self.golden_over(LARGEST / f64::from(1 << halvings));
        }
        found
    }

    fn golden_over(&self, amplitude: f64) -> Result<Golden, ExportError> {
        let mut simulation = HeldSimulation::new(self.model().clone(), self.law.state);
        let drive = |k: usize, i: usize| {
            let Limits { low, high, .. } = self.limits[i];
            0.5 * (low + high) + amplitude * (high - low) * wave(k, i)
        };
        let given: Vec<Vec<f64>> =
            (0..VECTORS).map(|k| (0..self.limits.len()).map(|i| drive(k, i)).collect()).collect();
        let mut single = (self.precision == Precision::F32)
            .then(|| Single::new(self.model(), self.law.state, simulation.settling_steps()));
        let mut golden = Golden::new(1);
        for u in given {
            simulation.advance();
            let found = single.as_mut().map(|single| single.step(&rounded(&u)).to_vec());
            golden.push(simulation.apply(&u).to_vec(), found);
            golden.given.push(u);
        }
        golden.judged("output of the several axes", &self.output_unit)
    }

    /// Vectors of the inverse.
    pub(super) fn golden_inverse(&self) -> Result<Golden, ExportError> {
        let mut controller: DecouplingController = self.law.controller(&self.limits)?;
        let rest = controller.output().to_vec();
        // The motion that a good part of the limits moves each axis by.
        let mut simulation = HeldSimulation::new(self.model().clone(), self.law.state);
        let middle: Vec<f64> = self.limits.iter().map(|l| 0.5 * (l.low + l.high)).collect();
        let top: Vec<f64> = self.limits.iter().map(|l| 0.75 * l.high + 0.25 * l.low).collect();
        simulation.rest_at(&middle);
        let from = simulation.output().to_vec();
        simulation.rest_at(&top);
        let strokes: Vec<f64> = simulation.output().iter().zip(&from).map(|(a, b)| (a - b).abs()).collect();
        let reference = |k: usize, m: usize| rest[m] + 0.5 * strokes[m] * wave(k, m);
        let given: Vec<Vec<f64>> =
            (0..VECTORS).map(|k| (0..rest.len()).map(|m| reference(k, m)).collect()).collect();
        let hold = self.law.preview.div_ceil(WITHIN).max(1);
        let held = |m: usize| given.iter().flat_map(|r| std::iter::repeat_n(r[m], hold)).collect();
        let references: Vec<Vec<f64>> = (0..rest.len()).map(held).collect();
        let along = self.law.follow(&references, &self.limits)?;
        if !self.law.is_steady(&along, &references, &self.limits)? {
            return Err(DecouplingError::Unsteady { bandwidth_hz: self.law.bandwidth_hz }.into());
        }
        let settles = simulation.settling_steps();
        let mut single =
            (self.precision == Precision::F32).then(|| SingleInverse::new(&self.law, &self.limits, settles));
        let mut golden = Golden::new(hold);
        for r in given {
            let mut found = None;
            for _ in 1..hold {
                controller.step(&r);
                if let Some(single) = &mut single {
                    single.step(&rounded(&r));
                }
            }
            if let Some(single) = &mut single {
                found = Some(single.step(&rounded(&r)).to_vec());
            }
            golden.push(controller.step(&r).to_vec(), found);
            golden.given.push(r);
        }
        golden.judged("voltage of the several axes", &self.input_unit)
    }
}

/// Between −1 and 1: a growing sine of its own for every channel, then steps.
fn wave(k: usize, channel: usize) -> f64 {
    let phase = (0.05 + 0.013 * channel as f64) * k as f64;
    if k < 3 * VECTORS / 4 { phase.sin() * (k as f64 / 60.0).min(1.0) } else { phase.sin().signum() * 0.8 }
}

fn rounded(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

/// Vectors and what comes out along them.
#[derive(Default)]
pub(super) struct Golden {
    given: Vec<Vec<f64>>,
    /// At the end of every vector.
    wanted: Vec<Vec<f64>>,
    /// Samples that a vector lasts.
    hold: usize,
    /// Largest difference in single precision from what is wanted; `None` in double.
    apart: Option<f64>,
    /// The same as a share of the range.
    pub departure: Option<f64>,
    tolerance: f64,
}

impl Golden {
    fn new(hold: usize) -> Self {
        Self { hold, ..Self::default() }
    }

    /// What is wanted at the end of a vector, and what is found in single precision.
    fn push(&mut self, wanted: Vec<f64>, single: Option<Vec<f32>>) {
        if let Some(single) = single {
            let apart = wanted.iter().zip(single).map(|(wanted, single)| (wanted - f64::from(single)).abs());
            // A NaN counts.
            let worse = |worst: f64, x: f64| if x <= worst { worst } else { x };
            self.apart = Some(apart.fold(self.apart.unwrap_or(0.0), worse));
        }
        self.wanted.push(wanted);
    }

    /// The vectors with their tolerance: twice what single precision departs by.
    fn judged(mut self, what: &'static str, unit: &str) -> Result<Self, ExportError> {
        if !self.wanted.iter().flatten().all(|x| x.abs() < RUNS_AWAY) {
            return Err(DecouplingError::from(AxesError::RunsAway).into());
        }
        let all = self.wanted.iter().flatten();
        let ends = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let span = ends.1 - ends.0;
        if !(span > 0.0 && span.is_finite()) {
            return Err(ExportError::Still { what });
        }
        self.departure = self.apart.map(|apart| apart / span);
        self.tolerance = TOLERANCE * span;
        if let (Some(apart), Some(share)) = (self.apart, self.departure) {
            if share.is_nan() || share > LARGEST_DEPARTURE {
                let (unit, percent) = (unit.to_owned(), 100.0 * share);
                return Err(ExportError::Rounding { what, bound: apart, unit, percent });
            }
            self.tolerance = (2.0 * apart).max(16.0 * Precision::F32.epsilon() * span);
        }
        Ok(self)
    }

    /// Sets what a self-test is filled with.
    pub fn fill(&self, filling: &mut Filling, language: Language, precision: Precision) {
        let lines = |lists: &[Vec<f64>]| rows(lists.iter().map(|list| language.row(precision, list)));
        filling
            .key("VECTORS", self.given.len())
            .key("HOLD", self.hold)
            .key("N_GIVEN", self.given.first().map_or(0, Vec::len))
            .key("N_FOUND", self.wanted.first().map_or(0, Vec::len))
            .key("GIVEN", lines(&self.given))
            .key("WANTED", lines(&self.wanted))
            .key(
                "ALLOWED",
                match self.apart {
                    Some(_) => "twice what single precision departs by",
                    None => "1e-9 of the range of what comes out",
                },
            )
            .key("TOLERANCE", language.literal(precision, self.tolerance));
    }
}
