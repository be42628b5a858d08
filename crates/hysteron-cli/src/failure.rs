//! Failure messages: `error:` the failed action, `because:` the reason, `try:` the remedy.

use std::fmt::{self, Display, Formatter};
use std::process::ExitCode;

use hysteron_model::Advice;

use crate::advice;

/// A failure message for the user.
#[derive(Debug)]
pub struct Failure {
    error: String,
    because: Option<String>,
    hint: Option<String>,
    exit_code: u8,
}

impl Failure {
    /// A failure on the data (exit code 1).
    pub fn new(error: impl Into<String>) -> Self {
        Failure { error: error.into(), because: None, hint: None, exit_code: 1 }
    }

    /// Contradictory flags that the command-line parser cannot detect (exit code 2).
    pub fn usage(error: impl Into<String>) -> Self {
        Failure { exit_code: 2, ..Failure::new(error) }
    }

    /// Sets the exit code.
    pub fn exiting_with(self, exit_code: u8) -> Self {
        Failure { exit_code, ..self }
    }

    /// The reason, usually the library's error.
    pub fn because(mut self, reason: impl Display) -> Self {
        self.because = Some(abridged(reason.to_string()));
        self
    }

    /// Adds to the reason.
    pub fn because_also(self, more: impl Display) -> Self {
        let reason = match &self.because {
            Some(reason) => format!("{reason}; {more}"),
            None => more.to_string(),
        };
        self.because(reason)
    }

    /// Sets the remedy.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Puts a remedy before those there are.
    pub fn hint_first(self, hint: impl Into<String>) -> Self {
        let hint = hint.into();
        match &self.hint {
            Some(others) => {
                let all = format!("{hint}; {others}");
                self.hint(all)
            }
            None => self.hint(hint),
        }
    }

    /// Adds the library's remedy, if any, expressed in flags.
    pub fn advised(self, advice: Option<Advice>) -> Self {
        match advice {
            Some(advice) => self.hint(advice::in_flags(&advice)),
            None => self,
        }
    }

    /// True for wrong flags, false for wrong data.
    pub fn is_usage(&self) -> bool {
        self.exit_code == 2
    }

    /// Error and reason in one line.
    pub fn in_a_line(&self) -> String {
        self.because
            .as_ref()
            .map_or_else(|| self.error.clone(), |because| format!("{}: {because}", self.error))
    }

    /// Exit code of the command.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.exit_code)
    }
}

/// Longest reason, and what is kept of a longer one at its beginning and its end \[characters\]: a name or unit
/// of a damaged file may be of any length.
const LONGEST: usize = 2000;
const KEPT: [usize; 2] = [1000, 500];

fn abridged(text: String) -> String {
    let count = text.chars().count();
    if count <= LONGEST {
        return text;
    }
    let begin: String = text.chars().take(KEPT[0]).collect();
    let end: String = text.chars().skip(count - KEPT[1]).collect();
    format!("{begin} … ({} characters left out) … {end}", count - KEPT[0] - KEPT[1])
}

impl Display for Failure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.error)?;
        for (label, text) in [("because", &self.because), ("try", &self.hint)] {
            if let Some(text) = text {
                write!(f, "\n{label}: {text}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_reason_is_abridged() {
        let short = "x".repeat(LONGEST);
        assert_eq!(abridged(short.clone()), short);
        let long = abridged(format!("{}é{}", "a".repeat(2500), "b".repeat(2499)));
        assert!(long.starts_with("aaa") && long.ends_with("bbb"), "{long}");
        assert!(long.contains("(3500 characters left out)"), "{long}");
        assert!(long.chars().count() < 1600);
    }
}
