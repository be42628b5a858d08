//! Golden vectors of a controller: the library's own simulation on a stage that is not the model.

use hysteron_model::control::{Plant, Stage, StageError, StageRun, StageSample, play};

use super::ClosedLoop;
use crate::error::ExportError;

/// Samples of the vectors; the last third are steps.
pub(super) const SAMPLES: usize = 600;
/// Share of the range of the displacement that the reference swings and steps by.
const SWING: f64 = 0.25;
/// Largest difference, as a share of the range of the voltage.
const TOLERANCE: f64 = 1e-12;

/// References, and the voltages and readings of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GoldenLoop {
    /// Voltage at rest before the first.
    pub rest_v: f64,
    /// Reading there.
    pub measured: f64,
    pub references: Vec<f64>,
    /// Voltage of every period.
    pub voltages: Vec<f64>,
    /// Reading at the beginning of it.
    pub readings: Vec<f64>,
    pub tolerance: f64,
}

/// A lag with another gain than the model, and no hysteresis.
#[derive(Clone, Copy)]
struct Lag {
    gain: f64,
    pace: f64,
}

struct LagRun {
    lag: Lag,
    displacement: f64,
}

impl Stage for Lag {
    fn at_rest(&self, _: f64, rest_v: f64) -> Result<Box<dyn StageRun + '_>, StageError> {
        Ok(Box::new(LagRun { lag: *self, displacement: self.gain * rest_v }))
    }
}

impl StageRun for LagRun {
    fn step(&mut self, drive_v: f64) -> Result<StageSample, StageError> {
        let now = self.displacement;
        self.displacement += self.lag.pace * (self.lag.gain * drive_v - now);
        Ok(StageSample { reading_um: now, true_um: now })
    }
}

impl GoldenLoop {
    pub fn new(closed: &ClosedLoop) -> Result<Self, ExportError> {
        let line = &closed.made.line;
        let [low, high] = closed.made.settings.range_v;
        let (middle, stroke) = (line.offset + 0.5 * line.slope * (low + high), line.slope * (high - low));
        let references: Vec<f64> = (0..SAMPLES)
            .map(|k| {
                let phase = 5.0 * std::f64::consts::TAU * k as f64 / SAMPLES as f64;
                let swing = if k < 2 * SAMPLES / 3 { phase.sin() } else { 0.5 * phase.sin().signum() };
                middle + SWING * stroke * swing
            })
            .collect();
        let stage = Lag { gain: 1.05 * line.slope, pace: 0.4 };
        let played = play(&closed.made, &references, Plant::Stage(&stage), None)?;
        let moves = played.drive.iter().any(|u| (u - played.rest_v).abs() > 0.01 * (high - low));
        if !moves {
            return Err(ExportError::Still { what: "voltage of the controller" });
        }
        Ok(Self {
            rest_v: played.rest_v,
            measured: middle,
            references,
            voltages: played.drive,
            readings: played.reading,
            tolerance: TOLERANCE * (high - low),
        })
    }
}
