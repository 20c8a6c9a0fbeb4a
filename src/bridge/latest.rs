//! What is known now: the last word on each channel, for as long as it is fresh.

use super::feed::Heard;
use crate::stream::wire::{ChannelInfo, EventLine, ReadingLine, StatsLine, VersionLine};
use crate::units::Nanos;
use nix::sys::time::TimeValLike;
use nix::time::{ClockId, clock_gettime};
use std::collections::BTreeMap;
use std::time::Duration;

/// The last word. Its size is that of the daemon's list of channels.
#[derive(Debug)]
pub struct Latest {
    /// A reading is fresh for so long.
    patience: Nanos,
    version: Option<VersionLine>,
    stats: Option<StatsLine>,
    readings: BTreeMap<String, ReadingLine>,
    events: BTreeMap<String, EventLine>,
}

impl Latest {
    pub fn new(patience: Duration) -> Latest {
        Latest::empty(Nanos::from_seconds(patience.as_secs_f64()))
    }

    fn empty(patience: Nanos) -> Latest {
        Latest { patience, version: None, stats: None, readings: BTreeMap::new(), events: BTreeMap::new() }
    }

    pub fn hear(&mut self, heard: &Heard) {
        match heard {
            Heard::Up(version) => {
                // What is pressed is said after it, and readings may be of another calibration.
                self.events.clear();
                self.readings.clear();
                self.version = Some(version.clone());
            }
            Heard::Reading(reading, _) => {
                if self.has(&reading.channel) {
                    self.readings.insert(reading.channel.clone(), (**reading).clone());
                }
            }
            Heard::Event(event, _) => {
                if self.has(&event.channel) {
                    self.events.insert(event.channel.clone(), event.clone());
                }
            }
            Heard::Stats(stats, _) => self.stats = Some((**stats).clone()),
            Heard::Down => *self = Latest::empty(self.patience),
            Heard::Nothing => {}
        }
    }

    /// The daemon that is there.
    pub fn version(&self) -> Option<&VersionLine> {
        self.version.as_ref()
    }

    /// What it has counted.
    pub fn stats(&self) -> Option<&StatsLine> {
        self.stats.as_ref()
    }

    /// Of no other channels, however many ids a daemon may send.
    fn has(&self, id: &str) -> bool {
        self.channels().any(|(channel, _)| channel.id == id)
    }

    /// Every channel of which it is known whether it is pressed. The daemon itself says when that is so no more.
    pub fn pressed(&self) -> impl Iterator<Item = (&str, bool)> {
        self.events.values().filter_map(|event| Some((&*event.channel, event.is_pressed()?)))
    }

    /// Every channel in the order of the configuration, with its last reading.
    fn channels(&self) -> impl Iterator<Item = (&ChannelInfo, Option<&ReadingLine>)> {
        let channels = self.version.iter().flat_map(|version| &version.channels);
        channels.map(|channel| (channel, self.readings.get(&channel.id)))
    }

    /// Every channel, with its last reading if that is fresh. `now`: `CLOCK_MONOTONIC`.
    pub fn fresh(&self, now: Nanos) -> impl Iterator<Item = (&ChannelInfo, Option<&ReadingLine>)> {
        // By the instant of the measurement, not by that of its arrival: this process may have been asleep.
        let is_fresh = move |reading: &&ReadingLine| now - Nanos(reading.t_mono_ns) <= self.patience;
        self.channels().map(move |(channel, reading)| (channel, reading.filter(is_fresh)))
    }
}

/// `CLOCK_MONOTONIC`, the clock of `t_mono_ns`: the daemon runs on this machine. It cannot fail.
pub fn now() -> Nanos {
    clock_gettime(ClockId::CLOCK_MONOTONIC).map_or(Nanos::ZERO, |time| Nanos(time.num_nanoseconds()))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::stream::wire::{EventName, StateLine, StatusName, Unit};

    pub fn up(ids: &[&str]) -> Heard {
        let channel = |id: &&str| ChannelInfo { id: (*id).to_owned(), unit: Unit::Newton, trigger: false };
        let channels = ids.iter().map(channel).collect();
        Heard::Up(VersionLine { channels, release: "1.2.3".to_owned(), ..VersionLine::new(&[]) })
    }

    pub fn reading(id: &str, t_mono_ns: i64, state: StateLine) -> Heard {
        let time = "2026-11-21T03:40:00.5Z".to_owned();
        let line =
            ReadingLine { channel: id.to_owned(), seq: 1, time, t_mono_ns, state, ..ReadingLine::default() };
        let text = serde_json::to_string(&line).unwrap();
        Heard::Reading(Box::new(line), text)
    }

    pub fn event(id: &str, event: EventName, reason: Option<&str>) -> Heard {
        let (channel, time) = (id.to_owned(), "2026-11-21T03:40:00.5Z".to_owned());
        let line = EventLine { channel, event, reason: reason.map(str::to_owned), time, t_mono_ns: 1 };
        let text = serde_json::to_string(&line).unwrap();
        Heard::Event(line, text)
    }

    pub fn ok(r_ohm: f64) -> StateLine {
        StateLine { status: StatusName::Ok, r_ohm: Some(r_ohm), r_u_ohm: Some(1.2), ..StateLine::default() }
    }

    fn told(latest: &Latest, now: i64) -> Vec<(&str, Option<f64>)> {
        latest
            .fresh(Nanos(now))
            .map(|(channel, reading)| (&*channel.id, reading.and_then(|reading| reading.state.r_ohm)))
            .collect()
    }

    #[test]
    fn a_reading_is_told_while_it_is_fresh_and_its_daemon_there() {
        let mut latest = Latest::new(Duration::from_nanos(10));
        latest.hear(&reading("thumb", 100, ok(1.0)));
        assert!(told(&latest, 100).is_empty(), "of a channel that nobody has announced");
        latest.hear(&up(&["thumb", "index"]));
        latest.hear(&reading("thumb", 100, ok(1.0)));
        latest.hear(&reading("index", 105, ok(2.0)));
        assert_eq!(told(&latest, 110), [("thumb", Some(1.0)), ("index", Some(2.0))]);
        assert_eq!(told(&latest, 111), [("thumb", None), ("index", Some(2.0))]);
        latest.hear(&up(&["index"]));
        assert_eq!(told(&latest, 111), [("index", None)], "of the calibration before");
        latest.hear(&Heard::Down);
        assert!(told(&latest, 111).is_empty() && latest.version().is_none());
        latest.hear(&up(&["index"]));
        assert_eq!(told(&latest, 111), [("index", None)], "of before the outage");
        latest.hear(&reading("index", 112, ok(3.0)));
        assert_eq!(told(&latest, 122), [("index", Some(3.0))], "the patience is that of before");
    }
    #[test]
    fn what_is_pressed_is_so_until_the_daemon_says_otherwise() {
        let mut latest = Latest::new(Duration::from_nanos(10));
        latest.hear(&up(&["thumb", "index"]));
        latest.hear(&event("thumb", EventName::Pressed, None));
        latest.hear(&event("nobody", EventName::Pressed, None));
        latest.hear(&event("index", EventName::Released, None));
        assert_eq!(latest.pressed().collect::<Vec<_>>(), [("index", false), ("thumb", true)]);
        latest.hear(&event("thumb", EventName::Released, Some("stale")));
        assert_eq!(latest.pressed().collect::<Vec<_>>(), [("index", false)], "not known");
        latest.hear(&up(&["index"]));
        assert_eq!(latest.pressed().count(), 0);
    }
}
