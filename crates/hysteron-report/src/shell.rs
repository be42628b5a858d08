//! Commands as they are typed.

/// A word for a shell: quoted where it holds more than letters, digits and `-_./=:,+@%`.
///
/// ```
/// use hysteron_report::shell::word;
/// assert_eq!((word("a-b.csv").as_str(), word("a b's").as_str()), ("a-b.csv", r"'a b'\''s'"));
/// ```
pub fn word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
