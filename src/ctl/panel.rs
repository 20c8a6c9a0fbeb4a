//! The channels as people see them: numbers, a bar with its scale, the rate; on one line where there is room, else on two.
//!
//! Time is that of the readings.

mod bar;
mod row;
#[cfg(test)]
mod tests;

use super::limits::{BAR_COLUMNS, HISTORY_COLUMNS, NAME_COLUMNS};
use super::terminal::wrapped;
use crate::stream::wire::{ChannelInfo, EventLine, ReadingLine, Unit};
use crate::units::{ForceUnit, Nanos};
use bar::Ends;
use console::{Alignment, measure_text_width, pad_str, style, truncate_str};
use row::{ChannelRow, Words};

/// All channels.
#[derive(Debug)]
pub struct Panel {
    rows: Vec<ChannelRow>,
    unicode: bool,
}

/// What the lines of a panel have in common, in columns.
#[derive(Debug, Clone, Copy)]
struct Columns {
    width: usize,
    name: usize,
    /// Of a force, or what a law gives; none where no channel has either.
    value: usize,
    /// Both ends of the scales.
    scale: [usize; 2],
    unicode: bool,
}

/// A force or a value, and ohms, with their uncertainties.
const VALUE_COLUMNS: [usize; 2] = [17, 19];
const STATUS_COLUMNS: usize = 8;
const RATE_COLUMNS: usize = 7;

impl Panel {
    /// Of these channels, with forces in this unit.
    pub fn new<'a>(channels: impl Iterator<Item = &'a ChannelInfo>, unit: ForceUnit, unicode: bool) -> Panel {
        Panel { rows: channels.map(|info| ChannelRow::new(info, unit)).collect(), unicode }
    }

    /// Takes a reading; one of an unknown channel is passed over.
    pub fn feed(&mut self, reading: &ReadingLine) {
        if let Some(row) = self.rows.iter_mut().find(|row| row.id == reading.channel) {
            row.feed(reading);
        }
    }

    /// Looks whether readings still come. `now`: `CLOCK_MONOTONIC`.
    pub fn look(&mut self, now: Nanos) {
        self.rows.iter_mut().for_each(|row| row.look(now));
    }

    /// Takes an event of a trigger, likewise.
    pub fn press(&mut self, event: &EventLine) {
        if let Some(row) = self.rows.iter_mut().find(|row| row.id == event.channel) {
            row.is_pressed = event.is_pressed() == Some(true);
        }
    }

    /// A line or more for each channel, in `width` columns.
    pub fn lines(&self, width: usize) -> Vec<String> {
        let layout = self.layout(width);
        self.rows.iter().flat_map(|row| layout.lines(row)).collect()
    }

    /// The last reading of a channel as a line of plain text; `None` if there is no such channel.
    pub fn plain(&self, id: &str) -> Option<String> {
        self.rows.iter().find(|row| row.id == id).map(|row| row.plain(self.unicode))
    }

    /// What each channel did in the last `seconds`, one line for each.
    pub fn history(&self, seconds: f64, width: usize) -> Vec<String> {
        let layout = self.layout(width);
        self.rows.iter().map(|row| layout.history(row, seconds)).collect()
    }

    fn layout(&self, width: usize) -> Columns {
        let widest = |columns: fn(&ChannelRow) -> usize| self.rows.iter().map(columns).max().unwrap_or(0);
        let has_value = self.rows.iter().any(|row| row.measures != Unit::Ohm);
        let end = |index: usize| {
            let columns = self.rows.iter().map(|row| row.scale().ends[index].len());
            columns.max().unwrap_or(0)
        };
        Columns {
            width,
            name: widest(|row| measure_text_width(&row.id)).min(NAME_COLUMNS.max(width / 6)),
            value: if has_value { VALUE_COLUMNS[0] } else { 0 },
            scale: [end(0), end(1)],
            unicode: self.unicode,
        }
    }
}

