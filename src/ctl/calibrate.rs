//! `cermctl calibrate`: the zero and the characteristic of a sensor, measured and put into the configuration.
//!
//! Nothing is changed before a yes.

pub mod edit;
mod force;
mod plot;
mod tare;
mod zero;

use super::limits::NEXT_READING;
use super::stream::Stream;
use super::{CtlError, line, print};
use crate::config::Config;
use crate::ctl::cli::{CalibrateBy, Tare, Update};
use crate::stream::client::ClientError;
use crate::stream::wire::ServerMessage;
use edit::Value;
use serde::Serialize;
use std::io::{self, BufRead, IsTerminal};
use std::path::PathBuf;

/// Nothing comes.
fn silent(what: &str) -> CtlError {
    CtlError::Said(format!("cermd sends no {what}; `cermctl stats` tells whether the instrument measures"))
}

/// Calibrates.
pub fn run(by: &CalibrateBy) -> Result<(), CtlError> {
    match by {
        CalibrateBy::Zero(arguments) => zero::run(arguments, 0.0),
        CalibrateBy::Reference(arguments) => zero::run(&arguments.zero, arguments.ohm),
        CalibrateBy::Force(arguments) => force::run(arguments),
    }
}

/// `cermctl zero`.
pub fn tare(arguments: &Tare) -> Result<(), CtlError> {
    tare::run(arguments)
}

/// What is calibrated: a channel of a configuration that is usable as it is.
struct Target<'a> {
    update: &'a Update,
    config: Config,
    id: String,
}

impl<'a> Target<'a> {
    fn new(update: &'a Update) -> Result<Target<'a>, CtlError> {
        let config = Config::load(&update.file.path)?;
        let known: Vec<String> = config.channels.iter().map(|channel| channel.id.clone()).collect();
        let id = match (&update.channel, known.as_slice()) {
            (Some(id), known) if known.contains(id) => id.clone(),
            (Some(id), known) => return Err(CtlError::no_channel(id, known)),
            (None, [only]) => only.clone(),
            (None, _) => {
                let known = known.join(", ");
                return Err(CtlError::Said(format!(
                    "there are several channels: name one with --channel; there is {known}"
                )));
            }
        };
        Ok(Target { update, config, id })
    }

    /// For people on standard output, unless that is for a machine.
    fn say(&self, text: &str) -> Result<(), CtlError> {
        if self.update.json { Ok(()) } else { print(&format!("{text}\n")) }
    }

    /// Asks, and puts a value into the configuration after a yes. Prints `result` with what was done for a machine.
    fn offer(&self, value: &Value, result: impl Serialize) -> Result<(), CtlError> {
        let path = self.update.file.path.display();
        let is_wanted = self.update.yes || ask(&format!("write to {path}? [y/N] "))?;
        let kept = is_wanted.then(|| edit::update(&self.update.file.path, &self.id, value)).transpose()?;
        match &kept {
            Some(kept) => {
                self.say(&format!("{path} is updated; as it was, it is {}", kept.display()))?;
                self.say("cermd takes it over at: systemctl reload cermd")?;
            }
            None => self.say(&format!("{path} is as it was"))?,
        }
        if !self.update.json {
            return Ok(());
        }
        print(&line(&Outcome { result, updated: is_wanted, kept }))
    }
}

/// A result, and what became of the configuration.
#[derive(Serialize)]
struct Outcome<T> {
    #[serde(flatten)]
    result: T,
    updated: bool,
    /// The configuration as it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    kept: Option<PathBuf>,
}

/// Waits for what `found` is looking for; `what` it is.
fn wait_for<T>(
    stream: &mut Stream,
    what: &str,
    mut found: impl FnMut(ServerMessage) -> Option<T>,
) -> Result<T, CtlError> {
    stream.wait_for(NEXT_READING, |_, message| found(message)).map_err(|error| match error {
        CtlError::Client(ClientError::TimedOut(_)) => silent(what),
        other => other,
    })
}

/// The next line of standard input; `None` where its end came first: without its newline it was cut off. The question goes to
/// standard error, because standard output may be for a machine.
pub(super) fn typed_line(question: &str) -> Result<Option<String>, CtlError> {
    eprint!("{question}");
    let mut text = String::new();
    io::stdin().lock().read_line(&mut text).map_err(CtlError::system("standard input"))?;
    Ok(text.ends_with('\n').then_some(text))
}

/// Whether the next line is a yes.
fn ask(question: &str) -> Result<bool, CtlError> {
    let answer = typed_line(question)?.unwrap_or_default();
    if !io::stdin().is_terminal() {
        eprintln!();
    }
    Ok(matches!(answer.trim().to_ascii_lowercase().as_str(), "y" | "yes"))
}
