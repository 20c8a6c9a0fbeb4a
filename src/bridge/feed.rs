//! The daemon as a bridge hears it: connected again whenever it ends, with its figures asked for in between.

use super::Wish;
use super::limits::{ANSWER, LOOK_AROUND, RETRY_AFTER, STATS_EVERY};
use crate::stream::client::{Client, ClientError};
use crate::stream::wire::{
    ErrorCode, EventLine, ReadingLine, Request, ServerMessage, StatsLine, VersionLine, Watch,
};
use std::path::PathBuf;
use std::time::Instant;

/// What is heard.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// The daemon is there, or its channels have changed.
    Up(VersionLine),
    /// A reading, and the line that it came as.
    Reading(Box<ReadingLine>, String),
    /// A channel has passed a threshold, and the line that said so.
    Event(EventLine, String),
    /// The daemon's figures, and the line that they came as.
    Stats(Box<StatsLine>, String),
    /// The daemon is gone: nothing that it said is so any more.
    Down,
    /// Nothing for a while.
    Nothing,
}

/// The way to the daemon.
#[derive(Debug)]
pub struct Feed {
    socket: PathBuf,
    /// At most so many readings of each channel a second, Hz; `None`: all.
    max_hz: Option<f64>,
    client: Option<Client>,
    try_at: Instant,
    /// When the figures are asked for next, and since when an answer is missing.
    ask_at: Instant,
    asked_at: Option<Instant>,
    /// What the log knows of an outage.
    said: Option<String>,
}

impl Feed {
    pub fn new(socket: PathBuf, max_hz: Option<f64>) -> Feed {
        let now = Instant::now();
        Feed { socket, max_hz, client: None, try_at: now, ask_at: now, asked_at: None, said: None }
    }

    /// Tells all that is heard, until somebody wants the end.
    pub fn hear(mut self, wish: Wish<'_>, mut tell: impl FnMut(&Heard)) {
        while !wish() {
            tell(&self.next());
        }
    }

    /// Waits a while at most.
    pub fn next(&mut self) -> Heard {
        let Some(client) = &mut self.client else { return self.connect() };
        match turn(client, &mut self.ask_at, &mut self.asked_at) {
            Ok(heard) => heard,
            Err(error) => {
                self.client = None;
                self.complain(&error);
                Heard::Down
            }
        }
    }

    fn connect(&mut self) -> Heard {
        let wait = self.try_at.saturating_duration_since(Instant::now());
        if !wait.is_zero() {
            std::thread::sleep(wait.min(LOOK_AROUND));
            return Heard::Nothing;
        }
        self.try_at = Instant::now() + RETRY_AFTER;
        match self.greet() {
            Ok(client) => {
                let version = client.version().clone();
                log::info!("cermd {} answers at {}", version.release, self.socket.display());
                (self.client, self.ask_at, self.asked_at, self.said) =
                    (Some(client), Instant::now(), None, None);
                Heard::Up(version)
            }
            Err(error) => {
                self.complain(&error);
                Heard::Nothing
            }
        }
    }

    fn greet(&self) -> Result<Client, ClientError> {
        let mut client = Client::connect(&self.socket, ANSWER)?;
        if self.max_hz.is_some() {
            client.request(&Request::Watch(Watch { max_hz: self.max_hz, ..Watch::default() }))?;
        }
        client.set_timeout(LOOK_AROUND)?;
        Ok(client)
    }

    /// Once for each thing that is wrong. A bridge outlives them all: rights are given, and releases installed, while it
    /// waits.
    fn complain(&mut self, error: &ClientError) {
        let text = error.to_string();
        if self.said.as_ref() != Some(&text) {
            log::warn!("{text}; trying again every {RETRY_AFTER:?}");
            self.said = Some(text);
        }
    }
}

fn turn(
    client: &mut Client,
    ask_at: &mut Instant,
    asked_at: &mut Option<Instant>,
) -> Result<Heard, ClientError> {
    let now = Instant::now();
    match asked_at {
        // It takes connections and has no time for them: stopped, or without a processor.
        Some(asked) if now - *asked > ANSWER => return Err(ClientError::TimedOut(ANSWER)),
        None if now >= *ask_at => {
            client.request(&Request::Stats)?;
            (*ask_at, *asked_at) = (now + STATS_EVERY, Some(now));
        }
        _ => {}
    }
    let line = match client.line() {
        Ok(line) => line.ok_or(ClientError::Closed)?,
        Err(ClientError::TimedOut(_)) => return Ok(Heard::Nothing),
        Err(error) => return Err(error),
    };
    let text = || String::from_utf8_lossy(&line).into_owned();
    Ok(match client.read(&line)? {
        ServerMessage::Version(version) => Heard::Up(version),
        ServerMessage::Reading(reading) => Heard::Reading(reading, text()),
        ServerMessage::Event(event) => Heard::Event(event, text()),
        ServerMessage::Stats(stats) => {
            *asked_at = None;
            Heard::Stats(stats, text())
        }
        ServerMessage::Error(error) if !matches!(error.code, ErrorCode::NoReading | ErrorCode::Lost) => {
            return Err(ClientError::Refused(error.message));
        }
        _ => Heard::Nothing,
    })
}
