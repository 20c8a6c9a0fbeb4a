//! One channel: its last reading in words, and what it did before.

use super::bar::Ends;
use crate::ctl::limits::{BAR_OHM, FULL_N, HISTORY, RATE_WINDOW, SILENT_READINGS, SILENT_S};
use crate::stream::wire::{ChannelInfo, ReadingLine, StateLine, StatusName, Unit};
use crate::units::{ForceUnit, Nanos, Ohm, measured, rough, rounded};
use console::Style;
use std::collections::VecDeque;

/// One channel.
#[derive(Debug)]
pub struct ChannelRow {
    pub id: String,
    pub measures: Unit,
    /// Known to be, by its trigger.
    pub is_pressed: bool,
    unit: ForceUnit,
    last: Option<ReadingLine>,
    /// Nothing has come for long: what was last is not shown as if it were so now.
    is_silent: bool,
    /// The force at which a bar is full, in the unit.
    full: f64,
    /// Where the bar of a value is empty and full, and what these ends are multiples of.
    span: Option<([f64; 2], f64)>,
    /// When, and how far the bar was filled; the newest last.
    history: VecDeque<(i64, Option<f64>)>,
}

/// The last reading, in words.
#[derive(Debug, Default)]
pub struct Words {
    /// A force, or what a law gives.
    pub value: String,
    /// Or the name of a fault.
    pub ohms: String,
    pub status: &'static str,
    /// Of the status.
    pub style: Style,
}

impl ChannelRow {
    pub fn new(info: &ChannelInfo, unit: ForceUnit) -> ChannelRow {
        // The power of ten that is nearest.
        let full = 10f64.powf((FULL_N / unit.newton()).log10().round());
        let (id, measures) = (info.id.clone(), info.unit.clone());
        ChannelRow {
            id,
            measures,
            is_pressed: false,
            unit,
            last: None,
            is_silent: false,
            full,
            span: None,
            history: VecDeque::new(),
        }
    }

    pub fn feed(&mut self, reading: &ReadingLine) {
        while reading.state.f_n.is_some_and(|f_n| f_n / self.unit.newton() > self.full) {
            self.full *= 2.0;
        }
        if let Some(value) = reading.state.value {
            self.widen(value);
        }
        self.last = Some(reading.clone());
        self.is_silent = false;
        self.history.push_back((reading.t_mono_ns, self.share()));
        if self.history.len() > HISTORY {
            self.history.pop_front();
        }
    }

    /// Looks whether readings still come. `now`: `CLOCK_MONOTONIC`.
    pub fn look(&mut self, now: Nanos) {
        let Some(reading) = &self.last else { return };
        let patience_s = self.rate().map_or(0.0, |rate| SILENT_READINGS / rate).max(SILENT_S);
        if (now - Nanos(reading.t_mono_ns)).as_seconds() > patience_s {
            (self.last, self.is_silent) = (None, true);
        }
    }

    /// So that the bar holds this value, too.
    fn widen(&mut self, value: f64) {
        let power = |value: f64| 10f64.powf(value.abs().max(1e-3).log10().floor());
        let step = self.span.map_or(power(value), |(_, step)| step);
        let [from, to] = [(value / step).floor() * step, (value / step + 1.0).floor() * step];
        let [low, high] = self.span.map_or([from, to], |([low, high], _)| [low.min(from), high.max(to)]);
        self.span = Some(([low, high], step));
    }

    /// Of the bar. Forces begin at 0; ohms are logarithmic, and little of them is much pressure.
    pub fn scale(&self) -> Ends {
        let ends = match &self.measures {
            Unit::Other(unit) => match self.span {
                Some(([low, high], _)) => {
                    [rounded(low, 6).to_string(), format!("{} {unit}", rounded(high, 6))]
                }
                None => Default::default(),
            },
            Unit::Newton => [String::new(), format!("{} {}", self.full, self.unit)],
            Unit::Ohm => {
                let [full, empty] = BAR_OHM.map(|ohm| Ohm(ohm).to_string());
                [empty, full]
            }
        };
        Ends { ends }
    }

