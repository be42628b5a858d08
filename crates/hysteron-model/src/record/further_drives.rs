//! Drives beside the input: a record of several actuators.

use crate::Advice;

use super::{Channel, Quantity, Record};

/// Least range of a further drive, as a share of that of the input: less is an actuator at rest.
const MOVES: f64 = 0.05;
/// Largest correlation with a drive that is already known: above it is the same drive, measured or scaled.
const SAME: f64 = 0.9;

impl Record {
    /// The channels of a model of several axes, where the record has more than one drive that moves on its
    /// own and a position: the input of this name (`None`: the first voltage) with all further voltages that
    /// move by at least a twentieth of it and are not its copy, and every position. `None` elsewhere.
    pub fn several_axes(&self, input: Option<&str>) -> Option<Advice> {
        let drives = || self.channels.iter().filter(|c| c.unit.base().0 == Quantity::Voltage);
        let first = match input {
            Some(name) => drives().find(|channel| channel.is_called(name)),
            None => drives().next(),
        }?;
        let mut inputs = vec![first];
        for channel in drives() {
            let moves = in_base_unit_range(channel) >= MOVES * in_base_unit_range(first);
            if moves && inputs.iter().all(|known| correlation(known, channel).abs() <= SAME) {
                inputs.push(channel);
            }
        }
        let is_position = |c: &&Channel| matches!(c.unit.base().0, Quantity::Length | Quantity::Angle);
        let outputs: Vec<&Channel> = self.channels.iter().filter(is_position).collect();
        if inputs.len() < 2 || outputs.is_empty() {
            return None;
        }
        let headers = |channels: Vec<&Channel>| channels.into_iter().map(Channel::header).collect();
        Some(Advice::SeveralAxes { inputs: headers(inputs), outputs: headers(outputs) })
    }
}

fn in_base_unit_range(channel: &Channel) -> f64 {
    let (low, high) = super::range_of(&channel.samples);
    (high - low) * channel.unit.base().1
}

/// Correlation coefficient; 0 where one is constant.
fn correlation(a: &Channel, b: &Channel) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (mean_a, mean_b) = (mean(&a.samples), mean(&b.samples));
    let (mut product, mut square_a, mut square_b) = (0.0, 0.0, 0.0);
    for (a, b) in a.samples.iter().zip(&b.samples) {
        let (a, b) = (a - mean_a, b - mean_b);
        product += a * b;
        square_a += a * a;
        square_b += b * b;
    }
    let scale = (square_a * square_b).sqrt();
    if scale > 0.0 { product / scale } else { 0.0 }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::record::TimeBase;

    fn record(channels: &[(&str, &str, f64, f64)]) -> Record {
        let samples = |amplitude: f64, frequency: f64| {
            (0..500).map(|k| amplitude * (f64::from(k) * 0.05 * frequency).sin()).collect()
        };
        let channel = |(name, unit, amplitude, frequency): &(&str, &str, f64, f64)| {
            Channel::new(name, unit, samples(*amplitude, *frequency))
        };
        Record::new("r", TimeBase::uniform(1000.0), channels.iter().map(channel).collect()).unwrap()
    }

    #[test]
    fn drives_that_move_on_their_own_are_axes() {
        let found = record(&[
            ("u1", "V", 5.0, 1.0),
            ("u2", "mV", 4000.0, 1.7),
            ("y1", "um", 3.0, 1.0),
            ("y2", "urad", 2.0, 1.7),
        ])
        .several_axes(Some("u1"));
        let names = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let (inputs, outputs) = (names(["u1_V", "u2_mV"]), names(["y1_um", "y2_urad"]));
        assert_eq!(found, Some(Advice::SeveralAxes { inputs, outputs }));
    }

    #[test]
    fn a_copy_a_monitor_and_an_actuator_at_rest_are_none() {
        for other in [("u_meas", "V", 4.9, 1.0), ("monitor", "mV", 490.0, 1.0), ("u2", "V", 0.05, 1.7)] {
            let record = record(&[("u_cmd", "V", 5.0, 1.0), other, ("y", "um", 3.0, 1.0)]);
            assert_eq!(record.several_axes(Some("u_cmd")), None, "{other:?}");
            assert_eq!(record.several_axes(None), None, "{other:?}");
        }
        let no_position = record(&[("u1", "V", 5.0, 1.0), ("u2", "V", 5.0, 1.7), ("F", "N", 1.0, 1.0)]);
        assert_eq!(no_position.several_axes(None), None);
    }
}
