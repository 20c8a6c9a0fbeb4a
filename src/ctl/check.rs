//! Everything that can be said before a start: `cermd --check` and `cermctl check` say the same of the configuration, of
//! the files that it names, and of what stands behind its backend; `cermctl check` tests the hardware, too.

use super::terminal::Terminal;
use super::{CtlError, cli};
use crate::config::backend::{self, OpenError};
use crate::config::{Backend, Config, ConfigError, Findings, SettingsError, Severity};
use crate::instrument::discharge::Plan;
use crate::record::Through;
use crate::units::Nanos;
use hardware::Tried;
use std::fmt;
use std::path::Path;

pub mod expect;
mod hardware;
pub mod latency;
mod metered;
mod processor;
pub mod wiring;

/// `cermctl check`.
pub(super) fn run(arguments: &cli::Check) -> Result<(), CtlError> {
    let mut report = check(&arguments.file.path);
    let mut extra = String::new();
    if let (true, Ok(config)) = (report.is_usable(), &report.config) {
        let Tried { latencies, busy } = hardware::check(config, &mut report.findings);
        extra = latencies;
        if let (false, Ok(settings)) = (report.findings.has_errors(), config.settings()) {
            extra += &processor::text(config, &settings, busy);
        }
    }
    let text = report.to_string() + &extra;
    let mut terminal = Terminal::new();
    text.lines().try_for_each(|line| terminal.say(line))?;
    let refusal = || CtlError::said("not usable as it is: see the findings above");
    report.is_usable().then_some(()).ok_or_else(refusal)
}

/// Checks a configuration file and, if it can be used, what it names; says what readings are to be expected.
pub fn check(path: &Path) -> CheckReport {
    let mut report = usable(path, Config::load(path));
    if let (true, Ok(config)) = (report.is_usable(), &report.config) {
        if let Ok(settings) = config.settings() {
            expect::readings(config, &settings, None, &mut report.findings);
        }
    }
    report
}

/// The same, without a rehearsal, of a configuration that was read, or was not, from that file.
pub(super) fn usable(path: &Path, config: Result<Config, ConfigError>) -> CheckReport {
    let findings = config.as_ref().map(Config::check).unwrap_or_default();
    let mut report = CheckReport { origin: path.display().to_string(), config, findings };
    if let (true, Ok(config)) = (report.is_usable(), &report.config) {
        named_files(config, &mut report.findings);
    }
    report
}

/// A full discharge of the configured circuit, up to its last node, whether the method times it or not.
fn full_plan(config: &Config, through: Through, timeout: Nanos) -> Plan {
    let last = config.circuit.kind().last();
    Plan { settle: config.settle_time(), ..Plan::full(through, last, config.charges().anew, timeout) }
}

/// Lines are tested where they may be touched.
fn named_files(config: &Config, findings: &mut Findings) {
    let mut error = |key: &str, reason: &dyn fmt::Display| findings.add(Severity::Error, key, reason, None);
    if let Err(SettingsError { id, key, reason }) = config.settings() {
        error(&format!("channel.{id}.{key}"), &reason);
    }
    let scene = (config.gpio.backend == Backend::Mock).then(|| backend::scene(config));
    match scene {
        Some(Err(OpenError::Scene(scene))) => error("mock.scene", &scene),
        Some(Err(other)) => error("mock", &other),
        Some(Ok(_)) | None => {}
    }
}

/// What a configuration file is worth.
#[derive(Debug)]
pub struct CheckReport {
    origin: String,
    config: Result<Config, ConfigError>,
    findings: Findings,
}

impl CheckReport {
    /// Whether the instrument would start: no error, warnings allowed. Decides the exit status.
    pub fn is_usable(&self) -> bool {
        self.config.is_ok() && !self.findings.has_errors()
    }

    /// What keeps the instrument from starting, a line each.
    pub(super) fn errors(&self) -> String {
        match &self.config {
            Ok(_) => self.findings.errors(),
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
        for finding in &self.findings.0 {
            writeln!(f, "{finding}")?;
        }
        let [errors, warnings] =
            [Severity::Error, Severity::Warning].map(|severity| self.findings.of(severity).count());
        let verdict = if errors == 0 { "usable" } else { "not usable" };
        writeln!(f, "{}: {verdict}: {errors} error(s), {warnings} warning(s)", self.origin)
    }
}

#[cfg(test)]
mod tests;
