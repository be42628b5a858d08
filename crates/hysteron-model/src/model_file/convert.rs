//! Conversion between a model and its file.

use super::{
    DynamicsBlock, DynamicsKind, FORMAT, HysteresisBlock, HysteresisKind, Kind, ModelFile, ModelFileError,
    Normalisation, Parameters, Quantity, SignalUnits, TermEntry, VERSION, polynomial_name,
};
use crate::dynamics::{Arx, Dynamics, Term, TransferFunction};
use crate::hammerstein::Model;
use crate::hysteresis::{BoucWen, DriveSpan, Family, FamilyForm, Hysteresis, HysteresisForm, NumberUnit};

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

    /// Of β and γ.
    pub fn shape(&self, n: f64) -> String {
        if n == 1.0 { format!("1/{}", self.input) } else { self.shape_of_any_n() }
    }

    pub fn shape_of_any_n(&self) -> String {
        format!("{}^(1-n)/{}", self.output, self.input)
    }

    /// Of a number of a family.
    pub fn product(&self, unit: NumberUnit) -> String {
        unit.of(&self.input, &self.output)
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
        let hysteresis = match self.hysteresis.kind.family() {
            HysteresisForm::BoucWen => Hysteresis::BoucWen(bouc_wen(parameters)?),
            HysteresisForm::Family(form) => Hysteresis::Family(family(form, parameters)?),
        };
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

fn parameters(block: &Hysteresis, units: &Units) -> Parameters {
    let mut parameters = Parameters::default();
    for (i, &coefficient) in block.polynomial().iter().enumerate() {
        parameters.set(&polynomial_name(i + 1), Quantity::new(coefficient, units.polynomial(i + 1)));
    }
    let own: Vec<String> = match block {
        // Of α, β, γ, n: in the file β and γ are those of the article, whose unit goes with n.
        Hysteresis::BoucWen(b) => {
            vec![units.polynomial(1), units.shape(b.n), units.shape(b.n), "1".into()]
        }
        Hysteresis::Family(_) => {
            let (form, elements) = (block.form().description(), block.form().elements());
            let shape = form.shape_numbers(elements, &DriveSpan::UNIT).into_iter().map(|number| number.unit);
            let weights = (0..block.form().columns()).map(|index| form.weight_unit(index));
            shape.chain(weights).map(|unit| units.product(unit)).collect()
        }
    };
    for ((name, value), unit) in block.numbers().into_iter().zip(own) {
        parameters.set(&name, Quantity::new(value, unit));
    }
    parameters
}

/// Names and units of a family's numbers, in file order.
pub(super) fn numbers_of(form: FamilyForm) -> Vec<(String, NumberUnit)> {
    form.shape_numbers().into_iter().chain(form.weight_numbers()).collect()
}

/// The family with as many weights as the file has.
pub(super) fn sized(form: FamilyForm, parameters: &Parameters) -> Result<FamilyForm, ModelFileError> {
    let weights = (1..).take_while(|i| parameters.get(&format!("weight_{i}")).is_some()).count();
    let missing = || ModelFileError::MissingParameter { name: format!("weight_{}", weights + 1) };
    form.with_weights(weights).ok_or_else(missing)
}

fn family(form: FamilyForm, parameters: &Parameters) -> Result<Family, ModelFileError> {
    let form = sized(form, parameters)?;
    let values = |numbers: Vec<(String, NumberUnit)>| {
        let value = |name: String| match parameters.get(&name) {
            Some(quantity) => Ok(quantity.value),
            None => Err(ModelFileError::MissingParameter { name }),
        };
        numbers.into_iter().map(|(name, _)| value(name)).collect::<Result<Vec<f64>, _>>()
    };
    let (shape, weights) = (values(form.shape_numbers())?, values(form.weight_numbers())?);
    Ok(Family { polynomial: polynomial(parameters), form, shape, weights })
}

fn polynomial(parameters: &Parameters) -> Vec<f64> {
    (1..).map_while(|i| parameters.get(&polynomial_name(i))).map(|q| q.value).collect()
}

fn bouc_wen(parameters: &Parameters) -> Result<BoucWen, ModelFileError> {
    let value = |name: &str| {
        let missing = || ModelFileError::MissingParameter { name: name.to_owned() };
        parameters.get(name).map(|q| q.value).ok_or_else(missing)
    };
    Ok(BoucWen {
        polynomial: polynomial(parameters),
        alpha: value("alpha")?,
        beta: value("beta")?,
        gamma: value("gamma")?,
        n: value("n")?,
    })
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
