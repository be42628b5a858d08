//! Numbers formatted for messages.

/// Digits that matter to a reader.
const DIGITS: usize = 5;

/// `x` to five significant digits without trailing zeros: `4006.5`, `0.1`, `1.2346e-7`.
///
/// ```
/// use hysteron_numeric::display::short;
/// assert_eq!(short(4006.536_961_934_710_2), "4006.5");
/// assert_eq!(short(-0.25), "-0.25");
/// ```
pub fn short(x: f64) -> String {
    short_to(x, DIGITS)
}

/// [`short`] to another number of significant digits, at least one.
pub fn short_to(x: f64, digits: usize) -> String {
    let rounded: f64 = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    let size = rounded.abs();
    if rounded == 0.0 || (1e-4..1e7).contains(&size) || !size.is_finite() {
        // −0 is 0.
        (rounded + 0.0).to_string()
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::{short, short_to};

    #[test]
    fn digits_that_do_not_matter_are_dropped() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (10.0, "10"),
            (0.1 + 0.2, "0.3"),
            (4_006.536_961_934_71, "4006.5"),
            (123_456.0, "123460"),
            (99_999.6, "100000"),
            (-1.0 / 3.0, "-0.33333"),
            (1e-4, "0.0001"),
            (1.234_56e-7, "1.2346e-7"),
            (-5e300, "-5e300"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(short(x), text);
        }
        assert_eq!((short_to(1.23456, 3), short_to(98_765.0, 1)), ("1.23".to_owned(), "100000".to_owned()));
    }
}
