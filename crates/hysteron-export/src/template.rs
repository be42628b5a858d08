//! Source text with places to be filled in.
//!
//! * `$key`: the text of that key, the longest key that fits.
//! * `R(x)`: the constant x, a number, a fraction of two or the name of one of the runtime's, as a literal of
//!   the number type.
//! * `F(f)`: the function f of `<math.h>` in the number type.
//! * `K(x)`: where the coefficients x are kept.
//! * Lines `//{ a|b`, `//{ !a` … `//}`: only where one of the flags is set (not set).
//! * A line `//+ part`: the text of that part, filled in as this one.

use std::collections::{BTreeMap, BTreeSet};

use crate::error::ExportError;
use crate::number::Precision;

/// Values that fill a template.
#[derive(Clone, Debug)]
pub(crate) struct Filling {
    precision: Precision,
    keys: BTreeMap<String, String>,
    flags: BTreeSet<&'static str>,
    coefficients: BTreeMap<&'static str, String>,
    parts: BTreeMap<&'static str, String>,
}

impl Filling {
    pub fn new(precision: Precision) -> Self {
        Self {
            precision,
            keys: BTreeMap::new(),
            flags: BTreeSet::new(),
            coefficients: BTreeMap::new(),
            parts: BTreeMap::new(),
        }
    }

    /// Sets `$key`.
    pub fn key(&mut self, key: &str, text: impl ToString) -> &mut Self {
        self.keys.insert(key.to_owned(), text.to_string());
        self
    }

    /// Sets `$key` to a number.
    pub fn number(&mut self, key: &str, value: f64) -> &mut Self {
        self.key(key, self.precision.c_literal(value))
    }

    /// The text of `$key`; empty where it is not set.
    pub fn text(&self, key: &str) -> &str {
        self.keys.get(key).map_or("", String::as_str)
    }

    /// Sets a flag where `on`.
    pub fn flag(&mut self, flag: &'static str, on: bool) -> &mut Self {
        if on {
            self.flags.insert(flag);
        } else {
            self.flags.remove(flag);
        }
        self
    }

    /// Whether a flag is set.
    pub fn has(&self, flag: &str) -> bool {
        self.flags.contains(flag)
    }

    /// Sets where coefficients are kept.
    pub fn coefficients(&mut self, name: &'static str, place: impl ToString) -> &mut Self {
        self.coefficients.insert(name, place.to_string());
        self
    }

    /// Sets the text of a part.
    pub fn part(&mut self, name: &'static str, text: impl ToString) -> &mut Self {
        self.parts.insert(name, text.to_string());
        self
    }

    /// The text of a template.
    ///
    /// # Errors
    /// [`ExportError::Template`] where it refers to an undefined item.
    pub fn fill(&self, template: &str) -> Result<String, ExportError> {
        let mut out = String::with_capacity(2 * template.len());
        self.lines(template, &mut out)?;
        Ok(out)
    }

    fn lines(&self, template: &str, out: &mut String) -> Result<(), ExportError> {
        let mut open: Vec<bool> = Vec::new();
        for line in template.lines() {
            if let Some(condition) = line.trim_start().strip_prefix("//{ ") {
                open.push(self.holds(condition.trim()));
            } else if line.trim_start() == "//}" {
                if open.pop().is_none() {
                    return Err(ExportError::Template { place: "//}".into() });
                }
            } else if open.contains(&false) {
                continue;
            } else if let Some(part) = line.trim_start().strip_prefix("//+ ") {
                let unknown = || ExportError::Template { place: line.into() };
                self.lines(self.parts.get(part.trim()).ok_or_else(unknown)?, out)?;
            } else {
                self.line(line, out)?;
                out.push('\n');
            }
        }
        if open.is_empty() { Ok(()) } else { Err(ExportError::Template { place: "//{".into() }) }
    }

    fn holds(&self, condition: &str) -> bool {
        condition.split('|').any(|flag| match flag.strip_prefix('!') {
            Some(flag) => !self.has(flag),
            None => self.has(flag),
        })
    }

    fn line(&self, line: &str, out: &mut String) -> Result<(), ExportError> {
        let mut rest = line;
        let mut last = ' ';
        while let Some(c) = rest.chars().next() {
            let call = !(last.is_alphanumeric() || last == '_')
                && matches!(c, 'R' | 'F' | 'K')
                && rest[1..].starts_with('(');
            if c == '$' {
                let (key, text) = self
                    .keys
                    .iter()
                    .filter(|(key, _)| rest[1..].starts_with(key.as_str()))
                    .max_by_key(|(key, _)| key.len())
                    .ok_or_else(|| ExportError::Template { place: rest.into() })?;
                out.push_str(text);
                rest = &rest[1 + key.len()..];
                last = '$';
            } else if call && let Some(end) = rest.find(')') {
                out.push_str(&self.call(c, &rest[2..end])?);
                rest = &rest[end + 1..];
                last = ')';
            } else {
                out.push(c);
                rest = &rest[c.len_utf8()..];
                last = c;
            }
        }
        Ok(())
    }

    fn call(&self, kind: char, argument: &str) -> Result<String, ExportError> {
        let unknown = || ExportError::Template { place: format!("{kind}({argument})") };
        match kind {
            'R' => {
                let value = match argument.split_once('/') {
                    Some((top, bottom)) => {
                        top.parse().ok().zip(bottom.parse().ok()).map(|(t, b): (f64, f64)| t / b)
                    }
                    None => argument.parse().ok().or_else(|| self.precision.constant(argument)),
                };
                Ok(self.precision.c_literal(value.ok_or_else(unknown)?))
            }
            'F' => Ok(match (self.precision, argument) {
                (_, "HUGE_VAL") => self.precision.c_infinity().into(),
                (Precision::F32, f) => format!("{f}f"),
                (Precision::F64, f) => f.into(),
            }),
            _ => self.coefficients.get(argument).cloned().ok_or_else(unknown),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_and_lines_chosen() {
        let mut filling = Filling::new(Precision::F32);
        filling.key("name", "stage").key("name_long", "x").flag("on", true).coefficients("c", "C");
        let text = "//{ on\n  $name_step(R(1/3), R(0), F(exp)(-K(c)[0]), MAXR(2));\n//{ \
                    off|other\nno\n//}\n//}\n//{ !on\nno\n//}\n$name_long";
        assert_eq!(
            filling.fill(text).unwrap(),
            "  stage_step(0.33333334f, 0.0f, expf(-C[0]), MAXR(2));\nx\n"
        );
        filling.part("of it", "//{ on\n$name\n//}");
        assert_eq!(filling.fill("//+ of it\n.").unwrap(), "stage\n.\n");
        for bad in ["//}", "//{ on", "$nobody", "R(nobody)", "K(nobody)", "//+ nobody"] {
            assert!(filling.fill(bad).is_err(), "{bad}");
        }
    }
}
