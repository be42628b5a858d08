//! Java properties: lines of `key=value`.

use std::collections::HashMap;

use crate::laboratory_text::Text;

/// Properties of a file, a segment, or shared by all segments.
#[derive(Default)]
pub(super) struct Properties(HashMap<String, String>);

impl Properties {
    pub fn new(bytes: &[u8]) -> Self {
        let text = Text::new("", bytes);
        let mut entries = HashMap::new();
        let mut whole = String::new();
        let mut goes_on = false;
        for (_, line) in text.lines() {
            let line = line.trim_start();
            if !goes_on && (line.is_empty() || line.starts_with(['#', '!'])) {
                continue;
            }
            whole.push_str(line);
            // An odd number of backslashes: the last one escapes the end of the line.
            goes_on = whole.bytes().rev().take_while(|&byte| byte == b'\\').count() % 2 == 1;
            if goes_on {
                whole.pop();
            } else {
                entries.extend([entry(&whole)]);
                whole.clear();
            }
        }
        if !whole.is_empty() {
            entries.extend([entry(&whole)]);
        }
        Properties(entries)
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }
}

/// Key and value, between them `=`, `:` or spaces; a backslash takes the meaning from the character behind it.
fn entry(line: &str) -> (String, String) {
    let mut chars = line.chars().peekable();
    let mut key = String::new();
    while let Some(c) = chars.next_if(|c| !matches!(c, '=' | ':') && !c.is_whitespace()) {
        key.extend(unescaped(c, &mut chars));
    }
    let space = |c: &char| c.is_whitespace();
    while chars.next_if(space).is_some() {}
    if chars.next_if(|c| matches!(c, '=' | ':')).is_some() {
        while chars.next_if(space).is_some() {}
    }
    let mut value = String::new();
    while let Some(c) = chars.next() {
        value.extend(unescaped(c, &mut chars));
    }
    (key, value)
}

/// The character that `c` and, behind a backslash, the next ones stand for.
fn unescaped(c: char, rest: &mut impl Iterator<Item = char>) -> Option<char> {
    if c != '\\' {
        return Some(c);
    }
    match rest.next()? {
        'u' => {
            let code: String = rest.take(4).collect();
            u32::from_str_radix(&code, 16).ok().and_then(char::from_u32)
        }
        't' => Some('\t'),
        'n' => Some('\n'),
        'r' => Some('\r'),
        'f' => Some('\u{c}'),
        other => Some(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_on_behind_a_backslash_and_a_space_ends_a_key() {
        let properties = Properties::new(b" a\\ b 1\\\r\n   2\nc\\\\=\\t3\\\\\n! no = 1\nlast=4\\");
        assert_eq!(properties.get("a b"), Some("12"));
        assert_eq!(properties.get("c\\"), Some("\t3\\"));
        assert_eq!(properties.get("last"), Some("4"));
        assert_eq!(properties.0.len(), 3);
    }

    #[test]
    fn escapes_are_taken_out() {
        let properties =
            Properties::new(b"#Wed Feb 04\n time-stamp=11\\:25\\:21\na\\=b : \\u00b5m\nempty=\nno\n");
        assert_eq!(properties.get("time-stamp"), Some("11:25:21"));
        assert_eq!(properties.get("a=b"), Some("\u{b5}m"));
        assert_eq!(properties.get("empty"), Some(""));
        assert_eq!(properties.get("no"), Some(""));
    }
}
