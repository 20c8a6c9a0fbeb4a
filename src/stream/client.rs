//! The other end of the socket: what `cermctl` and other Rust programs use. It needs no feature of the crate
//! (`default-features = false`).
//!
//! ```no_run
//! # fn main() -> Result<(), cermd::client::ClientError> {
//! use cermd::{client::Client, wire::ServerMessage};
//! use std::{path::Path, time::Duration};
//!
//! let mut client = Client::connect(Path::new("/run/cermd/cermd.sock"), Duration::from_secs(2))?;
//! while let Some(message) = client.message()? {
//!     if let ServerMessage::Reading(reading) = message {
//!         println!("{} {:?} N", reading.channel, reading.state.f_n);
//!     }
//! }
//! # Ok(())
//! # }
//! ```

use crate::stream::wire::{
    ErrorLine, LineSplitter, LineTooLong, PROTO_MAJOR, Request, ServerMessage, UnreadableLine, VersionLine,
};
use std::io::{self, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// There is no such file.
    #[error("no socket {0}: is cermd running? (systemctl status cermd)")]
    NoSocket(PathBuf),
    /// There is a file, but nobody behind it.
    #[error("nobody answers at {0}: cermd was killed or is still starting (systemctl status cermd)")]
    NobodyThere(PathBuf),
    /// We may not write to the socket.
    #[error("no permission for {path}: {hint}")]
    Permission {
        /// The socket.
        path: PathBuf,
        /// Who may, and how to become one of them.
        hint: String,
    },
    /// The server has nothing more to say, or is gone.
    #[error("cermd closed the connection; it was stopped or restarted")]
    Closed,
    /// Nothing came within the time-out.
    #[error(
        "no answer from cermd within {0:?}: it hangs, or the machine is too busy (systemctl status cermd)"
    )]
    TimedOut(Duration),
    /// The first line was a refusal: too many clients.
    #[error("cermd refused the connection: {0}")]
    Refused(String),
    /// It speaks another protocol.
    #[error("cermd speaks protocol {0}, this program {PROTO_MAJOR}: install the same release of both")]
    OtherProtocol(u32),
    /// It speaks no protocol of ours.
    #[error(transparent)]
    Unreadable(#[from] UnreadableLine),
    /// Another failure of the connection.
    #[error("connection to cermd: {0}")]
    Io(#[from] io::Error),
}

/// A connection to a running daemon. Calls wait, at most as long as the time-out.
#[derive(Debug)]
pub struct Client {
    socket: UnixStream,
    input: LineSplitter,
    timeout: Duration,
    version: VersionLine,
}

impl Client {
    /// Connects, and reads the VERSION. `timeout` holds for each later wait, too, and must not be 0.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn connect(path: &Path, timeout: Duration) -> Result<Client, ClientError> {
        let socket = UnixStream::connect(path).map_err(|error| explain(path, error))?;
        socket.set_read_timeout(Some(timeout))?;
        socket.set_write_timeout(Some(timeout))?;
        let (input, version) = (LineSplitter::default(), VersionLine::new(&[]));
        let mut client = Client { socket, input, timeout, version };
        match client.message()?.ok_or(ClientError::Closed)? {
            ServerMessage::Version(version) if version.proto_major != PROTO_MAJOR => {
                Err(ClientError::OtherProtocol(version.proto_major))
            }
            ServerMessage::Version(_) => Ok(client),
            ServerMessage::Error(ErrorLine { message, .. }) => Err(ClientError::Refused(message)),
            _ => Err(UnreadableLine("the first line is no VERSION".to_owned()).into()),
        }
    }

    /// Waits at most so long for a line from now on; not 0.
    ///
    /// # Errors
    /// The system refuses the time-out.
    pub fn set_timeout(&mut self, timeout: Duration) -> Result<(), ClientError> {
        self.socket.set_read_timeout(Some(timeout))?;
        self.timeout = timeout;
        Ok(())
    }

    /// The last VERSION that was read: the release and the channels of the daemon.
    pub fn version(&self) -> &VersionLine {
        &self.version
    }

    /// Sends a request. Its answer comes among the messages.
    ///
    /// # Errors
    /// [`ClientError::Closed`] or [`ClientError::TimedOut`].
    pub fn request(&mut self, request: &Request) -> Result<(), ClientError> {
        self.socket.write_all(&request.to_line()).map_err(|error| self.failed(error))
    }

    /// The next line, as it came. `None`: the server has closed the connection; a last line without a newline is
    /// dropped.
    ///
    /// # Errors
    /// [`ClientError::TimedOut`]: nothing is lost, the call may be repeated.
    pub fn line(&mut self) -> Result<Option<Vec<u8>>, ClientError> {
        let mut chunk = [0; 16 * 1024];
        loop {
            match self.input.next_line() {
                Some(Ok(line)) => return Ok(Some(line)),
                Some(Err(LineTooLong)) => {
                    return Err(UnreadableLine("a line that never ends".to_owned()).into());
                }
                None => {}
            }
            match self.socket.read(&mut chunk) {
                Ok(0) => return Ok(None),
                Ok(length) => self.input.feed(&chunk[..length]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::ConnectionReset => return Ok(None),
                Err(error) => return Err(self.failed(error)),
            }
        }
    }

    /// The next line, read. `None`: the server has closed the connection.
    ///
    /// # Errors
    /// As [`line`](Client::line), and [`ClientError::Unreadable`].
    pub fn message(&mut self) -> Result<Option<ServerMessage>, ClientError> {
        let Some(line) = self.line()? else { return Ok(None) };
        self.read(&line).map(Some)
    }

    /// What a [`line`](Client::line) says; a VERSION is remembered.
    ///
    /// # Errors
    /// [`ClientError::Unreadable`].
    pub fn read(&mut self, line: &[u8]) -> Result<ServerMessage, ClientError> {
        let message = ServerMessage::parse(line)?;
        if let ServerMessage::Version(version) = &message {
            self.version.clone_from(version);
        }
        Ok(message)
    }

    fn failed(&self, error: io::Error) -> ClientError {
        match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => ClientError::TimedOut(self.timeout),
            io::ErrorKind::BrokenPipe | io::ErrorKind::ConnectionReset => ClientError::Closed,
            _ => ClientError::Io(error),
        }
    }
}

