//! What is wrong with a configuration that parses, and what to expect of one that is right.
//!
//! For: findings, each with its key, its reason and a remedy. Must not know: the file system, the hardware, or who
//! prints them; everything here follows from the configuration alone.

mod channels;
mod circuit;
mod gpio;
mod measure;
mod predict;
mod realtime;
mod server;

pub use channels::LARGEST_ZERO_OHM;

use super::Config;
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

/// One thing that [`Config::check`] has to say.
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

/// Findings so far.
#[derive(Default)]
struct Findings(Vec<Finding>);

impl Findings {
    fn error(&mut self, key: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) {
        self.push(Severity::Error, key.into(), reason.into(), Some(remedy.into()));
    }

    fn warning(&mut self, key: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) {
        self.push(Severity::Warning, key.into(), reason.into(), Some(remedy.into()));
    }

    fn info(&mut self, key: impl Into<String>, reason: impl Into<String>) {
        self.push(Severity::Info, key.into(), reason.into(), None);
    }

    fn push(&mut self, severity: Severity, key: String, reason: String, remedy: Option<String>) {
        self.0.push(Finding { severity, key, reason, remedy });
    }

    fn has_errors(&self) -> bool {
        self.0.iter().any(|finding| finding.severity == Severity::Error)
    }
}

impl Config {
    /// Everything that is wrong or worth knowing; what is compared with predicted times comes last, and only
    /// when circuit and settings are right in themselves.
    pub fn check(&self) -> Vec<Finding> {
        let mut findings = Findings::default();
        circuit::check(&self.circuit, &mut findings);
        measure::check(self, &mut findings);
        let predictable = !findings.has_errors();
        if channels::number(&self.channels, &mut findings) {
            gpio::check(self, &mut findings);
            channels::check(&self.channels, &mut findings);
        }
        server::check(self, &mut findings);
        realtime::check(&self.realtime, &mut findings);
        if predictable {
            predict::check(self, &mut findings);
        }
        findings.0
    }
}

#[cfg(test)]
mod tests;
