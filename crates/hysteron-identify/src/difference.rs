//! Whether two models of the same structure differ by more than their standard errors.
//!
//! Number by number, z = (b − a)/√(σ_a² + σ_b²); all numbers whose correlation both files hold together,
//! d = b − a, by Wald's statistic d′ (C_a + C_b)⁻¹ d, which is χ² distributed with as many degrees of
//! freedom as the sum of the covariances has rank (A. Wald, *Trans. Amer. Math. Soc.* 54 (1943) 426,
//! doi:10.1090/S0002-9947-1943-0012401-3). Both assume independent records, and a model class that is true:
//! where the residual is systematic, standard errors are too small or too large and so are these figures.

use hysteron_model::Model;
use hysteron_model::model_file::{ModelFileError, Quantity};
use hysteron_numeric::distribution::chi_square_tail;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::Serialize;

use crate::recalibrate::SIGNIFICANT;

/// Directions whose variance is below this share of the largest are known from other numbers.
const RANK: f64 = 1e-9;

/// Why two models cannot be compared number by number.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DifferenceError {
    /// They are not of one structure.
    #[error("the models differ in {what}: {first} and {second}, so that their numbers mean different things")]
    Structure {
        /// `kind`, `hysteresis`, `dynamics` or `unit of NAME`.
        what: String,
        /// Of the first model.
        first: String,
        /// Of the second model.
        second: String,
    },
    /// Invalid data.
    #[error(transparent)]
    File(#[from] ModelFileError),
}

/// One number of two models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NumberDifference {
    /// Name in the model file.
    pub name: String,
    /// Unit of the values.
    pub unit: String,
    /// Value in the first model.
    pub first: f64,
    /// Its standard error.
    pub first_std_error: Option<f64>,
    /// Value in the second model.
    pub second: f64,
    /// Its standard error.
    pub second_std_error: Option<f64>,
    /// (second − first)/√(σ² + σ²); `None` unless both standard errors are known.
    pub in_standard_errors: Option<f64>,
    /// Probability of a larger one in two calibrations of an unchanged device.
    pub p: Option<f64>,
    /// More than [`SIGNIFICANT`] combined standard errors.
    pub significant: bool,
}

/// All numbers with a known correlation together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointDifference {
    /// Wald's statistic.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees: usize,
    /// Probability of a larger one in two calibrations of an unchanged device.
    pub p: f64,
    /// `p` below that of [`SIGNIFICANT`] standard errors of one number.
    pub significant: bool,
}

/// Difference of two models of one structure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Numbers of both, in the order of the model file.
    pub numbers: Vec<NumberDifference>,
    /// Names that only the first has.
    pub only_first: Vec<String>,
    /// Names that only the second has.
    pub only_second: Vec<String>,
    /// All numbers together; `None` where not both models state the correlation of some number.
    pub joint: Option<JointDifference>,
}

impl Difference {
    /// Whether the models differ: by the joint test where there is one, else by any number.
    pub fn is_significant(&self) -> bool {
        match &self.joint {
            Some(joint) => joint.significant,
            None => self.numbers.iter().any(|number| number.significant),
        }
    }
}

/// Compares two models of the same structure.
///
/// # Errors
/// [`DifferenceError`] for models of different kinds, families or units.
pub fn difference(first: &Model, second: &Model) -> Result<Difference, DifferenceError> {
    same_structure(first, second)?;
    let (a, b) = (first.numbers()?, second.numbers()?);
    let in_b = |name: &str| b.iter().find(|(other, _)| other == name).map(|(_, quantity)| quantity);
    let numbers = a.iter().filter_map(|(name, of_a)| Some((name, of_a, in_b(name)?)));
    let numbers = numbers.map(|(name, of_a, of_b)| number(name, of_a, of_b));
    let missing = |from: &[(String, Quantity)], to: &[(String, Quantity)]| {
        let names = from.iter().map(|(name, _)| name);
        names.filter(|name| !to.iter().any(|(other, _)| other == *name)).cloned().collect()
    };
    Ok(Difference {
        numbers: numbers.collect::<Result<_, _>>()?,
        only_first: missing(&a, &b),
        only_second: missing(&b, &a),
        joint: joint(first, second),
    })
}

