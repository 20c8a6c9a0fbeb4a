//! The channels as people see them: one line for each, with numbers, a bar and the rate.
//!
//! Time is that of the readings.

use super::limits::{BAR_COLUMNS, BAR_OHM, FULL_N, HISTORY, HISTORY_COLUMNS, RATE_WINDOW_NS};
use crate::stream::wire::{ChannelInfo, ReadingLine, StateLine, StatusName, Unit};
use crate::units::{measured, rough};
use console::{Alignment, Style, measure_text_width, pad_str, style, truncate_str};
use std::collections::VecDeque;

/// One channel.
#[derive(Debug)]
struct Row {
    id: String,
    unit: Unit,
    last: Option<ReadingLine>,
    full_n: f64,
    /// When, and how far the bar was filled; the newest last.
    history: VecDeque<(i64, Option<f64>)>,
}

/// All channels.
#[derive(Debug)]
pub struct Panel {
    rows: Vec<Row>,
    unicode: bool,
}

impl Panel {
    /// Of these channels.
    pub fn new<'a>(channels: impl Iterator<Item = &'a ChannelInfo>, unicode: bool) -> Panel {
        let row = |info: &ChannelInfo| Row {
            id: info.id.clone(),
            unit: info.unit,
            last: None,
            full_n: FULL_N,
            history: VecDeque::new(),
        };
        Panel { rows: channels.map(row).collect(), unicode }
    }

    /// Takes a reading; one of an unknown channel is passed over.
    pub fn feed(&mut self, reading: &ReadingLine) {
        if let Some(row) = self.rows.iter_mut().find(|row| row.id == reading.channel) {
            row.feed(reading);
        }
    }

    /// One line for each channel, in `width` columns.
    pub fn lines(&self, width: usize) -> Vec<String> {
        let has_force = self.rows.iter().any(|row| row.unit == Unit::Newton);
        let name = self.name_width();
        self.rows.iter().map(|row| row.line(name, has_force, width, self.unicode)).collect()
    }

    /// The last reading of a channel as a line of plain text; `None` if there is no such channel.
    pub fn plain(&self, id: &str) -> Option<String> {
        self.rows.iter().find(|row| row.id == id).map(|row| row.plain(self.unicode))
    }

    /// What each channel did in the last `seconds`, one line for each.
    pub fn history(&self, seconds: f64, width: usize) -> Vec<String> {
        let name = self.name_width();
        let label = format!(" last {seconds:.0} s");
        let columns = width.saturating_sub(name + 3 + label.len()).min(HISTORY_COLUMNS);
        let draw = |row: &Row| {
            let slots = row.slots((seconds * 1e9) as i64, columns);
            let line = sparkline(slots.into_iter(), self.unicode);
            format!(" {:name$} {}{}", "", style(line).cyan(), style(&label).dim())
        };
        self.rows.iter().map(draw).collect()
    }

    fn name_width(&self) -> usize {
        self.rows.iter().map(|row| measure_text_width(&row.id)).max().unwrap_or(0)
    }
}

impl Row {
    fn feed(&mut self, reading: &ReadingLine) {
        while reading.state.f_n.is_some_and(|force| force > self.full_n) {
            self.full_n *= 2.0;
        }
        self.last = Some(reading.clone());
        self.history.push_back((reading.t_mono_ns, self.share(reading)));
        if self.history.len() > HISTORY {
            self.history.pop_front();
        }
    }

    /// How far the bar is filled; `None` where nothing is known.
    fn share(&self, reading: &ReadingLine) -> Option<f64> {
        match (reading.state.status, self.unit) {
            (StatusName::Fault, _) => None,
            (StatusName::Open, _) => Some(0.0),
            (StatusName::Short, _) => Some(1.0),
            (StatusName::Ok, Unit::Newton) => Some(reading.state.f_n? / self.full_n),
            (StatusName::Ok, Unit::Ohm) => {
                let [full, empty] = BAR_OHM.map(f64::ln);
                Some(((empty - reading.state.r_ohm?.max(1e-3).ln()) / (empty - full)).clamp(0.0, 1.0))
            }
        }
    }

