//! Conversion between a model and its file.

use super::{
    DynamicsBlock, DynamicsKind, FORMAT, HysteresisBlock, HysteresisKind, Kind, ModelFile, ModelFileError,
    Normalisation, Parameters, Quantity, SignalUnits, TermEntry, VERSION, polynomial_name,
};
use crate::dynamics::{Arx, Dynamics, Term, TransferFunction};
use crate::hammerstein::Model;
use crate::hysteresis::{Hysteresis, HysteresisForm, ModelNumber, NumberUnit, Place};

/// Units of a model's numbers, from the units of its signals.
pub(super) struct Units {
    pub input: String,
    pub output: String,
}

impl Units {
    pub fn new(signals: &SignalUnits) -> Self {
        let or_one = |unit: &str| if unit.is_empty() { "1".to_owned() } else { unit.to_owned() };
        Units { input: or_one(&signals.input), output: or_one(&signals.output) }
    }

    /// Of the coefficient of uⁱ.
    pub fn polynomial(&self, degree: usize) -> String {
        match degree {
            1 => format!("{}/{}", self.output, self.input),
            _ => format!("{}/{}^{degree}", self.output, self.input),
        }
    }

    /// Of a number of a family with this exponent n, if it has one.
    pub fn product(&self, unit: NumberUnit, exponent: Option<f64>) -> String {
        let without_exponent = unit.falls_with_exponent && exponent == Some(1.0);
        NumberUnit { falls_with_exponent: unit.falls_with_exponent && !without_exponent, ..unit }
            .of(&self.input, &self.output)
    }

    /// Of |du/dt|.
    pub fn rate(&self) -> String {
        format!("{}/s", self.input)
    }

    /// Of the coefficient of s^order.
    pub fn coefficient(order: f64) -> String {
        if order == 0.0 {
            "1".into()
        } else if order == 1.0 {
            "s".into()
        } else {
            format!("s^{order}")
        }
    }
}

impl ModelFile {
    /// File of a model whose signals have the given units; without standard errors, range, provenance or
    /// scores.
    pub fn from_model(model: &Model, signals: SignalUnits) -> Self {
        let units = Units::new(&signals);
        let hysteresis = HysteresisBlock {
            kind: HysteresisKind::of(&model.hysteresis),
            parameters: parameters(&model.hysteresis, &units),
        };
        let dynamics = match &model.dynamics {
            Dynamics::None => {
                DynamicsBlock { kind: DynamicsKind::None, numerator: Vec::new(), denominator: Vec::new() }
            }
            Dynamics::Integer(g) => transfer_function(DynamicsKind::Integer, g),
            Dynamics::Fractional(g) => transfer_function(DynamicsKind::Fractional, g),
            Dynamics::Arx(arx) => DynamicsBlock {
                kind: DynamicsKind::Arx,
                numerator: powers_of_z(&arx.b),
                denominator: powers_of_z(&[&[1.0], arx.a.as_slice()].concat()),
            },
        };
        ModelFile {
            format: FORMAT.into(),
            version: VERSION,
            kind: Kind::Hammerstein,
            name: None,
            hysteresis,
            dynamics,
            delay: Quantity::new(model.delay_s, "s"),
            offset: Quantity::new(model.offset, units.output),
            units: signals,
            scheme: model.scheme,
            inter_sample: model.inter_sample,
            sample_rate_hz: model.sample_rate_hz,
            normalisation: Normalisation::default(),
            start: super::StartEntry::default(),
            valid_range: None,
            provenance: None,
            scores: Vec::new(),
            correlation: None,
            misfit: None,
        }
    }