fn explain(path: &Path, error: io::Error) -> ClientError {
    match error.kind() {
        io::ErrorKind::NotFound => ClientError::NoSocket(path.to_owned()),
        io::ErrorKind::ConnectionRefused => ClientError::NobodyThere(path.to_owned()),
        io::ErrorKind::PermissionDenied => {
            ClientError::Permission { path: path.to_owned(), hint: who_may_write(path) }
        }
        _ => ClientError::Io(error),
    }
}

fn who_may_write(path: &Path) -> String {
    let Ok(metadata) = path.metadata() else {
        return "its directory may not be searched by this user: try sudo".to_owned();
    };
    hint_of(metadata.mode(), metadata.gid())
}

/// Nobody is to join the group of root.
fn hint_of(mode: u32, gid: u32) -> String {
    if mode & 0o020 == 0 {
        return "it is open to its owner only: try sudo, or set [server] mode = \"0660\"".to_owned();
    }
    if gid == 0 {
        return "it belongs to root: try sudo, or run cermd by its unit, as a user of its own".to_owned();
    }
    let group = group_name(gid).unwrap_or_else(|| gid.to_string());
    format!("it is open to group {group}: sudo usermod -aG {group} $USER, then log in again")
}

/// Of a local group, where a daemon's group is; usermod takes a number as well.
fn group_name(gid: u32) -> Option<String> {
    let groups = std::fs::read_to_string("/etc/group").ok()?;
    let mut groups = groups.lines().map(|line| line.split(':'));
    groups.find_map(|mut fields| {
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(gid)).then(|| name.to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_is_told_to_join_the_group_of_root() {
        assert!(hint_of(0o660, 1234).contains("usermod -aG 1234 "));
        for hint in [hint_of(0o660, 0), hint_of(0o600, 1234)] {
            assert!(hint.contains("try sudo") && !hint.contains("usermod"), "{hint}");
        }
    }

    #[test]
    fn groups_have_names() {
        assert_eq!(group_name(0).as_deref(), Some("root"));
        assert_eq!(group_name(u32::MAX), None);
    }
}
