//! Findings.
//!
//! For: x. Must not know: y.

use super::Config;
use std::fmt;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The instrument refuses to start.
    Error,
    /// It works, but not well.
    Warning,
    /// A prediction.
    Info,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "info",
        })
    }
}

/// One thing that [`Config::check`] has to say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// The key it is about, `circuit.r-c1`.
    pub key: String,
    /// What is wrong, or what is predicted.
    pub reason: String,
    /// What to do; empty for a prediction.
    pub remedy: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}: {}", self.severity, self.key, self.reason)?;
        if !self.remedy.is_empty() {
            write!(f, "; try {}", self.remedy)?;
        }
        Ok(())
    }
}

impl Config {
    /// Everything that is wrong or worth knowing.
    pub fn check(&self) -> Vec<Finding> {
        Vec::new()
    }
}
