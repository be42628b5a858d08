//! Physical quantities of scheduled modes: those that do not depend on the scale of the states.
//!
//! Any state can be scaled, with its rows of B and H down and its columns of C up, and the model does the
//! same. Frequencies, dampings and gains do not change with it. Nor do the coefficients c of the hysteresis
//! times the gain of the strains relative to that of the inputs,
//!
//! ```text
//! c ‖G_w‖ / ‖G_u‖,   G_u = D + C (I − A)⁻¹ B,   G_w = D_h + C (I − A)⁻¹ H   at the highest level, at rest
//! ```
//!
//! the share of the motion that a term contributes per unit of it.

use hysteron_model::axes::{POWERS, ScheduledModes, linear_states};
use hysteron_model::model_file::{DerivedQuantity, SignalUnits};
use hysteron_numeric::Complex64;

/// Part of the model that a quantity belongs to; numbers from 0, modes in the order of their frequencies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// A mode.
    Mode(usize),
    /// From an input to an output.
    Path(usize, usize),
    /// A mode, from an input to an output.
    ModePath(usize, usize, usize),
    /// Hysteresis of the free strokes.
    Drive,
    /// Hysteresis of an actuator's stress.
    Stress(usize),
}

/// Name of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Name {
    /// Frequency at the lowest level \[Hz\].
    FrequencyLow,
    /// At the highest level.
    FrequencyHigh,
    /// Relative fall of the frequency from the lowest to the highest level.
    Fall,
    /// Damping ratio at the lowest level.
    DampingLow,
    /// At the highest level.
    DampingHigh,
    /// Gain at rest at the lowest level \[output unit/input unit\].
    GainLow,
    /// At the highest level.
    GainHigh,
    /// Share of the motion by c₂ \[1/input unit\].
    Square,
    /// By c₃ \[1/input unit²\].
    Cube,
    /// By the weight of a play.
    Play(usize),
}

/// A physical quantity of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// The part it belongs to.
    pub part: Part,
    /// Its name.
    pub name: Name,
    /// Its value.
    pub value: f64,
    /// Standard error; `None` where the records do not determine it, or after a stop.
    pub std_error: Option<f64>,
}

/// Modes by ascending frequency at the highest level.
pub(super) fn order(model: &ScheduledModes) -> Vec<usize> {
    let modes = model.modes_at(model.level.state(model.level.highest));
    let mut order: Vec<usize> = (0..modes.len()).collect();
    order.sort_by(|&a, &b| modes[a].frequency_hz.total_cmp(&modes[b].frequency_hz));
    order
}

/// The quantities of a model, its modes in this `order`; those of the lowest level only where the model was
/// identified at several.
pub(super) fn quantities(model: &ScheduledModes, order: &[usize]) -> Vec<Quantity> {
    let mut all = Vec::new();
    let mut add = |part, name, value| all.push(Quantity { part, name, value, std_error: None });
    let state = |level| model.level.state(level);
    let (low, high) = (state(model.level.lowest), state(model.level.highest));
    let several = low != high;
    let (at_low, at_high) = (model.modes_at(low), model.modes_at(high));
    for (k, &mode) in order.iter().enumerate() {
        let (low, high) = (at_low[mode], at_high[mode]);
        if several {
            add(Part::Mode(k), Name::FrequencyLow, low.frequency_hz);
            add(Part::Mode(k), Name::DampingLow, low.damping);
            add(Part::Mode(k), Name::Fall, 1.0 - high.frequency_hz / low.frequency_hz);
        }
        add(Part::Mode(k), Name::FrequencyHigh, high.frequency_hz);
        add(Part::Mode(k), Name::DampingHigh, high.damping);
    }
    let drive = AtRest::new(model, high, &model.input, &model.feedthrough, &model.feedthrough_slopes);
    let paths = || (0..model.inputs).flat_map(|i| (0..model.outputs).map(move |o| (i, o)));
    if several {
        let low = AtRest::new(model, low, &model.input, &model.feedthrough, &model.feedthrough_slopes);
        paths().for_each(|(i, o)| add(Part::Path(i, o), Name::GainLow, low.whole(model, i, o)));
    }
    paths().for_each(|(i, o)| add(Part::Path(i, o), Name::GainHigh, drive.whole(model, i, o)));
    for (k, &mode) in order.iter().enumerate() {
        for (i, o) in paths() {
            add(Part::ModePath(k, i, o), Name::GainHigh, drive.of_mode(mode, i, o));
        }
    }
    let Some(feedback) = &model.feedback else { return all };
    let none = vec![0.0; model.strain_feedthrough.len()];
    let strain = AtRest::new(model, high, &model.strain_input, &model.strain_feedthrough, &none);
    let size = |of: &AtRest| paths().map(|(i, o)| of.whole(model, i, o).powi(2)).sum::<f64>().sqrt();
    let share = size(&strain) / size(&drive).max(f64::MIN_POSITIVE);
    let stress = feedback.stress.iter().enumerate().map(|(i, law)| (Part::Stress(i), law));
    for (part, law) in std::iter::once((Part::Drive, &feedback.drive)).chain(stress) {
        for (term, c) in law.coefficients.iter().enumerate() {
            let name = match term {
                0 => Name::Square,
                1 => Name::Cube,
                _ => Name::Play(term - POWERS),
            };
            add(part, name, share * c);
        }
    }
    all
}

