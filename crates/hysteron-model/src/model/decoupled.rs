//! The inverse of a model of several axes, and its summary for programs.

use serde::{Serialize, Serializer};

use super::run::extrapolates;
use super::{Capability, Model, Preview, Remark, RunError, SignalRole, Unsupported};
use crate::axes::{AxesRecord, ScheduledModes};
use crate::compensator::Limits;
use crate::decoupling::{
    AxesDrive, DecouplingLaw, DecouplingOptions, LawOptions, decouple, decouple_branches, level_of,
};
use crate::record::{Keyed, Unit, ends_of, key_in, range_of};
use crate::{Finding, FindingKind};

impl Model {
    /// Drives of all actuators with which the outputs follow `references`: a record whose inputs are the
    /// references, one per output of the model, in its order.
    ///
    /// # Errors
    /// [`RunError::Unsupported`] for a model of one axis (see [`crate::invert`]) or of another kind,
    /// [`RunError::Unit`], [`RunError::Decoupling`].
    pub fn decouple(
        &self,
        references: &AxesRecord,
        options: &DecouplingOptions,
    ) -> Result<AxesDrive, RunError> {
        self.check_references(references)?;
        let rate = references.sample_rate_hz;
        match self {
            Self::Modes(body) => Ok(decouple(body.law(), &references.u, rate, options)?),
            Self::Branches(body) => Ok(decouple_branches(body.law(), &references.u, rate, options)?),
            _ => Err(Unsupported { kind: self.kind(), wanted: Capability::Inversion }.into()),
        }
    }

    /// [`Self::decouple`] sample by sample, by the law of a controller, and the law.
    ///
    /// # Errors
    /// Those of [`Self::decouple`].
    pub fn decouple_by_sample(
        &self,
        references: &AxesRecord,
        options: &LawOptions,
        limits: &[Limits],
    ) -> Result<(AxesDrive, DecouplingLaw), RunError> {
        self.check_references(references)?;
        let wanted = match self {
            // Its inverse takes the whole reference.
            Self::Branches(_) => Capability::Realisation,
            _ => Capability::Inversion,
        };
        let model = self.scheduled_modes(wanted)?;
        let law = DecouplingLaw::new(model, references.sample_rate_hz, options)?;
        Ok((law.follow(&references.u, limits)?, law))
    }

    /// The scheduled modes, for what other kinds do not support yet.
    ///
    /// # Errors
    /// [`Unsupported`], which names the kind and `wanted`.
    pub fn scheduled_modes(&self, wanted: Capability) -> Result<&ScheduledModes, Unsupported> {
        match self {
            Self::Modes(body) => Ok(body.law()),
            _ => Err(Unsupported { kind: self.kind(), wanted }),
        }
    }

    /// The range of the records of the identification as the limits of every actuator of a model of several
    /// axes; `None` where the data do not state it.
    pub fn limits_of_records(&self) -> Option<Vec<Limits>> {
        let (inputs, _) = self.channels()?;
        let range = &self.valid_range()?.input;
        Some(vec![Limits::range(range.low, range.high); inputs.len()])
    }

    /// What to know of an inverse for drives of this level (rms) and range with this bandwidth \[Hz\], for
    /// models of several axes.
    pub fn decoupling_findings(
        &self,
        level: f64,
        range: Option<(f64, f64)>,
        bandwidth_hz: f64,
    ) -> Vec<Finding> {
        let far = self.valid_range().zip(range).and_then(|(valid, range)| extrapolates(valid, range));
        let swings = self.valid_range().and_then(|range| range.frequency.as_ref()).map(|swings| swings.high);
        let fast = swings
            .filter(|identified_hz| bandwidth_hz > *identified_hz)
            .map(|identified_hz| Remark::BandwidthExtrapolates { bandwidth_hz, identified_hz });
        let warning = |(topic, remark): (&'static str, Remark)| {
            let (text, _) = remark.in_words(self);
            Finding::new(FindingKind::Warning, topic, text + ".")
        };
        let all = [("level", self.beyond_levels(level)), ("range", far), ("bandwidth", fast)];
        all.into_iter().filter_map(|(topic, remark)| Some((topic, remark?))).map(warning).collect()
    }

    /// The remark on a level (rms) beyond those identified.
    pub(super) fn beyond_levels(&self, level: f64) -> Option<Remark> {
        let Self::Modes(body) = self else { return None };
        let law = &body.law().level;
        (!law.holds_at(level)).then(|| Remark::LevelExtrapolates {
            level,
            identified: (law.lowest, law.highest),
            unit: Unit::new(&self.units().input),
        })
    }

    fn check_references(&self, references: &AxesRecord) -> Result<(), RunError> {
        let model = Unit::new(&self.units().output);
        let given = &references.u_unit;
        if given.symbol().is_empty() || model.base().0 == given.base().0 {
            return Ok(());
        }
        Err(RunError::Unit { signal: SignalRole::Reference, model, record: given.clone() })
    }
}

