//! Magnitudes implausible for a piezo actuator: almost always a wrong unit in the file's header.
//!
//! Limits, with room to spare on either side of what is sold: strokes of amplified stacks and benders end at
//! about 1 to 2 mm, of tip-tilt stages at about 50 mrad; nothing is identified from a nanometre; stacks are
//! driven with up to 200 V, high-voltage stacks, tubes and macro-fibre patches with up to 1.5 kV;
//! displacement sensors end at some 10 kHz. Crossing a limit is a question to the user, never a refusal; crossing
//! those of drive and stroke at once is no question, where a soft electrostatic actuator does so.

use hysteron_numeric::display::short;

use super::{InputOutput, Quantity, Unit, range_of};

/// Strokes \[µm\] and \[µrad\] outside of which a unit is doubted.
const STROKE_UM: (f64, f64) = (1e-3, 2e3);
const STROKE_URAD: (f64, f64) = (1e-3, 2e5);
/// Largest |u| \[V\].
const LARGEST_V: f64 = 2e3;
/// Largest drive \[V\] and stroke \[µm\] of soft electrostatic actuators (dielectric elastomers, HASEL), which
/// are beyond both limits of a piezo actuator at once: kilovolts move millimetres.
const SOFT: (f64, f64) = (2e4, 1e5);
/// A sample rate \[Hz\] that is doubted where the drive takes more than [`SAMPLES_A_CYCLE`] for its fastest
/// cycle.
const FAST_SAMPLING_HZ: f64 = 1e5;
const SAMPLES_A_CYCLE: f64 = 50.0;
/// A fastest cycle \[s\] that is doubted.
const SLOWEST_CYCLE_S: f64 = 600.0;

/// Quantities of a record that are implausible for a piezo actuator, in plain words. `fastest_hz`: the
/// drive's highest frequency, if known.
pub fn implausible_units(data: &InputOutput, fastest_hz: Option<f64>) -> Vec<String> {
    let of_piezo = if is_soft(data) { [None, None] } else { [stroke(data), voltage(data)] };
    of_piezo.into_iter().chain([time(data, fastest_hz)]).flatten().collect()
}

/// True for drive and stroke of a soft electrostatic actuator.
fn is_soft(data: &InputOutput) -> bool {
    let ((u, to_v), (y, to_um)) = (data.u_unit.base(), data.y_unit.base());
    let within = |value: f64, least: f64, most: f64| value > least && value <= most;
    (u, y) == (Quantity::Voltage, Quantity::Length)
        && within(to_v * largest(data), LARGEST_V, SOFT.0)
        && within(to_um * moved(data), STROKE_UM.1, SOFT.1)
}

/// Largest drive, in its unit.
fn largest(data: &InputOutput) -> f64 {
    let (low, high) = range_of(&data.u);
    high.abs().max(low.abs())
}

/// Range of the valid output, in its unit.
fn moved(data: &InputOutput) -> f64 {
    let valid = |k: usize| data.is_valid(k);
    let output: Vec<f64> = data.y.iter().enumerate().filter(|(k, _)| valid(*k)).map(|(_, y)| *y).collect();
    let (low, high) = range_of(&output);
    high - low
}

fn stroke(data: &InputOutput) -> Option<String> {
    let (quantity, factor) = data.y_unit.base();
    let ((smallest, largest), scales): (_, &[&str]) = match quantity {
        Quantity::Length => (STROKE_UM, &LENGTHS),
        Quantity::Angle => (STROKE_URAD, &ANGLES),
        _ => return None,
    };
    let stroke = factor * moved(data);
    // A constant output is another matter.
    if !(stroke > 0.0 && stroke.is_finite()) || (smallest..=largest).contains(&stroke) {
        return None;
    }
    let (size, unit) = readable(stroke, scales);
    let name = &data.output;
    Some(format!(
        "A stroke of {} {unit} is implausible for a piezo actuator (expected {}): is the column `{name}` \
         really in the unit its header names?",
        short(size),
        if quantity == Quantity::Length { "1 nm to 2 mm" } else { "1 nrad to 200 mrad" }
    ))
}

