//! A parameter of an identified model.

use hysteron_model::dynamics::FormParameter;
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{DriveSpan, Place};
use hysteron_model::model_file::{ModelFile, typographic};
use hysteron_model::record::Unit;

use super::joint::Interval;

/// One parameter of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Role in the model.
    pub role: ParameterRole,
    /// Name as on the command line.
    pub name: String,
    /// Value in V, µm, s, Hz.
    pub value: f64,
    /// Standard error; `None` where the parameter was held or the data do not determine it.
    pub std_error: Option<f64>,
    /// 95 % confidence interval; a joint fit only.
    pub interval: Option<Interval>,
    /// It was held at this value: by demand, or because this fit does not search it.
    pub held: bool,
}

/// Role of a parameter in the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterRole {
    /// Coefficient of this power of u.
    Polynomial(usize),
    /// Number of the hysteresis family.
    Hysteresis(Place),
    /// Parameter of the dynamic form.
    Dynamics(FormParameter),
    /// Gain at zero frequency of the dynamics of Eq. 13.
    Gain,
    /// Delay.
    Delay,
    /// Coefficient of Eq. 13, which follows from other parameters: b of the numerator, or c₀, c₁ of the
    /// denominator.
    Equation13(Equation13),
    /// Coefficient of a linear model identified on its own.
    Linear(LinearPart),
    /// Hysteresis memory at the start of the record of this index.
    Memory(usize),
}

/// Coefficients of Eq. 13, G = b / (s^α₂ + c₁ s^α₁ + c₀).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equation13 {
    /// b.
    Numerator,
    /// c₀.
    Constant,
    /// c₁.
    Middle,
}

/// Polynomial of a linear model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinearPart {
    /// B.
    Numerator,
    /// F, or A in continuous time.
    Denominator,
    /// C or D of the noise model C/D.
    Noise,
}

impl Parameter {
    pub(super) fn new(role: ParameterRole, name: &str, value: f64, std_error: Option<f64>) -> Self {
        Self { role, name: name.to_owned(), value, std_error, interval: None, held: false }
    }

    /// Block of the model it belongs to: `hysteresis`, `dynamics`, or `start` for the memory of a record.
    pub fn block(&self) -> &'static str {
        match self.role {
            ParameterRole::Polynomial(_) | ParameterRole::Hysteresis(_) => "hysteresis",
            ParameterRole::Memory(_) => "start",
            _ => "dynamics",
        }
    }

    /// Unit; empty for a number without one.
    pub fn unit(&self, file: &ModelFile) -> String {
        match self.role {
            ParameterRole::Polynomial(_) | ParameterRole::Hysteresis(_) => {
                let unit = file.hysteresis.parameters.get(&self.name).map_or("1", |quantity| &quantity.unit);
                if unit == "1" { String::new() } else { typographic(unit) }
            }
            ParameterRole::Dynamics(parameter) => parameter.unit.into(),
            ParameterRole::Delay => "s".into(),
            ParameterRole::Memory(_) => {
                let remembers_output = file.hysteresis.kind.family().description().remembers_output();
                let unit = if remembers_output { &file.units.output } else { &file.units.input };
                Unit::new(unit).to_string()
            }
            ParameterRole::Gain | ParameterRole::Equation13(_) | ParameterRole::Linear(_) => String::new(),
        }
    }

    /// Symbol; its name where it has none.
    pub fn symbol(&self) -> &str {
        match self.role {
            ParameterRole::Polynomial(1) => "l₁",
            ParameterRole::Polynomial(2) => "l₂",
            ParameterRole::Polynomial(3) => "l₃",
            ParameterRole::Dynamics(parameter) => parameter.symbol,
            ParameterRole::Gain => "K",
            ParameterRole::Delay => "τ",
            ParameterRole::Equation13(Equation13::Constant) => "c₀",
            ParameterRole::Equation13(Equation13::Middle) => "c₁",
            ParameterRole::Hysteresis(_) => greek(&self.name),
            _ => &self.name,
        }
    }

    /// Meaning in a few words, in this model.
    pub fn meaning(&self, model: &Model) -> String {
        let form = model.hysteresis.form();
        match self.role {
            ParameterRole::Polynomial(1) => "coefficient of u".into(),
            ParameterRole::Polynomial(2) => "coefficient of u²".into(),
            ParameterRole::Polynomial(3) => "coefficient of u³".into(),
            ParameterRole::Polynomial(_) => "polynomial coefficient".into(),
            ParameterRole::Hysteresis(Place::Weight(_)) if form.columns() == 1 => "size of the loop".into(),
            ParameterRole::Hysteresis(Place::Weight(_)) => "weight of a column".into(),
            ParameterRole::Hysteresis(Place::Shape(index)) => {
                let numbers = form.shape_numbers(&DriveSpan::UNIT);
                numbers.get(index).map_or_else(String::new, |number| number.meaning.into())
            }
            ParameterRole::Dynamics(parameter) => parameter.meaning.into(),
            ParameterRole::Gain => "gain at zero frequency".into(),
            ParameterRole::Delay => "delay".into(),
            ParameterRole::Equation13(Equation13::Numerator) => "numerator, K·c₀".into(),
            ParameterRole::Equation13(Equation13::Constant) => "coefficient of s⁰".into(),
            ParameterRole::Equation13(Equation13::Middle) => "coefficient of s^α₁".into(),
            ParameterRole::Linear(LinearPart::Numerator) => "coefficient of the numerator".into(),
            ParameterRole::Linear(LinearPart::Denominator) => "coefficient of the denominator".into(),
            ParameterRole::Linear(LinearPart::Noise) => "coefficient of the noise model C/D".into(),
            ParameterRole::Memory(_) => match form.description().remembers_output() {
                true => "hysteretic part z at the first sample".into(),
                false => "input of the demagnetised state before the first sample".into(),
            },
        }
    }
}

/// The letter that a name spells.
fn greek(name: &str) -> &str {
    match name {
        "alpha" => "α",
        "beta" => "β",
        "gamma" => "γ",
        "delta" => "δ",
        other => other,
    }
}
