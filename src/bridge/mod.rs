//! What the socket says, in the words of other systems. Each bridge is a client of the daemon in a process of its own.
//!
//! For: readings where people already look for values. Must not know: how anything is measured, how the instrument is
//! configured, GPIO.
//!
//! Two rules hold for every bridge. What is told is fresh: a reading older than its patience, or of a daemon that is gone,
//! is told no more, and none of an outage is told afterwards. And a state stays a state: where there is no number, none is
//! made up.

mod feed;
pub mod http;
pub mod iio;
mod latest;
mod limits;
pub mod mqtt;
pub mod prometheus;
mod queue;
mod server;
pub mod web;

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What all bridges need to know.
#[derive(Debug, Clone)]
pub struct Upstream {
    /// The socket of the daemon.
    pub socket: PathBuf,
    /// A reading that is older is told no more.
    pub patience: Duration,
}

/// Whether somebody wants the end.
pub type Wish<'a> = &'a (dyn Fn() -> bool + Sync);

/// What threads share, even if one of them has died with it.
fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Why a bridge cannot start. Once it runs it does not give up: a peer that is gone may come back.
#[derive(Debug, thiserror::Error)]
pub enum BridgeError {
    /// The address is not to be had.
    #[error("--listen {address}: {error}; {hint}", hint = look_where(.error))]
    Listen {
        /// The one that was asked for.
        address: SocketAddr,
        /// What the system says.
        error: io::Error,
    },
    /// A file that was named cannot be read.
    #[error("{path}: {error}; {hint}", path = path.display(), hint = crate::files::hint(.error))]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: io::Error,
    },
    /// The system refuses something basic.
    #[error("{what}: {error}")]
    System {
        /// What was tried.
        what: &'static str,
        /// What the system says.
        error: io::Error,
    },
}

fn look_where(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::AddrInUse => "another program listens there: choose another port",
        io::ErrorKind::AddrNotAvailable => "this machine has no such address",
        io::ErrorKind::PermissionDenied => "ports below 1024 are for root: choose a higher one",
        _ => "is it an address of this machine, and its port free?",
    }
}