impl Columns {
    /// Marked where it is pressed.
    fn name(self, row: &ChannelRow) -> String {
        let (tail, mark) = if self.unicode { ("…", "●") } else { (">", "*") };
        let mark = if row.is_pressed { mark } else { " " };
        let name = pad_str(&row.id, self.name, Alignment::Left, Some(tail));
        format!("{}{} ", style(mark).cyan(), style(name).bold())
    }

    /// What a name takes where there is none.
    fn blank(self) -> String {
        " ".repeat(self.name + 2)
    }

    fn lines(self, row: &ChannelRow) -> Vec<String> {
        let words = row.words(self.unicode);
        let rate = row.rate().map_or_else(String::new, |rate| format!("{rate:.1}/s"));
        let rate = style(format!("{rate:>RATE_COLUMNS$}")).dim().to_string();
        let status = words
            .style
            .apply_to(format!("{:<STATUS_COLUMNS$}", truncate_str(words.status, STATUS_COLUMNS, ".")));
        let [_, ohms] = VALUE_COLUMNS;
        let gap = usize::from(self.value > 0);
        let numbers = self.name + 2 + self.value + gap + ohms + 2;
        let mut lines = if self.width > numbers + STATUS_COLUMNS + RATE_COLUMNS {
            let room = self.width - 1 - numbers - STATUS_COLUMNS - RATE_COLUMNS;
            vec![format!("{}{}  {}{status}{rate}", self.name(row), self.values(&words), self.bar(row, room))]
        } else {
            self.narrow(row, &words, &[status.to_string(), rate])
        };
        if let Some(hint) = row.hint() {
            let hint = wrapped(hint, self.width.saturating_sub(self.name + 2).max(1));
            lines.extend(hint.lines().map(|line| format!("{}{}", self.blank(), style(line).dim())));
        }
        lines
    }

    fn values(self, words: &Words) -> String {
        let [_, columns] = VALUE_COLUMNS;
        let ohms = format!("{:>columns$}", words.ohms);
        match self.value {
            0 => ohms,
            value => format!("{} {ohms}", style(format!("{:>value$}", words.value)).bold()),
        }
    }

    /// Numbers first: value and status, and below them ohms and rate; or ohms and status, and no rate.
    fn narrow(self, row: &ChannelRow, words: &Words, [status, rate]: &[String; 2]) -> Vec<String> {
        let columns = VALUE_COLUMNS[0];
        let ohms = format!("{:>columns$}", words.ohms);
        match self.value {
            0 => vec![format!("{}{ohms}  {status}", self.name(row))],
            _ => {
                let value = style(format!("{:>columns$}", words.value)).bold();
                vec![
                    format!("{}{value}  {status}", self.name(row)),
                    format!("{}{ohms}  {rate}", self.blank()),
                ]
            }
        }
    }

    /// With its scale, in so many columns at the most; nothing where that is too few to show anything.
    fn bar(self, row: &ChannelRow, room: usize) -> String {
        let [left, right] = self.scale;
        let around = left + right + 3 + usize::from(left > 0);
        if room < around + BAR_COLUMNS.start() {
            return String::new();
        }
        let columns = (room - around).min(*BAR_COLUMNS.end());
        let Ends { ends: [from, to], .. } = row.scale();
        // Nothing known is not nothing.
        let Some(share) = row.share() else { return " ".repeat(columns + around) };
        let (full, empty) = bar::bar(share, columns, self.unicode);
        let from = if left > 0 { format!("{from:>left$} ") } else { String::new() };
        let (from, to) = (style(from).dim(), style(format!(" {to:<right$}")).dim());
        format!("{from}{}{}{to}  ", style(full).cyan(), style(empty).dim())
    }

    fn history(self, row: &ChannelRow, seconds: f64) -> String {
        let label = format!(" last {seconds:.0} s, {}", row.scale().in_words());
        let columns = self.width.saturating_sub(self.name + 3 + label.len()).min(HISTORY_COLUMNS);
        let slots = row.slots((seconds * 1e9) as i64, columns);
        let line = bar::sparkline(slots.into_iter(), self.unicode);
        format!("{}{}{}", self.name(row), style(line).cyan(), style(label).dim())
    }
}
