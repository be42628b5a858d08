//! Java properties: lines of `key=value`.

use std::collections::HashMap;

use crate::laboratory_text::Text;

/// Properties of a file, a segment, or shared by all segments.
#[derive(Default)]
pub(super) struct Properties(HashMap<String, String>);

impl Properties {
    pub fn new(bytes: &[u8]) -> Self {
        let text = Text::new("", bytes);
        let entries = text.lines().filter(|(_, line)| !line.starts_with(['#', '!']));
        Properties(entries.filter_map(|(_, line)| entry(line)).collect())
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }
}

/// Key and value; a backslash takes the meaning from the character behind it.
fn entry(line: &str) -> Option<(String, String)> {
    let (mut key, mut value) = (String::new(), None);
    let mut chars = line.trim_start().chars();
    while let Some(c) = chars.next() {
        let escaped = if c == '\\' { chars.next() } else { None };
        match (c, escaped) {
            ('=' | ':', _) if value.is_none() => value = Some(String::new()),
            (_, Some('u')) => {
                let code: String = chars.by_ref().take(4).collect();
                let character = u32::from_str_radix(&code, 16).ok().and_then(char::from_u32);
                value.as_mut().unwrap_or(&mut key).extend(character);
            }
            _ => value.as_mut().unwrap_or(&mut key).push(escaped.unwrap_or(c)),
        }
    }
    Some((key.trim_end().to_owned(), value?.trim_start().to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_are_taken_out() {
        let properties =
            Properties::new(b"#Wed Feb 04\n time-stamp=11\\:25\\:21\na\\=b : \\u00b5m\nempty=\nno\n");
        assert_eq!(properties.get("time-stamp"), Some("11:25:21"));
        assert_eq!(properties.get("a=b"), Some("\u{b5}m"));
        assert_eq!(properties.get("empty"), Some(""));
        assert_eq!(properties.get("no"), None);
    }
}
