//! Text in figures: escaping, widths, numbers.

use std::fmt::Write as _;

/// Family of every text in a figure: what browsers, LaTeX converters and rasterisers find, in that order.
pub(crate) const FONT_FAMILY: &str = "Helvetica Neue, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Estimated width \[px\] of `text` set at `size_px`, on the safe side for the fonts of [`FONT_FAMILY`].
pub(crate) fn width(text: &str, size_px: f64) -> f64 {
    let em: f64 = text
        .chars()
        .map(|c| match c {
            'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '|' | '\'' | '!' => 0.28,
            'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' | ' ' | '\u{202f}' => 0.34,
            'm' | 'M' | 'w' => 0.84,
            'W' | '@' | '—' | '…' => 1.0,
            '\u{2009}' => 0.22,
            '⁰' | '¹' | '²' | '³' | '⁴'..='⁹' | '⁻' => 0.38,
            c if c.is_ascii_uppercase() => 0.69,
            c if c.is_ascii() => 0.56,
            c if (c as u32) < 0x2e80 => 0.62,
            _ => 1.0,
        })
        .sum();
    em * size_px * 1.07
}

/// `text` cut to `limit_px` at `size_px`, with an ellipsis where something was cut.
pub(crate) fn fit(text: &str, size_px: f64, limit_px: f64) -> String {
    if width(text, size_px) <= limit_px {
        return text.to_owned();
    }
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if width(&kept, size_px) + size_px > limit_px {
            kept.pop();
            break;
        }
    }
    kept.push('…');
    kept
}

/// `text` in at most `most` lines of `limit_px` at `size_px`, broken after a space or one of `+ _ / , : ·`;
/// what does not fit is cut with an ellipsis. At least one line, which may be empty.
pub(crate) fn wrap(text: &str, size_px: f64, limit_px: f64, most: usize) -> Vec<String> {
    let mut lines = Vec::new();
    let mut rest = text;
    while lines.len() + 1 < most && width(rest, size_px) > limit_px {
        let ends = rest.char_indices().filter(|(_, c)| matches!(c, ' ' | '+' | '_' | '/' | ',' | ':' | '·'));
        let ends = ends.map(|(at, c)| at + c.len_utf8());
        let Some(end) = ends.take_while(|end| width(rest[..*end].trim_end(), size_px) <= limit_px).last()
        else {
            break;
        };
        lines.push(rest[..end].trim_end().to_owned());
        rest = rest[end..].trim_start();
    }
    lines.push(fit(rest, size_px, limit_px));
    lines
}

/// `value` with two decimals at most and no trailing zeros, for coordinates.
pub(crate) fn number(value: f64) -> String {
    let mut out = String::new();
    push_number(&mut out, value);
    out
}

/// Appends [`number`] of `value` to `out`; what is not finite becomes 0.
pub(crate) fn push_number(out: &mut String, value: f64) {
    let hundredths = (value.clamp(-1e7, 1e7) * 100.0).round() as i64;
    if hundredths < 0 {
        out.push('-');
    }
    let (whole, rest) = (hundredths.unsigned_abs() / 100, hundredths.unsigned_abs() % 100);
    let written = match (whole, rest) {
        (whole, 0) => write!(out, "{whole}"),
        (0, rest) if rest % 10 == 0 => write!(out, ".{}", rest / 10),
        (0, rest) => write!(out, ".{rest:02}"),
        (whole, rest) if rest % 10 == 0 => write!(out, "{whole}.{}", rest / 10),
        (whole, rest) => write!(out, "{whole}.{rest:02}"),
    };
    debug_assert!(written.is_ok(), "writing to a string cannot fail");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_rounded_to_hundredths() {
        let cases = [
            (0.0, "0"),
            (-0.004, "0"),
            (12.0, "12"),
            (0.5, ".5"),
            (-0.05, "-.05"),
            (3.1449, "3.14"),
            (-7.1, "-7.1"),
        ];
        for (value, expected) in cases {
            assert_eq!(number(value), expected);
        }
        assert_eq!(number(f64::NAN), "0");
    }

    #[test]
    fn long_names_are_broken_where_their_parts_meet() {
        let lines = wrap("fractional+creep+prandtl-ishlinskii", 12.0, 130.0, 3);
        assert_eq!(lines, ["fractional+creep+", "prandtl-ishlinskii"]);
        assert_eq!(
            wrap("simulated_sweep_1_100hz.csv", 12.0, 100.0, 3),
            ["simulated_", "sweep_1_", "100hz.csv"]
        );
        assert_eq!(wrap("short", 12.0, 100.0, 3), ["short"]);
        assert_eq!(wrap("", 12.0, 100.0, 3), [""]);
        let cut = wrap("one two three four five six seven", 12.0, 50.0, 2);
        assert!(cut.len() == 2 && cut[1].ends_with('…'), "{cut:?}");
    }

    #[test]
    fn text_longer_than_its_place_is_cut_with_an_ellipsis() {
        assert_eq!(fit("short", 12.0, 100.0), "short");
        let cut = fit("a name that is far too long for the place it has", 12.0, 100.0);
        assert!(cut.ends_with('…') && width(&cut, 12.0) <= 100.0, "{cut}");
    }
}
