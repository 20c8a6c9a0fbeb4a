//! The verbs of `cermctl`, one file each.
//!
//! For: what a person sees: live lines, tables, files, errors as sentences. Must not know: how anything is measured; the
//! [`demo`] alone starts an instrument, [`check`] alone tests one.

mod calibrate;
pub mod check;
pub mod cli;
pub mod demo;
mod error;
mod estimate;
mod get;
mod interrupt;
mod limits;
mod lines;
mod panel;
mod record;
pub mod replay;
mod screen;
mod stats;
mod stream;
mod terminal;
mod watch;

pub use error::CtlError;

use crate::ctl::cli::Verb;
use serde::Serialize;
use std::io::Write;

/// Does what was asked for.
///
/// # Errors
/// A sentence for the person who asked.
pub fn run(verb: Verb) -> Result<(), CtlError> {
    match verb {
        Verb::Demo(arguments) => demo::run(&arguments),
        Verb::Watch(arguments) => watch::run(&arguments),
        Verb::Get(arguments) => get::run(&arguments),
        Verb::Stats(arguments) => stats::run(&arguments),
        Verb::Check(arguments) => check::run(&arguments),
        Verb::Lines(arguments) => lines::run(&arguments),
        Verb::Record(arguments) => record::run(&arguments),
        Verb::Estimate(arguments) => estimate::run(&arguments),
        Verb::Calibrate(arguments) => calibrate::run(&arguments.by),
    }
}

/// A message as a line of JSON. Numbers and texts always serialise.
fn line(message: &impl Serialize) -> String {
    serde_json::to_string(message).unwrap_or_default() + "\n"
}

/// To standard output.
fn print(text: &str) -> Result<(), CtlError> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(CtlError::Output)
}
