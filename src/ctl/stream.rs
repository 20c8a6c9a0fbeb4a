//! The lines of a running daemon, with pauses to look around in.

use super::CtlError;
use super::limits::{ANSWER, LOOK_AROUND};
use crate::stream::client::{Client, ClientError};
use crate::stream::wire::{ErrorCode, Request, ServerMessage, StatsLine, VersionLine, Watch};
use std::path::Path;
use std::time::{Duration, Instant};

/// What comes next.
#[derive(Debug)]
pub enum Next {
    /// A line without its newline, and what it says.
    Line(String, ServerMessage),
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
        let mut client = Client::connect(socket, ANSWER)?;
        client.set_timeout(LOOK_AROUND)?;
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

    /// The next line, whatever it says, or that there is none.
    pub fn next_line(&mut self) -> Result<Next, CtlError> {
        match self.client.line() {
            Ok(Some(line)) => {
                let message = self.client.read(&line)?;
                Ok(Next::Line(String::from_utf8_lossy(&line).into_owned(), message))
            }
            Ok(None) | Err(ClientError::Closed) => Ok(Next::Ended),
            Err(ClientError::TimedOut(_)) => Ok(Next::Quiet),
            Err(error) => Err(error.into()),
        }
    }

    /// The same; a refusal is an error. What is lost, or not there yet, is none.
    pub fn next(&mut self) -> Result<Next, CtlError> {
        match self.next_line()? {
            Next::Line(_, ServerMessage::Error(error))
                if !matches!(error.code, ErrorCode::Lost | ErrorCode::NoReading) =>
            {
                Err(CtlError::Refused(error.message))
            }
            next => Ok(next),
        }
    }

    /// Waits for what `found` is looking for, so long at most.
    pub fn wait_for<T>(
        &mut self,
        patience: Duration,
        mut found: impl FnMut(String, ServerMessage) -> Option<T>,
    ) -> Result<T, CtlError> {
        let since = Instant::now();
        loop {
            match self.next()? {
                Next::Line(line, message) => {
                    if let Some(found) = found(line, message) {
                        return Ok(found);
                    }
                }
                Next::Quiet => {}
                Next::Ended => return Err(ClientError::Closed.into()),
            }
            if since.elapsed() > patience {
                return Err(ClientError::TimedOut(patience).into());
            }
        }
    }

    /// What the daemon has counted and learned: the line of STATS, and what it says.
    pub fn stats(&mut self) -> Result<(String, StatsLine), CtlError> {
        self.request(&Request::Stats)?;
        self.wait_for(ANSWER, |line, message| match message {
            ServerMessage::Stats(stats) => Some((line, *stats)),
            _ => None,
        })
    }
}

/// Whether a channel is among those asked for; an empty list stands for all.
pub fn is_wanted(channels: &[String], id: &str) -> bool {
    channels.is_empty() || channels.iter().any(|wanted| wanted == id)
}
