//! `cermctl watch`: readings as they come.
//!
//! It outlives the daemon: when the connection ends, it says so and waits for the next one.

use super::interrupt::Interrupt;
use super::limits::RETRY_AFTER;
use super::screen::Screen;
use super::stream::{Next, Stream};
use super::{CtlError, achieved, print};
use crate::ctl::cli;
use crate::pins::monotonic;
use crate::stream::client::ClientError;
use crate::stream::wire::{ReadingTally, ServerMessage, Unit};
use crate::units::ForceUnit;
use console::style;
use std::collections::BTreeMap;

/// What has come, by channel.
type Tallies = BTreeMap<String, ReadingTally>;

/// Watches until Ctrl-C, and says what it has seen.
pub fn run(arguments: &cli::Watch) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let mut stream = connect(arguments)?;
    let mut screen = Screen::new(stream.channels(), arguments.shown.unit);
    let mut tallies = Tallies::new();
    loop {
        follow(arguments.json, &mut screen, &mut tallies, &mut stream, &interrupt)?;
        if interrupt.is_set() {
            break;
        }
        note(arguments, &mut screen, "cermd closed the connection; waiting for it to come back")?;
        match reconnect(arguments, &interrupt)? {
            Some(again) => stream = again,
            None => break,
        }
        screen.restart(stream.channels());
        note(arguments, &mut screen, "connected again")?;
    }
    if arguments.json {
        Ok(())
    } else {
        conclude(arguments.shown.unit, &stream.units(), &mut screen, &tallies)
    }
}

fn conclude(
    unit: ForceUnit,
    units: &BTreeMap<String, Unit>,
    screen: &mut Screen,
    tallies: &Tallies,
) -> Result<(), CtlError> {
    tallies.iter().map(|(id, tally)| (id, tally.stats())).try_for_each(|(id, stats)| {
        let value_unit = units.get(id).map(Unit::as_str).unwrap_or_default();
        let (readings, words) = (stats.readings, achieved::in_words(&stats, unit, value_unit));
        screen.terminal.say(&format!(" {id}: {readings} readings in {:.1} s: {words}", stats.span_s))
    })
}

fn connect(arguments: &cli::Watch) -> Result<Stream, CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    stream.watch(arguments.max_hz, false)?;
    Ok(stream)
}

/// Tries until the daemon is there again; `None`: interrupted.
fn reconnect(arguments: &cli::Watch, interrupt: &Interrupt) -> Result<Option<Stream>, CtlError> {
    while !interrupt.is_set() {
        match connect(arguments) {
            Ok(stream) => return Ok(Some(stream)),
            Err(CtlError::Client(error)) if is_passing(&error) => std::thread::sleep(RETRY_AFTER),
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

/// What a daemon that starts or stops looks like.
fn is_passing(error: &ClientError) -> bool {
    use ClientError::{Closed, Io, NoSocket, NobodyThere, TimedOut};
    matches!(error, NoSocket(_) | NobodyThere(_) | Closed | TimedOut(_) | Io(_))
}

/// Shows readings, or prints lines, until the connection ends.
fn follow(
    json: bool,
    screen: &mut Screen,
    tallies: &mut Tallies,
    stream: &mut Stream,
    interrupt: &Interrupt,
) -> Result<(), CtlError> {
    while !interrupt.is_set() {
        // A program reads a refusal as it reads every other line.
        let next = if json { stream.next_line() } else { stream.next() };
        screen.look(monotonic());
        match next? {
            Next::Line(line, _) if json => print(&(line + "\n"))?,
            Next::Line(_, ServerMessage::Reading(reading)) => {
                tallies.entry(reading.channel.clone()).or_default().add_line(&reading);
                screen.feed(&reading)?;
            }
            Next::Line(_, ServerMessage::Event(event)) => screen.press(&event)?,
            // The channels have changed.
            Next::Line(_, ServerMessage::Version(_)) => screen.restart(stream.channels()),
            Next::Quiet if !json => screen.redraw()?,
            Next::Line(..) | Next::Quiet => {}
            Next::Ended => break,
        }
    }
    Ok(())
}

/// Where the readings do not go, so that they stay readings.
fn note(arguments: &cli::Watch, screen: &mut Screen, text: &str) -> Result<(), CtlError> {
    if screen.terminal.is_live && !arguments.json {
        screen.terminal.say(&style(format!(" {text}")).yellow().to_string())
    } else {
        eprintln!("cermctl: {text}");
        Ok(())
    }
}
