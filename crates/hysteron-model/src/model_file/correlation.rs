//! Correlation of the estimates of the numbers in a model file.
//!
//! Standard errors are stored with the numbers; beside them the file holds their correlation R, without
//! redundancy: the covariance is σ_i R_ij σ_j.

use std::fmt;
use std::marker::PhantomData;

use nalgebra::DMatrix;
use schemars::JsonSchema;
use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::ser::{Error as _, Serializer};
use serde::{Deserialize, Serialize};

use super::{ModelFile, ModelFileError, Quantity, polynomial_name};
use crate::dynamics::{Dynamics, TransferFunction};
use crate::hammerstein::Model;
use hysteron_numeric::display::exact;

/// Most numbers whose correlation a file may hold; a power law with 40 poles and
/// as many zeros has 163.
pub const MAX_CORRELATED: usize = 200;
/// Rounding allowed for: of 1 on the diagonal, of symmetry, and of the eigenvalues per number.
const ROUNDING: f64 = 1e-9;

/// Correlation of the estimates of a model's numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object with the keys `names` and `matrix`")]
pub struct CorrelationEntry {
    /// The numbers, each with a standard error: names of hysteresis parameters, `numerator[i].coefficient`,
    /// `denominator[i].order` …, `delay`, `offset`.
    #[serde(deserialize_with = "bounded")]
    pub names: Vec<String>,
    /// Correlation coefficients, a row a number.
    #[serde(deserialize_with = "bounded")]
    pub matrix: Vec<CorrelationRow>,
}

/// A row of numbers, written on one line.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct CorrelationRow(#[serde(deserialize_with = "bounded")] pub Vec<f64>);

impl Serialize for CorrelationRow {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let text = serde_json::to_string(&self.0).map_err(S::Error::custom)?;
        serde_json::value::RawValue::from_string(text).map_err(S::Error::custom)?.serialize(serializer)
    }
}

/// A list of bounded length.
pub(super) fn bounded<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    struct List<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a list of at most {MAX_CORRELATED} entries")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let mut entries = Vec::new();
            while let Some(entry) = list.next_element()? {
                if entries.len() == MAX_CORRELATED {
                    return Err(A::Error::custom(format!("more than {MAX_CORRELATED} entries")));
                }
                entries.push(entry);
            }
            Ok(entries)
        }
    }
    deserializer.deserialize_seq(List(PhantomData))
}

/// Names of the numbers of a transfer function as a model file has them, with their values: coefficient and
/// order of every term, numerator first.
pub fn transfer_function_numbers(g: &TransferFunction) -> (Vec<String>, Vec<f64>) {
    let lists = [("numerator", &g.numerator), ("denominator", &g.denominator)];
    let terms = lists.into_iter().flat_map(|(list, terms)| terms.iter().enumerate().map(move |t| (list, t)));
    terms
        .flat_map(|(list, (i, term))| {
            [
                (format!("{list}[{i}].coefficient"), term.coefficient),
                (format!("{list}[{i}].order"), term.order),
            ]
        })
        .unzip()
}

/// Term that a name such as `denominator[1].order` refers to: whether in the denominator, its place, whether
/// its order.
fn term(name: &str) -> Option<(bool, usize, bool)> {
    let (list, rest) = name.split_once('[')?;
    let (place, what) = rest.split_once("].")?;
    let is_order = match what {
        "coefficient" => false,
        "order" => true,
        _ => return None,
    };
    match list {
        "numerator" => Some((false, place.parse().ok()?, is_order)),
        "denominator" => Some((true, place.parse().ok()?, is_order)),
        _ => None,
    }
}

/// The number of a model that a [`CorrelationEntry`] calls by this name.
pub fn number_mut<'a>(model: &'a mut Model, name: &str) -> Option<&'a mut f64> {
    match name {
        "delay" => return Some(&mut model.delay_s),
        "offset" => return Some(&mut model.offset),
        _ => {}
    }
    if let Some((is_denominator, place, is_order)) = term(name) {
        return match &mut model.dynamics {
            Dynamics::None => None,
            Dynamics::Integer(g) | Dynamics::Fractional(g) => {
                let list = if is_denominator { &mut g.denominator } else { &mut g.numerator };
                let term = list.get_mut(place)?;
                Some(if is_order { &mut term.order } else { &mut term.coefficient })
            }
            Dynamics::Arx(arx) => match (is_order, is_denominator) {
                (true, _) => None,
                // The leading 1 is not among them.
                (false, true) => arx.a.get_mut(place.checked_sub(1)?),
                (false, false) => arx.b.get_mut(place),
            },
        };
    }
    let degree = model.hysteresis.polynomial().len();
    match (1..=degree).find(|&i| polynomial_name(i) == name) {
        Some(power) => model.hysteresis.polynomial_mut().get_mut(power - 1),
        None => model.hysteresis.number_mut(name),
    }
}

/// Shrinks a matrix of correlations towards the unit matrix until no eigenvalue is negative: those of
/// parameters that are nearly dependent are zero but for rounding, of either sign.
fn lift(matrix: &mut [CorrelationRow]) {
    let count = matrix.len();
    let lowest = DMatrix::from_fn(count, count, |i, j| matrix[i].0[j]).symmetric_eigenvalues().min();
    if lowest >= 0.0 {
        return;
    }
    // (R + x I)/(1 + x) has the lowest eigenvalue 0 at x = -lowest.
    let shrunk = 1.0 / (1.0 - lowest);
    for (i, row) in matrix.iter_mut().enumerate() {
        row.0.iter_mut().enumerate().filter(|(j, _)| *j != i).for_each(|(_, r)| *r *= shrunk);
    }
}

