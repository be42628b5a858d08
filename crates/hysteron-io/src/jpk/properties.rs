//! Java properties: lines of `key=value`.

use std::collections::{HashMap, HashSet};

use crate::laboratory_text::Text;

/// Key of the number of the properties that segments share.
const SHARED: &str = "lcd-info.*";
/// Prefixes of the keys that describe numbers and times.
const READ: [&str; 3] = ["channel.", "lcd-info.", "force-segment-header.duration"];

/// Properties of a file, a segment, or shared by all segments, as far as they are read.
#[derive(Default)]
pub(super) struct Properties {
    entries: HashMap<String, String>,
    /// Channels that are described here, not only by a reference to what segments share.
    described: HashSet<String>,
}

impl Properties {
    pub fn new(bytes: &[u8]) -> Self {
        let text = Text::new("", bytes);
        let mut properties = Properties::default();
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
                properties.add(&whole);
                whole.clear();
            }
        }
        if !whole.is_empty() {
            properties.add(&whole);
        }
        properties
    }

    /// Adds the property of a line, if it is read.
    fn add(&mut self, line: &str) {
        let (key, value) = entry(line);
        if !READ.iter().any(|start| key.starts_with(start)) {
            return;
        }
        if let Some((name, about)) = key.strip_prefix("channel.").and_then(|key| key.split_once('.'))
            && about != SHARED
            && !self.described.contains(name)
        {
            self.described.insert(name.to_owned());
        }
        self.entries.insert(key, value);
    }

    /// Whether properties of a channel stand here besides the number of its shared ones.
    pub fn describes(&self, channel: &str) -> bool {
        // A name with a point is known by the part before it.
        channel.split('.').next().is_some_and(|name| self.described.contains(name))
    }

    /// Number of the properties that segments share for a channel.
    pub fn shared_number(&self, channel: &str) -> Option<&str> {
        self.get(&format!("channel.{channel}.{SHARED}"))
    }

    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.get(key).map(String::as_str)
    }

    pub fn number(&self, key: &str) -> Option<f64> {
        self.get(key)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    }
}

/// Key and value, between them `=`, `:` or spaces; a backslash escapes the next character.
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
    fn escapes_are_taken_out() {
        let text = "#Wed Feb 04\n channel.t=11\\:25\\:21\nlcd-info.a\\=b : \
            \\u00b5m\nchannel.empty=\nchannel.no\nother=1\n";
        let properties = Properties::new(text.as_bytes());
        assert_eq!(properties.get("channel.t"), Some("11:25:21"));
        assert_eq!(properties.get("lcd-info.a=b"), Some("\u{b5}m"));
        assert_eq!(properties.get("channel.empty"), Some(""));
        assert_eq!(properties.get("channel.no"), Some(""));
        assert_eq!(properties.get("other"), None);
    }

    #[test]
    fn a_line_goes_on_behind_a_backslash_and_a_space_ends_a_key() {
        let text = " channel.a\\ b 1\\\r\n   2\nchannel.c\\\\=\\t3\\\\\n! channel.no = 1\nchannel.last=4\\";
        let properties = Properties::new(text.as_bytes());
        assert_eq!(properties.get("channel.a b"), Some("12"));
        assert_eq!(properties.get("channel.c\\"), Some("\t3\\"));
        assert_eq!(properties.get("channel.last"), Some("4"));
        assert_eq!(properties.entries.len(), 3);
    }

    #[test]
    fn a_channel_is_described_by_more_than_a_number() {
        let properties =
            Properties::new(b"channel.a.lcd-info.*=0\nchannel.b.lcd-info.*=1\nchannel.b.type=short\n");
        assert_eq!(properties.shared_number("a"), Some("0"));
        assert!(!properties.describes("a") && properties.describes("b"));
    }
}
