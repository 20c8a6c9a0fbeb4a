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
use crate::stream::tape::Header;
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

    /// Refuses where the daemon measures by another file, or by this one as it was. What is stored is found by readings, and is
    /// true of what they were made with.
    fn check_in_force(&self, stream: &mut Stream) -> Result<(), CtlError> {
        stream.watch(None, true)?;
        let header = wait_for(stream, "header of a tape", |message| match message {
            ServerMessage::Tape(header) => Some(header),
            _ => None,
        })?;
        self.check_circuit(&header)?;
        let id = &self.id;
        let ours = self.config.channels.iter().find(|channel| channel.id == *id);
        let theirs = header.channels.iter().find(|channel| channel.id == *id);
        let ours = ours.map(|channel| (channel.zero_ohm, channel.scale)).unwrap_or_default();
        let theirs = theirs.map(|channel| (channel.zero_ohm, channel.scale)).unwrap_or_default();
        self.check_same(&format!("zero-ohm of {id}"), theirs.0.unwrap_or(0.0), ours.0.unwrap_or(0.0))?;
        self.check_same(&format!("scale of {id}"), theirs.1.unwrap_or(1.0), ours.1.unwrap_or(1.0))?;
        stream.watch(None, false)
    }

    /// The same of what every resistance is measured by, whatever a channel has for zero and scale.
    fn check_circuit(&self, header: &Header) -> Result<(), CtlError> {
        let (theirs, ours) = (&header.circuit, &self.config.circuit);
        self.check_same("r-c1 in ohm", theirs.r_c1_ohm, ours.r_c1.0)?;
        self.check_same("r-c2 in ohm", theirs.r_c2_ohm, ours.r_c2.0)
    }

    /// `what`: with its unit, if the name has none.
    fn check_same(&self, what: &str, theirs: f64, ours: f64) -> Result<(), CtlError> {
        // Each has been text.
        if (theirs - ours).abs() <= 1e-9 * ours.abs() {
            return Ok(());
        }
        let path = self.update.file.path.display();
        Err(CtlError::Said(format!(
            "cermd measures with {what} = {theirs}, and {path} says {ours}: what is found now would not be true of either; \
             `systemctl reload cermd`, or name the file that it runs by with --config"
        )))
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
                self.say("cermd takes it over at: systemctl reload cermd (or kill -HUP, if you have started it by hand)")?;
            }
            None => self.say(&format!("{path} is as it was"))?,
        }
        if !self.update.json {
            return Ok(());
        }
        print(&line(&CalibrationLine { result, updated: is_wanted, kept }))
    }
}

/// A result, and what became of the configuration.
#[derive(Serialize)]
struct CalibrationLine<T> {
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
