//! What the inverse of a model of several axes is asked for, with the defaults of every front end.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DecoupledSummary, Model, Preview, RunError, ends_apart};
use crate::axes::AxesRecord;
use crate::compensator::Limits;
use crate::decoupling::{AxesDrive, DecouplingError, DecouplingOptions, LawOptions};
use crate::record::{Channel, Record, RecordError, Unit};

/// Drives of all actuators, or their controller, as they are asked for; what is left out takes its default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DecouplingRequest {
    /// Least and greatest drive, one for all actuators or one each; left out: the range that the model was
    /// identified in.
    pub ranges: Vec<[f64; 2]>,
    /// Largest slew rate in the unit of the drive per second, one for all actuators or one each; left out:
    /// none.
    pub slews_per_s: Vec<f64>,
    /// Frequency up to which the outputs follow \[Hz\]; left out: a twentieth of the sample rate.
    pub bandwidth_hz: Option<f64>,
    /// Level of the drive (rms) for modes that move with it; left out: that of the drives found, and with a
    /// preview the highest identified.
    pub level: Option<f64>,
    /// The references are periods of a periodic motion.
    pub periodic: bool,
    /// Compute sample by sample, as a controller does, with so many samples of the references known ahead;
    /// left out: the whole references are known.
    pub preview: Option<usize>,
}

impl DecouplingRequest {
    /// Limits of every actuator.
    ///
    /// # Errors
    /// [`DecouplingError::RangeUnknown`]; [`DecouplingError::Limits`] for neither one nor one each.
    pub fn limits(&self, model: &Model) -> Result<Vec<Limits>, DecouplingError> {
        let inputs = model.channels().map_or(1, |(inputs, _)| inputs.len());
        for given in [self.ranges.len(), self.slews_per_s.len()] {
            if given > 1 && given != inputs {
                return Err(DecouplingError::Limits { inputs, limits: given });
            }
        }
        let of_records = || model.limits_of_records().ok_or(DecouplingError::RangeUnknown);
        let mut limits = match self.ranges.as_slice() {
            [] => of_records()?,
            [[low, high]] => vec![Limits::range(*low, *high); inputs],
            each => each.iter().map(|[low, high]| Limits::range(*low, *high)).collect(),
        };
        for (k, limit) in limits.iter_mut().enumerate() {
            if let Some(slew) = self.slews_per_s.get(k).or(self.slews_per_s.first()) {
                *limit = limit.slew(*slew);
            }
        }
        Ok(limits)
    }

    /// Options of the law of a controller.
    pub fn law(&self) -> LawOptions {
        LawOptions { bandwidth_hz: self.bandwidth_hz, preview: self.preview, level: self.level }
    }
}

impl Model {
    /// Drives of all actuators for references as they are asked for ([`Self::decouple`],
    /// [`Self::decouple_by_sample`]), with their summary.
    ///
    /// # Errors
    /// Those of [`Self::decouple`] and [`DecouplingRequest::limits`];
    /// [`DecouplingError::Repeats`] for periodic references one sample at a time.
    pub fn decouple_for(
        &self,
        references: &AxesRecord,
        request: &DecouplingRequest,
    ) -> Result<(AxesDrive, DecoupledSummary), RunError> {
        let limits = request.limits(self)?;
        let (found, law) = match request.preview {
            Some(_) if request.periodic => return Err(DecouplingError::Repeats.into()),
            Some(_) => {
                let (found, law) = self.decouple_by_sample(references, &request.law(), &limits)?;
                if !law.is_steady(&found, &references.u, &limits)? {
                    return Err(DecouplingError::Unsteady { bandwidth_hz: law.bandwidth_hz }.into());
                }
                (found, Some(Preview::from(&law)))
            }
            None => {
                let options = DecouplingOptions {
                    bandwidth_hz: request.bandwidth_hz,
                    periodic: request.periodic,
                    level: request.level,
                    ..DecouplingOptions::within(limits)
                };
                (self.decouple(references, &options)?, None)
            }
        };
        let mut summary = DecoupledSummary::new(self, references, &found, law);
        if request.periodic {
            let (_, outputs) = self.channels().unwrap_or((&[], &[]));
            let unit = Unit::new(&self.units().output);
            let named = references.u.iter().zip(outputs);
            summary.findings.extend(named.filter_map(|(r, name)| ends_apart(r, Some(name), &unit)));
        }
        summary.findings.extend(law.and_then(|preview| preview.finding(request.preview)));
        Ok((found, summary))
    }

    /// Drives, predicted outputs and references as a record: `u1`, …, `y1`, …, `reference_y1`, …, by the names
    /// of the model.
    ///
    /// # Errors
    /// Those of [`Record::new`].
    pub fn decoupled_record(
        &self,
        name: &str,
        references: AxesRecord,
        found: AxesDrive,
    ) -> Result<Record, RecordError> {
        let units = self.units();
        let (inputs, outputs) = self.channels().unwrap_or((&[], &[]));
        let mut channels = Vec::new();
        let mut add = |names: &[String], prefix: &str, unit: &str, lists: Vec<Vec<f64>>| {
            let named = names.iter().zip(lists);
            channels.extend(named.map(|(name, list)| Channel::new(&format!("{prefix}{name}"), unit, list)));
        };
        add(inputs, "", &units.input, found.drive);
        add(outputs, "", &units.output, found.predicted);
        add(outputs, "reference_", &units.output, references.u);
        Record::new(name, references.time, channels)
    }
}
