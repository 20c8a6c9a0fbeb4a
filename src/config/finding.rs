//! What a check has found: which key, how bad, why, and what to try.

use std::fmt;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The instrument refuses to start.
    Error,
    /// It works, but not as well as it could, or not as was meant.
    Warning,
    /// A prediction.
    Info,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        })
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

impl Finding {
    fn new(severity: Severity, key: impl Into<String>, reason: impl Into<String>) -> Finding {
        Finding { severity, key: key.into(), reason: reason.into(), remedy: None }
    }

    /// What keeps the instrument from working.
    pub(crate) fn error(key: impl Into<String>, reason: impl Into<String>) -> Finding {
        Finding::new(Severity::Error, key, reason)
    }

    /// What makes it worse than it could be.
    pub(crate) fn warning(key: impl Into<String>, reason: impl Into<String>) -> Finding {
        Finding::new(Severity::Warning, key, reason)
    }

    /// What is worth knowing.
    pub(crate) fn info(key: impl Into<String>, reason: impl Into<String>) -> Finding {
        Finding::new(Severity::Info, key, reason)
    }

    /// The same with something to try.
    pub(crate) fn try_this(self, remedy: impl Into<String>) -> Finding {
        Finding { remedy: Some(remedy.into()), ..self }
    }

    /// The errors among findings, a line each; empty if there is none.
    pub(crate) fn errors(findings: &[Finding]) -> String {
        let errors = findings.iter().filter(|finding| finding.severity == Severity::Error);
        errors.map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }
}
