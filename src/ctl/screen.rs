//! Readings as they come: lines that are rewritten in place on a terminal, one line after the other anywhere else.

use super::CtlError;
use super::limits::{HISTORY_S, REDRAW_AFTER};
use super::panel::Panel;
use super::terminal::Terminal;
use crate::stream::wire::{ChannelInfo, EventLine, ReadingLine};
use crate::units::{ForceUnit, Nanos};
use std::time::{Duration, Instant};

/// What `watch` and `demo` show.
#[derive(Debug)]
pub struct Screen {
    pub terminal: Terminal,
    panel: Panel,
    unit: ForceUnit,
    /// How far back the sparklines under the live lines go, seconds.
    history_s: f64,
    /// On anything but a terminal, one reading in this time is written, after this text.
    plain: (Duration, &'static str),
    shown: Option<Instant>,
}

impl Screen {
    /// Of these channels, with forces in this unit; every reading.
    pub fn new<'a>(channels: impl Iterator<Item = &'a ChannelInfo>, unit: ForceUnit) -> Screen {
        let terminal = Terminal::new();
        let panel = Panel::new(channels, unit, terminal.unicode);
        Screen { terminal, panel, unit, history_s: HISTORY_S, plain: (Duration::ZERO, ""), shown: None }
    }

    /// With so much history, and fewer lines where they stay.
    pub fn with_history(self, seconds: f64, pause: Duration, prefix: &'static str) -> Screen {
        Screen { history_s: seconds, plain: (pause, prefix), ..self }
    }

    /// Begins anew with other channels.
    pub fn restart<'a>(&mut self, channels: impl Iterator<Item = &'a ChannelInfo>) {
        self.panel = Panel::new(channels, self.unit, self.terminal.unicode);
    }

    /// Takes a reading, and shows it when it is time.
    pub fn feed(&mut self, reading: &ReadingLine) -> Result<(), CtlError> {
        self.panel.feed(reading);
        let (pause, prefix) = if self.terminal.is_live { (REDRAW_AFTER, "") } else { self.plain };
        if self.shown.is_some_and(|shown| shown.elapsed() < pause) {
            return Ok(());
        }
        self.shown = Some(Instant::now());
        if self.terminal.is_live {
            return self.redraw();
        }
        match self.panel.plain(&reading.channel) {
            Some(line) => self.terminal.say(&(prefix.to_owned() + &line)),
            None => Ok(()),
        }
    }

    /// Takes an event, and shows at once what it has changed; elsewhere the next reading says it.
    pub fn press(&mut self, event: &EventLine) -> Result<(), CtlError> {
        self.panel.press(event);
        self.redraw()
    }

    /// Looks whether readings still come. `now`: `CLOCK_MONOTONIC`.
    pub fn look(&mut self, now: Nanos) {
        self.panel.look(now);
    }

    /// Brings live lines up to date, whether something came or not.
    pub fn redraw(&mut self) -> Result<(), CtlError> {
        if !self.terminal.is_live {
            return Ok(());
        }
        let (width, height) = self.terminal.size();
        let mut lines = self.panel.lines(width);
        let history = self.panel.history(self.history_s, width);
        // What is now comes before what was.
        if lines.len() + history.len() < height {
            lines.extend(history);
        }
        self.terminal.draw(&lines)
    }
}
