//! What a check has found: which key, how bad, why, and what to try.

use crate::units::named;
use std::fmt;

named! {
    /// How bad a finding is.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    Severity {
        /// The instrument refuses to start.
        Error = "error",
        /// It works, but not as well as it could, or not as was meant.
        Warning = "warning",
        /// A prediction.
        Info = "info",
    }
}

/// One thing that a check has to say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The key it is about: `circuit.r-c1`, `channel.thumb.sink`.
    pub key: String,
    /// What is wrong, or what is predicted.
    pub reason: String,
    /// What to try; absent from predictions.
    pub remedy: Option<String>,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.severity, self.key, self.reason)?;
        match &self.remedy {
            Some(remedy) => write!(f, "; try {remedy}"),
            None => Ok(()),
        }
    }
}

/// What a check has found, in the order in which it is printed.
#[derive(Debug, Clone, Default)]
pub struct Findings(pub Vec<Finding>);

impl Findings {
    /// Those of one severity.
    pub fn of(&self, severity: Severity) -> impl Iterator<Item = &Finding> {
        self.0.iter().filter(move |finding| finding.severity == severity)
    }

    /// Whether something keeps the instrument from working.
    pub fn has_errors(&self) -> bool {
        self.of(Severity::Error).next().is_some()
    }

    /// The errors, a line each; empty if there is none.
    pub fn errors(&self) -> String {
        self.of(Severity::Error).map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }

    /// One more; `remedy`: what to try.
    pub(crate) fn add(
        &mut self,
        severity: Severity,
        key: impl Into<String>,
        reason: impl ToString,
        remedy: Option<&str>,
    ) {
        let remedy = remedy.map(str::to_owned);
        self.0.push(Finding { severity, key: key.into(), reason: reason.to_string(), remedy });
    }

    /// What keeps the instrument from working.
    pub(crate) fn error(&mut self, key: impl Into<String>, reason: impl ToString, remedy: impl AsRef<str>) {
        self.add(Severity::Error, key, reason, Some(remedy.as_ref()));
    }

    /// What makes it worse than it could be.
    pub(crate) fn warning(&mut self, key: impl Into<String>, reason: impl ToString, remedy: impl AsRef<str>) {
        self.add(Severity::Warning, key, reason, Some(remedy.as_ref()));
    }

    /// What is worth knowing.
    pub(crate) fn info(&mut self, key: impl Into<String>, reason: impl ToString) {
        self.add(Severity::Info, key, reason, None);
    }
}
