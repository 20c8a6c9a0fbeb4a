//! The service manager, as far as a setup needs it.

use super::CtlError;
use crate::ctl::cli::{CONFIGURATION, Setup};
use std::fs;
use std::io;
use std::path::Path;
use std::process::{Command, Output};

/// The service.
pub const UNIT: &str = "cermd.service";

/// Why the service is left alone; `None`: it is not.
pub fn left_alone(arguments: &Setup) -> Option<&'static str> {
    let real = |path: &Path| fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if arguments.no_service {
        Some("as asked for")
    } else if real(&arguments.file.path) != real(Path::new(CONFIGURATION)) {
        Some("it has a configuration of its own, /etc/cermd/cermd.toml")
    } else if !Path::new("/run/systemd/system").is_dir() || !nix::unistd::geteuid().is_root() {
        Some("it takes root and systemd")
    } else {
        None
    }
}

/// Whether it is started at boot.
pub fn is_enabled() -> bool {
    systemctl(&["is-enabled", "--quiet", UNIT]).is_ok_and(|output| output.status.success())
}

/// Whether the service runs.
pub fn is_active() -> bool {
    systemctl(&["is-active", "--quiet", UNIT]).is_ok_and(|output| output.status.success())
}

/// Asks for something, and waits until it is done.
pub fn run(what: &[&str]) -> Result<(), CtlError> {
    let command = format!("systemctl {}", what.join(" "));
    let output = systemctl(what).map_err(CtlError::system(&command))?;
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(CtlError::Said(format!(
        "{command}: {}; is the package installed whole? journalctl -u cermd",
        said.trim()
    )))
}

fn systemctl(what: &[&str]) -> io::Result<Output> {
    Command::new("systemctl").args(what).output()
}
