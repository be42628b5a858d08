//! Numbers on the command line: what is wrong with one is said in words. Their flags take values that begin with a hyphen
//! (`allow_hyphen_values`), so that −1 gets here and is not taken for a flag.

use std::str::FromStr;

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("expected a number".into()),
    }
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|x| *x > 0.0).ok_or_else(|| "expected a number above 0".into())
}

/// A number that is not negative.
pub fn not_negative(text: &str) -> Result<f64, String> {
    number(text).ok().filter(|x| *x >= 0.0).ok_or_else(|| "expected a number of at least 0".into())
}

/// A number between 0 and 1.
pub fn share(text: &str) -> Result<f64, String> {
    let within = number(text).ok().filter(|x| *x > 0.0 && *x < 1.0);
    within.ok_or_else(|| "expected a number above 0 and below 1".into())
}

/// A whole number from 1.
pub fn count<T: FromStr + PartialOrd + From<u8>>(text: &str) -> Result<T, String> {
    text.parse().ok().filter(|n| *n >= T::from(1)).ok_or_else(|| "expected a whole number above 0".into())
}

/// A whole number from 0.
pub fn whole<T: FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| "expected a whole number of at least 0".into())
}