fn same_structure(first: &Model, second: &Model) -> Result<(), DifferenceError> {
    let structure = |model: &Model| {
        let mut blocks = vec![("kind", model.kind().name().to_owned())];
        if let Model::Hammerstein(body) = model {
            let data = body.data();
            blocks.push(("hysteresis", data.hysteresis.kind.family().name().to_owned()));
            blocks.push(("dynamics", format!("{:?}", data.dynamics.kind).to_lowercase()));
        }
        blocks
    };
    for ((what, first), (_, second)) in structure(first).into_iter().zip(structure(second)) {
        if first != second {
            return Err(DifferenceError::Structure { what: what.to_owned(), first, second });
        }
    }
    Ok(())
}

fn number(name: &str, first: &Quantity, second: &Quantity) -> Result<NumberDifference, DifferenceError> {
    if first.unit != second.unit {
        let (what, first, second) = (format!("unit of {name}"), first.unit.clone(), second.unit.clone());
        return Err(DifferenceError::Structure { what, first, second });
    }
    let combined = first.std_error.zip(second.std_error).map(|(a, b)| a.hypot(b)).filter(|s| *s > 0.0);
    let z = combined.map(|deviation| (second.value - first.value) / deviation);
    Ok(NumberDifference {
        name: name.to_owned(),
        unit: first.unit.clone(),
        first: first.value,
        first_std_error: first.std_error,
        second: second.value,
        second_std_error: second.std_error,
        in_standard_errors: z,
        p: z.map(|z| chi_square_tail(z * z, 1.0)),
        significant: z.is_some_and(|z| z.abs() > SIGNIFICANT),
    })
}

