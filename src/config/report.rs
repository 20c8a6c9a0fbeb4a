//! The report of `cermd --check` and `cermctl check`.
//!
//! For: both programs saying the same. Must not know: who prints it.

use super::{Config, ConfigError, Finding, Severity};
use std::fmt;
use std::path::Path;

/// What a configuration file is worth.
#[derive(Debug)]
pub struct Report {
    /// The file.
    pub origin: String,
    /// Its findings, or why it could not be read.
    pub outcome: Result<Vec<Finding>, ConfigError>,
}

/// Reads a file and checks it.
pub fn report(path: &Path) -> Report {
    Report { origin: path.display().to_string(), outcome: Config::load(path).map(|config| config.check()) }
}

impl Report {
    /// Whether the instrument would start: no error, warnings allowed. Decides the exit status.
    pub fn is_usable(&self) -> bool {
        match &self.outcome {
            Ok(findings) => findings.iter().all(|finding| finding.severity != Severity::Error),
            Err(_) => false,
        }
    }
}

impl fmt::Display for Report {
    /// One finding a line, then a summary; each line ends in a line feed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let findings = match &self.outcome {
            Ok(findings) => findings,
            Err(error) => return writeln!(f, "error: {}", error.to_string().trim_end()),
        };
        for finding in findings {
            writeln!(f, "{finding}")?;
        }
        let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
        let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
        let verdict = if errors == 0 { "usable" } else { "not usable" };
        writeln!(f, "{}: {verdict}: {errors} error(s), {warnings} warning(s)", self.origin)
    }
}
