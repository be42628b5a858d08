//! Escaping of text for SVG and HTML: every string that a user or a file supplied passes through here.

/// `text` made safe as element content and inside a quoted attribute.
///
/// `& < > " '` become character references; control characters that XML 1.0 forbids become U+FFFD.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_and_forbidden_characters_are_neutralised() {
        assert_eq!(
            escape("</script><b a='1'>\"&\0"),
            "&lt;/script&gt;&lt;b a=&#39;1&#39;&gt;&quot;&amp;\u{fffd}"
        );
        assert_eq!(escape("µm, β′ ≥ 0"), "µm, β′ ≥ 0");
    }
}
