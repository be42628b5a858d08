//! Identified modes in tables, with standard errors: frequencies and dampings, gains, weights of the
//! hysteresis.

use hysteron_identify::modes::{ModesIdentification, Part, Quantity, QuantityName};
use hysteron_model::Model;
use hysteron_model::model_file::{SignalUnits, typographic};

use super::{Listing, in_unit};
use crate::number::{significant, with_std_error};

/// Note under the gains.
pub const ABOUT_GAINS: &str = "Gains of the linear part for a constant input.";
/// Note under the weights.
pub const ABOUT_WEIGHTS: &str = "Coefficients times the gain of the strains relative to that of the inputs: \
    the share of the motion that a term contributes per unit of it. The radii of the plays differ from row \
    to row.";

/// Names of the channels and units as printed.
pub struct Names {
    /// Inputs.
    pub inputs: Vec<String>,
    /// Outputs.
    pub outputs: Vec<String>,
    /// Unit of the inputs.
    pub input_unit: String,
    /// Unit of the outputs.
    pub output_unit: String,
    /// Unit of a gain.
    pub gain_unit: String,
}

impl Names {
    /// Of a model of several axes.
    pub fn of(model: &Model) -> Self {
        let (inputs, outputs) = model.channels().unwrap_or_default();
        let SignalUnits { input, output } = model.units();
        let (input_unit, output_unit) = (typographic(input), typographic(output));
        let gain_unit = format!("{output_unit}/{input_unit}");
        Self { inputs: inputs.to_vec(), outputs: outputs.to_vec(), input_unit, output_unit, gain_unit }
    }
}

fn find(found: &ModesIdentification, part: Part, name: QuantityName) -> Option<&Quantity> {
    found.quantities.iter().find(|q| q.part == part && q.name == name)
}

/// Value ± standard error, times `scale`.
fn cell(quantity: Option<&Quantity>, scale: f64) -> String {
    let Some(q) = quantity else { return "–".to_owned() };
    match q.std_error {
        Some(error) => {
            let (value, error) = with_std_error(scale * q.value, Some(scale * error));
            if error.is_empty() { value } else { format!("{value} ± {error}") }
        }
        None => significant(scale * q.value, 4),
    }
}

/// Every mode at the lowest and the highest level.
pub fn modes(found: &ModesIdentification) -> Listing {
    use QuantityName::{DampingHigh, DampingLow, Fall, FrequencyHigh, FrequencyLow};
    let mut table = Listing::new([
        "mode",
        "frequency, lowest level [Hz]",
        "highest level [Hz]",
        "fall [%]",
        "damping, lowest level [%]",
        "highest level [%]",
    ]);
    for k in 0..found.modes.len() {
        let of = |name, scale| cell(find(found, Part::Mode(k), name), scale);
        table.push([
            (k + 1).to_string(),
            of(FrequencyLow, 1.0),
            of(FrequencyHigh, 1.0),
            of(Fall, 100.0),
            of(DampingLow, 100.0),
            of(DampingHigh, 100.0),
        ]);
    }
    table
}

/// Gains at rest from every input to every output.
pub fn gains(found: &ModesIdentification, names: &Names) -> Listing {
    let mut table = Listing::new([
        "input".to_owned(),
        "output".to_owned(),
        in_unit("gain at rest, lowest level", &names.gain_unit),
        in_unit("highest level", &names.gain_unit),
    ]);
    for (i, input) in names.inputs.iter().enumerate() {
        for (o, output) in names.outputs.iter().enumerate() {
            let of = |name| cell(find(found, Part::Path(i, o), name), 1.0);
            table.push([
                input.clone(),
                output.clone(),
                of(QuantityName::GainLow),
                of(QuantityName::GainHigh),
            ]);
        }
    }
    table
}

/// Weights of the hysteresis, a row per strain; `None` without hysteresis.
pub fn weights(found: &ModesIdentification, names: &Names) -> Option<Listing> {
    let plays = found.model.feedback.as_ref()?.drive.radii.len();
    let mut columns = vec![
        "strain of".to_owned(),
        in_unit("square", &format!("1/{}", names.input_unit)),
        in_unit("cube", &format!("1/{}²", names.input_unit)),
    ];
    columns.extend((0..plays).map(|j| format!("play {}", j + 1)));
    let mut table = Listing::new(columns);
    let stress =
        names.inputs.iter().enumerate().map(|(i, name)| (Part::Stress(i), format!("stress, {name}")));
    for (part, name) in std::iter::once((Part::Drive, "free strokes".to_owned())).chain(stress) {
        let terms = [QuantityName::Square, QuantityName::Cube].into_iter();
        let terms = terms.chain((0..plays).map(QuantityName::Play));
        let cells = terms.map(|name| cell(find(found, part, name), 1.0));
        table.push(std::iter::once(name).chain(cells));
    }
    Some(table)
}
