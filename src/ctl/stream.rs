//! The lines of a running daemon, with pauses to look around in.

use super::CtlError;
use super::limits::{ANSWER, LOOK_AROUND};
use crate::stream::client::{Client, ClientError};
use crate::stream::wire::{ChannelInfo, ErrorCode, Request, ServerMessage, StatsLine, Unit, Watch};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// What comes next.
#[derive(Debug)]
pub enum Next {
    /// A line without its newline, and what it says.
    Line(String, ServerMessage),
    /// Nothing for us for a while.
    Quiet,
    /// The daemon has closed the connection.
    Ended,
}

/// A connection on which the daemon talks of some channels.
#[derive(Debug)]
pub struct Stream {
    client: Client,
    /// Empty: all of them.
    wanted: Vec<String>,
}

impl Stream {
    /// Connects; the daemon sends readings at once. Readings of other channels than these are passed over; an empty list
    /// stands for all.
    pub fn connect(socket: &Path, channels: &[String]) -> Result<Stream, CtlError> {
        let mut client = Client::connect(socket, ANSWER)?;
        client.set_timeout(LOOK_AROUND)?;
        let known: Vec<String> = client.version().channels.iter().map(|channel| channel.id.clone()).collect();
        match channels.iter().find(|wanted| !known.contains(wanted)) {
            Some(wanted) => Err(CtlError::no_channel(wanted, &known)),
            None => Ok(Stream { client, wanted: channels.to_vec() }),
        }
    }

    /// What is wanted of what there is, in the order of the configuration.
    pub fn channels(&self) -> impl Iterator<Item = &ChannelInfo> {
        self.client.version().channels.iter().filter(|channel| self.is_wanted(&channel.id))
    }

    /// What each channel measures in.
    pub fn units(&self) -> BTreeMap<String, Unit> {
        self.channels().map(|channel| (channel.id.clone(), channel.unit.clone())).collect()
    }

    fn is_wanted(&self, id: &str) -> bool {
        self.wanted.is_empty() || self.wanted.iter().any(|wanted| wanted == id)
    }

    /// Asks for something; the answer comes among the lines.
    pub fn request(&mut self, request: &Request) -> Result<(), CtlError> {
        Ok(self.client.request(request)?)
    }

    /// Has the daemon send only what is wanted, if that is not what it sends anyway.
    pub fn watch(&mut self, max_hz: Option<f64>, raw: bool) -> Result<(), CtlError> {
        let channels = (!self.wanted.is_empty()).then(|| self.wanted.clone());
        let watch = Watch { channels, max_hz, raw, ..Watch::default() };
        if watch == Watch::default() { Ok(()) } else { self.request(&Request::Watch(watch)) }
    }

    /// The next line, whatever it says, or that there is none.
    pub fn next_line(&mut self) -> Result<Next, CtlError> {
        match self.client.line() {
            Ok(Some(line)) => {
                let message = self.client.read(&line)?;
                match &message {
                    // Measured before the daemon knew what is wanted.
                    ServerMessage::Reading(reading) if !self.is_wanted(&reading.channel) => Ok(Next::Quiet),
                    ServerMessage::Event(event) if !self.is_wanted(&event.channel) => Ok(Next::Quiet),
                    _ => Ok(Next::Line(String::from_utf8_lossy(&line).into_owned(), message)),
                }
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
                Err(CtlError::Said(format!("cermd: {}", error.message)))
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
