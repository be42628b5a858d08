//! Parsers of numbers on the command line, with readable errors. Their flags take values that begin with a
//! hyphen (`allow_hyphen_values`), so that −1 is not taken for a flag.

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

/// A time in s, or followed by another unit of time.
pub fn seconds(text: &str) -> Result<f64, String> {
    let units = [("ns", 1e-9), ("us", 1e-6), ("µs", 1e-6), ("ms", 1e-3), ("min", 60.0), ("s", 1.0)];
    in_unit(text, &units).ok_or_else(|| "expected a time such as 1.5, 1.5s or 300ms".into())
}

/// A frequency above 0 in Hz, or followed by another unit of frequency.
pub fn hertz(text: &str) -> Result<f64, String> {
    let units = [("kHz", 1e3), ("MHz", 1e6), ("Hz", 1.0)];
    let rate = in_unit(text, &units).filter(|rate| *rate > 0.0);
    rate.ok_or_else(|| "expected a rate above 0 such as 500, 500Hz or 2kHz".into())
}

/// A number followed by one of these units (the first match) or by none.
fn in_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let text = text.trim();
    let given = units.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, *factor)));
    let (number_text, factor) = given.unwrap_or((text, 1.0));
    number(number_text.trim_end()).ok().map(|x| x * factor).filter(|x| x.is_finite())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_rates_carry_their_units() {
        for (text, value) in [("1.5s", 1.5), ("20", 20.0), ("-300 ms", -0.3), ("2min", 120.0), ("5us", 5e-6)]
        {
            assert!((seconds(text).unwrap() - value).abs() < 1e-15, "{text}");
        }
        assert_eq!((hertz("500Hz"), hertz("2 kHz"), hertz("0.5")), (Ok(500.0), Ok(2000.0), Ok(0.5)));
        for text in ["", "s", "1.5h", "nan", "infs", "1e309", "1,5s"] {
            assert!(seconds(text).is_err() && hertz(text).is_err(), "{text}");
        }
        assert!(hertz("0Hz").is_err() && hertz("-5").is_err());
    }
}
