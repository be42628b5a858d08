//! Escaping of model-file text for each target language: every text in a source passes through here.

/// Text inside a C comment, as printable ASCII on one line.
///
/// The text begins and ends with any character: the comment around it must not put `*`, `/` or `?` beside it.
pub(crate) fn c_comment(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        let c = match c {
            'µ' | 'μ' => 'u',
            '\\' => '/',
            ' '..='~' => c,
            _ => '?',
        };
        // No end of the comment, no second beginning (a warning), no trigraph.
        if matches!((out.chars().next_back(), c), (Some('*'), '/') | (Some('/'), '*') | (Some('?'), '?')) {
            out.push(' ');
        }
        out.push(c);
    }
    out
}

/// A string literal of C, with its quotes, that holds the text in UTF-8; control characters become `?`, for
/// they would end the string or command the terminal.
pub(crate) fn c_string(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars().map(printed) {
        match c {
            // Escaped, a question mark is no part of a trigraph.
            '"' | '\\' | '?' => out.extend(['\\', c]),
            ' '..='~' => out.push(c),
            // Three octal digits, so that no digit of the text is taken for a fourth.
            _ => c.encode_utf8(&mut [0; 4]).bytes().for_each(|b| out.push_str(&format!("\\{b:03o}"))),
        }
    }
    out.push('"');
    out
}

/// A string of MATLAB and Octave, with its quotes; control characters, which would end its line, become `?`.
pub(crate) fn matlab_string(text: &str) -> String {
    let inside: String = text.chars().map(printed).collect();
    format!("'{}'", inside.replace('\'', "''"))
}

/// Text inside a documentation comment of Rust, on one line: printable ASCII, without Markdown.
pub(crate) fn rust_comment(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in c_comment(text).chars() {
        match c {
            '[' | ']' | '<' | '*' | '_' | '&' | '~' => out.extend(['\\', c]),
            // Code and links; an escaped backquote would still have to be balanced.
            '`' => out.push('\''),
            '/' if out.ends_with(':') => out.push_str("\\/"),
            _ => out.push(c),
        }
    }
    out
}

/// A basic string of TOML, with its quotes.
pub(crate) fn toml_string(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Text of an attribute, in double quotes, or of an element of XML; what XML 1.0 cannot hold and what is not
/// printed become `?`.
pub(crate) fn xml(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars().map(printed) {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => out.push('?'),
            c => out.push(c),
        }
    }
    out
}

