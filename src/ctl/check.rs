//! Everything that can be said before a start: `cermd --check` and `cermctl check` say the same of the configuration, of
//! the files that it names, and of what stands behind its backend; `cermctl check` tests the hardware, too.

use super::{CtlError, cli, print};
use crate::config::backend::{self, OpenError};
use crate::config::{Backend, Config, ConfigError, Finding, SettingsError, Severity};
use std::fmt;
use std::path::Path;

mod hardware;
pub mod latency;
pub mod wiring;

/// `cermctl check`.
pub(super) fn run(arguments: &cli::Check) -> Result<(), CtlError> {
    let mut report = check(&arguments.config);
    let mut latencies = String::new();
    if let (true, Ok(config)) = (report.is_usable(), &report.config) {
        latencies = hardware::check(config, &mut report.findings);
    }
    print(&(report.to_string() + &latencies))?;
    if report.is_usable() { Ok(()) } else { Err(CtlError::Unusable) }
}

/// Checks a configuration file and, if it can be used, what it names.
pub fn check(path: &Path) -> CheckReport {
    let config = Config::load(path);
    let findings = config.as_ref().map(Config::check).unwrap_or_default();
    let mut report = CheckReport { origin: path.display().to_string(), config, findings };
    if let (true, Ok(config)) = (report.is_usable(), &report.config) {
        report.findings.extend(force_table(config).into_iter().chain(scene(config)));
    }
    report
}

fn force_table(config: &Config) -> Option<Finding> {
    let SettingsError::Table { id, source } = config.settings().err()?;
    Some(Finding::error(format!("channel.{id}.force"), source.to_string()))
}

/// Lines are tested where they may be touched.
fn scene(config: &Config) -> Option<Finding> {
    if config.gpio.backend != Backend::Mock {
        return None;
    }
    match backend::scene(config).err()? {
        OpenError::Scene(scene) => Some(Finding::error("mock.scene", scene.to_string())),
        other => Some(Finding::error("mock", other.to_string())),
    }
}

/// What a configuration file is worth.
#[derive(Debug)]
pub struct CheckReport {
    origin: String,
    config: Result<Config, ConfigError>,
    findings: Vec<Finding>,
}

impl CheckReport {
    /// What was found in a file that could be read.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// Whether the instrument would start: no error, warnings allowed. Decides the exit status.
    pub fn is_usable(&self) -> bool {
        self.config.is_ok() && self.count(Severity::Error) == 0
    }

    fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// What keeps the instrument from starting, a line each.
    pub(super) fn errors(&self) -> String {
        match &self.config {
            Ok(_) => Finding::errors(&self.findings),
            Err(error) => format!("error: {}", error.to_string().trim_end()),
        }
    }
}

impl fmt::Display for CheckReport {
    /// One finding a line, then a summary; each line ends in a line feed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.config.is_err() {
            return writeln!(f, "{}", self.errors());
        }
        for finding in &self.findings {
            writeln!(f, "{finding}")?;
        }
        let (errors, warnings) = (self.count(Severity::Error), self.count(Severity::Warning));
        let verdict = if errors == 0 { "usable" } else { "not usable" };
        writeln!(f, "{}: {verdict}: {errors} error(s), {warnings} warning(s)", self.origin)
    }
}

#[cfg(test)]
mod tests;
