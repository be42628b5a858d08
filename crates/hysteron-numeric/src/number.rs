//! Numbers for tables: significant digits, standard errors, powers of ten.

/// Exponents of ten outside of which a number is written as m × 10ⁿ.
const PLAIN: std::ops::RangeInclusive<i32> = -4..=6;
/// Ratio of error to value above which no digit is significant.
const LOST: f64 = 20.0;

/// `value` with `digits` significant digits: `0.0123`, `12.3`, `5.26 × 10⁷`; `—` when it is not finite.
///
/// Digits before the decimal point are never rounded away below 10⁷: 12 345 with three digits is `12 345`.
///
/// ```
/// use hysteron_numeric::number::significant;
/// assert_eq!(significant(0.0123456, 3), "0.0123");
/// assert_eq!(significant(-1.5e-9, 2), "−1.5 × 10⁻⁹");
/// ```
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "—".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.clamp(1, 17);
    // Rounded first, so that 9.996 with three digits counts as 10.0.
    let exponent = rounded_exponent(value, digits);
    if PLAIN.contains(&exponent) {
        fixed(value, (digits as i32 - 1 - exponent).max(0) as usize)
    } else {
        power(value, exponent, digits - 1)
    }
}

/// `value` and its standard error, both to the digit that the error's two leading digits reach,
/// and with the same power of ten. A value lost in its error keeps three digits.
///
/// Without an error (or with one that is not positive and finite) the value has five significant digits and
/// the error is an empty text.
///
/// ```
/// use hysteron_numeric::number::with_std_error;
/// assert_eq!(with_std_error(12.34567, Some(0.0234)), ("12.346".into(), "0.023".into()));
/// assert_eq!(with_std_error(2.0, None), ("2.0000".into(), String::new()));
/// ```
pub fn with_std_error(value: f64, std_error: Option<f64>) -> (String, String) {
    let error = match std_error {
        Some(error) if error.is_finite() && error > 0.0 && value.is_finite() => error,
        _ => return (significant(value, 5), String::new()),
    };
    // A value lost in its error is shown all the same.
    if error > LOST * value.abs() && value != 0.0 {
        return (significant(value, 3), significant(error, 2));
    }
    let last = rounded_exponent(error, 2) - 1;
    // A value lost in its error has the error's power of ten.
    let top = if value == 0.0 { last + 1 } else { rounded_exponent(value, 17).max(last + 1) };
    if PLAIN.contains(&top) && last >= -12 {
        let decimals = (-last).max(0) as usize;
        return (fixed(value, decimals), significant(error, 2));
    }
    let digits = (top - last).clamp(0, 15) as usize;
    (power(value, top, digits), power(error, top, digits))
}

/// Decimal exponent of `value` after rounding to `digits` significant digits.
fn rounded_exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{:.*e}", digits.saturating_sub(1), value);
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// m × 10ⁿ with `decimals` digits after the point of m.
fn power(value: f64, exponent: i32, decimals: usize) -> String {
    let text = format!("{value:.17e}");
    let shift = text.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0) - exponent;
    let mantissa = text.split_once('e').and_then(|(m, _)| m.parse::<f64>().ok()).unwrap_or(0.0);
    format!("{} × 10{}", fixed(mantissa * 10f64.powi(shift), decimals), superscript(exponent))
}

/// `exponent` in superscript digits.
pub fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent
        .to_string()
        .chars()
        .map(|c| c.to_digit(10).and_then(|d| DIGITS.get(d as usize).copied()).unwrap_or('⁻'))
        .collect()
}

/// `value` with fixed decimals, a true minus sign and thin spaces between thousands from 10 000 on.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{:.*}", decimals, value.abs());
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    let negative = value < 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b));
    let mut out = String::from(if negative { "−" } else { "" });
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && whole.len() > 4 && (whole.len() - i) % 3 == 0 {
            out.push('\u{2009}');
        }
        out.push(c);
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_digits_that_matter() {
        for (value, digits, expected) in [
            (0.0, 3, "0"),
            (9.996, 3, "10.0"),
            (12345.0, 3, "12\u{2009}345"),
            (5.2589e6, 5, "5\u{2009}258\u{2009}900"),
            (5.2589e8, 5, "5.2589 × 10⁸"),
            (-0.00012, 2, "−0.00012"),
            (1e-300, 2, "1.0 × 10⁻³⁰⁰"),
            (f64::MAX, 2, "1.8 × 10³⁰⁸"),
            (f64::NAN, 2, "—"),
            (f64::INFINITY, 2, "—"),
        ] {
            assert_eq!(significant(value, digits), expected);
        }
    }

    #[test]
    fn a_value_ends_where_its_error_ends() {
        assert_eq!(with_std_error(-1.2039, Some(0.00096)), ("−1.20390".into(), "0.00096".into()));
        assert_eq!(with_std_error(5.4955e9, Some(1.2e6)), ("5.4955 × 10⁹".into(), "0.0012 × 10⁹".into()));
        assert_eq!(with_std_error(0.0, Some(0.1)), ("0.00".into(), "0.10".into()));
        assert_eq!(with_std_error(0.0, Some(6.4e-5)), ("0.0 × 10⁻⁵".into(), "6.4 × 10⁻⁵".into()));
        assert_eq!(with_std_error(19.087, Some(3e12)), ("19.1".into(), "3.0 × 10¹²".into()));
        assert_eq!(with_std_error(1.5, Some(f64::NAN)), ("1.5000".into(), String::new()));
    }
}
