//! `cermctl get`: the last reading of each channel, once.
//!
//! For: scripts, and a quick look. Must not know: how a reading is shown.

use super::panel::Panel;
use super::stream::{Next, Stream, is_wanted};
use super::terminal::Terminal;
use super::{CtlError, print};
use crate::ctl::cli;
use crate::stream::client::ClientError;
use crate::stream::wire::{ErrorCode, ReadingLine, Request, ServerMessage};
use std::time::{Duration, Instant};

/// How long to wait for the first reading of an instrument that has just started.
const PATIENCE: Duration = Duration::from_secs(5);

/// Prints, in the order of the configuration.
pub fn run(arguments: &cli::Get) -> Result<(), CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    let mut panel = Panel::new(stream.version().channels.iter(), Terminal::new().unicode());
    let ids = stream.version().channels.iter().map(|channel| channel.id.clone());
    let wanted: Vec<String> = ids.filter(|id| is_wanted(&arguments.channels, id)).collect();
    stream.request(&Request::Poll)?;
    let mut found: Vec<Option<(Vec<u8>, ReadingLine)>> = vec![None; wanted.len()];
    let since = Instant::now();
    while let Some(missing) = found.iter().position(Option::is_none) {
        match stream.next()? {
            Next::Line(line, ServerMessage::Reading(reading)) => {
                if let Some(index) = wanted.iter().position(|id| *id == reading.channel) {
                    found[index] = Some((line, *reading));
                }
            }
            // The stream brings it.
            Next::Line(_, ServerMessage::Error(error)) if error.code == ErrorCode::NoReading => {}
            Next::Line(_, ServerMessage::Error(error)) => return Err(CtlError::Refused(error.message)),
            Next::Line(..) | Next::Quiet => {}
            Next::Ended => return Err(ClientError::Closed.into()),
        }
        if since.elapsed() > PATIENCE {
            return Err(CtlError::NoReading(wanted[missing].clone()));
        }
    }
    for (line, reading) in found.into_iter().flatten() {
        if arguments.json {
            print(&(String::from_utf8_lossy(&line) + "\n"))?;
        } else {
            panel.feed(&reading);
            Terminal::new().say(&panel.plain(&reading.channel))?;
        }
    }
    Ok(())
}
