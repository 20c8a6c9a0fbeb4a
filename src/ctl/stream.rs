//! The lines of a running daemon, with pauses to look around in.
//!
//! For: connecting, choosing channels, and telling silence from the end. Must not know: what the lines are used for.

use super::CtlError;
use crate::stream::client::{Client, ClientError};
use crate::stream::wire::{Request, ServerMessage, VersionLine, Watch};
use std::path::Path;
use std::time::Duration;

/// How long a verb waits for a line before it looks around: for Ctrl-C, or for the end of its time.
const PATIENCE: Duration = Duration::from_millis(100);
/// How many times that for the first line of a daemon that is busy.
const GREETING: Duration = Duration::from_secs(2);

/// What comes next.
#[derive(Debug)]
pub enum Next {
    /// A line without its newline, and what it says.
    Line(Vec<u8>, ServerMessage),
    /// Nothing for a while.
    Quiet,
    /// The daemon has closed the connection.
    Ended,
}

/// A connection on which the daemon talks.
#[derive(Debug)]
pub struct Stream {
    client: Client,
}

impl Stream {
    /// Connects; the daemon sends readings at once. `channels`: those that will be asked for.
    pub fn connect(socket: &Path, channels: &[String]) -> Result<Stream, CtlError> {
        let mut client = Client::connect(socket, GREETING)?;
        client.set_timeout(PATIENCE)?;
        let known = || client.version().channels.iter().map(|channel| channel.id.clone());
        match channels.iter().find(|wanted| !known().any(|id| id == **wanted)) {
            Some(wanted) => Err(CtlError::NoChannel { wanted: wanted.clone(), known: known().collect() }),
            None => Ok(Stream { client }),
        }
    }

    /// What the daemon has said of itself.
    pub fn version(&self) -> &VersionLine {
        self.client.version()
    }

    /// Asks for something; the answer comes among the lines.
    pub fn request(&mut self, request: &Request) -> Result<(), CtlError> {
        Ok(self.client.request(request)?)
    }

    /// Narrows the stream; an empty list stands for all channels.
    pub fn watch(&mut self, channels: &[String], max_hz: Option<f64>, raw: bool) -> Result<(), CtlError> {
        let channels = (!channels.is_empty()).then(|| channels.to_vec());
        self.request(&Request::Watch(Watch { channels, max_hz, raw, ..Watch::default() }))
    }

    /// The next line, or that there is none.
    pub fn next(&mut self) -> Result<Next, CtlError> {
        match self.client.line() {
            Ok(Some(line)) => {
                let message = self.client.read(&line)?;
                Ok(Next::Line(line, message))
            }
            Ok(None) | Err(ClientError::Closed) => Ok(Next::Ended),
            Err(ClientError::TimedOut(_)) => Ok(Next::Quiet),
            Err(error) => Err(error.into()),
        }
    }
}

/// Whether a channel is among those asked for; an empty list stands for all.
pub fn is_wanted(channels: &[String], id: &str) -> bool {
    channels.is_empty() || channels.iter().any(|wanted| wanted == id)
}
