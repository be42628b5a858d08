//! Limits of an inverse drive, with remedies.

use super::Hammerstein;
use crate::dynamics::Dynamics;
use crate::invert::InverseDrive;
use crate::record::Unit;
use crate::{Advice, Finding, FindingKind};
use hysteron_numeric::display::{short, short_to};

/// A gain at rest that differs by more than this factor from that of the slowest record is extrapolated.
pub const FAR_FROM_REST: f64 = 1.25;

/// Jump from the last sample of a period to its first, over the largest step within, that is told.
const FARTHER_THAN_A_STEP: f64 = 2.0;

impl Hammerstein {
    /// Gain at rest over that at the lowest frequency of the records it was identified from, and that
    /// frequency \[Hz\]; infinite for unbounded creep. `None` for a static model, or one whose records had no
    /// frequency.
    pub fn gain_at_rest(&self) -> Option<(f64, f64)> {
        let (Dynamics::Integer(g) | Dynamics::Fractional(g)) = &self.law().dynamics else { return None };
        let lowest_hz = self.data().valid_range.as_ref()?.frequency.as_ref()?.low;
        let over = g.dc_gain_over(lowest_hz).abs();
        (over > 0.0 && !over.is_nan()).then_some((over, lowest_hz))
    }

    /// Warnings on the drive `found`: limits that keep it from following its reference, and gains at rest
    /// that the model only extrapolates, so that it follows the model rather than the device.
    pub fn findings_on_drive(&self, found: &InverseDrive, range: [f64; 2]) -> Vec<Finding> {
        let mut findings = Vec::new();
        let mut say = |topic, text: String, advice| {
            findings.push(Finding::new(FindingKind::Warning, topic, text).with_advice(advice));
        };
        let samples = found.drive.len();
        let input = Unit::new(&self.data().units.input).spaced();
        if let Some([low, high]) = self.drive_range().filter(|own| reaches_far_beyond(range, *own)) {
            let text = format!(
                "The range of the drive, {} to {}{input}, reaches far beyond that of the records, {} to \
                 {}{input}: beyond it the model extrapolates, and whether device and amplifier bear it is not \
                 known here.",
                short(range[0]),
                short(range[1]),
                short(low),
                short(high)
            );
            say("range", text, Advice::DriveRange);
        }
        if found.at_range > 0 {
            let text = format!(
                "The drive is clipped at its range, {} to {}{input}, in {} of {samples} samples: the \
                 reference asks for more. Take a wider range where device and amplifier allow it, move the \
                 reference's offset, or reduce its amplitude.",
                short(range[0]),
                short(range[1]),
                found.at_range
            );
            say("range", text, Advice::DriveRange);
        }
        if found.at_slew > 0 {
            let text = format!(
                "The drive is clipped at its largest rate in {} of {samples} samples: the reference is too \
                 fast for it. Slow the reference down, round its turns, or allow a higher rate.",
                found.at_slew
            );
            say("slew", text, Advice::DriveRate);
        }
        match self.gain_at_rest() {
            Some((over, _)) if over.is_infinite() => {
                let text = "The model creeps for ever: its gain at rest is infinite, so that a reference \
                            that is held is met by a drive that keeps falling, and the rest before it is \
                            only a convention. Identify it with creep that ends.";
                say("rest", text.to_owned(), Advice::CreepThatEnds);
            }
            Some((over, lowest_hz)) if over.max(1.0 / over) > FAR_FROM_REST => {
                let text = format!(
                    "At rest the model's gain is {} times that at {} Hz, the slowest it was identified with: \
                     drives for levels that are held are extrapolated by that factor. Identify it with a \
                     slower record or held levels, and creep that ends.",
                    short_to(over, 2),
                    short(lowest_hz)
                );
                say("rest", text, Advice::CreepThatEnds);
            }
            _ => {}
        }
        findings
    }
}