    /// Readings per second.
    fn rate(&self) -> Option<f64> {
        let (newest, _) = *self.history.back()?;
        let since = self.history.partition_point(|(at, _)| newest - at > RATE_WINDOW_NS);
        let (oldest, _) = *self.history.get(since)?;
        let intervals = self.history.len() - since - 1;
        (intervals > 0 && newest > oldest).then(|| intervals as f64 * 1e9 / (newest - oldest) as f64)
    }

    /// The greatest share in each of `columns` slots of the last `span_ns`; a slot without a reading is like the one
    /// before it, one with nothing but faults is blank.
    fn slots(&self, span_ns: i64, columns: usize) -> Vec<Option<f64>> {
        let mut slots: Vec<Option<Option<f64>>> = vec![None; columns];
        let newest = self.history.back().map_or(0, |(at, _)| *at);
        for (at, share) in self.history.iter().rev() {
            let back = ((newest - at) as f64 / span_ns as f64 * columns as f64) as usize;
            let Some(slot) = columns.checked_sub(back + 1).and_then(|index| slots.get_mut(index)) else {
                break;
            };
            *slot = Some(match (slot.flatten(), *share) {
                (Some(old), Some(new)) => Some(f64::max(old, new)),
                (old, new) => old.or(new),
            });
        }
        let mut shown: Option<f64> = None;
        slots
            .into_iter()
            .map(|slot| {
                shown = slot.unwrap_or(shown);
                shown
            })
            .collect()
    }

    /// Force, then resistance or the name of a fault, then the status and how it looks.
    fn words(&self, unicode: bool) -> ([String; 2], &'static str, Style) {
        let Some(reading) = &self.last else { return (Default::default(), "waiting", Style::new().dim()) };
        let value = |value: Option<f64>, u, unit| {
            value.map(|value| measured(value, u, unit, unicode)).unwrap_or_default()
        };
        let bound = |sign: &str, value: Option<f64>, unit| {
            value.map(|value| format!("{sign} {}", rough(value, unit))).unwrap_or_default()
        };
        let style = Style::new();
        match reading.state.status {
            StatusName::Ok => {
                let force = value(reading.state.f_n, reading.state.f_u_n, "N");
                let ohms = value(reading.state.r_ohm, reading.state.r_u_ohm, "ohm");
                ([force, ohms], mark(&reading.state), style.green())
            }
            StatusName::Open => {
                let force = bound("<", reading.state.f_max_n, "N");
                ([force, bound(">", reading.state.r_min_ohm, "ohm")], "open", style.dim())
            }
            StatusName::Short => {
                let force = bound(">", reading.state.f_min_n, "N");
                ([force, bound("<", reading.state.r_max_ohm, "ohm")], "short", style.yellow())
            }
            StatusName::Fault => {
                ([String::new(), reading.state.fault.clone().unwrap_or_default()], "fault", style.red())
            }
        }
    }

    /// What to look at on the board, if the daemon has said so.
    fn hint(&self) -> Option<&str> {
        self.last.as_ref().and_then(|reading| reading.hint.as_deref())
    }

    /// In columns: name, force, ohms, a hint or a bar where there is room, status, rate.
    fn line(&self, name: usize, has_force: bool, width: usize, unicode: bool) -> String {
        let ([force, ohms], status, colour) = self.words(unicode);
        let id = pad_str(&self.id, name, Alignment::Left, None);
        let force = if has_force { format!("{force:>19}  ") } else { String::new() };
        let before = format!(" {}  {}{ohms:>21}  ", style(id).bold(), style(force).bold());
        let rate = self.rate().map_or_else(|| " ".repeat(7), |rate| format!("{rate:>5.1}/s"));
        let after = format!(
            "{}{}",
            colour.apply_to(format!("{:<7}", truncate_str(status, 7, "."))),
            style(rate).dim()
        );
        let room = width.saturating_sub(measure_text_width(&before) + measure_text_width(&after) + 2);
        let middle = match self.hint() {
            _ if room < *BAR_COLUMNS.start() => String::new(),
            Some(hint) => truncate_str(hint, room, "").into_owned() + "  ",
            None => {
                let share = self.last.as_ref().and_then(|reading| self.share(reading)).unwrap_or(0.0);
                let (full, empty) = bar(share, room.min(*BAR_COLUMNS.end()), unicode);
                format!("{}{}  ", style(full).cyan(), style(empty).dim())
            }
        };
        before + &middle + &after
    }

