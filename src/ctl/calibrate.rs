//! `cermctl calibrate`: the zero and the characteristic of a sensor, measured and put into the configuration.
//!
//! Nothing is changed before a yes.

mod edit;
mod force;
mod plot;
mod zero;

use super::limits::NEXT_READING;
use super::stream::Stream;
use super::{CtlError, print};
use crate::config::{Config, PairsError};
use crate::ctl::cli::{CalibrateBy, Update};
use crate::estimate::fit::FitError;
use crate::stream::client::ClientError;
use crate::stream::wire::{ReadingLine, ServerMessage};
use edit::Value;
use serde::Serialize;
use std::io::{self, BufRead, IsTerminal};
use std::path::PathBuf;

/// Why a calibration came to nothing. The configuration is as it was.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// Which channel?
    #[error("there are several channels: name one with --channel; there is {}", .0.join(", "))]
    WhichChannel(Vec<String>),
    /// Too few discharges gave a number.
    #[error("only {numbers} of {discharges} discharges gave a number{}; is the {part} in the sensor's place?", .fault.map(|fault| format!(" (the last fault: {fault})")).unwrap_or_default())]
    FewNumbers {
        /// How many did.
        numbers: usize,
        /// Of how many.
        discharges: usize,
        /// Of the last one that did not.
        fault: Option<&'static str>,
        /// What should be in the sensor's place.
        part: &'static str,
    },
    /// That is no short circuit.
    #[error(
        "a zero of {zero_ohm:.1} ohm is more than pins and a series resistor make up; is the {part} in the sensor's place?"
    )]
    NoZero {
        /// What was found.
        zero_ohm: f64,
        /// What should be in the sensor's place.
        part: &'static str,
    },
    /// The discharges that tell a zero are not taken.
    #[error(
        "a tracked calibration takes too few discharges of Rc1 and Rc2 to tell a zero from; for the zero, set method = \"cerm\" \
         and calibration = \"each-reading\" in [measure] and reload cermd; it holds for every method"
    )]
    Tracked,
    /// Nothing comes.
    #[error("cermd sends no {0}; `cermctl stats` tells whether the instrument measures")]
    Silent(&'static str),
    /// A line of pairs is wrong.
    #[error(transparent)]
    Pairs(#[from] PairsError),
    /// The pairs cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The file is no TOML, or not as we know it.
    #[error("{}: {reason}; nothing was changed", path.display())]
    Edit {
        /// The configuration file.
        path: PathBuf,
        /// What is in the way.
        reason: String,
    },
    /// With the new value the configuration cannot be used.
    #[error("nothing was changed, for the configuration would not be usable:\n{0}")]
    Unusable(String),
}

/// Calibrates.
pub fn run(by: &CalibrateBy) -> Result<(), CtlError> {
    match by {
        CalibrateBy::Zero(arguments) => zero::run(arguments, 0.0),
        CalibrateBy::Reference(arguments) => zero::run(&arguments.zero, arguments.ohm),
        CalibrateBy::Force(arguments) => force::run(arguments),
    }
}

/// What is calibrated: a channel of a configuration that is usable as it is.
struct Target<'a> {
    update: &'a Update,
    config: Config,
    id: String,
}

impl<'a> Target<'a> {
    fn new(update: &'a Update) -> Result<Target<'a>, CtlError> {
        let config = Config::load(&update.config)?;
        let known: Vec<String> = config.channels.iter().map(|channel| channel.id.clone()).collect();
        let id = match (&update.channel, known.as_slice()) {
            (Some(id), known) if known.contains(id) => id.clone(),
            (Some(id), _) => return Err(CtlError::NoChannel { wanted: id.clone(), known }),
            (None, [only]) => only.clone(),
            (None, _) => return Err(CalibrateError::WhichChannel(known).into()),
        };
        Ok(Target { update, config, id })
    }

    /// For people on standard output, unless that is for a machine.
    fn say(&self, text: &str) -> Result<(), CtlError> {
        if self.update.json { Ok(()) } else { print(&format!("{text}\n")) }
    }

    /// Asks, and puts a value into the configuration after a yes. Prints `result` with what was done for a machine.
    fn offer(&self, value: &Value, result: impl Serialize) -> Result<(), CtlError> {
        let path = self.update.config.display();
        let is_wanted = self.update.yes || ask(&format!("write to {path}? [y/N] "))?;
        let kept = is_wanted.then(|| edit::update(&self.update.config, &self.id, value)).transpose()?;
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
        let outcome = Outcome { result, updated: is_wanted, kept };
        // Numbers and texts always serialise.
        print(&(serde_json::to_string(&outcome).unwrap_or_default() + "\n"))
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

/// The next reading of a channel.
fn next_reading(stream: &mut Stream, id: &str) -> Result<Box<ReadingLine>, CtlError> {
    let reading = stream.wait_for(NEXT_READING, |_, message| match message {
        ServerMessage::Reading(reading) if reading.channel == id => Some(reading),
        _ => None,
    });
    reading.map_err(silent("reading"))
}

/// What waiting in vain for something means here.
fn silent(what: &'static str) -> impl Fn(CtlError) -> CtlError {
    move |error| match error {
        CtlError::Client(ClientError::TimedOut(_)) => CalibrateError::Silent(what).into(),
        other => other,
    }
}

/// Whether the next line of standard input is a yes; its end is a no. The question goes to standard error, because
/// standard output may be for a machine.
fn ask(question: &str) -> Result<bool, CtlError> {
    eprint!("{question}");
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer).map_err(|error| CtlError::System("standard input", error))?;
    if !io::stdin().is_terminal() {
        eprintln!();
    }
    // Without its newline it was cut off.
    let is_whole = answer.ends_with('\n');
    Ok(is_whole && matches!(answer.trim().to_ascii_lowercase().as_str(), "y" | "yes"))
}
