//! Checks of a model file beyond its types.

use super::start::StartKind;
use super::{
    DynamicsKind, FORMAT, Interval, Kind, ModelFile, ModelFileError, ModesScoreEntry, Parameters, Quantity,
    ScoreEntry, TermEntry, VERSION, ValidRange,
    convert::{EXPONENT, Units, sized},
    polynomial_name,
};
use crate::hysteresis::{HysteresisForm, ModelNumber, Place};
use crate::record::{MOST_MAGNITUDE, RATES_HZ};

// What a file may ask for: memory and time to realise a model grow with the square of these, and a fit ends far
// below them.
/// Terms of a numerator or denominator in s.
const MOST_TERMS: usize = 64;
/// Terms in 1/z: a delay before them is as many zeros.
const MOST_ARX_TERMS: usize = 4096;
/// Numbers of the hysteresis block.
const MOST_NUMBERS: usize = 4096;
/// Degree of the polynomial.
const MOST_DEGREE: usize = 32;
/// Saturating terms of a force.
pub(super) const MOST_SATURATING: usize = 64;
/// Paths of coupled branches, inputs by outputs.
pub(super) const MOST_PATHS: usize = 4096;

impl ModelFile {
    /// Checks everything that is not a matter of types: version, finite numbers, ranges, units, parameter
    /// names, terms that suit the kind of dynamics, a correlation matrix that is one.
    ///
    /// # Errors
    /// [`ModelFileError`] naming the first offending place.
    pub fn check(&self) -> Result<(), ModelFileError> {
        header(&self.format, self.version, (self.kind, Kind::Hammerstein))?;
        let units = Units::new(&self.units);
        let parameters = &self.hysteresis.parameters;
        family(self.hysteresis.kind.family(), parameters, &units)?;
        self.dynamics()?;
        quantity("delay", &self.delay, "s", Some(0.0))?;
        quantity("offset", &self.offset, &units.output, None)?;
        if let Some(rate) = self.sample_rate_hz {
            sample_rate(rate)?;
        }
        if let Some(voltage) = &self.start.voltage {
            if self.start.kind != StartKind::Rest {
                return Err(ModelFileError::VoltageOfSettledStart);
            }
            quantity("start.voltage", voltage, &units.input, None)?;
        }
        valid_range(self.valid_range.as_ref(), &units)?;
        self.check_correlation()?;
        if let Some(misfit) = &self.misfit {
            misfit.check()?;
        }
        self.scores.iter().enumerate().try_for_each(|(i, s)| score(i, s))
    }

