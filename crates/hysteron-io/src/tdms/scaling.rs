//! Scaling of raw values to physical ones, as channels of a TDMS file describe it in their properties.

use super::property::{Properties, Value};

/// Most scales of a channel.
const MAX_SCALES: usize = 64;
/// Most coefficients of a polynomial.
const MAX_COEFFICIENTS: u32 = 64;
/// Input source that means the raw values.
const RAW: u32 = 0xFFFF_FFFF;

/// Scales that are applied one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Scaling(Vec<Vec<f64>>);

impl Scaling {
    /// The scaling that the first of the objects, from channel to file, describes. An error names a scale
    /// that is not known.
    pub fn new(objects: &[&Properties]) -> Result<Self, String> {
        for properties in objects {
            let count = match properties.get("NI_Number_Of_Scales").and_then(Value::as_index) {
                Some(count) => count as usize,
                None => (0..MAX_SCALES).rev().find(|&i| kind(properties, i).is_some()).map_or(0, |i| i + 1),
            };
            if count == 0 || properties.get("NI_Scaling_Status").and_then(Value::text) == Some("scaled") {
                continue;
            }
            if count > MAX_SCALES {
                return Err(format!("values behind {count} scales (at most {MAX_SCALES} are applied)"));
            }
            return Scaling::chain(properties, count - 1);
        }
        Ok(Scaling::default())
    }

    /// Scales from the raw values to this one.
    fn chain(properties: &Properties, last: usize) -> Result<Self, String> {
        let mut polynomials = Vec::new();
        let mut scale = last;
        loop {
            let Some(kind) = kind(properties, scale) else {
                return Err(format!(
                    "values behind a scale that the file does not describe (NI_Scale[{scale}])"
                ));
            };
            let property = |name: &str| properties.get(&format!("NI_Scale[{scale}]_{kind}_{name}"));
            let number = |name: &str| {
                let missing = || format!("values behind a scale without NI_Scale[{scale}]_{kind}_{name}");
                property(name).and_then(Value::number).ok_or_else(missing)
            };
            polynomials.push(match kind {
                "Linear" => vec![number("Y_Intercept")?, number("Slope")?],
                "Polynomial" => {
                    let count = property("Coefficients_Size").and_then(Value::as_index).unwrap_or(4);
                    if count == 0 || count > MAX_COEFFICIENTS {
                        return Err(format!("values behind a polynomial of {count} coefficients"));
                    }
                    let coefficients = (0..count).map(|i| number(&format!("Coefficients[{i}]")));
                    coefficients.collect::<Result<_, _>>()?
                }
                other => {
                    return Err(format!(
                        "raw values behind the scale {other} (linear and polynomial are applied)"
                    ));
                }
            });
            match property("Input_Source").map(|source| source.as_index()) {
                None | Some(Some(RAW)) => break,
                // An earlier scale only: cyclic references would not end.
                Some(Some(source)) if (source as usize) < scale => scale = source as usize,
                _ => return Err(format!("values behind scales without order (NI_Scale[{scale}])")),
            }
        }
        polynomials.reverse();
        Ok(Scaling(polynomials))
    }

    /// Converts raw values to physical ones.
    pub fn apply(&self, values: &mut [f64]) {
        for polynomial in &self.0 {
            for value in values.iter_mut() {
                *value = polynomial.iter().rev().copied().reduce(|sum, c| sum * *value + c).unwrap_or(*value);
            }
        }
    }
}

/// Type of a scale.
fn kind(properties: &Properties, scale: usize) -> Option<&str> {
    properties.get(&format!("NI_Scale[{scale}]_Scale_Type")).and_then(Value::text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn properties(entries: &[(&str, Value)]) -> Properties {
        entries.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
    }

    #[test]
    fn a_polynomial_takes_the_values_of_the_linear_scale_in_front_of_it() {
        let text = |text: &str| Value::Text(text.to_owned());
        let channel = properties(&[
            ("NI_Number_Of_Scales", Value::Integer(2)),
            ("NI_Scale[0]_Scale_Type", text("Linear")),
            ("NI_Scale[0]_Linear_Slope", Value::Float(0.5)),
            ("NI_Scale[0]_Linear_Y_Intercept", Value::Float(1.0)),
            ("NI_Scale[0]_Linear_Input_Source", Value::Integer(i128::from(RAW))),
            ("NI_Scale[1]_Scale_Type", text("Polynomial")),
            ("NI_Scale[1]_Polynomial_Coefficients_Size", Value::Integer(3)),
            ("NI_Scale[1]_Polynomial_Coefficients[0]", Value::Float(1.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[1]", Value::Float(2.0)),
            ("NI_Scale[1]_Polynomial_Coefficients[2]", Value::Float(3.0)),
            ("NI_Scale[1]_Polynomial_Input_Source", Value::Integer(0)),
        ]);
        let mut values = [0.0, 2.0];
        Scaling::new(&[&channel, &Properties::new()]).unwrap().apply(&mut values);
        assert_eq!(values, [6.0, 17.0]);
        let circular = properties(&[
            ("NI_Scale[0]_Scale_Type", text("Linear")),
            ("NI_Scale[0]_Linear_Slope", Value::Float(0.5)),
            ("NI_Scale[0]_Linear_Y_Intercept", Value::Float(1.0)),
            ("NI_Scale[0]_Linear_Input_Source", Value::Integer(0)),
        ]);
        assert!(Scaling::new(&[&circular]).unwrap_err().contains("without order"));
        let thermocouple = properties(&[("NI_Scale[0]_Scale_Type", text("Thermocouple"))]);
        assert!(Scaling::new(&[&thermocouple]).unwrap_err().contains("Thermocouple"));
    }
}
