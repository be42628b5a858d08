//! Names in running text, broken where their parts meet.

use crate::escape::escape;

/// Words shorter than this are left whole \[characters\].
const LONG: usize = 20;
/// Longest part that is kept on one line \[characters\].
const PART: usize = 32;

/// `text` as HTML, escaped; a long name such as `fractional+creep+prandtl-ishlinskii` or
/// `simulated_sweep_1_100hz.csv` may break after `+`, `_` or `/`, and one with `+` nowhere else. What is
/// copied is the text itself.
pub(super) fn breakable(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 4);
    for word in text.split_inclusive(char::is_whitespace) {
        let parts: Vec<&str> = word.split_inclusive(['+', '_', '/']).collect();
        let length = word.trim_end().chars().count();
        // Names of two people, as Bouc–Wen, and short ones of structures are not torn at their dashes.
        if word.contains('–') && length < PART || word.contains('+') && length < LONG && length > 1 {
            put!(out, "<bdi>{}</bdi>{}", escape(word.trim_end()), escape(&word[word.trim_end().len()..]));
            continue;
        }
        if length < LONG || parts.len() < 2 {
            out += &escape(word);
            continue;
        }
        let whole = word.contains('+') && parts.iter().all(|part| part.chars().count() <= PART);
        out.push_str(if whole { "<bdi>" } else { "" });
        for (i, part) in parts.iter().enumerate() {
            out.push_str(if i > 0 { "<wbr>" } else { "" });
            out += &escape(part.trim_end());
        }
        out.push_str(if whole { "</bdi>" } else { "" });
        out += &escape(&word[word.trim_end().len()..]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_break_between_their_parts_only() {
        assert_eq!(
            breakable("best: fractional+creep+bouc-wen <b>"),
            "best: <bdi>fractional+<wbr>creep+<wbr>bouc-wen</bdi> &lt;b&gt;"
        );
        assert_eq!(breakable("simulated_sweep_100hz.csv, x"), "simulated_<wbr>sweep_<wbr>100hz.csv, x");
        assert_eq!(breakable("none+n-free c_d"), "<bdi>none+n-free</bdi> c_d");
        assert_eq!(breakable("1 + 2"), "1 + 2");
        assert_eq!(breakable("a Bouc–Wen loop"), "a <bdi>Bouc–Wen</bdi> loop");
        assert_eq!(breakable("</script></style><b>"), "&lt;/<wbr>script&gt;&lt;/<wbr>style&gt;&lt;b&gt;");
    }
}