    /// The model in the file.
    ///
    /// # Errors
    /// Those of [`ModelFile::check`].
    pub fn to_model(&self) -> Result<Model, ModelFileError> {
        self.check()?;
        let values = |list: &[TermEntry]| list.iter().map(|t| t.coefficient.value).collect::<Vec<f64>>();
        let terms = |list: &[TermEntry]| {
            list.iter().map(|t| Term { coefficient: t.coefficient.value, order: t.order.value }).collect()
        };
        let block = &self.dynamics;
        let in_s = || TransferFunction {
            numerator: terms(&block.numerator),
            denominator: terms(&block.denominator),
        };
        let dynamics = match block.kind {
            DynamicsKind::None => Dynamics::None,
            DynamicsKind::Integer => Dynamics::Integer(in_s()),
            DynamicsKind::Fractional => Dynamics::Fractional(in_s()),
            DynamicsKind::Arx => Dynamics::Arx(Arx {
                a: values(block.denominator.get(1..).unwrap_or_default()),
                b: values(&block.numerator),
            }),
        };
        let parameters = &self.hysteresis.parameters;
        let hysteresis = operator(self.hysteresis.kind.family(), parameters)?;
        Ok(Model {
            hysteresis,
            dynamics,
            offset: self.offset.value,
            delay_s: self.delay.value,
            scheme: self.scheme,
            inter_sample: self.inter_sample,
            sample_rate_hz: self.sample_rate_hz,
        })
    }
}

pub(super) fn parameters(block: &Hysteresis, units: &Units) -> Parameters {
    let mut parameters = Parameters::default();
    for (i, &coefficient) in block.polynomial().iter().enumerate() {
        parameters.set(&polynomial_name(i + 1), Quantity::new(coefficient, units.polynomial(i + 1)));
    }
    let units_of = block.form().model_numbers().into_iter().map(|number| number.unit);
    let exponent = block.number(EXPONENT);
    for ((name, value), unit) in block.numbers().into_iter().zip(units_of) {
        parameters.set(&name, Quantity::new(value, units.product(unit, exponent)));
    }
    parameters
}

/// Name of a family's exponent n.
pub(super) const EXPONENT: &str = "n";

/// The family with as many weights as the file has.
pub(super) fn sized(form: HysteresisForm, parameters: &Parameters) -> Result<HysteresisForm, ModelFileError> {
    if form.description().elements().is_none() {
        return Ok(form);
    }
    let weights = (1..).take_while(|i| parameters.get(&format!("weight_{i}")).is_some()).count();
    let missing = || ModelFileError::MissingParameter { name: format!("weight_{}", weights + 1) };
    form.with_weights(weights).ok_or_else(missing)
}

pub(super) fn operator(form: HysteresisForm, parameters: &Parameters) -> Result<Hysteresis, ModelFileError> {
    let form = sized(form, parameters)?;
    let (mut shape, mut weights) = (vec![0.0; form.shape_names().len()], vec![0.0; form.columns()]);
    for ModelNumber { name, place, .. } in form.model_numbers() {
        let Some(quantity) = parameters.get(&name) else {
            return Err(ModelFileError::MissingParameter { name });
        };
        match place {
            Place::Shape(index) => shape[index] = quantity.value,
            Place::Weight(index) => weights[index] = quantity.value,
        }
    }
    Ok(Hysteresis::unchecked(polynomial(parameters), form, shape, weights))
}

fn polynomial(parameters: &Parameters) -> Vec<f64> {
    (1..).map_while(|i| parameters.get(&polynomial_name(i))).map(|q| q.value).collect()
}

fn transfer_function(kind: DynamicsKind, g: &TransferFunction) -> DynamicsBlock {
    let entries = |terms: &[Term]| {
        terms
            .iter()
            .map(|t| TermEntry {
                coefficient: Quantity::new(t.coefficient, Units::coefficient(t.order)),
                order: Quantity::new(t.order, "1"),
            })
            .collect()
    };
    DynamicsBlock { kind, numerator: entries(&g.numerator), denominator: entries(&g.denominator) }
}

fn powers_of_z(coefficients: &[f64]) -> Vec<TermEntry> {
    let entry = |(i, &c): (usize, &f64)| TermEntry {
        coefficient: Quantity::new(c, "1"),
        order: Quantity::new(i as f64, "1"),
    };
    coefficients.iter().enumerate().map(entry).collect()
}