    fn dynamics(&self) -> Result<(), ModelFileError> {
        let kind = self.dynamics.kind;
        let lists = [
            ("dynamics.numerator", &self.dynamics.numerator),
            ("dynamics.denominator", &self.dynamics.denominator),
        ];
        for (path, list) in lists {
            let complain = |expected| Err(ModelFileError::Terms { path, terms: list.len(), expected });
            match (kind, list.is_empty()) {
                (DynamicsKind::None, true) => continue,
                (DynamicsKind::None, false) => return complain("no terms for the kind \"none\""),
                (_, true) => return complain("at least one term"),
                (DynamicsKind::Arx, false) if list.len() > MOST_ARX_TERMS => {
                    return complain("at most 4096 terms");
                }
                (DynamicsKind::Integer | DynamicsKind::Fractional, false) if list.len() > MOST_TERMS => {
                    return complain("at most 64 terms");
                }
                (_, false) => terms(path, list, kind)?,
            }
        }
        match (kind, self.dynamics.denominator.first(), self.dynamics.denominator.last()) {
            (DynamicsKind::Arx, Some(leading), _) => {
                let expected = "1, the coefficient of the output itself";
                let value = leading.coefficient.value;
                allowed("dynamics.denominator[0].coefficient.value", value, value == 1.0, expected)?;
                if self.sample_rate_hz.is_none() {
                    return Err(ModelFileError::ArxWithoutSampleRate);
                }
            }
            (DynamicsKind::Integer | DynamicsKind::Fractional, _, Some(highest)) => {
                let path = format!(
                    "dynamics.denominator[{}].coefficient.value",
                    self.dynamics.denominator.len() - 1
                );
                let value = highest.coefficient.value;
                allowed(&path, value, value != 0.0, "a coefficient of the highest order that is not 0")?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// The degree of the polynomial.
fn polynomial(parameters: &Parameters, units: &Units) -> Result<usize, ModelFileError> {
    let mut degree = 0;
    while let Some(coefficient) = parameters.get(&polynomial_name(degree + 1)) {
        degree += 1;
        let path = format!("hysteresis.parameters.{}", polynomial_name(degree));
        quantity(&path, coefficient, &units.polynomial(degree), None)?;
    }
    if degree == 0 {
        return Err(ModelFileError::MissingParameter { name: "linear".into() });
    }
    Ok(degree)
}

/// The hysteresis block: polynomial, and the numbers of its family.
pub(super) fn family(
    form: HysteresisForm,
    parameters: &Parameters,
    units: &Units,
) -> Result<(), ModelFileError> {
    let numbers = parameters.iter().count();
    allowed("hysteresis.parameters", numbers as f64, numbers <= MOST_NUMBERS, "at most 4096 numbers")?;
    let degree = polynomial(parameters, units)?;
    allowed(
        "hysteresis.parameters",
        degree as f64,
        degree <= MOST_DEGREE,
        "a polynomial of degree 32 at most",
    )?;
    let form = sized(form, parameters)?;
    let numbers = form.model_numbers();
    let exponent = parameters.get(EXPONENT).map(|n| n.value);
    let missing = |name: &str| ModelFileError::MissingParameter { name: name.to_owned() };
    // Units may depend on the exponent, which has to be right first.
    if numbers.iter().any(|number| number.unit.falls_with_exponent) {
        let exponent = parameters.get(EXPONENT).ok_or_else(|| missing(EXPONENT))?;
        quantity(&format!("hysteresis.parameters.{EXPONENT}"), exponent, "1", Some(1.0))?;
    }
    for ModelNumber { name, unit, .. } in &numbers {
        let found = parameters.get(name).ok_or_else(|| missing(name))?;
        // A unit with the exponent in it is right for n = 1 as well.
        let [plain, general] = [exponent, None].map(|exponent| units.product(*unit, exponent));
        let expected = if found.unit == general { general } else { plain };
        quantity(&format!("hysteresis.parameters.{name}"), found, &expected, None)?;
    }
    let known: std::collections::HashSet<&str> = numbers.iter().map(|number| number.name.as_str()).collect();
    let is_known = |name: &str| known.contains(name) || (1..=degree).any(|i| polynomial_name(i) == name);
    if let Some((name, _)) = parameters.iter().find(|(name, _)| !is_known(name)) {
        let polynomial = "linear, quadratic, cubic, quartic, quintic, degree_6 … without gaps";
        let own: Vec<&str> = numbers.iter().map(|number| number.name.as_str()).collect();
        let expected = format!("{polynomial}, and {}", own.join(", "));
        return Err(ModelFileError::UnknownParameter { name: name.to_owned(), expected });
    }
    let mut shape = vec![f64::NAN; form.shape_names().len()];
    for number in &numbers {
        if let Place::Shape(index) = number.place {
            shape[index] = parameters.get(&number.name).map_or(f64::NAN, |q| q.value);
        }
    }
    form.check(&shape).map_err(|problem| ModelFileError::Shape { problem })
}

fn terms(path: &str, list: &[TermEntry], kind: DynamicsKind) -> Result<(), ModelFileError> {
    let mut previous = None;
    for (i, term) in list.iter().enumerate() {
        let order_path = format!("{path}[{i}].order");
        let coefficient_path = format!("{path}[{i}].coefficient");
        quantity(&order_path, &term.order, "1", Some(0.0))?;
        let order = term.order.value;
        let order_path = order_path + ".value";
        match kind {
            DynamicsKind::Arx => {
                allowed(&order_path, order, order == i as f64, "the powers 0, 1, 2, … of 1/z without gaps")?;
                quantity(&coefficient_path, &term.coefficient, "1", None)?;
            }
            _ => {
                let whole = kind != DynamicsKind::Integer || order.fract() == 0.0;
                allowed(&order_path, order, whole, "a whole number for the kind \"integer\"")?;
                let ascending = previous.is_none_or(|p| order > p);
                allowed(&order_path, order, ascending, "orders in ascending order, each once")?;
                power_of_seconds(&coefficient_path, &term.coefficient, order)?;
            }
        }
        previous = Some(order);
    }
    Ok(())
}

/// A coefficient of s^order: its unit is s^order, whichever way the exponent is written.
fn power_of_seconds(path: &str, coefficient: &Quantity, order: f64) -> Result<(), ModelFileError> {
    let exponent = match coefficient.unit.as_str() {
        "1" => Some(0.0),
        "s" => Some(1.0),
        unit => unit.strip_prefix("s^").and_then(|e| e.parse::<f64>().ok()),
    };
    if exponent == Some(order) {
        quantity(path, coefficient, &coefficient.unit, None)
    } else {
        quantity(path, coefficient, &Units::coefficient(order), None)
    }
}

pub(super) fn quantity(
    path: &str,
    quantity: &Quantity,
    unit: &str,
    least: Option<f64>,
) -> Result<(), ModelFileError> {
    let value = quantity.value;
    let value_path = format!("{path}.value");
    allowed(&value_path, value, value.is_finite(), "a finite number")?;
    allowed(&value_path, value, value.abs() <= MOST_MAGNITUDE, "a magnitude of at most 1e100")?;
    match least {
        Some(1.0) => allowed(&value_path, value, value >= 1.0, "a number of at least 1")?,
        Some(least) => allowed(&value_path, value, value >= least, "a number that is not negative")?,
        None => {}
    }
    if let Some(e) = quantity.std_error {
        allowed(
            &format!("{path}.std_error"),
            e,
            e.is_finite() && e >= 0.0,
            "a number that is not negative, or null",
        )?;
    }
    same_unit(path, &quantity.unit, unit)
}

/// Checks format, version and kind (found, expected).
pub(super) fn header(
    format: &str,
    version: u64,
    (found, expected): (Kind, Kind),
) -> Result<(), ModelFileError> {
    if format != FORMAT {
        return Err(ModelFileError::NotAModel { found: Some(format!("{format:?}")) });
    }
    if version != VERSION {
        return Err(ModelFileError::UnknownVersion { found: Some(version.to_string()) });
    }
    if found == expected { Ok(()) } else { Err(ModelFileError::OtherKind { expected, found }) }
}

/// Names of inputs and outputs: all there, none twice.
pub(super) fn channels(inputs: &[String], outputs: &[String]) -> Result<(), ModelFileError> {
    let mut names: Vec<&String> = inputs.iter().chain(outputs).collect();
    names.sort();
    match names.windows(2).find(|pair| pair[0] == pair[1] || pair[0].is_empty()) {
        Some(twice) => Err(ModelFileError::Channels { name: twice[0].clone() }),
        None => Ok(()),
    }
}

pub(super) fn sample_rate(rate: f64) -> Result<(), ModelFileError> {
    allowed("sample_rate_hz", rate, RATES_HZ.contains(&rate), "a rate from 1e-9 to 1e12 Hz")
}

pub(super) fn valid_range(range: Option<&ValidRange>, units: &Units) -> Result<(), ModelFileError> {
    let Some(range) = range else { return Ok(()) };
    interval("valid_range.input", &range.input, &units.input)?;
    if let Some(frequency) = &range.frequency {
        interval("valid_range.frequency", frequency, "Hz")?;
    }
    match &range.rate {
        Some(rate) => interval("valid_range.rate", rate, &units.rate()),
        None => Ok(()),
    }
}

pub(super) fn axes_score(index: usize, score: &ModesScoreEntry) -> Result<(), ModelFileError> {
    let path = format!("scores[{index}]");
    let mut numbers = score.output_rmse.iter().chain([&score.level, &score.rmse, &score.fit_percent]);
    numbers.try_for_each(|x| allowed(&path, *x, x.is_finite(), "finite numbers"))
}

pub(super) fn interval(path: &str, interval: &Interval, unit: &str) -> Result<(), ModelFileError> {
    let least = interval.low;
    allowed(&format!("{path}.low"), least, least.abs() <= MOST_MAGNITUDE, "a magnitude of at most 1e100")?;
    let high = interval.high;
    allowed(
        &format!("{path}.high"),
        high,
        high <= MOST_MAGNITUDE && high >= interval.low,
        "a number from `low` to 1e100",
    )?;
    same_unit(path, &interval.unit, unit)
}

pub(super) fn same_unit(path: &str, found: &str, expected: &str) -> Result<(), ModelFileError> {
    if found == expected {
        return Ok(());
    }
    Err(ModelFileError::WrongUnit {
        path: format!("{path}.unit"),
        found: found.to_owned(),
        expected: expected.to_owned(),
    })
}

pub(super) fn score(index: usize, score: &ScoreEntry) -> Result<(), ModelFileError> {
    let values = [
        ("offset", Some(score.offset)),
        ("rmse", Some(score.rmse)),
        ("max_abs_error", Some(score.max_abs_error)),
        ("rmse_percent_of_stroke", score.rmse_percent_of_stroke),
        ("max_percent_of_stroke", score.max_percent_of_stroke),
        ("fit_percent", score.fit_percent),
        ("relative_error", score.relative_error),
        ("loop_width_error_percent", score.loop_width_error_percent),
    ];
    for (key, value) in values {
        if let Some(value) = value {
            allowed(&format!("scores[{index}].{key}"), value, value.is_finite(), "a finite number")?;
        }
    }
    Ok(())
}

pub(super) fn allowed(
    path: &str,
    value: f64,
    holds: bool,
    expected: &'static str,
) -> Result<(), ModelFileError> {
    if holds { Ok(()) } else { Err(ModelFileError::NotAllowed { path: path.to_owned(), value, expected }) }
}
