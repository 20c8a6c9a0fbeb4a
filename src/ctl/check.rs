//! Everything that can be said before a start.
//!
//! For: `cermd --check` and `cermctl check` saying the same of the configuration, of the files that it names, and of
//! what stands behind its backend. Must not know: who prints it.

use crate::config::SettingsError;
use crate::config::backend::{self, OpenError};
use crate::config::{self, Backend, Config, Finding, Report, Severity};
use std::path::Path;

pub mod latency;
pub mod wiring;

/// Checks a configuration file and, if it can be used, what it names.
pub fn check(path: &Path) -> Report {
    let mut report = config::report(path);
    let is_usable = report.is_usable();
    if let (true, Ok(findings), Ok(config)) = (is_usable, &mut report.outcome, Config::load(path)) {
        findings.extend(files(&config));
        findings.extend(behind(&config));
    }
    report
}

/// The tables of forces.
fn files(config: &Config) -> Option<Finding> {
    let SettingsError::Table { id, source } = config.settings().err()?;
    Some(error(format!("channel.{id}.force"), source.to_string()))
}

/// The circuit that is to be measured.
fn behind(config: &Config) -> Option<Finding> {
    match config.gpio.backend {
        Backend::Mock => match backend::scene(config).err()? {
            OpenError::Scene(scene) => Some(error("mock.scene", scene.to_string())),
            other => Some(error("mock", other.to_string())),
        },
        // The lines themselves are tested where they may be touched.
        Backend::Chardev | Backend::ChardevV1 => None,
    }
}

fn finding(severity: Severity, key: impl Into<String>, reason: impl Into<String>) -> Finding {
    Finding { severity, key: key.into(), reason: reason.into(), remedy: None }
}

/// What keeps the instrument from working.
pub(crate) fn error(key: impl Into<String>, reason: impl Into<String>) -> Finding {
    finding(Severity::Error, key, reason)
}

/// What makes it worse than it could be.
pub(crate) fn warning(key: impl Into<String>, reason: impl Into<String>) -> Finding {
    finding(Severity::Warning, key, reason)
}

/// What is worth knowing.
pub(crate) fn info(key: impl Into<String>, reason: impl Into<String>) -> Finding {
    finding(Severity::Info, key, reason)
}

impl Finding {
    /// The same with something to try.
    pub(crate) fn try_this(self, remedy: impl Into<String>) -> Finding {
        Finding { remedy: Some(remedy.into()), ..self }
    }
}
