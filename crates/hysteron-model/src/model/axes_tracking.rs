//! Summary of a comparison of controllers of several axes, for programs.

use serde::{Serialize, Serializer};

use super::{Model, Preview};
use crate::Finding;
use crate::axes::AxesRecord;
use crate::decoupling::{AxesController, AxesTracking};
use crate::record::{Channel, Keyed, Record, RecordError, ends_of};

/// An [`AxesTracking`] without its curves.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesTrackingSummary {
    /// The controllers' rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Where scoring begins \[s\].
    pub scored_from_s: f64,
    /// Names of the outputs.
    pub axes: Vec<String>,
    /// Stroke of every reference.
    pub strokes: Vec<f64>,
    /// Bandwidth of the inverse \[Hz\].
    pub bandwidth_hz: f64,
    /// Preview of the sample-by-sample controller.
    pub preview_samples: usize,
    /// Frequency at which the gain of the integral's loop is 1 \[Hz\].
    pub integral_crossover_hz: f64,
    /// Every controller.
    pub controllers: Vec<AxesControllerSummary>,
    /// What to know of the inverse.
    pub findings: Vec<Finding>,
    /// Symbol of the unit of the outputs.
    pub output_unit: String,
}

/// Errors of one controller.
#[derive(Clone, Debug, PartialEq)]
pub struct AxesControllerSummary {
    /// The controller.
    pub controller: AxesController,
    /// rms error of every axis, in the unit of the outputs.
    pub rms: Vec<f64>,
    /// Largest rms error of an axis in per cent of its stroke; `None` where no reference moves.
    pub rms_percent: Option<f64>,
    /// Largest error in per cent of the stroke of its axis.
    pub max_percent: Option<f64>,
    /// rms cross-coupling of the worst pair, in per cent of the stroke of the moving axis.
    pub cross_rms_percent: Option<f64>,
    /// Largest cross-coupling.
    pub cross_max_percent: Option<f64>,
    /// Moving and staying axis of the worst pair.
    pub cross_pair: Option<[String; 2]>,
    /// Samples at a limit.
    pub samples_at_limits: usize,
}

impl Model {
    /// References, and drives and displacements of every controller, as a record called `name`: channels as
    /// the model names them, with the controller behind.
    ///
    /// # Errors
    /// [`RecordError`].
    pub fn tracked_record(
        &self,
        name: &str,
        found: &AxesTracking,
        references: &AxesRecord,
    ) -> Result<Record, RecordError> {
        let units = self.units();
        let (inputs, outputs) = self.channels().unwrap_or((&[], &[]));
        let mut channels = Vec::new();
        let mut add = |names: &[String], suffix: &str, unit: &str, lists: &[Vec<f64>]| {
            let named = names.iter().zip(lists);
            channels.extend(
                named.map(|(name, list)| Channel::new(&format!("{name}{suffix}"), unit, list.clone())),
            );
        };
        add(outputs, "_reference", &units.output, &references.u);
        for run in &found.runs {
            let suffix = format!("_{}", run.controller.name());
            add(inputs, &suffix, &units.input, &run.drive);
            add(outputs, &suffix, &units.output, &run.displacement);
        }
        Record::new(name, references.time.clone(), channels)
    }
}

impl AxesTrackingSummary {
    /// Of a comparison with a model of several axes.
    pub fn new(model: &Model, found: &AxesTracking) -> Self {
        let axes = model.channels().map_or_else(Vec::new, |(_, outputs)| outputs.to_vec());
        let percent = |errors: &[f64]| {
            let moving = errors.iter().zip(&found.strokes).filter(|(_, stroke)| **stroke > 0.0);
            moving.map(|(e, stroke)| 100.0 * e / stroke).reduce(f64::max)
        };
        let name = |axis: usize| axes.get(axis).cloned().unwrap_or_default();
        let controllers = found
            .runs
            .iter()
            .map(|run| AxesControllerSummary {
                controller: run.controller,
                rms: run.rms.clone(),
                rms_percent: percent(&run.rms),
                max_percent: percent(&run.max),
                cross_rms_percent: run.cross.map(|cross| cross.rms_percent),
                cross_max_percent: run.cross.map(|cross| cross.max_percent),
                cross_pair: run.cross.map(|cross| [name(cross.moving), name(cross.staying)]),
                samples_at_limits: run.held_back,
            })
            .collect();
        let law = &found.law;
        let planned = found.runs.iter().find(|run| run.controller == AxesController::Feedforward);
        let range = planned.and_then(|run| ends_of(&run.drive));
        let mut findings = model.decoupling_findings(law.level, range, law.bandwidth_hz);
        findings.extend(Preview::from(law).finding(None));
        Self {
            bandwidth_hz: law.bandwidth_hz,
            preview_samples: law.preview,
            findings,
            sample_rate_hz: found.sample_rate_hz,
            scored_from_s: found.scored.start as f64 / found.sample_rate_hz,
            strokes: found.strokes.clone(),
            integral_crossover_hz: found.integral.1,
            controllers,
            output_unit: model.units().output.clone(),
            axes,
        }
    }
}

impl Serialize for AxesTrackingSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let output = self.output_unit.as_str();
        let controller = |one: &AxesControllerSummary| {
            Keyed::default()
                .with("controller", one.controller)
                .in_unit("rms", output, &one.rms)
                .with("rms_percent_of_stroke", one.rms_percent)
                .with("max_percent_of_stroke", one.max_percent)
                .with("cross_coupling_rms_percent", one.cross_rms_percent)
                .with("cross_coupling_max_percent", one.cross_max_percent)
                .with("cross_coupling_pair", &one.cross_pair)
                .with("samples_at_limits", one.samples_at_limits)
        };
        Keyed::default()
            .with("simulated", true)
            .with("sample_rate_hz", self.sample_rate_hz)
            .with("scored_from_s", self.scored_from_s)
            .with("axes", &self.axes)
            .in_unit("strokes", output, &self.strokes)
            .with("bandwidth_hz", self.bandwidth_hz)
            .with("preview_samples", self.preview_samples)
            .with("integral_crossover_hz", self.integral_crossover_hz)
            .with("controllers", self.controllers.iter().map(controller).collect::<Vec<_>>())
            .with("findings", &self.findings)
            .serialize(serializer)
    }
}
