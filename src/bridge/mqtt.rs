//! MQTT: each channel as a topic of a broker, announced so that Home Assistant shows it without being configured.
//!
//! Below `cermd/ID`: `availability` (retained; the broker says "offline" when this process ends without a word),
//! `channel/CHANNEL` with the numbers or the state of its readings, `trigger/CHANNEL` with the last event of its trigger, at once
//! and again with each `instrument`, and `instrument` with the figures of the daemon. Nothing
//! else is retained: whoever subscribes gets what is measured from then on.

mod discovery;
mod link;
mod report;

pub use link::{Broker, Login};

use super::feed::{Feed, Heard};
use super::latest::now;
use super::limits::{MAX_HZ, MOST_ANNOUNCED};
use super::{BridgeError, Upstream, Wish};
use crate::stream::wire::{EventLine, EventName, ReadingLine, StateLine, StatsLine, VersionLine};
use crate::units::Nanos;
use link::{BrokerState, Link, Publication};
use report::{Pacing, Reporter};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// Who this board is, and when it speaks.
#[derive(Debug, Clone)]
pub struct Options {
    /// What the board is called on the broker: one name for one board. Letters, digits, "-" and "_" only.
    pub id: String,
    /// The first level of Home Assistant's topics; `None`: nothing is announced.
    pub discovery: Option<String>,
    /// How much a resistance must change to be told before `every`, in units of its uncertainty.
    pub change: f64,
    /// The longest silence of a channel that is read.
    pub every: Duration,
    /// The shortest time between two reports of a channel whose state stays.
    pub at_least: Duration,
}

/// Publishes until somebody wants the end.
///
/// # Errors
/// The file of a certificate or a password cannot be read, or the system refuses a thread.
pub fn run(source: Upstream, broker: Broker, options: Options, wish: Wish<'_>) -> Result<(), BridgeError> {
    let patience = Nanos::from_seconds(source.patience.as_secs_f64());
    let mut feed = Feed::new(source.socket, Some(MAX_HZ));
    let mut teller = Teller::new(options, patience);
    let will = Publication::retained(teller.topics.availability(), OFFLINE);
    let mut link = Link::start(broker, &teller.options.id, will, teller.topics.births())?;
    while !wish() {
        let heard = feed.next();
        match link.state() {
            BrokerState::Up { is_new } => {
                if is_new {
                    link.publish_all(teller.introduction());
                }
                for message in teller.tell(&heard, now()) {
                    let (channel, is_retained) = (message.channel.clone(), message.is_retained);
                    if link.publish(message) {
                        continue;
                    }
                    // The broker is slow: what it has not taken was not told.
                    channel.into_iter().for_each(|channel| teller.forget(&channel));
                    if is_retained {
                        link.introduce_again();
                    }
                }
            }
            BrokerState::Down => teller.note(&heard),
        }
    }
    link.end(Publication::retained(teller.topics.availability(), OFFLINE));
    Ok(())
}

const ONLINE: &str = "online";
const OFFLINE: &str = "offline";

/// The names of the topics of one board.
#[derive(Debug, Clone)]
struct Topics {
    id: String,
    discovery: Option<String>,
}

impl Topics {
    fn availability(&self) -> String {
        format!("cermd/{}/availability", self.id)
    }

    fn instrument(&self) -> String {
        format!("cermd/{}/instrument", self.id)
    }

    fn channel(&self, channel: &str) -> String {
        self.of("channel", channel)
    }

    fn trigger(&self, channel: &str) -> String {
        self.of("trigger", channel)
    }

    /// A channel may be called anything, but "/", "+" and "#" mean something in a topic: percent-encoded as in an address.
    fn of(&self, what: &str, channel: &str) -> String {
        let encoded = channel.bytes().map(|byte| match byte {
            b'-' | b'_' | b'.' => char::from(byte).to_string(),
            _ if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
            _ => format!("%{byte:02X}"),
        });
        format!("cermd/{}/{what}/{}", self.id, encoded.collect::<String>())
    }

    fn device(&self) -> Option<String> {
        self.discovery.as_ref().map(|prefix| format!("{prefix}/device/{}/config", self.id))
    }

    /// Where Home Assistant says that it has started.
    fn births(&self) -> Option<String> {
        self.discovery.as_ref().map(|prefix| format!("{prefix}/status"))
    }
}

/// What is known, and what of it has been told.
#[derive(Debug)]
struct Teller {
    options: Options,
    topics: Topics,
    /// A reading that is older is not told.
    patience: Nanos,
    version: Option<VersionLine>,
    /// The channels that Home Assistant may still have, the latest first: all that were announced, since nobody says what has
    /// reached it.
    announced: Option<VersionLine>,
    /// Of the figures before: readings, and the time of the daemon, s.
    counted: Option<(u64, f64)>,
    reporters: BTreeMap<String, Reporter>,
    /// The last event of each trigger.
    events: BTreeMap<String, EventLine>,
}

impl Teller {
    fn new(options: Options, patience: Nanos) -> Teller {
        let topics = Topics { id: options.id.clone(), discovery: options.discovery.clone() };
        let (reporters, events) = (BTreeMap::new(), BTreeMap::new());
        Teller { options, topics, patience, version: None, announced: None, counted: None, reporters, events }
    }