    fn plain(&self, unicode: bool) -> String {
        let ([force, ohms], status, _) = self.words(unicode);
        let time = self.last.as_ref().and_then(|reading| reading.time.get(11..23)).unwrap_or_default();
        let rate = self.rate().map(|rate| format!("{rate:.1}/s")).unwrap_or_default();
        let pieces = [time, &self.id, &force, &ohms, status, &rate, self.hint().unwrap_or_default()];
        let kept: Vec<&str> = pieces.into_iter().filter(|piece| !piece.is_empty()).collect();
        kept.join("  ")
    }
}

/// What is to be known of a number before it is used: the most that u is about to change by first.
fn mark(state: &StateLine) -> &'static str {
    match state {
        StateLine { moving: true, .. } => "moving",
        StateLine { settling: true, .. } => "settling",
        // Of the force; the ohms are as good as any.
        StateLine { extrapolated: true, .. } => "extrapolated",
        _ => "ok",
    }
}

/// A bar of `width` columns, filled to a share of 0 to 1, to an eighth of a column: what is full, and what is empty.
fn bar(share: f64, width: usize, unicode: bool) -> (String, String) {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let share = share.clamp(0.0, 1.0);
    let eighths = (share * width as f64 * 8.0).round() as usize;
    let (full, part) = if unicode { (eighths / 8, EIGHTHS[eighths % 8]) } else { ((eighths + 4) / 8, "") };
    let filled = if unicode { "█" } else { "#" }.repeat(full) + part;
    let empty = if unicode { "·" } else { "." }.repeat(width.saturating_sub(filled.chars().count()));
    (filled, empty)
}