/// The character, with control characters replaced by `?`.
fn printed(c: char) -> char {
    if c.is_control() { '?' } else { c }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Text of characters that are special in one of the languages.
    fn hostile() -> impl Strategy<Value = String> {
        let piece = prop_oneof![
            prop::sample::select(vec![
                "\"",
                "\\",
                "%",
                "%s",
                "%n",
                "*/",
                "/*",
                "//",
                "*",
                "/",
                "?",
                "??/",
                "??'",
                "\n",
                "\r\n",
                "\0",
                "\x1b[2J",
                "]]>",
                "&",
                "<",
                ">",
                "'",
                "`",
                "$name",
                "{}",
                "#",
                "[",
                "]",
                "_",
                "0",
                "7",
                "u0041",
                "µ",
                "é",
                "\u{85}",
                "\u{2028}",
                "\u{fffe}",
                "\u{ffff}",
                "\u{1f980}",
                "http://a.b",
                "-->",
                "<!--",
                "&#0;",
            ])
            .prop_map(str::to_owned),
            any::<char>().prop_map(String::from),
        ];
        prop::collection::vec(piece, 0..12).prop_map(|pieces| pieces.concat())
    }

    /// The bytes of a string literal of C, read as translation phases 1 to 5 do. `None` where it is none.
    fn read_c(literal: &str) -> Option<Vec<u8>> {
        let trigraph = (0..literal.len()).any(|at| {
            let mut rest = literal.get(at..).unwrap_or_default().chars();
            rest.next() == Some('?')
                && rest.next() == Some('?')
                && rest.next().is_some_and(|c| "=/'()!<>-".contains(c))
        });
        let inside = literal.strip_prefix('"')?.strip_suffix('"')?;
        let (mut bytes, mut rest) = (Vec::new(), inside.bytes().peekable());
        while let Some(b) = rest.next() {
            match b {
                b'\\' => {
                    let mut octal = String::new();
                    while octal.len() < 3
                        && let Some(digit) = rest.next_if(|b| (b'0'..=b'7').contains(b))
                    {
                        octal.push(char::from(digit));
                    }
                    if octal.is_empty() {
                        bytes.push(rest.next().filter(|b| b"\"\\?".contains(b))?);
                    } else {
                        bytes.push(u8::from_str_radix(&octal, 8).ok()?);
                    }
                }
                b' '..=b'~' if b != b'"' => bytes.push(b),
                _ => return None,
            }
        }
        (!trigraph).then_some(bytes)
    }

    /// The text of a basic string of TOML 1.0.
    fn read_toml(literal: &str) -> Option<String> {
        let mut rest = literal.strip_prefix('"')?.strip_suffix('"')?.chars();
        let mut text = String::new();
        while let Some(c) = rest.next() {
            match c {
                '\\' => match rest.next()? {
                    c @ ('"' | '\\') => text.push(c),
                    'u' => {
                        let digits: String = rest.by_ref().take(4).collect();
                        text.push(char::from_u32(u32::from_str_radix(&digits, 16).ok()?)?);
                    }
                    _ => return None,
                },
                '"' => return None,
                c if c != '\t' && (c < ' ' || c == '\x7f') => return None,
                c => text.push(c),
            }
        }
        Some(text)
    }

    proptest! {
        #[test]
        fn a_c_string_holds_the_text(text in hostile()) {
            let printed: String = text.chars().map(printed).collect();
            prop_assert_eq!(read_c(&c_string(&text)), Some(printed.into_bytes()));
        }

        #[test]
        fn a_comment_of_c_is_one_line_and_cannot_be_left(text in hostile()) {
            let comment = c_comment(&text);
            prop_assert!(comment.chars().all(|c| (' '..='~').contains(&c) && c != '\\'), "{}", comment);
            for end in ["*/", "/*", "??"] {
                prop_assert!(!comment.contains(end), "{}", comment);
            }
            prop_assert_eq!(c_comment(&comment), comment.clone(), "escaped twice");
        }

        #[test]
        fn a_comment_of_rust_is_one_line_without_markdown(text in hostile()) {
            let comment = rust_comment(&text);
            prop_assert!(comment.chars().all(|c| (' '..='~').contains(&c) && c != '`'), "{}", comment);
            // Every special character comes after a backslash, and every backslash before one.
            let mut rest = comment.chars();
            let mut bare = String::new();
            while let Some(c) = rest.next() {
                if c == '\\' {
                    prop_assert!(rest.next().is_some_and(|c| "[]<*_&~/".contains(c)), "{}", comment);
                } else {
                    bare.push(c);
                }
            }
            prop_assert!(!bare.contains(['[', ']', '<', '*', '_', '&', '~']), "{}", comment);
            prop_assert!(!comment.contains("://"), "{}", comment);
        }

        #[test]
        fn a_toml_string_holds_the_text(text in hostile()) {
            prop_assert_eq!(read_toml(&toml_string(&text)), Some(text));
        }

        /// By a parser: as attribute and as content.
        #[test]
        fn xml_holds_the_text(text in hostile()) {
            let wanted: String = text.chars().map(printed).collect();
            let wanted = wanted.replace(['\u{fffe}', '\u{ffff}'], "?");
            let document = format!("<a b=\"{0}\">{0}</a>", xml(&text));
            let parsed = roxmltree::Document::parse(&document);
            prop_assert!(parsed.is_ok(), "{:?} {}", parsed.err(), document);
            let parsed = parsed.unwrap();
            let root = parsed.root_element();
            prop_assert_eq!(root.attribute("b"), Some(wanted.as_str()));
            prop_assert_eq!(root.text().unwrap_or_default(), wanted);
        }
    }

    #[test]
    fn ordinary_text_stays_readable() {
        assert_eq!(c_comment("a*/ \n/*b\\ µm"), "a* / ?/ *b/ um");
        assert_eq!(c_comment("*\\ ???/"), "* / ? ? ?/");
        assert_eq!(c_string("um/V"), "\"um/V\"");
        assert_eq!(c_string("µ\"1"), "\"\\302\\265\\\"1\"");
        assert_eq!(rust_comment("run_1 [V]"), "run\\_1 \\[V\\]");
        assert_eq!(toml_string("C:\\rt"), "\"C:\\\\rt\"");
        assert_eq!(xml("a < µ"), "a &lt; µ");
    }
}