impl ModelFile {
    /// The number that a [`CorrelationEntry`] calls by this name.
    pub fn number(&self, name: &str) -> Option<&Quantity> {
        match (name, term(name)) {
            ("delay", _) => Some(&self.delay),
            ("offset", _) => Some(&self.offset),
            (_, Some((is_denominator, place, is_order))) => {
                let block = &self.dynamics;
                let list = if is_denominator { &block.denominator } else { &block.numerator };
                let term = list.get(place)?;
                Some(if is_order { &term.order } else { &term.coefficient })
            }
            (name, None) => self.hysteresis.parameters.get(name),
        }
    }

    /// The number of this name, mutable, to set its standard error.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut Quantity> {
        match (name, term(name)) {
            ("delay", _) => Some(&mut self.delay),
            ("offset", _) => Some(&mut self.offset),
            (_, Some((is_denominator, place, is_order))) => {
                let block = &mut self.dynamics;
                let list = if is_denominator { &mut block.denominator } else { &mut block.numerator };
                let term = list.get_mut(place)?;
                Some(if is_order { &mut term.order } else { &mut term.coefficient })
            }
            (name, None) => self.hysteresis.parameters.get_mut(name),
        }
    }

    /// Takes standard errors and correlation from a covariance of numbers of the model, each named once.
    /// Numbers that the model does not have, and those without a positive finite variance, are left out.
    pub fn set_covariance(&mut self, names: &[String], covariance: &DMatrix<f64>) {
        let mut kept = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let variance = covariance[(i, i)];
            if variance.is_finite()
                && variance > 0.0
                && let Some(number) = self.number_mut(name)
            {
                number.std_error = Some(variance.sqrt());
                kept.push(i);
            }
        }
        let coefficient = |i: usize, j: usize| {
            let product = covariance[(i, i)].sqrt() * covariance[(j, j)].sqrt();
            if i == j { 1.0 } else { (covariance[(i.min(j), i.max(j))] / product).clamp(-1.0, 1.0) }
        };
        let row = |&i: &usize| CorrelationRow(kept.iter().map(|&j| coefficient(i, j)).collect());
        let count = kept.len();
        let entry = || {
            let mut matrix: Vec<CorrelationRow> = kept.iter().map(row).collect();
            lift(&mut matrix);
            CorrelationEntry { names: kept.iter().map(|&i| names[i].clone()).collect(), matrix }
        };
        self.correlation = (count > 0 && count <= MAX_CORRELATED).then(entry);
    }

    /// Names and covariance of the numbers whose correlation the file holds; `None` where it holds none.
    pub fn covariance(&self) -> Option<(Vec<String>, DMatrix<f64>)> {
        let entry = self.correlation.as_ref()?;
        let errors: Vec<f64> =
            entry.names.iter().map(|name| self.number(name)?.std_error).collect::<Option<_>>()?;
        let at = |i: usize, j: usize| Some(entry.matrix.get(i)?.0.get(j)? * errors[i] * errors[j]);
        let count = errors.len();
        let values = (0..count * count).map(|k| at(k / count, k % count)).collect::<Option<Vec<f64>>>()?;
        Some((entry.names.clone(), DMatrix::from_row_slice(count, count, &values)))
    }

    /// Checks for a valid correlation matrix, of numbers of the model that have standard errors.
    pub(super) fn check_correlation(&self) -> Result<(), ModelFileError> {
        let Some(CorrelationEntry { names, matrix }) = &self.correlation else { return Ok(()) };
        let refuse = |problem: String| Err(ModelFileError::Correlation { problem });
        let count = names.len();
        if count == 0 || count > MAX_CORRELATED {
            return refuse(format!("expected 1 to {MAX_CORRELATED} names, found {count}"));
        }
        for (i, name) in names.iter().enumerate() {
            if names[..i].contains(name) {
                return refuse(format!("`{name}` is named twice"));
            }
            match self.number(name).map(|number| number.std_error) {
                None => return refuse(format!("the model has no number `{name}`")),
                Some(Some(error)) if error > 0.0 => {}
                Some(_) => return refuse(format!("`{name}` has no standard error above 0")),
            }
        }
        if let Some(row) = matrix.iter().map(|row| row.0.len()).chain([matrix.len()]).find(|&n| n != count) {
            return refuse(format!("expected {count} rows of {count} coefficients, found {row}"));
        }
        for i in 0..count {
            for j in 0..=i {
                let (value, mirror) = (matrix[i].0[j], matrix[j].0[i]);
                let sound = value.is_finite() && value.abs() <= 1.0 + ROUNDING;
                if !sound || (i == j && (value - 1.0).abs() > ROUNDING) {
                    let expected = if i == j { "1" } else { "a number from -1 to 1" };
                    return refuse(format!("matrix[{i}][{j}]: expected {expected}, found {}", exact(value)));
                }
                if !mirror.is_finite() || (value - mirror).abs() > ROUNDING {
                    return refuse(format!(
                        "not symmetric: matrix[{i}][{j}] is {}, matrix[{j}][{i}] is {}",
                        exact(value),
                        exact(mirror)
                    ));
                }
            }
        }
        let lowest = DMatrix::from_fn(count, count, |i, j| matrix[i].0[j]).symmetric_eigenvalues().min();
        if lowest >= -ROUNDING * count as f64 {
            return Ok(());
        }
        refuse(format!("no correlation matrix: it has the negative eigenvalue {lowest:.3e}"))
    }
}
