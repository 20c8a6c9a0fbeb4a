//! Readings as they come: lines that are rewritten in place on a terminal, one line after the other anywhere else.

use super::CtlError;
use super::limits::REDRAW_AFTER;
use super::panel::Panel;
use super::terminal::Terminal;
use crate::stream::wire::{ChannelInfo, ReadingLine};
use std::time::{Duration, Instant};

/// What `watch` and `demo` show.
#[derive(Debug)]
pub struct Screen {
    pub terminal: Terminal,
    panel: Panel,
    /// How far back a sparkline under the live lines goes, seconds; `None`: there is none.
    history_s: Option<f64>,
    /// On anything but a terminal, one reading in this time is written, after this text.
    plain: (Duration, &'static str),
    shown: Option<Instant>,
}

impl Screen {
    /// Of these channels; every reading, and no history.
    pub fn new<'a>(channels: impl Iterator<Item = &'a ChannelInfo>) -> Screen {
        let terminal = Terminal::new();
        let panel = Panel::new(channels, terminal.unicode());
        Screen { terminal, panel, history_s: None, plain: (Duration::ZERO, ""), shown: None }
    }

    /// With a history, and fewer lines where they stay.
    pub fn with_history(self, seconds: f64, pause: Duration, prefix: &'static str) -> Screen {
        Screen { history_s: Some(seconds), plain: (pause, prefix), ..self }
    }

    /// Begins anew with other channels.
    pub fn restart<'a>(&mut self, channels: impl Iterator<Item = &'a ChannelInfo>) {
        self.panel = Panel::new(channels, self.terminal.unicode());
    }

    /// Takes a reading, and shows it when it is time.
    pub fn feed(&mut self, reading: &ReadingLine) -> Result<(), CtlError> {
        self.panel.feed(reading);
        let (pause, prefix) = if self.terminal.is_live() { (REDRAW_AFTER, "") } else { self.plain };
        if self.shown.is_some_and(|shown| shown.elapsed() < pause) {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        if self.terminal.is_live() {
            return self.redraw();
        }
        match self.panel.plain(&reading.channel) {
            Some(line) => self.terminal.say(&(prefix.to_owned() + &line)),
            None => Ok(()),
        }
    }

    /// Brings live lines up to date, whether something came or not.
    pub fn redraw(&mut self) -> Result<(), CtlError> {
        if !self.terminal.is_live() {
            return Ok(());
        }
        let width = self.terminal.width();
        let mut lines = self.panel.lines(width);
        lines.extend(self.history_s.into_iter().flat_map(|seconds| self.panel.history(seconds, width)));
        self.terminal.draw(&lines)
    }
}
