//! `cermctl watch`: readings as they come.
//!
//! It outlives the daemon: when the connection ends, it says so and waits for the next one.

use super::interrupt::Interrupt;
use super::limits::RETRY_AFTER;
use super::screen::Screen;
use super::stream::{Next, Stream, is_wanted};
use super::{CtlError, print};
use crate::ctl::cli;
use crate::stream::client::ClientError;
use crate::stream::wire::{ChannelInfo, ServerMessage, VersionLine};
use console::style;

/// Watches until Ctrl-C.
pub fn run(arguments: &cli::Watch) -> Result<(), CtlError> {
    let interrupt = Interrupt::new()?;
    let mut stream = connect(arguments)?;
    let mut screen = Screen::new(wanted(arguments, stream.version()));
    loop {
        match arguments.json {
            true => follow_json(arguments, &mut stream, &interrupt)?,
            false => follow(arguments, &mut screen, &mut stream, &interrupt)?,
        }
        if interrupt.is_set() {
            return Ok(());
        }
        note(arguments, &mut screen, "cermd closed the connection; waiting for it to come back")?;
        match reconnect(arguments, &interrupt)? {
            Some(again) => stream = again,
            None => return Ok(()),
        }
        screen.restart(wanted(arguments, stream.version()));
        note(arguments, &mut screen, "connected again")?;
    }
}

fn wanted<'a>(arguments: &cli::Watch, version: &'a VersionLine) -> impl Iterator<Item = &'a ChannelInfo> {
    version.channels.iter().filter(|channel| is_wanted(&arguments.channels, &channel.id))
}

fn connect(arguments: &cli::Watch) -> Result<Stream, CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    if !arguments.channels.is_empty() || arguments.max_hz.is_some() {
        stream.watch(&arguments.channels, arguments.max_hz, false)?;
    }
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

/// Shows readings until the connection ends.
fn follow(
    arguments: &cli::Watch,
    screen: &mut Screen,
    stream: &mut Stream,
    interrupt: &Interrupt,
) -> Result<(), CtlError> {
    while !interrupt.is_set() {
        match stream.next()? {
            Next::Line(_, ServerMessage::Reading(reading)) => screen.feed(&reading)?,
            // The channels have changed.
            Next::Line(_, ServerMessage::Version(version)) => screen.restart(wanted(arguments, &version)),
            Next::Line(..) => {}
            Next::Quiet => screen.redraw()?,
            Next::Ended => break,
        }
    }
    Ok(())
}

/// Prints lines until the connection ends.
fn follow_json(arguments: &cli::Watch, stream: &mut Stream, interrupt: &Interrupt) -> Result<(), CtlError> {
    while !interrupt.is_set() {
        match stream.next_line()? {
            // Measured before the daemon knew what is wanted.
            Next::Line(_, ServerMessage::Reading(reading))
                if !is_wanted(&arguments.channels, &reading.channel) => {}
            Next::Line(line, _) => print(&(line + "\n"))?,
            Next::Quiet => {}
            Next::Ended => break,
        }
    }
    Ok(())
}

/// Where the readings do not go, so that they stay readings.
fn note(arguments: &cli::Watch, screen: &mut Screen, text: &str) -> Result<(), CtlError> {
    if screen.terminal.is_live() && !arguments.json {
        screen.terminal.say(&style(format!(" {text}")).yellow().to_string())
    } else {
        eprintln!("cermctl: {text}");
        Ok(())
    }
}
