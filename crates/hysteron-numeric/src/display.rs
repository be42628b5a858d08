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

/// `x` with as many digits as it takes to tell it from every other number, as a power of ten where that is
/// shorter: `0.1`, `1e300`.
///
/// ```
/// use hysteron_numeric::display::exact;
/// assert_eq!(exact(1e300), "1e300");
/// assert_eq!(exact(12345.678), "12345.678");
/// ```
pub fn exact(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || (1e-5..1e9).contains(&size) || !size.is_finite() {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

/// What a JSON parser says of a file, in words for who wrote it.
pub fn json_problem(problem: &dyn std::fmt::Display) -> String {
    const LONGEST: usize = 400;
    let said = problem.to_string();
    if said == "EOF while parsing a value at line 1 column 0" {
        return "the file is empty".to_owned();
    }
    let words = said.replace("EOF while parsing", "the file ends within");
    let mut words = words.replace("expected f64", "expected a number");
    for whole in ["usize", "u8", "u32", "u64", "i32", "i64"] {
        words = words.replace(&format!("expected {whole}"), "expected a whole number");
    }
    match words.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &words[..end]),
        None => words,
    }
}

#[cfg(test)]
mod tests {
    use super::{exact, json_problem, short, short_to};

    #[test]
    fn a_number_is_told_from_every_other_without_rows_of_zeros() {
        for (x, text) in [(0.0, "0"), (12.5, "12.5"), (1e300, "1e300"), (1.5e-7, "1.5e-7"), (f64::NAN, "NaN")]
        {
            assert_eq!(exact(x), text);
        }
    }

    #[test]
    fn a_parser_is_quoted_in_plain_words() {
        assert_eq!(json_problem(&"EOF while parsing a value at line 1 column 0"), "the file is empty");
        let ends = json_problem(&"EOF while parsing an object at line 3 column 0");
        assert_eq!(ends, "the file ends within an object at line 3 column 0");
        let float = json_problem(&"invalid type: floating point `1.5`, expected usize at line 2 column 9");
        assert_eq!(float, "invalid type: floating point `1.5`, expected a whole number at line 2 column 9");
        assert!(json_problem(&"a".repeat(5000)).chars().count() < 500);
    }

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
