//! The verbs of `cermctl`, one file each.
//!
//! For: what a person sees: live lines, tables, files, errors as sentences. Must not know: how anything is measured; the
//! [`demo`] alone starts an instrument, [`check`] alone tests one.

mod achieved;
mod bridge;
mod calibrate;
mod characterize;
pub mod check;
pub mod cli;
pub mod demo;
mod error;
mod estimate;
mod get;
mod interrupt;
mod limits;
mod lines;
pub mod log;
mod panel;
mod progress;
mod record;
pub mod replay;
mod screen;
#[cfg(test)]
mod screens;
mod setup;
mod size;
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
        Verb::Size(arguments) => size::run(&arguments),
        Verb::Lines(arguments) => lines::run(&arguments),
        Verb::Record(arguments) => record::run(&arguments),
        Verb::Estimate(arguments) => estimate::run(&arguments),
        Verb::Calibrate(arguments) => calibrate::run(&arguments.by),
        Verb::Characterize(arguments) => characterize::run(&arguments),
        Verb::Zero(arguments) => calibrate::tare(&arguments),
        Verb::Setup(arguments) => setup::run(&arguments),
        Verb::Bridge(arguments) => bridge::run(arguments.to),
        Verb::Web(arguments) => bridge::web(arguments),
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