    /// What somebody must hear who has heard nothing yet. From now on everything is news.
    fn introduction(&mut self) -> Vec<Publication> {
        self.reporters.clear();
        let gone = self.version.as_ref().and_then(|version| self.gone(version));
        self.announce();
        let state = if self.version.is_some() { ONLINE } else { OFFLINE };
        let device = self.topics.device().zip(self.version.as_ref()).map(|(topic, version)| {
            Publication::retained(
                topic,
                &discovery::device(&self.topics, version, self.options.every).to_string(),
            )
        });
        gone.into_iter()
            .chain(device)
            .chain([Publication::retained(self.topics.availability(), state)])
            .collect()
    }

    /// With the channels that there are now, beside those before.
    fn announce(&mut self) {
        let Some(mut version) = self.version.clone() else { return };
        let before = self.announced.take().into_iter().flat_map(|announced| announced.channels);
        let before: Vec<_> = before.filter(|channel| !version.channels.contains(channel)).collect();
        version.channels.extend(before);
        version.channels.truncate(MOST_ANNOUNCED);
        self.announced = Some(version);
    }

    /// Remembers who is there, while there is nobody to tell.
    fn note(&mut self, heard: &Heard) {
        match heard {
            Heard::Up(version) => {
                self.version = Some(version.clone());
                self.events.clear();
            }
            Heard::Down => {
                (self.version, self.counted) = (None, None);
                self.events.clear();
            }
            Heard::Event(event, _) if self.has(&event.channel) => {
                self.events.insert(event.channel.clone(), event.clone());
            }
            _ => {}
        }
    }

    /// What there is to tell of what was heard.
    fn tell(&mut self, heard: &Heard, now: Nanos) -> Vec<Publication> {
        self.note(heard);
        match heard {
            Heard::Up(_) => self.introduction(),
            Heard::Down => self.introduction(),
            Heard::Reading(reading, _) => self.report(reading, now).into_iter().collect(),
            Heard::Event(event, _) if self.has(&event.channel) => vec![self.trigger(event)],
            Heard::Event(..) => Vec::new(),
            // Again: who has come meanwhile knows what is so, and who hears nothing knows that it may not be.
            Heard::Stats(stats, _) => {
                let triggers: Vec<_> = self.events.values().map(|event| self.trigger(event)).collect();
                [self.figures(stats)].into_iter().chain(triggers).collect()
            }
            Heard::Nothing => Vec::new(),
        }
    }

    /// The entities of channels that are no more, taken back.
    fn gone(&self, version: &VersionLine) -> Option<Publication> {
        let (topic, before) = self.topics.device().zip(self.announced.as_ref())?;
        let device = discovery::device_without(&self.topics, version, before, self.options.every)?;
        Some(Publication::retained(topic, &device.to_string()))
    }

    /// Of no other channels, however many ids a daemon may send.
    fn has(&self, id: &str) -> bool {
        self.version.iter().any(|version| version.channels.iter().any(|channel| channel.id == id))
    }

    fn trigger(&self, event: &EventLine) -> Publication {
        let payload = TriggerPayload { time: &event.time, event: event.event, reason: &event.reason };
        Publication::passing(self.topics.trigger(&event.channel), &json(&payload))
    }

    fn report(&mut self, reading: &ReadingLine, now: Nanos) -> Option<Publication> {
        if now - Nanos(reading.t_mono_ns) > self.patience || !self.has(&reading.channel) {
            return None;
        }
        let Options { change, every, at_least, .. } = self.options;
        let [every, at_least] = [every, at_least].map(|time| Nanos::from_seconds(time.as_secs_f64()));
        let rules = Pacing { change, every, at_least };
        let reporter = self.reporters.entry(reading.channel.clone()).or_default();
        reporter.is_news(&reading.state, Nanos(reading.t_mono_ns), &rules).then(|| {
            let payload = json(&Payload { time: &reading.time, state: &reading.state, hint: &reading.hint });
            let topic = self.topics.channel(&reading.channel);
            Publication { channel: Some(reading.channel.clone()), ..Publication::passing(topic, &payload) }
        })
    }

    fn forget(&mut self, channel: &str) {
        self.reporters.remove(channel);
    }

    fn figures(&mut self, stats: &StatsLine) -> Publication {
        let of = &stats.instrument;
        let before = self.counted.replace((of.readings, of.uptime_s));
        let rate_hz = before.and_then(|(readings, uptime_s)| {
            let (count, seconds) = (of.readings.checked_sub(readings)?, of.uptime_s - uptime_s);
            (seconds > 0.0).then(|| crate::units::rounded(count as f64 / seconds, 3))
        });
        let figures = Figures {
            rate_hz,
            gpio_works: of.gpio_works,
            uptime_s: of.uptime_s.round(),
            offset_us: of.offset_ns.map(|ns| crate::units::rounded(ns * 1e-3, 4)),
            pin_ohm: of.r_o_ohm,
            hint: of.hint.as_deref(),
        };
        Publication::passing(self.topics.instrument(), &json(&figures))
    }
}

fn json(payload: &impl Serialize) -> String {
    // Texts and finite numbers always serialise.
    serde_json::to_string(payload).unwrap_or_default()
}

/// A reading as it is published: the names of READING.
#[derive(Serialize)]
struct Payload<'a> {
    time: &'a str,
    #[serde(flatten)]
    state: &'a StateLine,
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: &'a Option<String>,
}

/// An event as it is published: the names of EVENT.
#[derive(Serialize)]
struct TriggerPayload<'a> {
    time: &'a str,
    event: EventName,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: &'a Option<String>,
}

#[derive(Serialize)]
struct Figures<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_hz: Option<f64>,
    gpio_works: bool,
    uptime_s: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    offset_us: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pin_ohm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hint: Option<&'a str>,
}

#[cfg(test)]
mod tests;