fn voltage(data: &InputOutput) -> Option<String> {
    let (Quantity::Voltage, factor) = data.u_unit.base() else { return None };
    // The output of a piezo actuator is a motion.
    if !matches!(data.y_unit.base().0, Quantity::Length | Quantity::Angle) {
        return None;
    }
    let largest = factor * largest(data);
    (largest > LARGEST_V && largest.is_finite()).then(|| {
        format!(
            "A drive of {} kV is implausible for a piezo actuator (expected at most 2 kV): is the column \
             `{}` really in the unit its header names?",
            short(1e-3 * largest),
            data.input
        )
    })
}

fn time(data: &InputOutput, fastest_hz: Option<f64>) -> Option<String> {
    let (rate, fastest) = (data.sample_rate_hz()?, fastest_hz.filter(|f| *f > 0.0)?);
    let asked = "is the time column really in the unit its header names, or the sample rate right?";
    if rate >= FAST_SAMPLING_HZ && rate > SAMPLES_A_CYCLE * fastest {
        return Some(format!(
            "{} kHz is a very fast sampling for a drive that takes {:.0} samples a cycle (sensors end at \
             some 10 kHz): {asked}",
            short(1e-3 * rate),
            rate / fastest
        ));
    }
    (1.0 > SLOWEST_CYCLE_S * fastest).then(|| {
        format!(
            "The drive's fastest cycle takes {} s, very long for an experiment: {asked}",
            short(1.0 / fastest)
        )
    })
}

const LENGTHS: [&str; 5] = ["m", "mm", "um", "nm", "pm"];
const ANGLES: [&str; 4] = ["rad", "mrad", "urad", "nrad"];

/// A value in the base unit as one of 1 to 1000 of the largest unit that allows it.
fn readable(value: f64, units: &[&str]) -> (f64, Unit) {
    let scaled = |symbol: &str| (value / Unit::new(symbol).base().1, Unit::new(symbol));
    let smallest = units.last().copied().unwrap_or_default();
    units.iter().map(|symbol| scaled(symbol)).find(|(size, _)| *size >= 1.0).unwrap_or(scaled(smallest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{TimeBase, inspect};

    /// A loop of `stroke_um` at 1 Hz and 200 Hz sampling, its time axis stretched by `slower`.
    fn record(stroke_um: f64, volts: f64, slower: f64) -> InputOutput {
        let angle = |k: i32| std::f64::consts::TAU * f64::from(k) / 200.0;
        let u = (0..2000).map(|k| 0.5 * volts * (1.0 - angle(k).cos())).collect();
        let y = (0..2000).map(|k| 0.5 * stroke_um * (1.0 - angle(k - 3).cos())).collect();
        let mut data = InputOutput::new("r", TimeBase::uniform(200.0 / slower), u, y).unwrap();
        (data.u_unit, data.y_unit) = (Unit::new("V"), Unit::new("um"));
        data
    }

    #[test]
    fn ordinary_records_pass_and_a_wrong_unit_is_asked_about() {
        let soft = record(21e3, 8e3, 1.0);
        for data in [record(49.0, 100.0, 1.0), record(0.01, 1.0, 1.0), record(1500.0, 1500.0, 20.0), soft] {
            assert_eq!(implausible_units(&data, Some(1.0)), Vec::<String>::new());
        }
        for (data, part) in [
            (record(49e3, 100.0, 1.0), "A stroke of 49 mm is implausible"),
            (record(49e-5, 100.0, 1.0), "A stroke of 490 pm is implausible"),
            (record(49.0, 3600.0, 1.0), "A drive of 3.6 kV is implausible"),
            (record(49.0, 100.0, 1e-3), "200 kHz is a very fast sampling"),
            (record(49.0, 100.0, 1e3), "fastest cycle takes 1000 s"),
        ] {
            let warnings: Vec<_> = inspect(&data).findings.into_iter().filter(|f| f.is_warning()).collect();
            assert_eq!(warnings.len(), 1, "{warnings:?}");
            assert!(warnings[0].text.contains(part), "{part}: {}", warnings[0].text);
        }
    }

    #[test]
    fn other_quantities_have_no_limits() {
        let mut data = record(1e9, 1e9, 1.0);
        (data.u_unit, data.y_unit) = (Unit::new("A_per_m"), Unit::new("T"));
        assert_eq!(implausible_units(&data, None), Vec::<String>::new());
        data.y_unit = Unit::new("urad");
        assert!(implausible_units(&data, None)[0].contains("A stroke of 1000 rad"));
    }
}
