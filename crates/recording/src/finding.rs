//! Findings: something odd in usable data, with what it means for a verdict.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Effect of a finding on a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Worth knowing; changes nothing.
    Info,
    /// Worth a look before the verdict is used; changes nothing.
    Warning,
    /// The data cannot carry a pass: the verdict is unusable unless the lever was lost before `at_s`.
    Blocking,
}

impl Severity {
    /// Name, as documents have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Blocking => "blocking",
        }
    }
}

/// Something odd in a recording, its conditioning or its replay.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Stable name, listed in `docs/findings.md`.
    pub code: Cow<'static, str>,
    /// Effect on a verdict.
    pub severity: Severity,
    /// One or two sentences: the observation and its meaning.
    pub text: String,
    /// The instant from which it holds, on the recording's clock [s]; `None` for the whole record.
    pub at_s: Option<f64>,
    /// True if a pass needs a person's confirmation, and is undecided without; nothing else changes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub needs_word: bool,
}

impl Finding {
    /// Builds a finding that changes nothing.
    pub fn info(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(code, Severity::Info, text.into())
    }

    /// Builds a finding that asks for a look.
    pub fn warning(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(code, Severity::Warning, text.into())
    }

    /// Builds a finding that forbids a pass.
    pub fn blocking(code: &'static str, text: impl Into<String>) -> Self {
        Self::new(code, Severity::Blocking, text.into())
    }

    /// Adds the instant from which it holds [s].
    pub fn at(mut self, at_s: f64) -> Self {
        self.at_s = Some(at_s);
        self
    }

    /// Makes a pass depend on a person's word.
    pub fn needing_word(mut self) -> Self {
        self.needs_word = true;
        self
    }

    /// Sets the instant from which it holds, if that is known [s].
    pub(super) fn since(self, at_s: Option<f64>) -> Self {
        Self { at_s, ..self }
    }

    /// Warns of a channel that is not plainly a lateral acceleration of the structure.
    pub(super) fn not_lateral(name: &str, doubt: &str) -> Self {
        let text = format!(
            "`{name}` is not clearly a lateral acceleration of the struck vehicle's structure: \
             {doubt}. Check the channel"
        );
        Self::warning("channel-not-lateral", text)
    }

    /// Warns of a channel that was filtered before it was stored; `reason` is the evidence.
    pub(super) fn filtered(reason: &str) -> Self {
        let text = format!(
            "{reason}. No filter setting brings back what that removed. Use the unfiltered channel"
        );
        Self::warning("already-filtered", text)
    }

    fn new(code: &'static str, severity: Severity, text: String) -> Self {
        Self {
            code: Cow::Borrowed(code),
            severity,
            text,
            at_s: None,
            needs_word: false,
        }
    }
}
