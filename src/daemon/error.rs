//! Why the daemon does not run, and what the service manager is to make of that.

use super::measuring::Stuck;
use crate::config::backend::{CONSUMER, OpenError};
use crate::config::{ConfigError, SettingsError};
use crate::pins::chardev::ChardevError;
use crate::stream::server::ListenError;
use std::io;

/// Why the daemon does not run.
#[derive(Debug, thiserror::Error)]
pub enum DaemonError {
    /// The configuration cannot be read.
    #[error("{0}")]
    Config(#[from] ConfigError),
    /// A file that it names is wrong.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// There are no pins.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// There is no socket.
    #[error(transparent)]
    Listen(#[from] ListenError),
    /// The configuration cannot work.
    #[error("{0}")]
    NotUsable(String),
    /// The system refuses something basic.
    #[error("{0}")]
    Refused(String),
    /// The measuring thread cannot be stopped.
    #[error(transparent)]
    Stuck(#[from] Stuck),
    /// The measuring or the triggering thread has panicked, which is a mistake of the program.
    #[error(
        "a thread that does the work has died; every line is released. Please report this with the lines above"
    )]
    Died,
}

impl DaemonError {
    /// Whether the next start would end in the same way: only another configuration or another wiring helps.
    pub fn is_lasting(&self) -> bool {
        match self {
            DaemonError::Config(_) | DaemonError::NotUsable(_) | DaemonError::Settings(_) => true,
            DaemonError::Open(OpenError::Hardware(error)) => matches!(error, ChardevError::Wiring(_)),
            DaemonError::Open(_) => true,
            DaemonError::Listen(_) | DaemonError::Refused(_) | DaemonError::Stuck(_) | DaemonError::Died => {
                false
            }
        }
    }

    /// Whether there is nothing to measure with until the chip comes.
    pub fn is_absent(&self) -> bool {
        matches!(self, DaemonError::Open(OpenError::Hardware(ChardevError::NoChip { .. })))
    }
}

/// Whether another program holds a line that was asked for: it may let go of it.
pub fn is_held(error: &OpenError) -> bool {
    matches!(error, OpenError::Hardware(error) if error.is_busy())
}

/// Whether the holder is known, and another program than a cermd; of one that was killed the kernel may still have the lines.
pub fn is_of_others(error: &OpenError) -> bool {
    matches!(error, OpenError::Hardware(error) if error.is_held_by_others_than(CONSUMER))
}

pub fn system(call: &'static str) -> impl Fn(io::Error) -> DaemonError {
    move |error| DaemonError::Refused(format!("{call}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_that_is_away_may_come_a_line_without_an_interrupt_stays_so() {
        let opened = |error| DaemonError::Open(OpenError::Hardware(error));
        let wiring = opened(ChardevError::Wiring("sense-a (GPIO5) has no interrupt".into()));
        let chip = opened(ChardevError::NoChip { wanted: "pinctrl-rp1".into(), present: String::new() });
        assert!(wiring.is_lasting() && !wiring.is_absent());
        assert!(!chip.is_lasting() && chip.is_absent());
    }
}