/// States and outputs under constant unit forces at one level.
struct AtRest {
    /// States, a list per input.
    states: Vec<Vec<f64>>,
    output: Vec<f64>,
    feedthrough: Vec<f64>,
}

impl AtRest {
    fn new(model: &ScheduledModes, s: f64, input: &[f64], feedthrough: &[f64], slopes: &[f64]) -> Self {
        let at = model.at(s);
        let one = Complex64::new(1.0, 0.0);
        let states = |i: usize| {
            let force = |k: usize| Complex64::new(input[k * model.inputs + i], 0.0);
            let x = linear_states(&at.transition, model.modes, one, force);
            x.into_iter().map(|x| x.re).collect()
        };
        Self {
            states: (0..model.inputs).map(states).collect(),
            output: at.output,
            feedthrough: feedthrough.iter().zip(slopes).map(|(d, slope)| d + s * slope).collect(),
        }
    }

    fn row(&self, i: usize, o: usize) -> impl Iterator<Item = f64> {
        let states = &self.states[i];
        let row = &self.output[o * states.len()..(o + 1) * states.len()];
        row.iter().zip(states).map(|(c, x)| c * x)
    }

    fn whole(&self, model: &ScheduledModes, i: usize, o: usize) -> f64 {
        self.row(i, o).sum::<f64>() + self.feedthrough[o * model.inputs + i]
    }

    fn of_mode(&self, mode: usize, i: usize, o: usize) -> f64 {
        self.row(i, o).skip(2 * mode).take(2).sum()
    }
}

impl Quantity {
    /// Entry of the model file, for channels of these names and units.
    pub fn entry(&self, inputs: &[String], outputs: &[String], units: &SignalUnits) -> DerivedQuantity {
        let input = |i: usize| inputs.get(i).cloned().unwrap_or_default();
        let output = |o: usize| outputs.get(o).cloned().unwrap_or_default();
        let of = match self.part {
            Part::Mode(k) => format!("mode {}", k + 1),
            Part::Path(i, o) => format!("{} to {}", input(i), output(o)),
            Part::ModePath(k, i, o) => format!("mode {}, {} to {}", k + 1, input(i), output(o)),
            Part::Drive => "free strokes".to_owned(),
            Part::Stress(i) => format!("stress of {}", input(i)),
        };
        let per_input = format!("1/{}", units.input);
        let (name, unit) = match self.name {
            Name::FrequencyLow => ("frequency_lowest_level".to_owned(), "Hz".to_owned()),
            Name::FrequencyHigh => ("frequency_highest_level".to_owned(), "Hz".to_owned()),
            Name::Fall => ("frequency_fall".to_owned(), "1".to_owned()),
            Name::DampingLow => ("damping_lowest_level".to_owned(), "1".to_owned()),
            Name::DampingHigh => ("damping_highest_level".to_owned(), "1".to_owned()),
            Name::GainLow => ("gain_lowest_level".to_owned(), format!("{}/{}", units.output, units.input)),
            Name::GainHigh => ("gain_highest_level".to_owned(), format!("{}/{}", units.output, units.input)),
            Name::Square => ("square".to_owned(), per_input),
            Name::Cube => ("cube".to_owned(), per_input + "^2"),
            Name::Play(j) => (format!("play_{}", j + 1), "1".to_owned()),
        };
        DerivedQuantity { of, name, value: self.value, unit, std_error: self.std_error }
    }
}
