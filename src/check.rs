//! Everything that can be said before a start.
//!
//! For: `cermd --check` and `cermctl check` saying the same of the configuration, of the files that it names, and of
//! what stands behind its backend. Must not know: who prints it.

use crate::backend::{self, OpenError};
use crate::config::{self, Backend, Config, Finding, Report, Severity};
use crate::settings::{Settings, SettingsError};
use std::path::Path;

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
    match Settings::new(config).err()? {
        SettingsError::Table { id, source } => Some(error(format!("channel.{id}.force"), source.to_string())),
        other => Some(error("measure.method".to_owned(), other.to_string())),
    }
}

/// The circuit that is to be measured.
fn behind(config: &Config) -> Option<Finding> {
    match config.gpio.backend {
        Backend::Mock => match backend::scene(config).err()? {
            OpenError::Scene(scene) => Some(error("mock.scene".to_owned(), scene.to_string())),
            other => Some(error("mock".to_owned(), other.to_string())),
        },
        Backend::Chardev | Backend::ChardevV1 => Some(Finding {
            severity: Severity::Info,
            key: "gpio".to_owned(),
            reason: "the chip and its lines were not looked at; starting cermd tells".to_owned(),
            remedy: None,
        }),
    }
}

fn error(key: String, reason: String) -> Finding {
    Finding { severity: Severity::Error, key, reason, remedy: None }
}