/// That a reference in the unit `output`, which is to repeat, does not end where it begins; `name`: its name
/// among several.
pub fn ends_apart(reference: &[f64], name: Option<&str>, output: &Unit) -> Option<Finding> {
    let (first, last) = (reference.first()?, reference.last()?);
    let jump = (first - last).abs();
    let step = reference.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    if jump <= FARTHER_THAN_A_STEP * step {
        return None;
    }
    let text = format!(
        "As a period the reference{} jumps from its last sample to its first by {}{unit}; its largest step is \
         {}{unit}. Give one or more whole periods.",
        name.map(|name| format!(" {name}")).unwrap_or_default(),
        short(jump),
        short(step),
        unit = output.spaced()
    );
    Some(Finding::new(FindingKind::Warning, "period", text))
}

/// True if a range exceeds the one of the records by more than its width on either side.
fn reaches_far_beyond([low, high]: [f64; 2], [own_low, own_high]: [f64; 2]) -> bool {
    let width = own_high - own_low;
    low < own_low - width || high > own_high + width
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;
    use crate::dynamics::{Scheme, Term, TransferFunction};
    use crate::hammerstein;
    use crate::hysteresis::Hysteresis;
    use crate::model::{Capability, Model};
    use crate::model_file::{ModelFile, SignalUnits, ValidRange};
    use crate::record::InterSample;

    /// A straight line before 1/(`c` s^`order`) or 1/(1 + `c` s), identified from 1 to 10 Hz.
    fn model(denominator: Vec<Term>) -> Model {
        let law = hammerstein::Model {
            hysteresis: Hysteresis::without_memory(vec![1.0]).unwrap(),
            dynamics: Dynamics::Fractional(
                TransferFunction::new(vec![Term::new(1.0, 0.0)], denominator).unwrap(),
            ),
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            sample_rate_hz: None,
            inter_sample: InterSample::Linear,
        };
        let mut file = ModelFile::from_model(&law, SignalUnits::default());
        file.valid_range = Some(ValidRange::of_inputs(&[0.0, 10.0], "V", Some((1.0, 10.0))));
        file.try_into().unwrap()
    }

    fn told(denominator: Vec<Term>, at_range: usize) -> Vec<Finding> {
        let drive = vec![0.0, 10.0, 10.0];
        let found = InverseDrive {
            predicted: drive.clone(),
            drive,
            rest: None,
            at_range,
            at_slew: 0,
            dynamics: None,
        };
        let model = model(denominator);
        model.hammerstein(Capability::Inversion).unwrap().findings_on_drive(&found, [0.0, 10.0])
    }

    #[test]
    fn a_range_far_beyond_the_records_is_named() {
        let far = |range| reaches_far_beyond(range, [0.0, 10.0]);
        assert!(far([-1000.0, 10.0]) && far([0.0, 21.0]));
        assert!(!far([-10.0, 20.0]) && !far([2.0, 5.0]));
    }

    #[test]
    fn causes_are_named_with_what_to_do() {
        // 1/(1 + T s), T = 1 s: at 1 Hz its gain is 1/6.4 of that at rest.
        let slow = told(vec![Term::new(1.0, 0.0), Term::new(1.0, 1.0)], 2);
        assert!(slow[0].text.contains("clipped at its range, 0 to 10 V, in 2 of 3 samples"), "{slow:?}");
        assert_eq!(slow[0].advice, Some(Advice::DriveRange));
        assert!(slow[1].text.contains("6.4 times that at 1 Hz"), "{slow:?}");
        assert_eq!(slow[1].advice, Some(Advice::CreepThatEnds));
        let creeping = told(vec![Term::new(1.0, 0.05)], 0);
        assert!(creeping.len() == 1 && creeping[0].text.contains("gain at rest is infinite"), "{creeping:?}");
        assert_eq!(told(vec![Term::new(1.0, 0.0), Term::new(1e-4, 1.0)], 0), Vec::new());
    }
}
