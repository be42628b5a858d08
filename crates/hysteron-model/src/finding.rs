//! Findings about records, a fit or a model, in plain words.

use std::borrow::Cow;
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Advice;

/// A statement in plain words.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// Severity.
    pub kind: FindingKind,
    /// Topic, in a word or two.
    pub topic: Cow<'static, str>,
    /// The statement.
    pub text: String,
    /// Remedy, for a front end to word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<Advice>,
}

/// Severity of a [`Finding`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FindingKind {
    /// Information.
    Verdict,
    /// The records do not determine something; states what to measure.
    Advice,
    /// Do not use the model without having read this.
    Warning,
}

impl Finding {
    /// A finding about `topic`.
    pub fn new(kind: FindingKind, topic: &'static str, text: impl Into<String>) -> Self {
        Self { kind, topic: Cow::Borrowed(topic), text: text.into(), advice: None }
    }

    /// The finding with its remedy.
    pub fn with_advice(self, advice: Advice) -> Self {
        Self { advice: Some(advice), ..self }
    }

    /// Adds its remedy.
    pub fn advise(&mut self, advice: Advice) {
        self.advice = Some(advice);
    }

    /// True if it is a warning.
    pub fn is_warning(&self) -> bool {
        self.kind == FindingKind::Warning
    }
}

impl FindingKind {
    /// `verdict`, `advice` or `warning`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Verdict => "verdict",
            Self::Advice => "advice",
            Self::Warning => "warning",
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.name(), self.text)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_written_by_their_names_and_findings_read_back() {
        for kind in [FindingKind::Verdict, FindingKind::Advice, FindingKind::Warning] {
            let finding = Finding::new(kind, "units", "the output has no unit")
                .with_advice(Advice::ScaleColumn { column: "y".to_owned() });
            let json = serde_json::to_value(&finding).unwrap();
            assert_eq!(json["kind"], kind.name());
            assert_eq!(serde_json::from_value::<Finding>(json).unwrap(), finding);
        }
    }
}