/// Figures of the drives of several actuators. As JSON, quantities in the units of inputs and outputs have
/// keys that end in them.
#[derive(Clone, Debug, PartialEq)]
pub struct DecoupledSummary {
    /// Samples of the references.
    pub samples: usize,
    /// Their rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Bandwidth \[Hz\].
    pub bandwidth_hz: f64,
    /// Preview; `None`: the whole references were known.
    pub preview: Option<Preview>,
    /// Level of the drive for which the modes were taken, rms.
    pub level: f64,
    /// Rounds of the iteration.
    pub rounds: usize,
    /// Relative rms error of the model's linear response at this rate; 0 where it is exact.
    pub rate_error: f64,
    /// Every actuator.
    pub actuators: Vec<ActuatorSummary>,
    /// Every axis.
    pub axes: Vec<AxisSummary>,
    /// What to know of them.
    pub findings: Vec<Finding>,
    /// Symbol of the unit of the inputs.
    pub input_unit: String,
    /// Symbol of the unit of the outputs.
    pub output_unit: String,
}

/// Drive of one actuator, in the unit of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSummary {
    /// Name of the input.
    pub name: String,
    /// Drive before the first sample; `None` where the references repeat.
    pub rest: Option<f64>,
    /// Least drive.
    pub low: f64,
    /// Largest drive.
    pub high: f64,
    /// Largest rate, per second.
    pub fastest_per_s: f64,
    /// Samples limited by the range.
    pub samples_at_range: usize,
    /// Samples limited by the slew rate.
    pub samples_at_slew: usize,
}

/// Prediction of one axis, the model assumed exact, in the unit of the outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSummary {
    /// Name of the output.
    pub name: String,
    /// Largest less least reference.
    pub stroke: f64,
    /// rms error.
    pub rms: f64,
    /// Largest error.
    pub max: f64,
}

impl DecoupledSummary {
    /// Summary of the `found` drives of a model for references; `preview`, where it was limited.
    pub fn new(model: &Model, references: &AxesRecord, found: &AxesDrive, preview: Option<Preview>) -> Self {
        let (inputs, outputs) = model.channels().unwrap_or((&[], &[]));
        let rate = references.sample_rate_hz;
        let actuator = |(n, (name, drive)): (usize, (&String, &Vec<f64>))| {
            let (low, high) = range_of(drive);
            let rest = found.rest.as_ref().map(|rest| rest[n]);
            let before = rest.or_else(|| drive.last().copied());
            let steps = before.into_iter().chain(drive.iter().copied()).zip(drive);
            ActuatorSummary {
                name: name.clone(),
                rest,
                low,
                high,
                fastest_per_s: rate * steps.map(|(a, b)| (b - a).abs()).fold(0.0, f64::max),
                samples_at_range: found.at_range[n],
                samples_at_slew: found.at_slew[n],
            }
        };
        let rms = found.rms_errors(&references.u);
        let axis = |(m, (name, reference)): (usize, (&String, &Vec<f64>))| {
            let (low, high) = range_of(reference);
            let errors = reference.iter().zip(&found.predicted[m]).map(|(r, y)| (r - y).abs());
            AxisSummary {
                name: name.clone(),
                stroke: high - low,
                rms: rms[m],
                max: errors.fold(0.0, f64::max),
            }
        };
        Self {
            samples: references.len(),
            sample_rate_hz: rate,
            bandwidth_hz: found.bandwidth_hz,
            preview,
            level: found.level,
            rounds: found.rounds,
            rate_error: found.rate_error,
            actuators: inputs.iter().zip(&found.drive).enumerate().map(actuator).collect(),
            axes: outputs.iter().zip(&references.u).enumerate().map(axis).collect(),
            findings: model.decoupling_findings(
                found.level.max(level_of(&found.drive)),
                ends_of(&found.drive),
                found.bandwidth_hz,
            ),
            input_unit: model.units().input.clone(),
            output_unit: model.units().output.clone(),
        }
    }
}

impl Serialize for DecoupledSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (input, output) = (self.input_unit.as_str(), self.output_unit.as_str());
        let actuator = |one: &ActuatorSummary| {
            Keyed::default()
                .with("name", &one.name)
                .in_unit("rest", input, one.rest)
                .in_unit("drive_low", input, one.low)
                .in_unit("drive_high", input, one.high)
                .with(key_in("fastest_drive", input) + "_per_s", one.fastest_per_s)
                .with("samples_at_range", one.samples_at_range)
                .with("samples_at_slew", one.samples_at_slew)
        };
        let axis = |one: &AxisSummary| {
            Keyed::default()
                .with("name", &one.name)
                .in_unit("stroke", output, one.stroke)
                .in_unit("predicted_rms_error", output, one.rms)
                .in_unit("predicted_max_error", output, one.max)
        };
        Keyed::default()
            .with("samples", self.samples)
            .with("sample_rate_hz", self.sample_rate_hz)
            .with("bandwidth_hz", self.bandwidth_hz)
            .with("preview_samples", self.preview.map(|preview| preview.samples))
            .in_unit("level", input, self.level)
            .with("rounds", self.rounds)
            .with("rate_error", self.rate_error)
            .with("actuators", self.actuators.iter().map(actuator).collect::<Vec<_>>())
            .with("axes", self.axes.iter().map(axis).collect::<Vec<_>>())
            .with("findings", &self.findings)
            .serialize(serializer)
    }
}