/// Wald's test of the numbers whose covariance both files hold.
fn joint(first: &Model, second: &Model) -> Option<JointDifference> {
    let (Model::Hammerstein(first), Model::Hammerstein(second)) = (first, second) else { return None };
    let (a_names, a) = first.data().covariance()?;
    let (b_names, b) = second.data().covariance()?;
    let places = |(i, name): (usize, &String)| Some((i, b_names.iter().position(|other| other == name)?));
    let common: Vec<(usize, usize)> = a_names.iter().enumerate().filter_map(places).collect();
    let moved = common.iter().map(|&(i, _)| {
        let name = &a_names[i];
        Some(second.data().number(name)?.value - first.data().number(name)?.value)
    });
    let moved = moved.collect::<Option<Vec<f64>>>()?;
    let count = common.len();
    // In combined standard errors, so that no unit weighs more than another.
    let variance = |k: usize, l: usize| {
        let ((i, m), (j, n)) = (common[k], common[l]);
        a[(i, j)] + b[(m, n)]
    };
    let scale: Vec<f64> = (0..count).map(|k| variance(k, k).sqrt()).collect();
    let correlation = DMatrix::from_fn(count, count, |k, l| variance(k, l) / (scale[k] * scale[l]));
    let d = DVector::from_fn(count, |k, _| moved[k] / scale[k]);
    if count == 0 || correlation.iter().chain(d.iter()).any(|x| !x.is_finite()) {
        return None;
    }
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(correlation);
    let least = RANK * eigenvalues.max();
    let along = eigenvectors.transpose() * d;
    let kept = eigenvalues.iter().zip(along.iter()).filter(|(value, _)| **value > least);
    let (degrees, chi_square) = kept.fold((0, 0.0), |(n, sum), (value, d)| (n + 1, sum + d * d / value));
    let p = chi_square_tail(chi_square, degrees as f64);
    let significant = p < chi_square_tail(SIGNIFICANT * SIGNIFICANT, 1.0);
    Some(JointDifference { chi_square, degrees, p, significant })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A static model: linear and alpha with standard errors and a correlation.
    fn model(linear: f64, alpha: f64, correlation: f64) -> Model {
        let text = format!(
            r#"{{"format": "hysteron-model", "version": 2, "kind": "hammerstein",
            "units": {{"input": "V", "output": "um"}},
            "hysteresis": {{"kind": "bouc-wen", "parameters": {{
              "linear": {{"value": {linear}, "unit": "um/V", "std_error": 0.3}},
              "alpha": {{"value": {alpha}, "unit": "um/V", "std_error": 0.4}},
              "beta": {{"value": 0.5, "unit": "1/V", "std_error": null}},
              "gamma": {{"value": 0.1, "unit": "1/V", "std_error": null}},
              "n": {{"value": 1, "unit": "1", "std_error": null}}}}}},
            "dynamics": {{"kind": "none", "numerator": [], "denominator": []}},
            "delay": {{"value": 0, "unit": "s", "std_error": null}},
            "offset": {{"value": 0, "unit": "um", "std_error": null}},
            "scheme": "band-limited", "sample_rate_hz": 100, "normalisation": "unit-dc-gain",
            "start": {{"kind": "rest", "voltage": null}},
            "correlation": {{"names": ["linear", "alpha"],
              "matrix": [[1, {correlation}], [{correlation}, 1]]}}}}"#
        );
        Model::from_json(text.as_bytes()).unwrap()
    }

    #[test]
    fn one_number_is_compared_in_combined_standard_errors() {
        let found = difference(&model(2.0, 1.0, 0.0), &model(4.0, 1.0, 0.0)).unwrap();
        let linear = found.numbers.iter().find(|number| number.name == "linear").unwrap();
        let z = 2.0 / (0.3f64 * 2f64.sqrt());
        assert!((linear.in_standard_errors.unwrap() - z).abs() < 1e-12 && linear.significant);
        let beta = found.numbers.iter().find(|number| number.name == "beta").unwrap();
        assert_eq!((beta.in_standard_errors, beta.p, beta.significant), (None, None, false));
        // Without correlation Wald's statistic is the sum of the squares.
        let joint = found.joint.clone().unwrap();
        assert!((joint.chi_square - z * z).abs() < 1e-9, "{joint:?}");
        assert_eq!(joint.degrees, 2);
        assert!((joint.p - (-z * z / 2.0).exp()).abs() < 1e-12 && found.is_significant());
    }

    #[test]
    fn correlated_numbers_that_move_against_their_correlation_differ_more() {
        // With r = 0.8, d = (0.3, -0.4)·√2·1 in standard errors (1, -1): d′R⁻¹d = 2/(1 − r) = 10.
        let scale = 2f64.sqrt();
        let found = difference(&model(2.0, 1.0, 0.8), &model(2.0 + 0.3 * scale, 1.0 - 0.4 * scale, 0.8));
        let joint = found.unwrap().joint.unwrap();
        assert!((joint.chi_square - 10.0).abs() < 1e-9, "{joint:?}");
        let along = difference(&model(2.0, 1.0, 0.8), &model(2.0 + 0.3 * scale, 1.0 + 0.4 * scale, 0.8));
        let joint = along.unwrap().joint.unwrap();
        assert!((joint.chi_square - 2.0 / 1.8).abs() < 1e-9, "{joint:?}");
    }

    #[test]
    fn numbers_that_follow_from_others_are_counted_once() {
        let joint = difference(&model(2.0, 1.0, 1.0), &model(2.3, 1.4, 1.0)).unwrap().joint.unwrap();
        assert_eq!(joint.degrees, 1);
    }

    #[test]
    fn the_same_model_does_not_differ_and_another_family_is_refused() {
        let found = difference(&model(2.0, 1.0, 0.5), &model(2.0, 1.0, 0.5)).unwrap();
        assert!(!found.is_significant() && found.joint.unwrap().p == 1.0);
        let text = model(2.0, 1.0, 0.5).to_json().unwrap();
        let (from, to) = (text.find("\"hysteresis\"").unwrap(), text.find("\"dynamics\"").unwrap());
        let dahl = r#""hysteresis": {"kind": "dahl", "parameters": {
            "linear": {"value": 2, "unit": "um/V"}, "weight_1": {"value": 1, "unit": "um/V"},
            "reach": {"value": 1, "unit": "V"}, "exponent": {"value": 1, "unit": "1"}}}, "#;
        let (other, end) = (format!("{}{dahl}{}", &text[..from], &text[to..]), text.find("\"correlation\""));
        let other = other[..other.len() - (text.len() - end.unwrap())].trim_end().trim_end_matches(',');
        let refused = Model::from_json(format!("{other}}}").as_bytes());
        let refused = difference(&model(2.0, 1.0, 0.5), &refused.unwrap()).unwrap_err().to_string();
        assert!(refused.contains("hysteresis: bouc-wen and dahl"), "{refused}");
    }
}
