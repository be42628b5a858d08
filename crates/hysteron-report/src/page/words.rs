//! Names in running text, broken where their parts meet.

use crate::escape::escape;

/// Words shorter than this are left whole \[characters\].
const LONG: usize = 12;
/// Longest part that is kept on one line \[characters\].
const PART: usize = 32;

/// `text` as HTML, escaped; a long name such as `fractional+creep+prandtl-ishlinskii` or
/// `simulated_sweep_1_100hz.csv` may break after `+`, `_` or `/`, and one with `+` nowhere else. What is
/// copied is the text itself.
pub(super) fn breakable(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 4);
    for word in text.split_inclusive(char::is_whitespace) {
        let parts: Vec<&str> = word.split_inclusive(['+', '_', '/']).collect();
        // Names of two people, as Bouc–Wen, are not torn apart.
        if word.contains('–') && word.chars().count() < PART {
            put!(out, "<bdi>{}</bdi>{}", escape(word.trim_end()), escape(&word[word.trim_end().len()..]));
            continue;
        }
        if word.chars().count() < LONG || parts.len() < 2 {
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
            breakable("best: fractional+bouc-wen <b>"),
            "best: <bdi>fractional+<wbr>bouc-wen</bdi> &lt;b&gt;"
        );
        assert_eq!(breakable("sweep_1_100hz.csv, x"), "sweep_<wbr>1_<wbr>100hz.csv, x");
        assert_eq!(breakable("a+b c_d"), "a+b c_d");
        assert_eq!(breakable("a Bouc–Wen loop"), "a <bdi>Bouc–Wen</bdi> loop");
        assert_eq!(breakable("</script><b>"), "&lt;/<wbr>script&gt;&lt;b&gt;");
    }
}
