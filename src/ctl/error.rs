//! What went wrong, as a sentence with a hint: the last line that a person sees of a verb that failed.

use crate::bridge::BridgeError;
use crate::characterize::cell::CellError;
use crate::characterize::folder::FolderError;
use crate::config::ConfigError;
use crate::daemon::DaemonError;
use crate::files::{self, FileError};
use crate::pins::sim::SceneError;
use crate::stream::client::ClientError;
use std::io;
use std::path::Path;

/// Why a verb failed.
#[derive(Debug, thiserror::Error)]
pub enum CtlError {
    /// No daemon that answers.
    #[error("{0}{hint}", hint = elsewhere(.0))]
    Client(#[from] ClientError),
    /// What a person needs to hear, whole.
    #[error("{0}")]
    Said(String),
    /// The configuration cannot be read.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The scene of the demo.
    #[error("--scene: {0}")]
    Scene(#[from] SceneError),
    /// The folder of a sweep.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A file or a folder.
    #[error(transparent)]
    File(#[from] FileError),
    /// A cell of a sweep.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// The daemon inside the demo.
    #[error("the simulated instrument: {0}")]
    Daemon(#[from] DaemonError),
    /// A bridge cannot start.
    #[error(transparent)]
    Bridge(#[from] BridgeError),
    /// Standard output is gone.
    #[error("standard output: {0}")]
    Output(io::Error),
}

/// Where else there are readings.
fn elsewhere(error: &ClientError) -> &'static str {
    match error {
        ClientError::NoSocket(_) | ClientError::NobodyThere(_) => "; no hardware? try `cermctl demo`",
        _ => "",
    }
}

fn look_where(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "is the path right, and is its directory there?",
        io::ErrorKind::PermissionDenied => "this user may not; choose another place, or try sudo",
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::FileTooLarge => {
            files::hint(error)
        }
        io::ErrorKind::AlreadyExists => "another program has just made it; nothing was changed, try again",
        _ => "is it a file, and is there room?",
    }
}

impl CtlError {
    /// A sentence of its own.
    pub(super) fn said(why: impl ToString) -> CtlError {
        CtlError::Said(why.to_string())
    }

    /// No channel of this name.
    pub(super) fn no_channel(wanted: &str, known: &[String]) -> CtlError {
        CtlError::Said(format!("no channel \"{wanted}\": there is {}", known.join(", ")))
    }

    /// A file cannot be read or written.
    pub(super) fn file(path: &Path) -> impl Fn(io::Error) -> CtlError {
        move |error| FileError::at(path, look_where)(error).into()
    }

    /// The system refuses something basic.
    pub(super) fn system(what: &str) -> impl Fn(io::Error) -> CtlError {
        move |error| CtlError::Said(format!("{what}: {error}"))
    }

    /// Whether the reader of our standard output has gone away, which is his right.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, CtlError::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}
