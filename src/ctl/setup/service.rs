//! The service manager, as far as a setup needs it.

use super::CtlError;
use std::io;
use std::path::Path;
use std::process::{Command, Output};

/// The service.
pub const UNIT: &str = "cermd.service";

/// Whether there is one that this user may ask for something.
pub fn can_be_asked() -> bool {
    Path::new("/run/systemd/system").is_dir() && nix::unistd::geteuid().is_root()
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