/// One column for each share of 0 to 1; `None`: a blank.
fn sparkline(shares: impl Iterator<Item = Option<f64>>, unicode: bool) -> String {
    const LEVELS: [[char; 8]; 2] =
        [['_', '.', '-', '-', '=', '=', '#', '#'], ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█']];
    let level = |share: f64| LEVELS[usize::from(unicode)][(share.clamp(0.0, 1.0) * 7.0).round() as usize];
    shares.map(|share| share.map_or(' ', level)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::wire::ServerMessage;

    fn reading(at_ms: i64, rest: &str) -> ReadingLine {
        let line = format!(
            r#"{{"class":"READING","channel":"thumb","seq":1,"time":"2026-11-21T03:40:00.123456789Z","t_mono_ns":{},{rest},"lost":0}}"#,
            at_ms * 1_000_000
        );
        match ServerMessage::parse(line.as_bytes()).unwrap() {
            ServerMessage::Reading(reading) => *reading,
            other => panic!("{other:?}"),
        }
    }

    const FULL: &str = r#""status":"ok","r_ohm":1334.6,"r_u_ohm":2.5,"f_n":10.0,"f_u_n":0.02"#;
    const HALF: &str = r#""status":"ok","r_ohm":2669.2,"r_u_ohm":2.5,"f_n":5.0,"f_u_n":0.01"#;
    const BEYOND: &str = r#""status":"ok","r_ohm":889.8,"r_u_ohm":2.5,"f_n":15.0,"f_u_n":1.3,"f_repeat_u_n":0.042,"extrapolated":true"#;
    const MOVING: &str = r#""status":"ok","r_ohm":889.8,"r_u_ohm":32.0,"f_n":15.0,"f_u_n":1.4,"extrapolated":true,"moving":true"#;
    const SETTLING: &str = r#""status":"ok","r_ohm":2669.2,"r_u_ohm":74,"settling":true"#;
    const OPEN: &str = r#""status":"open","r_min_ohm":63000.0,"f_max_n":0.21"#;
    const FAULT: &str = r#""status":"fault","fault":"missed-edge""#;

    const HINTED: &str = r#""status":"fault","fault":"no-calibration","hint":"nothing falls in a discharge through Rc1; look at the wire""#;

    fn panel(readings: &[(i64, &str)]) -> Panel {
        let info = ChannelInfo { id: "thumb".to_owned(), unit: Unit::Newton };
        let mut panel = Panel::new([info].iter(), true);
        readings.iter().for_each(|(at_ms, rest)| panel.feed(&reading(*at_ms, rest)));
        panel
    }

    #[test]
    fn each_state_has_its_words() {
        let plain = |rest| panel(&[(0, rest)]).plain("thumb").unwrap();
        let is = |line: String, text: &str| assert_eq!(line, text);
        is(plain(HALF), "03:40:00.123  thumb  5.000 ± 0.010 N  2669.2 ± 2.5 ohm  ok");
        is(plain(OPEN), "03:40:00.123  thumb  < 0.210 N  > 63000 ohm  open");
        is(plain(BEYOND), "03:40:00.123  thumb  15.0 ± 1.3 N  889.8 ± 2.5 ohm  extrapolated");
        is(plain(MOVING), "03:40:00.123  thumb  15.0 ± 1.4 N  890 ± 32 ohm  moving");
        is(plain(SETTLING), "03:40:00.123  thumb  2669 ± 74 ohm  settling");
        is(plain(FAULT), "03:40:00.123  thumb  missed-edge  fault");
        is(
            plain(HINTED),
            "03:40:00.123  thumb  no-calibration  fault  nothing falls in a discharge through Rc1; look at the wire",
        );
        is(
            panel(&[(0, OPEN), (100, OPEN), (200, OPEN)]).plain("thumb").unwrap(),
            "03:40:00.123  thumb  < 0.210 N  > 63000 ohm  open  10.0/s",
        );
    }

    #[test]
    fn the_history_repeats_silence_and_leaves_faults_blank() {
        let panel = panel(&[(0, OPEN), (1000, FULL), (3000, FAULT), (4000, HALF)]);
        assert_eq!(panel.rows[0].slots(5_000_000_000, 5), [Some(0.0), Some(1.0), Some(1.0), None, Some(0.5)]);
        // The first reading is past.
        assert_eq!(panel.rows[0].slots(4_000_000_000, 4), [Some(1.0), Some(1.0), None, Some(0.5)]);
    }

    #[test]
    fn a_narrow_terminal_loses_the_bar_first() {
        let line = |rest, width| {
            let line = panel(&[(0, rest)]).lines(width)[0].clone();
            console::strip_ansi_codes(&line).into_owned()
        };
        assert!(line(HALF, 90).contains('█'));
        let narrow = line(HALF, 60);
        assert!(!narrow.contains('█') && narrow.contains("ok"), "{narrow}");
        assert!(line(BEYOND, 90).contains("extrap. "));
        let hinted = line(HINTED, 100);
        assert!(hinted.contains("no-calibration  nothing falls in a discharge") && hinted.contains("fault"));
    }

    #[test]
    fn bars_keep_their_width() {
        for unicode in [true, false] {
            for share in 0..=100 {
                let (full, empty) = bar(f64::from(share) / 100.0, 9, unicode);
                assert_eq!(full.chars().count() + empty.chars().count(), 9);
            }
        }
        assert_eq!(bar(0.5, 3, true), ("█▌".to_owned(), "·".to_owned()));
        assert_eq!(bar(2.0, 3, false), ("###".to_owned(), String::new()));
        assert_eq!(sparkline([Some(0.0), None, Some(1.0)].into_iter(), true), "▁ █");
    }
}
