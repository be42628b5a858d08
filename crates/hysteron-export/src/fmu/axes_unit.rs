//! A unit of a model of several axes: what it holds, and its variables.

use hysteron_io::NamedFile;

use super::variables::{FIXED, INPUT, OUTPUT, Variable, WHOLE_OUTPUT};
use crate::escape::xml;
use crate::template::Filling;

/// A model of several axes, or its inverse, to be packed.
#[derive(Clone, Debug)]
pub(crate) struct AxesUnit {
    pub name: String,
    pub description: Vec<String>,
    /// What its C source was filled with.
    pub filling: Filling,
    /// The C source.
    pub files: Vec<NamedFile>,
    pub sample_rate_hz: f64,
    /// Units of voltages and displacements.
    pub units: [String; 2],
    pub inputs: usize,
    pub outputs: usize,
    /// What only an inverse has.
    pub inverse: Option<InverseOfAxes>,
}

/// What only the inverse has.
#[derive(Clone, Debug)]
pub(crate) struct InverseOfAxes {
    /// Samples that the references are ahead.
    pub preview: usize,
    /// Lowest and highest voltage of each actuator in the source.
    pub ranges: Vec<[f64; 2]>,
    /// Voltages that it rests at, and the displacements under them.
    pub rest_voltages: Vec<f64>,
    pub rest_displacements: Vec<f64>,
}

impl AxesUnit {
    /// Variables, each list one after the other.
    pub(super) fn signals(&self) -> Vec<Variable> {
        let mut all: Vec<Variable> = Vec::new();
        let mut add = |name: String, attributes, about: String, unit: Option<&String>, start| {
            let reference = all.len() + 1;
            all.push(Variable {
                name,
                reference,
                attributes,
                about,
                unit: unit.map(|unit| xml(unit)),
                start,
            });
        };
        let [input, output] = self.units.each_ref().map(Some);
        let voltage = |k: usize| format!("voltage_{}", k + 1);
        let status = if let Some(inverse) = &self.inverse {
            for (k, at_rest) in inverse.rest_displacements.iter().enumerate() {
                let about = format!("Reference of axis {}, {} samples ahead", k + 1, inverse.preview);
                add(format!("reference_{}", k + 1), INPUT, about, output, Some(*at_rest));
            }
            for (k, [low, high]) in inverse.ranges.iter().enumerate() {
                let about = format!("Voltage of actuator {} for the next period, {low} to {high}", k + 1);
                add(voltage(k), OUTPUT, about, input, None);
            }
            "0 followed, 1 limited by a range, 2 by a slew rate, -1 reference not finite, -2 out of the range \
             of numbers"
        } else {
            for k in 0..self.inputs {
                add(voltage(k), INPUT, format!("Voltage of actuator {}", k + 1), input, Some(0.0));
            }
            for k in 0..self.outputs {
                let about = format!("Displacement of axis {} after the last sample", k + 1);
                add(format!("displacement_{}", k + 1), OUTPUT, about, output, None);
            }
            "0 done, 1 a voltage outside of the range identified, -1 voltage not finite, -2 out of the range of \
             numbers"
        };
        add("status".into(), WHOLE_OUTPUT, format!("Status of the last sample: {status}"), None, None);
        for (k, at_rest) in self.inverse.iter().flat_map(|inverse| &inverse.rest_voltages).enumerate() {
            let about = format!("Voltage that actuator {} rests at before", k + 1);
            add(format!("rest_{}", voltage(k)), FIXED, about, input, Some(*at_rest));
        }
        all
    }
}
