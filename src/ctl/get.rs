//! `cermctl get`: the last reading of each channel, once.

use super::limits::FIRST_READING;
use super::panel::Panel;
use super::stream::Stream;
use super::terminal::Terminal;
use super::{CtlError, print};
use crate::ctl::cli;
use crate::stream::client::ClientError;
use crate::stream::wire::{ReadingLine, Request, ServerMessage};

/// Prints, in the order of the configuration.
pub fn run(arguments: &cli::Get) -> Result<(), CtlError> {
    let mut stream = Stream::connect(&arguments.connection.socket, &arguments.channels)?;
    let mut terminal = Terminal::new();
    let mut panel = Panel::new(stream.channels(), arguments.shown.unit, terminal.unicode);
    let wanted: Vec<String> = stream.channels().map(|channel| channel.id.clone()).collect();
    stream.request(&Request::Poll)?;
    let mut last: Vec<Option<(String, ReadingLine)>> = vec![None; wanted.len()];
    // Where POLL finds no reading yet, the stream brings one.
    let all = stream.wait_for(FIRST_READING, |line, message| {
        let ServerMessage::Reading(reading) = message else { return None };
        let index = wanted.iter().position(|id| *id == reading.channel)?;
        last[index] = Some((line, *reading));
        last.iter().all(Option::is_some).then_some(())
    });
    match (all, last.iter().position(Option::is_none)) {
        (Err(CtlError::Client(ClientError::TimedOut(_))), Some(missing)) => {
            let missing = &wanted[missing];
            return Err(CtlError::Said(format!(
                "no reading of {missing} yet: `cermctl stats` tells whether the instrument measures"
            )));
        }
        (all, _) => all?,
    }
    for (line, reading) in last.into_iter().flatten() {
        panel.feed(&reading);
        match panel.plain(&reading.channel) {
            Some(plain) if !arguments.json => terminal.say(&plain)?,
            _ => print(&(line + "\n"))?,
        }
    }
    Ok(())
}