    /// How far the bar is filled; `None` where nothing is known.
    pub fn share(&self) -> Option<f64> {
        let state = &self.last.as_ref()?.state;
        match (state.status, &self.measures) {
            (StatusName::Fault, _) => None,
            (StatusName::Ok, Unit::Other(_)) => {
                let ([low, high], _) = self.span?;
                Some((state.value? - low) / (high - low))
            }
            (_, Unit::Other(_)) if state.value_max.is_some() => Some(0.0),
            (_, Unit::Other(_)) => state.value_min.map(|_| 1.0),
            (StatusName::Open, _) => Some(0.0),
            (StatusName::Short, _) => Some(1.0),
            (StatusName::Ok, Unit::Newton) => Some(state.f_n? / self.unit.newton() / self.full),
            (StatusName::Ok, Unit::Ohm) => {
                let [full, empty] = BAR_OHM.map(f64::ln);
                Some(((empty - state.r_ohm?.max(1e-3).ln()) / (empty - full)).clamp(0.0, 1.0))
            }
        }
    }

    /// Readings per second.
    pub fn rate(&self) -> Option<f64> {
        let (newest, _) = *self.history.back()?;
        let since = self.history.partition_point(|(at, _)| newest - at > RATE_WINDOW.0);
        let (oldest, _) = *self.history.get(since)?;
        let intervals = self.history.len() - since - 1;
        (intervals > 0 && newest > oldest).then(|| intervals as f64 * 1e9 / (newest - oldest) as f64)
    }

    /// The greatest share in each of `columns` slots of the last `span_ns`; a slot without a reading is like the one
    /// before it, one with nothing but faults is blank.
    pub fn slots(&self, span_ns: i64, columns: usize) -> Vec<Option<f64>> {
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

    /// The last reading.
    pub fn words(&self, unicode: bool) -> Words {
        let Some(ReadingLine { state, .. }) = &self.last else {
            let status = if self.is_silent { "silent" } else { "waiting" };
            return Words { status, style: Style::new().dim(), ..Words::default() };
        };
        let in_unit = |f_n: Option<f64>| f_n.map(|f_n| f_n / self.unit.newton());
        let value = |value: Option<f64>, u, unit| {
            value.map(|value| measured(value, u, unit, unicode)).unwrap_or_default()
        };
        let bound = |sign: &str, value: Option<f64>, unit| {
            value.map(|value| format!("{sign} {}", rough(value, unit))).unwrap_or_default()
        };
        let other = if unicode { self.measures.symbol() } else { self.measures.as_str() };
        let is_other = matches!(self.measures, Unit::Other(_));
        let (unit, style) = (if is_other { other } else { self.unit.as_str() }, Style::new());
        let in_shown = |value, f_n| if is_other { value } else { in_unit(f_n) };
        let least = in_shown(state.value_min, state.f_min_n);
        let most = in_shown(state.value_max, state.f_max_n);
        let limit = || [bound("<", most, unit), bound(">", least, unit)].concat();
        let (shown, ohms, status, style) = match state.status {
            StatusName::Ok => (
                value(in_shown(state.value, state.f_n), in_shown(state.value_u, state.f_u_n), unit),
                value(state.r_ohm, state.r_u_ohm, "ohm"),
                mark(state),
                style.green(),
            ),
            StatusName::Open => (limit(), bound(">", state.r_min_ohm, "ohm"), "open", style.dim()),
            StatusName::Short => (limit(), bound("<", state.r_max_ohm, "ohm"), "short", style.yellow()),
            StatusName::Fault => {
                (String::new(), state.fault.clone().unwrap_or_default(), "fault", style.red())
            }
        };
        Words { value: shown, ohms, status, style }
    }

    /// What to look at on the board, if the daemon has said so.
    pub fn hint(&self) -> Option<&str> {
        self.last.as_ref().and_then(|reading| reading.hint.as_deref())
    }

    pub fn plain(&self, unicode: bool) -> String {
        let Words { value, ohms, status, .. } = self.words(unicode);
        let time = self.last.as_ref().and_then(|reading| reading.time.get(11..23)).unwrap_or_default();
        let rate = self.rate().map(|rate| format!("{rate:.1}/s")).unwrap_or_default();
        let pressed = if self.is_pressed { "pressed" } else { "" };
        let hint = self.hint().unwrap_or_default();
        let pieces = [time, &self.id, &value, &ohms, status, pressed, &rate, hint];
        let kept: Vec<&str> = pieces.into_iter().filter(|piece| !piece.is_empty()).collect();
        kept.join("  ")
    }
}

/// What is to be known of a number before it is used: the most that u is about to change by first.
fn mark(state: &StateLine) -> &'static str {
    match state {
        StateLine { moving: true, .. } => "moving",
        StateLine { settling: true, .. } => "settling",
        // Of the force or value; the ohms are as good as any.
        StateLine { extrapolated: true, .. } => "extrapolated",
        _ => "ok",
    }
}
